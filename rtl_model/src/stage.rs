//! The stages of the unit. A stage has one name in every implementation, vector file and document.

use core::fmt;

macro_rules! stages {
    ($($variant:ident: $name:literal, $meaning:literal;)+) => {
        /// A stage of the unit, in pipeline order.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Stage { $(#[doc = $meaning] $variant),+ }

        impl Stage {
            /// Every stage, in pipeline order.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// The stage's name: file name, function name, vector name, document name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    };
}

stages! {
    LocalFrame: "local_frame", "Tangent vectors e1, e2 of the surface, from the normal and the main direction h.";
    Bump: "bump", "The normal moved by the bump map's offsets.";
    Reflect: "reflect", "The reflected direction.";
    CubeFace: "cube_face", "Face, reciprocal of the major component, coordinates on the face.";
    Jacobian: "jacobian", "Derivatives of the face coordinates by screen position: the matrix D.";
    Roughness: "roughness", "The roughness ellipse B carried to the face: B'.";
    RayCone: "ray_cone", "Angle and width of a ray cone on its way.";
    Hit: "hit", "A ray's hit with the surface of a distance map.";
    SurfaceFootprint: "surface_footprint", "A cone's footprint on a textured surface: ddx, ddy and D.";
    Covariance: "covariance", "K = D Dᵀ + s² B' B'ᵀ with one shared exponent.";
    Eigen: "eigen", "Lengths and direction of the ellipse's axes.";
    Footprint: "footprint", "Probe count, probe width, level of detail and step.";
    Address: "address", "Texel addresses and weights of one probe.";
    Filter: "filter", "Weighted sums of texels and the output register.";
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

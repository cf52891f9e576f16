//! The registers of the unit and the events of its stages, each defined once.

use core::fmt;

use core::ops::Deref;

use crate::config::Config;
use crate::fx::{Format, Quantizer};
use crate::stage::Stage;

/// What kind of number a register holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Fixed point: `int`, `frac`, `rounding`, `overflow` apply.
    Fixed,
    /// Mantissas with a shared exponent that fill `int + frac` bits; they never overflow.
    Block,
}

/// Static description of a register.
#[derive(Clone, Copy, Debug)]
pub struct RegInfo {
    /// The stage that writes it.
    pub stage: Stage,
    /// Name within the stage.
    pub name: &'static str,
    /// Components (per probe where the stage works on probes).
    pub components: usize,
    /// Fixed or block.
    pub kind: Kind,
    /// Default format.
    pub format: Format,
    /// One sentence: what it holds, in which unit.
    pub meaning: &'static str,
}

macro_rules! registers {
    ($($variant:ident: $stage:ident . $name:literal [$components:literal] $kind:ident $sign:ident $int:literal . $frac:literal, $meaning:literal;)+) => {
        /// A named register of the unit.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Reg { $(#[doc = $meaning] $variant),+ }

        impl Reg {
            /// Every register, in pipeline order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// How many there are.
            pub const COUNT: usize = Self::ALL.len();

            /// Name, shape, default format and meaning.
            #[must_use]
            pub const fn info(self) -> RegInfo {
                match self {
                    $(Self::$variant => RegInfo {
                        stage: Stage::$stage,
                        name: $name,
                        components: $components,
                        kind: Kind::$kind,
                        format: Format::$sign($int, $frac),
                        meaning: $meaning,
                    }),+
                }
            }

            /// Position in [`Reg::ALL`].
            #[must_use]
            #[inline(always)]
            #[expect(clippy::as_conversions, reason = "a u8 discriminant widens without loss")]
            pub const fn index(self) -> usize {
                self as usize
            }
        }
    };
}

registers! {
    FrameN: LocalFrame."n"[3] Block signed 1 . 22, "interpolated normal, its largest component in [1, 2) times a power of two";
    FrameH: LocalFrame."h"[3] Block signed 1 . 22, "main direction, normalised like n";
    FrameCross: LocalFrame."cross"[3] Block signed 1 . 22, "h × n";
    FrameInvLength: LocalFrame."inv_length"[1] Block signed 1 . 24, "1/|h × n|";
    FrameLength: LocalFrame."length"[1] Fixed signed 2 . 24, "|n| of the normalised n";
    FrameScale: LocalFrame."scale"[1] Block signed 1 . 24, "|n|/|h × n|";
    FrameE1: LocalFrame."e1"[3] Fixed signed 2 . 22, "first tangent vector, as long as n";
    FrameNCross: LocalFrame."n_cross"[3] Fixed signed 4 . 22, "n × (h × n)";
    FrameE2: LocalFrame."e2"[3] Fixed signed 2 . 22, "second tangent vector, as long as n";
    BumpB: Bump."b"[2] Fixed signed 5 . 22, "bump offsets b1, b2 in units of |n|";
    BumpN: Bump."n_mod"[3] Fixed signed 8 . 22, "n + b1 e1 + b2 e2";
    ReflectV: Reflect."v"[3] Block signed 1 . 22, "direction to the eye, its largest component in [1, 2) times a power of two";
    ReflectN: Reflect."n"[3] Block signed 1 . 22, "normal that reflects: n_mod, or n without a bump";
    ReflectNdotV: Reflect."n_dot_v"[1] Fixed signed 4 . 22, "⟨n, v⟩";
    ReflectNdotN: Reflect."n_dot_n"[1] Fixed signed 4 . 22, "⟨n, n⟩";
    ReflectVr: Reflect."v_r"[3] Block signed 1 . 24, "reflected direction 2n⟨n,v⟩ − v⟨n,n⟩";
    FaceRotated: CubeFace."rotated"[3] Block signed 1 . 24, "A·v_r, the direction that is looked up";
    FaceInvMa: CubeFace."inv_ma"[1] Block signed 1 . 26, "1/|ma|, ma the major component";
    FaceU: CubeFace."u"[1] Fixed signed 1 . 24, "sc/|ma| in [−1, 1]";
    FaceV: CubeFace."v"[1] Fixed signed 1 . 24, "tc/|ma| in [−1, 1]";
    JacDvDx: Jacobian."dv_dx"[3] Fixed signed 3 . 22, "∂v per pixel in x, shifted with v";
    JacDvDy: Jacobian."dv_dy"[3] Fixed signed 3 . 22, "∂v per pixel in y, shifted with v";
    JacDnDx: Jacobian."dn_dx"[3] Fixed signed 7 . 22, "∂n per pixel in x, shifted with n";
    JacDnDy: Jacobian."dn_dy"[3] Fixed signed 7 . 22, "∂n per pixel in y, shifted with n";
    JacInvNn: Jacobian."inv_nn"[1] Fixed signed 1 . 24, "1/⟨n,n⟩ of the interpolated normal";
    JacNIdotDn: Jacobian."n_i_dot_dn"[2] Fixed signed 10 . 22, "⟨n,∂n⟩ of the interpolated normal, x and y";
    JacAlong: Jacobian."along"[2] Fixed signed 8 . 22, "⟨n,∂n⟩/⟨n,n⟩ of the interpolated normal, x and y";
    JacDnPerp: Jacobian."dn_perp"[6] Fixed signed 7 . 22, "∂n⊥ = ∂n − n⟨n,∂n⟩/⟨n,n⟩, x then y";
    JacPerpDotE: Jacobian."perp_dot_e"[4] Fixed signed 10 . 22, "⟨∂n⊥,e1⟩, ⟨∂n⊥,e2⟩, x then y (dnmod = frame)";
    JacTilt: Jacobian."tilt"[4] Fixed signed 8 . 22, "⟨∂n⊥,e1⟩/⟨n,n⟩ and ⟨∂n⊥,e2⟩/⟨n,n⟩, x then y (dnmod = frame)";
    JacTurn: Jacobian."turn"[3] Fixed signed 9 . 20, "⟨n,h⟩/⟨e2,h⟩ and the frame's rate of turn about n, x and y (dnmod = frame)";
    JacDe: Jacobian."de"[12] Fixed signed 9 . 22, "∂e1, ∂e2 in x, then in y (dnmod = frame)";
    JacDnMod: Jacobian."dn_mod"[6] Fixed signed 7 . 22, "∂n_mod, x then y, shifted with n_mod";
    JacNdotDv: Jacobian."n_dot_dv"[2] Fixed signed 6 . 22, "⟨n,∂v⟩, x and y";
    JacVdotDn: Jacobian."v_dot_dn"[2] Fixed signed 10 . 22, "⟨v,∂n_mod⟩, x and y";
    JacNdotDn: Jacobian."n_dot_dn"[2] Fixed signed 10 . 22, "⟨n_mod,∂n_mod⟩, x and y";
    JacDvr: Jacobian."dv_r"[6] Fixed signed 9 . 22, "∂v_r (rotated), x then y";
    JacNumerator: Jacobian."numerator"[4] Fixed signed 10 . 21, "|ma|·∂u, |ma|·∂v before the division, row by row";
    JacD: Jacobian."d"[4] Fixed signed 8 . 22, "D row by row: ∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y";
    RoughD: Roughness."d"[3] Fixed signed 4 . 22, "d1, d2, d3 of B = [d1 d2; 0 d3] in units of |n|";
    RoughScaled: Roughness."d_scaled"[3] Fixed signed 6 . 22, "s·d1, s·d2, s·d3";
    RoughVdotE: Roughness."v_dot_e"[2] Fixed signed 5 . 22, "⟨v,e1⟩, ⟨v,e2⟩";
    RoughNdotE: Roughness."n_dot_e"[2] Fixed signed 5 . 22, "⟨n_mod,e1⟩, ⟨n_mod,e2⟩";
    RoughDvr: Roughness."dv_r"[6] Fixed signed 7 . 22, "J_n e1 then J_n e2 (rotated)";
    RoughNumerator: Roughness."numerator"[4] Fixed signed 8 . 21, "|ma|·G A J_n [e1 e2] row by row";
    RoughE: Roughness."e"[4] Fixed signed 6 . 22, "G A J_n [e1 e2] row by row";
    RoughB: Roughness."b"[4] Fixed signed 8 . 22, "s·B' row by row";
    HitX: Hit."x"[3] Fixed signed 3 . 23, "where the ray starts, in units of the map's power of two";
    HitDirection: Hit."direction"[3] Block signed 1 . 24, "the ray's direction as it came, its largest component in [1, 2) times a power of two";
    HitInvNorm: Hit."inv_norm"[1] Block signed 1 . 26, "1/|direction|";
    HitR: Hit."r"[3] Fixed signed 1 . 24, "R, the unit direction";
    HitLookUp: Hit."look_up"[3] Block signed 1 . 24, "A·q, the direction of a distance look-up; three a look-up: R, x, then l";
    HitUv: Hit."uv"[2] Fixed signed 1 . 24, "(u, v) of a look-up on its face";
    HitS: Hit."s"[2] Fixed signed 16 . 8, "texel coordinates of a look-up";
    HitDistance: Hit."distance"[1] Fixed unsigned 1 . 19, "a distance in memory, in units of the map's power of two (a trace shows the nearest texel)";
    HitRadius: Hit."radius"[1] Fixed unsigned 1 . 23, "dist(q) after the interpolation: R, x, then l";
    HitInvRadius: Hit."inv_radius"[1] Block signed 1 . 26, "1/dist(q): x, then l";
    HitLength: Hit."length"[1] Fixed unsigned 8 . 23, "|x|, then |l|";
    HitRatio: Hit."ratio"[1] Fixed unsigned 3 . 24, "p_un = |x|/dist(x), then f = |l|/dist(l)";
    HitHalved: Hit."halved"[1] Fixed unsigned 3 . 24, "the other end's ratio after its residual was halved (method illinois)";
    HitInvSpan: Hit."inv_span"[1] Block signed 1 . 26, "1/(f − the other end's ratio)";
    HitQuotient: Hit."quotient"[1] Block signed 1 . 26, "(1 − f)/(f − the other end's ratio)";
    HitStep: Hit."step"[1] Fixed signed 6 . 23, "the change of d";
    HitD: Hit."d"[1] Fixed signed 6 . 23, "ray parameter, the first and after every step";
    HitL: Hit."l"[3] Fixed signed 7 . 23, "l = x + R d, the first and after every step";
    HitTo: Hit."to"[3] Block signed 1 . 24, "the hit's direction from the reference point, as ENV looks it up";
    HitInvAcross: Hit."inv_across"[1] Block signed 1 . 26, "1/|e_k × R|";
    HitInvNormal: Hit."inv_normal"[1] Block signed 1 . 26, "one over the length of the wall's normal (footprint plane)";
    HitNormal: Hit."normal"[3] Fixed signed 1 . 24, "unit normal of the wall (footprint plane)";
    HitCosine: Hit."cosine"[1] Fixed signed 1 . 24, "⟨n,R⟩, at least 1/max_probes (footprint plane)";
    HitInvCosine: Hit."inv_cosine"[1] Block signed 1 . 26, "1/⟨n,R⟩ (footprint plane)";
    HitAlong: Hit."along"[2] Fixed signed 1 . 24, "⟨n,t1⟩ and ⟨n,t2⟩ (footprint plane)";
    HitSlope: Hit."slope"[2] Fixed signed 7 . 24, "⟨n,t1⟩/⟨n,R⟩ and ⟨n,t2⟩/⟨n,R⟩ (footprint plane)";
    HitTangent: Hit."tangent"[6] Fixed signed 7 . 24, "t1 then t2, moved along R onto the wall's plane (footprint plane)";
    SurfDirection: SurfaceFootprint."direction"[3] Block signed 1 . 24, "the ray's direction as it came, its largest component in [1, 2) times a power of two";
    SurfNormal: SurfaceFootprint."normal"[3] Block signed 1 . 24, "the surface's normal, normalised like the direction";
    SurfDpDs: SurfaceFootprint."dp_ds"[3] Block signed 1 . 24, "∂P/∂s, or the triangle's edge AB, normalised like the direction";
    SurfDpDt: SurfaceFootprint."dp_dt"[3] Block signed 1 . 24, "∂P/∂t, or the triangle's edge AC, normalised like the direction";
    SurfEdge: SurfaceFootprint."edge_st"[4] Block signed 1 . 24, "differences of s, then of t, along AB and AC, with one exponent (triangles)";
    SurfS: SurfaceFootprint."s"[1] Fixed signed 9 . 24, "texture coordinate s";
    SurfT: SurfaceFootprint."t"[1] Fixed signed 9 . 24, "texture coordinate t";
    SurfInvLength: SurfaceFootprint."inv_length"[2] Block signed 1 . 26, "1/|D| and 1/|N| of what came";
    SurfD: SurfaceFootprint."d_unit"[3] Fixed signed 1 . 24, "D, the unit direction";
    SurfN: SurfaceFootprint."n_unit"[3] Fixed signed 1 . 24, "N, the unit normal";
    SurfCosine: SurfaceFootprint."cosine"[1] Fixed signed 1 . 24, "⟨D,N⟩";
    SurfInvCosine: SurfaceFootprint."inv_cosine"[1] Block signed 1 . 26, "1/max(|⟨D,N⟩|, 1/max_anisotropy)";
    SurfStretch: SurfaceFootprint."stretch"[1] Block signed 1 . 26, "|w|/max(|⟨D,N⟩|, 1/max_anisotropy), the length of dPdx";
    SurfCross: SurfaceFootprint."cross"[3] Block signed 1 . 24, "D × N";
    SurfInvCross: SurfaceFootprint."inv_cross"[1] Block signed 1 . 26, "1/|D × N|";
    SurfAcross: SurfaceFootprint."across"[3] Fixed signed 1 . 24, "unit(D × N), the direction of dPdy";
    SurfAlong: SurfaceFootprint."along"[3] Fixed signed 1 . 24, "N × unit(D × N), the direction of dPdx";
    SurfDpDx: SurfaceFootprint."dp_dx"[3] Fixed signed 8 . 22, "dPdx, in units of the width's power of two";
    SurfDpDy: SurfaceFootprint."dp_dy"[3] Fixed signed 2 . 24, "dPdy, in units of the width's power of two";
    SurfPlane: SurfaceFootprint."plane"[3] Block signed 1 . 24, "g = ∂P/∂s × ∂P/∂t";
    SurfInvSquare: SurfaceFootprint."inv_square"[2] Block signed 1 . 26, "1/|g|² (cone.gradient = gram); 1/|∂P/∂s|² and 1/|∂P/∂t|² (otk)";
    SurfTurned: SurfaceFootprint."turned"[6] Block signed 1 . 24, "∂P/∂t × g, then g × ∂P/∂s (gram)";
    SurfGradS: SurfaceFootprint."grad_s"[3] Block signed 1 . 24, "∇s on the surface: ∂P/∂t × g/|g|² (gram), ∂P/∂s/|∂P/∂s|² (otk)";
    SurfGradT: SurfaceFootprint."grad_t"[3] Block signed 1 . 24, "∇t on the surface: g × ∂P/∂s/|g|² (gram), ∂P/∂t/|∂P/∂t|² (otk)";
    SurfBarycentric: SurfaceFootprint."barycentric"[4] Block signed 1 . 24, "barycentric offsets of dPdx, then of dPdy, along AB and AC, with one exponent (triangles)";
    SurfDdx: SurfaceFootprint."ddx"[2] Block signed 1 . 24, "∂s/∂x and ∂t/∂x per pixel; ddy has the same exponent";
    SurfDdy: SurfaceFootprint."ddy"[2] Block signed 1 . 24, "∂s/∂y and ∂t/∂y per pixel";
    SurfJac: SurfaceFootprint."d"[4] Block signed 1 . 24, "D row by row with one exponent: ddx and ddy times the texture's size, in texels of level 0";
    CovK: Covariance."k"[3] Block signed 2 . 28, "a, b, c of K = D Dᵀ + s² B'B'ᵀ with one even exponent";
    EigenRoot: Eigen."root"[1] Fixed signed 3 . 28, "√((c−a)² + 4b²), at K's exponent";
    EigenSq: Eigen."lambda_sq"[2] Fixed signed 3 . 28, "λ1², λ2², at K's exponent";
    EigenLambda: Eigen."lambda"[2] Fixed signed 2 . 28, "λ1, λ2, at half of K's exponent";
    EigenAxis: Eigen."axis"[2] Fixed signed 1 . 20, "unit vector of the major axis, first component > 0 or (0, 1)";
    FootLength: Footprint."length"[1] Fixed signed 19 . 12, "M = λ1·N/2 in texels of level 0";
    FootWidth: Footprint."width"[1] Fixed signed 19 . 12, "m, the probe width in texels of level 0";
    FootLod: Footprint."lod"[1] Fixed signed 8 . 8, "log2 m clamped to the mip chain";
    FootLine: Footprint."line"[2] Fixed signed 9 . 22, "the probe line from end to end in u, v";
    FootStep: Footprint."step"[2] Fixed signed 8 . 24, "half the spacing of the probes in u, v";
    AddrU: Address."u"[1] Fixed signed 9 . 24, "u of a probe on the plane of the fragment's face";
    AddrV: Address."v"[1] Fixed signed 9 . 24, "v of a probe on the plane of the fragment's face";
    AddrS: Address."s"[4] Fixed signed 16 . 8, "texel coordinates (s, t) of a probe in its two levels";
    FilterBilinear: Filter."bilinear"[6] Fixed unsigned 17 . 40, "bilinear sums of a probe: RGB of its two levels";
    FilterColor: Filter."color"[3] Fixed unsigned 17 . 24, "filtered RGB";
}

/// A register of a compiled unit: which one it is, and the circuit that rounds what is written to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Register {
    /// Which one.
    pub reg: Reg,
    quantizer: Quantizer,
}

impl Deref for Register {
    type Target = Quantizer;

    #[inline(always)]
    fn deref(&self) -> &Quantizer {
        &self.quantizer
    }
}

impl Config {
    /// A register for values with `frac_in` fraction bits; 0 where every write has a shift of its own.
    #[must_use]
    pub fn register(&self, reg: Reg, frac_in: i64) -> Register {
        Register { reg, quantizer: Quantizer::new(self.format(reg), frac_in) }
    }
}

impl Reg {
    /// The register of that stage and name, if there is one.
    #[must_use]
    pub fn find(stage: &str, name: &str) -> Option<Self> {
        let named = |info: RegInfo| info.stage.name() == stage && info.name == name;
        Self::ALL.iter().copied().find(|reg| named(reg.info()))
    }
}

/// `<stage>.<register>`.
impl fmt::Display for Reg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let info = self.info();
        write!(f, "{}.{}", info.stage, info.name)
    }
}

macro_rules! events {
    ($($variant:ident: $name:literal, $meaning:literal;)+) => {
        /// Something that a stage reports besides its registers' overflows.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Event { $(#[doc = $meaning] $variant),+ }

        impl Event {
            /// Every event.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// How many there are.
            pub const COUNT: usize = Self::ALL.len();

            /// `<stage>.<event>`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// Position in [`Event::ALL`].
            #[must_use]
            #[inline(always)]
            #[expect(clippy::as_conversions, reason = "a u8 discriminant widens without loss")]
            pub const fn index(self) -> usize {
                self as usize
            }
        }
    };
}

events! {
    FrameParallel: "local_frame.parallel", "h ∥ n (or h = 0): any orthogonal pair was taken.";
    FaceZero: "cube_face.zero", "v_r = 0: +z, u = v = 0, D = 0 were taken.";
    InputNotFinite: "reflect.non_finite", "A component of the input was infinite or not a number: the largest finite number, or 0, was taken.";
    AddressOtherFace: "address.other_face", "A probe left the fragment's face and was looked up on another one.";
    ConeAngleSaturated: "ray_cone.angle.saturated", "A cone's angle was beyond its format: ± the largest number was taken.";
    ConeWidthSaturated: "ray_cone.width.saturated", "A cone's width was beyond its format: ± the largest number was taken.";
    ConeNotFinite: "ray_cone.non_finite", "A number of a cone was infinite or not a number: the largest finite number, or 0, was taken.";
    HitNotFinite: "hit.non_finite", "A component of a ray was infinite or not a number: the largest finite number, or 0, was taken.";
    HitNoDirection: "hit.no_direction", "R = 0: (0, 0, 1) was taken.";
    HitNoPlane: "hit.no_plane", "The wall has no plane there: the footprint is the disc's.";
    HitOvershoot: "hit.overshoot", "A step went beyond the reference surface.";
    SurfNotFinite: "surface_footprint.non_finite", "A number of a texture request was infinite or not a number: the largest finite number, or 0, was taken.";
    SurfParallel: "surface_footprint.parallel", "D ∥ N, or one of them 0: dPdx and dPdy are any orthogonal pair across N.";
    SurfDegenerate: "surface_footprint.degenerate", "∂P/∂s × ∂P/∂t = 0: ∇s and ∇t are the quotients of dot products; 0 where a derivative is 0.";
}

//! Fragments: the inputs of the unit for one pixel, as a rasteriser would send them.

/// One pixel's input to the ENV operation, in doubles.
///
/// World space, right-handed; `v` points from the surface to the eye. Nothing is normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Direction from the surface to the eye.
    pub v: [f64; 3],
    /// Interpolated surface normal.
    pub n: [f64; 3],
    /// ∂v per pixel to the right.
    pub dv_dx: [f64; 3],
    /// ∂v per pixel downwards (increasing y of the image plane).
    pub dv_dy: [f64; 3],
    /// ∂n per pixel to the right.
    pub dn_dx: [f64; 3],
    /// ∂n per pixel downwards.
    pub dn_dy: [f64; 3],
    /// Main direction of the local frame; needed by `bump` and `rough`.
    pub h: Option<[f64; 3]>,
    /// Bump offsets b1, b2 in units of |n|.
    pub bump: Option<[f64; 2]>,
    /// Roughness factors d1, d2, d3: B = [d1 d2; 0 d3].
    pub rough: Option<[f64; 3]>,
}

impl Fragment {
    /// Changes each of its numbers.
    #[inline]
    pub fn for_each(&mut self, mut change: impl FnMut(&mut f64)) {
        let Self { v, n, dv_dx, dv_dy, dn_dx, dn_dy, .. } = self;
        [v, n, dv_dx, dv_dy, dn_dx, dn_dy].into_iter().flatten().for_each(&mut change);
        self.h.iter_mut().chain(&mut self.rough).flatten().for_each(&mut change);
        self.bump.iter_mut().flatten().for_each(change);
    }
}

/// A fragment and the pixel that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelFragment {
    /// Column and row of the image, (0, 0) top left.
    pub pixel: [u32; 2],
    /// The unit's input.
    pub fragment: Fragment,
}

/// How texture coordinates change along a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tangents {
    /// Any surface, by its derivatives.
    Surface {
        /// ∂P/∂s.
        dp_ds: [f64; 3],
        /// ∂P/∂t.
        dp_dt: [f64; 3],
    },
    /// A triangle ABC.
    Triangle {
        /// B − A and C − A.
        edges: [[f64; 3]; 2],
        /// (s, t) of B less that of A, and of C less that of A.
        st: [[f64; 2]; 2],
    },
}

impl Tangents {
    /// ∂P/∂s and ∂P/∂t; of a triangle whose texture coordinates span no area, its edges.
    #[must_use]
    pub fn derivatives(&self) -> ([f64; 3], [f64; 3]) {
        match *self {
            Self::Surface { dp_ds, dp_dt } => (dp_ds, dp_dt),
            Self::Triangle { edges: [b, c], st: [[s_b, t_b], [s_c, t_c]] } => {
                let area = s_b * t_c - s_c * t_b;
                if area == 0.0 || !area.is_finite() {
                    return (b, c);
                }
                (
                    [0, 1, 2].map(|i| (b[i] * t_c - c[i] * t_b) / area),
                    [0, 1, 2].map(|i| (c[i] * s_b - b[i] * s_c) / area),
                )
            }
        }
    }
}

/// One texture request's geometry, in doubles; the cone is a separate argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexFragment {
    /// Direction of the ray, of any length.
    pub d: [f64; 3],
    /// Normal of the surface, of any length, facing either way.
    pub n: [f64; 3],
    /// The surface's texture coordinates.
    pub tangents: Tangents,
    /// (s, t); the texture covers 0…1.
    pub st: [f64; 2],
}

impl TexFragment {
    /// Changes each of its numbers.
    #[inline]
    pub fn for_each(&mut self, mut change: impl FnMut(&mut f64)) {
        let (vectors, st) = match &mut self.tangents {
            Tangents::Surface { dp_ds, dp_dt } => ([dp_ds, dp_dt], None),
            Tangents::Triangle { edges: [b, c], st } => ([b, c], Some(st.as_flattened_mut())),
        };
        let [first, second] = vectors;
        [&mut self.d, &mut self.n, first, second].into_iter().flatten().for_each(&mut change);
        st.into_iter().flatten().chain(&mut self.st).for_each(change);
    }
}

/// One ray's input to the HIT operation, in doubles. The map's reference point is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitFragment {
    /// Where the ray starts.
    pub x: [f64; 3],
    /// Its direction, of any length: the unit normalises it.
    pub r: [f64; 3],
    /// The pixel's ray cone at `x`: full angle in radians and full width in world units.
    pub cone: Option<[f64; 2]>,
}

//! Blocks of lanes: inputs, results of the stages, outputs.

use super::steps::StepFlags;
use crate::fx::Flags;
use crate::lanes::in_lanes;
use crate::stages::jacobian::normal_derivative;
use crate::stages::{
    bump, covariance, cube_face, eigen, footprint, jacobian, local_frame, reflect, roughness,
};

/// Which parts of the ENV operation a scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Needs {
    /// Bump offsets: `local_frame`, `bump`.
    pub bump: bool,
    /// Roughness: `local_frame`, `roughness`.
    pub rough: bool,
}

impl Needs {
    /// Whether the tangent vectors are needed.
    #[must_use]
    pub const fn frame(self) -> bool {
        self.bump || self.rough
    }
}

/// One fragment as binary64 words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Words {
    /// Direction to the eye.
    pub v: [u64; 3],
    /// Interpolated normal.
    pub n: [u64; 3],
    /// ∂v/∂x, ∂v/∂y.
    pub dv: [[u64; 3]; 2],
    /// ∂n/∂x, ∂n/∂y.
    pub dn: [[u64; 3]; 2],
    /// Main direction.
    pub h: [u64; 3],
    /// b1, b2.
    pub b: [u64; 2],
    /// d1, d2, d3.
    pub d: [u64; 3],
}

in_lanes! {
    /// Words of fragments.
    pub struct Ports<V> {
        /// Direction to the eye.
        pub v: [V; 3],
        /// Interpolated normal.
        pub n: [V; 3],
        /// Main direction.
        pub h: [V; 3],
        /// ∂v/∂x, ∂v/∂y.
        pub dv: [V; 6],
        /// ∂n/∂x, ∂n/∂y.
        pub dn: [V; 6],
        /// b1, b2.
        pub b: [V; 2],
        /// d1, d2, d3.
        pub d: [V; 3],
    }
}

in_lanes! {
    /// The registers behind the ports.
    pub struct Inputs<V> {
        /// Mantissas of v.
        pub v: [V; 3],
        /// v = nominal · 2^v_exp.
        pub v_exp: V,
        /// Mantissas of the interpolated normal.
        pub n: [V; 3],
        /// n = nominal · 2^n_exp.
        pub n_exp: V,
        /// Mantissas of h.
        pub h: [V; 3],
        /// h = nominal · 2^h_exp.
        pub h_exp: V,
        /// ∂v/∂x then ∂v/∂y, shifted with v.
        pub dv: [V; 6],
        /// ∂n/∂x then ∂n/∂y, shifted with n.
        pub dn: [V; 6],
        /// b1, b2 in units of |n|.
        pub b: [V; 2],
        /// d1, d2, d3 in units of |n|.
        pub d: [V; 3],
    }
}

/// Up to `N` requests of an operation on their way.
#[derive(Clone, Debug, Default)]
pub struct Block<F, const N: usize> {
    /// Their words, and the results of the operation's own stages.
    pub front: F,
    /// ENV's stages.
    pub env: State<N>,
}

impl<F: Default, const N: usize> Block<F, N> {
    /// A block that remembers the flags behind each step, so that its results can stay from unit to unit.
    #[must_use]
    pub fn kept() -> Self {
        Self { front: F::default(), env: State::kept() }
    }
}

/// What ENV's stages have written for a block of lanes; kept from block to block.
#[derive(Clone, Debug)]
pub struct State<const N: usize> {
    /// Lanes in use.
    pub len: usize,
    /// Flags behind each step, where a state is kept from unit to unit.
    pub(super) step_flags: Option<StepFlags<N>>,
    pub(super) flags: [Flags; N],
    pub(super) words: Ports<[i64; N]>,
    pub(super) input: Inputs<[i64; N]>,
    pub(super) frame: local_frame::Out<[i64; N]>,
    pub(super) bumped: bump::Out<[i64; N]>,
    pub(super) reflected: reflect::Out<[i64; N]>,
    /// Where the directions meet the cube.
    pub face: cube_face::Out<[i64; N]>,
    pub(super) dn_mod: normal_derivative::Out<[i64; N]>,
    pub(super) d: jacobian::Out<[i64; N]>,
    pub(super) d_exp: [i64; N],
    pub(super) b: roughness::Out<[i64; N]>,
    pub(super) k: covariance::Out<[i64; N]>,
    /// Axes of the ellipses.
    pub axes: eigen::Out<[i64; N]>,
    /// Probe lines.
    pub line: footprint::Out<[i64; N]>,
}

impl<const N: usize> Default for State<N> {
    fn default() -> Self {
        Self {
            len: 0,
            step_flags: None,
            flags: [NO_FLAGS; N],
            words: Default::default(),
            input: Default::default(),
            frame: Default::default(),
            bumped: Default::default(),
            reflected: Default::default(),
            face: cube_face::Out { face: [4; N], ..Default::default() },
            dn_mod: Default::default(),
            d: Default::default(),
            d_exp: [0; N],
            b: Default::default(),
            k: Default::default(),
            axes: Default::default(),
            line: footprint::Out { count: [1; N], ..Default::default() },
        }
    }
}

impl<const N: usize> State<N> {
    /// Face of a lane, 0…5.
    #[must_use]
    pub fn face_of(&self, lane: usize) -> usize {
        usize::try_from(self.face.face[lane]).unwrap_or(0)
    }
}

impl State<1> {
    /// The flags of the only lane.
    #[must_use]
    pub fn flags(&self) -> Flags {
        self.flags[0]
    }
}

pub(super) const NO_FLAGS: Flags = Flags { overflow: 0, events: 0 };

/// Results of up to `N` fragments.
#[derive(Clone, Debug)]
pub struct Results<const N: usize> {
    /// RGB with the fraction bits of `filter.color`.
    pub color: [[i64; 3]; N],
    /// Probes.
    pub probes: [i64; N],
    /// Texels read.
    pub texels: [u64; N],
    /// Sticky flags.
    pub flags: [Flags; N],
}

impl<const N: usize> Default for Results<N> {
    fn default() -> Self {
        Self { color: [[0; 3]; N], probes: [0; N], texels: [0; N], flags: [NO_FLAGS; N] }
    }
}

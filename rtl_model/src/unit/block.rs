//! Blocks of lanes: inputs, results of the stages, outputs.

use super::steps::StepFlags;
use crate::fx::Flags;
use crate::stages::{
    Lanes, bump, covariance, cube_face, eigen, footprint, jacobian, local_frame, reflect, roughness,
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

/// Words of fragments, one array a word.
#[derive(Clone, Debug)]
pub struct Ports<const N: usize> {
    pub(super) v: [[u64; N]; 3],
    pub(super) n: [[u64; N]; 3],
    pub(super) h: [[u64; N]; 3],
    pub(super) dv: [[u64; N]; 6],
    pub(super) dn: [[u64; N]; 6],
    pub(super) b: [[u64; N]; 2],
    pub(super) d: [[u64; N]; 3],
}

impl<const N: usize> Default for Ports<N> {
    fn default() -> Self {
        Self {
            v: [[0; N]; 3],
            n: [[0; N]; 3],
            h: [[0; N]; 3],
            dv: [[0; N]; 6],
            dn: [[0; N]; 6],
            b: [[0; N]; 2],
            d: [[0; N]; 3],
        }
    }
}

/// The registers behind the ports.
#[derive(Clone, Debug)]
pub struct Inputs<const N: usize> {
    pub(super) v: Lanes<N, 3>,
    pub(super) v_exp: [i64; N],
    pub(super) n: Lanes<N, 3>,
    pub(super) n_exp: [i64; N],
    pub(super) h: Lanes<N, 3>,
    pub(super) h_exp: [i64; N],
    pub(super) dv: Lanes<N, 6>,
    pub(super) dn: Lanes<N, 6>,
    pub(super) b: Lanes<N, 2>,
    pub(super) d: Lanes<N, 3>,
}

impl<const N: usize> Default for Inputs<N> {
    fn default() -> Self {
        Self {
            v: [[0; N]; 3],
            v_exp: [0; N],
            n: [[0; N]; 3],
            n_exp: [0; N],
            h: [[0; N]; 3],
            h_exp: [0; N],
            dv: [[0; N]; 6],
            dn: [[0; N]; 6],
            b: [[0; N]; 2],
            d: [[0; N]; 3],
        }
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
    pub(super) input: Inputs<N>,
    pub(super) frame: local_frame::Out<N>,
    pub(super) bumped: bump::Out<N>,
    pub(super) reflected: reflect::Out<N>,
    /// Where the directions meet the cube.
    pub face: cube_face::Out<N>,
    pub(super) dn_mod: Lanes<N, 6>,
    pub(super) d: jacobian::Out<N>,
    pub(super) d_exp: [i64; N],
    pub(super) b: roughness::Out<N>,
    pub(super) k: covariance::Out<N>,
    /// Axes of the ellipses.
    pub axes: eigen::Out<N>,
    /// Probe lines.
    pub line: footprint::Out<N>,
}

impl<const N: usize> Default for State<N> {
    fn default() -> Self {
        Self {
            len: 0,
            step_flags: None,
            flags: [NO_FLAGS; N],
            input: Default::default(),
            frame: Default::default(),
            bumped: Default::default(),
            reflected: Default::default(),
            face: Default::default(),
            dn_mod: [[0; N]; 6],
            d: Default::default(),
            d_exp: [0; N],
            b: Default::default(),
            k: Default::default(),
            axes: Default::default(),
            line: Default::default(),
        }
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

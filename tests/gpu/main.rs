//! The WGSL twins: valid without a GPU, and right on one.
//!
//! Tests that need an adapter run on the best one there is. Without one they say so on stderr and pass, or fail where
//! `TAPLINE_REQUIRE_GPU` is 1.
#![expect(clippy::float_cmp, reason = "infinities, and what is exact by construction")]

mod checks;
mod extremes;
mod extremes_hit;
mod extremes_tex;
mod extremes_texture;
mod fingerprint;
mod policies;
mod shaders;

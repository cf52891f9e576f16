//! The float64 reference: the ENV operation in exact arithmetic, as far as doubles can print it.
//!
//! One file per stage, one function of the stage's name in it. [`env()`] wires them; [`ewa()`] filters
//! the same footprint with an elliptical Gaussian. Stages are generic over [`real::Real`], so that the
//! same lines run in plain doubles and, where inputs are extreme or terms cancel, in [`wide::Wide`].

pub mod address;
pub mod angle;
pub mod bump;
pub mod covariance;
pub mod cube_face;
pub mod distances;
pub mod eigen;
pub mod env;
pub mod ewa;
pub mod filter;
pub mod flags;
pub mod footprint;
pub mod hit;
pub mod jacobian;
pub mod local_frame;
pub mod planar;
pub mod prepared;
pub mod ray_cone;
pub mod real;
pub mod reflect;
pub mod roughness;
pub mod surface_footprint;
pub mod tap;
pub mod tex;
pub mod texture;
pub mod vector;
pub mod weights;
pub mod wide;

pub use distances::Distances;
pub use env::{Env, env};
pub use ewa::{Ewa, ewa, ewa_counted, ewa_planar};
pub use flags::{Flag, Flags};
pub use hit::{Hit, HitEnv, hit, hit_env};
pub use planar::PlanarTexture;
pub use prepared::Prepared;
pub use tap::{NoTap, Tap};
pub use tex::{Tex, tex};
pub use texture::Texture;
pub use weights::probe_weights;

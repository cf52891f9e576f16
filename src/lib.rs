//! Tapline: a bit-accurate simulator of a texture unit for filtered environment maps.
//!
//! Programs use the items of [`api`], which stand here at the crate's root: a [`Unit`] with every knob, a [`Scene`], and
//! [`compare`], [`trace`], [`filter()`], [`vectors()`]. `examples` has three programs.
//!
//! Data flows one way: scenes make fragments and textures, an engine turns fragments into
//! colours, and the report compares the pictures. `rtl_model` knows nothing of this crate.

pub use rtl_model::policy;

pub mod api;
pub mod base;
pub mod caustic;
#[cfg(feature = "cli")]
pub mod cli;
pub mod conformance;
pub mod cube;
pub mod distance;
pub mod engine;
pub mod error;
#[cfg(feature = "files")]
pub mod fingerprint;
pub mod fragment;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(not(feature = "gpu"))]
#[path = "gpu/absent.rs"]
pub mod gpu;
#[cfg(feature = "files")]
pub mod image;
pub mod impostor;
pub mod mesh;
pub mod mips;
pub mod operation;
pub mod optics;
pub mod picture;
pub mod planar;

pub mod reference;
pub mod report;
pub mod sampler;
pub mod scene;
pub mod settings;
pub mod srgb;
pub use rtl_model::stage;
#[cfg(feature = "files")]
pub mod study;
pub mod taken;
pub mod truth;
pub mod unit;

pub use api::{
    Comparison, Judgement, Scene, Trace, Vector, Vectors, compare, filter, trace, vectors,
};
pub use unit::UnitSpec as Unit;

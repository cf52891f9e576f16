//! Integer-only model of the texture unit: number formats, tables and pipeline stages.
//!
//! Nothing in this crate is a floating-point value. A register holds `raw · 2^−frac` in an `i64`;
//! formats, roundings and overflow modes are data, so that a study can sweep them in one process.
#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs, unreachable_pub)]
#![deny(clippy::float_arithmetic, clippy::disallowed_types, clippy::as_conversions)]
#![allow(
    clippy::needless_range_loop,
    clippy::too_many_arguments,
    reason = "lanes: loops over an index are what becomes vector code, and arrays are written where they lie"
)]

extern crate alloc;

pub mod cone;
pub mod config;
pub mod distance;
pub mod fx;
pub mod lanes;
mod literals;
pub mod policy;
pub mod port;
pub mod regs;
pub mod stage;
pub mod stages;
pub mod tables;
pub mod tap;
pub mod texel;
pub mod texture;
pub mod unit;

pub use config::{Config, ConfigError};
pub use policy::{Policy, TexelFormat};
pub use regs::{Event, Reg};
pub use stage::Stage;
pub use tap::{NoTap, NoTapStandard, Tap};
pub use texture::Texture;
pub use unit::Unit;

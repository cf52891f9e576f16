//! Tables: reciprocal, reciprocal square root, square root, log2 and the eigen angle.
//!
//! Contents are correctly rounded (nearest, ties to even) by integer arithmetic and so are the
//! same on every platform. `contents` makes them, `rom` looks them up, `angle` holds the angles.

pub mod angle;
pub mod contents;
pub mod rom;

pub use angle::AngleRom;
pub use rom::{Function, Rom, TableSpec};

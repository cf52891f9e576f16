//! Number formats as data: value = raw · 2^−frac, rounding and overflow chosen at run time.

pub mod block;
pub mod flags;
pub mod format;
pub mod quantize;

pub use block::Block;
pub use flags::Flags;
pub use format::{Format, Overflow, Rounding};
pub use quantize::Quantizer;

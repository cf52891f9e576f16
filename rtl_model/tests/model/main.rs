//! The integer model against definitions written out.
//!
//! One test binary, because every stage is inlined into each size of lane block that it runs.

mod common;
mod footprint;
mod fx;
mod whole_unit;

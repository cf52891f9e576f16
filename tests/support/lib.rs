//! What the tests share, compiled once for all of their binaries.

pub mod golden;
pub mod gpu;
pub mod house;
pub mod knobs;
#[path = "../../rtl_model/tests/model/common.rs"]
pub mod model;
pub mod reference;
pub mod rtl;

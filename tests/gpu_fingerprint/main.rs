//! The fingerprint: models whose rules are known, the device that is there, the command.

mod command;
mod device;
#[path = "../gpu_support/mod.rs"]
mod gpu_support;
mod models;
mod planted;

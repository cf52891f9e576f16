//! The fingerprint: models whose rules are known, the device that is there, the command.

mod command;
mod device;
mod models;
mod planted;

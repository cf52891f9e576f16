//! The fingerprint: models whose rules are known, and the device that is there.

mod device;
mod models;
mod planted;

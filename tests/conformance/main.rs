//! The judges: that right vectors pass in every format, and that a device with one thing wrong is caught at the right stage.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

mod api;
mod budget;
mod corners;
mod mutants;
mod packages;
mod ties;
#[cfg(feature = "files")]
mod vectors;

//! Studies: what is reused, what is counted, what is written.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

#[path = "../cli_support/mod.rs"]
mod cli_support;
mod cost;
#[path = "../knob_support/mod.rs"]
mod knob_support;
mod plan;
mod report;
mod results;
mod reuse;
mod size;

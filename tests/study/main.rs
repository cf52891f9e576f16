//! Studies: what is planned, what is reused, what is counted.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

mod cost;
mod plan;
mod reuse;

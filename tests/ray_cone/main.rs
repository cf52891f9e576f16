//! Ray cones: formats, stores and operations, against `half`, doubles and exact fractions.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "tests: a failure is the message, and codes are cut on purpose"
)]

mod formats;
mod grid;
mod operations;

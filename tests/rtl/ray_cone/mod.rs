//! Ray cones: formats, stores and operations, against `half`, doubles and exact fractions.
#![expect(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::cast_possible_truncation,
    reason = "tests: a failure is the message, results are exact codes, and codes are cut on purpose"
)]

mod blocks;
mod extremes;
mod formats;
mod grid;
mod operations;
mod rules;

//! The float reference against independent computations.

mod axes;
mod derivatives;
mod ewa;
mod extremes;
mod filter;
mod moments;
mod total;

//! The ground that every other part may stand on: casts, seeded numbers, vectors, numbers with derivatives, hashes, decoders under guard. It knows nothing of them.

pub mod dual;
pub mod hash;
pub(crate) mod named;
pub mod num;
#[cfg(feature = "files")]
pub mod quiet;
pub mod random;
pub mod vector;

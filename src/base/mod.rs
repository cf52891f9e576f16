//! The ground that every other part may stand on: casts, seeded numbers, numbers with derivatives. It knows nothing of them.

pub mod dual;
pub mod num;
pub mod random;

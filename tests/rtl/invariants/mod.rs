//! What holds for every texture unit (after D3D11.3 §7.18.16.3), asked of the whole integer model; and where it jumps.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "tests: a failure is the message, and sizes and texels are small and exact"
)]

mod continuity;
mod symmetry;
mod values;

//! The device of the tests that need one.

use tapline::gpu::{Gpu, GpuError};

/// The device; a visible skip where there is no adapter, unless `TAPLINE_REQUIRE_GPU` is 1. An adapter that is there and does
/// not open is a failure.
pub fn device() -> Option<Gpu> {
    match Gpu::open(None) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            let required = std::env::var_os("TAPLINE_REQUIRE_GPU").is_some_and(|v| v == "1");
            assert!(
                error == GpuError::NoAdapter && !required,
                "TAPLINE_REQUIRE_GPU is 1, or the adapter does not open: {error}"
            );
            eprintln!("skipped, not checked: {error}");
            None
        }
    }
}

/// Runs a test on the device, or says that there is none.
pub fn on_gpu(test: impl FnOnce(&Gpu)) {
    if let Some(gpu) = device() {
        test(&gpu);
    }
}

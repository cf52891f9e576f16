//! What stands for the engines on a GPU in a build without the feature `gpu`: no device can be opened, so none of them can run.

use super::{Engine, Progress, Rendering};
use crate::gpu::{Gpu, GpuError};
use crate::settings::Settings;

/// An engine on a device that cannot be.
pub struct GpuEngine<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// Policies.
    pub settings: Settings,
}

impl<J> Engine<J> for GpuEngine<'_> {
    fn render(&self, _: &J, _: Progress<'_>) -> Result<Rendering, GpuError> {
        match *self.gpu {}
    }
}

pub mod sampler {
    //! A device's own sampler.
    pub use super::GpuEngine as SamplerEngine;
}

pub mod check {
    //! Stages side by side.
    use super::{Gpu, GpuError, Progress, Settings};
    use crate::cube::CubeMap;
    use crate::distance::Distance;
    use crate::engine::TexJob;
    pub use crate::engine::stage_checks::{Requests, StageChecks};
    use crate::fragment::{HitFragment, PixelFragment};
    use crate::planar::PlanarMap;

    /// Checks the stages of ENV.
    ///
    /// # Errors
    /// None: no device can be.
    pub fn check_env(
        gpu: &Gpu,
        _: &Settings,
        _: &CubeMap,
        _: &[PixelFragment],
        _: Progress<'_>,
    ) -> Result<StageChecks, GpuError> {
        match *gpu {}
    }

    /// Checks the stages of HIT.
    ///
    /// # Errors
    /// None: no device can be.
    pub fn check_hit(
        gpu: &Gpu,
        _: &Settings,
        _: (&CubeMap, &Distance),
        _: &[([u32; 2], HitFragment)],
        _: Progress<'_>,
    ) -> Result<StageChecks, GpuError> {
        match *gpu {}
    }

    /// Checks requests to a texture.
    ///
    /// # Errors
    /// None: no device can be.
    pub fn check_requests(
        gpu: &Gpu,
        _: &Settings,
        _: &PlanarMap,
        _: &Requests,
    ) -> Result<StageChecks, GpuError> {
        match *gpu {}
    }

    /// Checks the stages of TEX.
    ///
    /// # Errors
    /// None: no device can be.
    pub fn check_tex(
        gpu: &Gpu,
        _: &Settings,
        _: &TexJob,
        _: Progress<'_>,
    ) -> Result<StageChecks, GpuError> {
        match *gpu {}
    }
}

pub mod hit {
    //! The search for a hit.
    use super::{Gpu, GpuError, Progress, Settings};
    use crate::cube::CubeMap;
    use crate::distance::Distance;
    use crate::engine::hit::HitResult;
    use crate::fragment::HitFragment;

    /// A search on a device that cannot be.
    pub struct GpuHit<'a>(&'a Gpu);

    impl<'a> GpuHit<'a> {
        /// Makes none.
        ///
        /// # Errors
        /// None: no device can be.
        pub fn new(
            gpu: &'a Gpu,
            _: &Settings,
            _: &Distance,
            _: Option<&CubeMap>,
            _: usize,
        ) -> Result<Self, GpuError> {
            match *gpu {}
        }

        /// Finds nothing.
        ///
        /// # Errors
        /// None: no device can be.
        pub fn filter(
            &self,
            _: &[HitFragment],
            _: Progress<'_>,
        ) -> Result<Vec<HitResult>, GpuError> {
            match *self.0 {}
        }
    }
}

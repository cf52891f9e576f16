//! What stands for a GPU in a build without the feature `gpu`: there is none, and an error says why.

use std::fmt;

use crate::error::InputError;

/// A device that cannot be.
#[derive(Clone, Copy, Debug)]
pub enum Gpu {}

/// Why there is no device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GpuError {
    /// Nobody built it.
    NoAdapter,
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a build without the feature `gpu`")
    }
}

impl std::error::Error for GpuError {}

impl From<GpuError> for InputError {
    fn from(error: GpuError) -> Self {
        let remedy = "build with `--features gpu`, or leave the gpu out";
        Self::new("gpu", "an engine on a GPU", error.to_string(), remedy)
    }
}

impl Gpu {
    /// Opens nothing.
    ///
    /// # Errors
    /// Always.
    pub fn open(_: Option<&str>) -> Result<Self, GpuError> {
        Err(GpuError::NoAdapter)
    }

    /// What an adapter says of itself.
    #[must_use]
    pub fn adapter(&self) -> &Self {
        self
    }

    /// Its name.
    #[must_use]
    pub fn title(&self) -> String {
        match *self {}
    }
}

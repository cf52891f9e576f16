//! Errors of a GPU.

use crate::error::InputError;

/// Why a GPU did not do what was asked of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// No driver offers an adapter.
    #[error("no GPU adapter: no Vulkan driver was found")]
    NoAdapter,
    /// `--adapter` names none, or more than one, of those that are there.
    #[error("`{asked}` {problem} of the adapters {there}")]
    Choice {
        /// What was asked for.
        asked: String,
        /// "names none" or "names more than one".
        problem: &'static str,
        /// Index and name of each that is there.
        there: String,
    },
    /// The adapter gives no device with WebGPU's default limits.
    #[error("{adapter} gives no device: {message}")]
    NoDevice {
        /// The adapter.
        adapter: String,
        /// The driver's words.
        message: String,
    },
    /// The device went away: reset, removed, or hung.
    #[error("{adapter} was lost during {doing}: {message}")]
    Lost {
        /// The adapter.
        adapter: String,
        /// The work that noticed it.
        doing: String,
        /// The driver's words.
        message: String,
    },
    /// Not enough memory on the device.
    #[error("{adapter} has no memory left for {doing}")]
    OutOfMemory {
        /// The adapter.
        adapter: String,
        /// The work that failed.
        doing: String,
    },
    /// Something needs more than a limit of the device.
    #[error("{what} needs {wanted}, and {limit} is {most}")]
    TooLarge {
        /// What is too large.
        what: String,
        /// What it needs, in the limit's unit.
        wanted: u64,
        /// The limit's name in WebGPU.
        limit: &'static str,
        /// The limit.
        most: u64,
    },
    /// The device does not have what the work needs.
    #[error("{adapter} cannot do {doing}: it lacks {lacks}")]
    Unsupported {
        /// The adapter.
        adapter: String,
        /// The work.
        doing: String,
        /// The missing feature.
        lacks: String,
    },
    /// A knob's value that the kernels do not have.
    #[error("{value}, which the kernels do not have")]
    NoPolicy {
        /// The knob's path.
        path: &'static str,
        /// What they have.
        expected: &'static str,
        /// The value.
        value: &'static str,
    },
    /// A shader or a command is not valid: a fault of this program or of the driver.
    #[error("{adapter} refused {doing}: {message}")]
    Refused {
        /// The adapter.
        adapter: String,
        /// The work that was refused.
        doing: String,
        /// The message of the validation.
        message: String,
    },
}

impl GpuError {
    /// Refuses what needs more than a limit of the device.
    pub(super) fn within(
        what: impl Into<String>,
        wanted: u64,
        (limit, most): (&'static str, u64),
    ) -> Result<(), Self> {
        let refused = || Self::TooLarge { what: what.into(), wanted, limit, most };
        if wanted <= most { Ok(()) } else { Err(refused()) }
    }

    /// What a user can do.
    #[must_use]
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::NoAdapter => {
                "install a Vulkan driver (Debian: mesa-vulkan-drivers has one in software), or leave the gpu out"
            }
            Self::Choice { .. } => {
                "`tapline gpu list` prints them; name one by its index or by a part of its name"
            }
            Self::NoDevice { .. } | Self::Unsupported { .. } => {
                "choose another with --adapter, or update the driver"
            }
            Self::Lost { .. } => {
                "look into the system's log for a reset of the GPU, then try a smaller picture"
            }
            Self::OutOfMemory { .. } => "ask for a smaller picture or a smaller --face-size",
            Self::TooLarge { .. } => "ask for a smaller --face-size or a smaller map",
            Self::NoPolicy { .. } => "leave the gpu out",
            Self::Refused { .. } => "report it with the output of `tapline gpu list`",
        }
    }

    /// The subject and the expectation of the error as an input error.
    const fn subject(&self) -> (&'static str, &'static str) {
        match self {
            Self::NoAdapter => ("gpu", "a GPU adapter"),
            Self::Choice { .. } => ("--adapter", "the index or a part of the name of one adapter"),
            Self::NoDevice { .. } => ("gpu", "a device with WebGPU's default limits"),
            Self::Lost { .. } => ("gpu", "a device that stays until the work is done"),
            Self::OutOfMemory { .. } => ("gpu", "enough memory"),
            Self::TooLarge { .. } => ("gpu", "work within WebGPU's default limits"),
            Self::Unsupported { .. } => ("gpu", "a device that can do it"),
            Self::NoPolicy { path, expected, .. } => (path, expected),
            Self::Refused { .. } => ("gpu", "work that the driver accepts"),
        }
    }
}

impl From<GpuError> for InputError {
    fn from(error: GpuError) -> Self {
        let (subject, expected) = error.subject();
        Self::new(subject, expected, error.to_string(), error.remedy())
    }
}

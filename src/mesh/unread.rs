//! What stands for the readers of mesh files in a build without the feature `files`.

use std::path::Path;

use super::Soup;
use crate::error::InputError;

/// Reads nothing.
pub(super) fn read(_: &Path, subject: &str) -> Result<(Soup, &'static str), InputError> {
    Err(InputError::new(
        subject,
        "a build with the feature `files`",
        "one without",
        "build with `--features files`, or leave the mesh out",
    ))
}

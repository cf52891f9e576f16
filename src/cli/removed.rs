//! Commands that are gone: what says the same now.

use crate::error::InputError;

/// The first words of each command, and where its figures are.
const REMOVED: [(&[&str], &str); 1] = [(
    &["impostor", "study"],
    "its figures are those of `tapline study`, see docs/studies/hit.md and hit-search.toml beside it",
)];

/// Names the replacement of a command that is gone.
pub(super) fn check(words: impl Iterator<Item = std::ffi::OsString>) -> Result<(), InputError> {
    let words: Vec<_> = words.collect();
    let gone = |(name, _): &&(&[&str], &str)| {
        words.len() >= name.len() && name.iter().zip(&words).all(|(a, b)| b == a)
    };
    match REMOVED.iter().find(gone) {
        None => Ok(()),
        Some((name, now)) => Err(InputError::new(
            name.join(" "),
            "a command that is there",
            "one that was removed",
            *now,
        )),
    }
}

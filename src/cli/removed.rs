//! Commands that are gone: what says the same now.

use crate::error::InputError;

/// The first words of each command, and where its figures are.
const REMOVED: [(&[&str], &str); 4] = [
    (
        &["conform", "extremes"],
        "run `tapline study` with extremes.toml, and `tapline vectors gen`, see docs/studies/extremes.md",
    ),
    (&["impostor", "study"], "run `tapline study` with hit-search.toml, see docs/studies/hit.md"),
    (&["cones", "cube"], "docs/studies/cones.md has its formula and table"),
    (
        &["cones"],
        "run `tapline study` with cones-tiles.toml or cones-bounces.toml, see docs/studies/cones.md",
    ),
];

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

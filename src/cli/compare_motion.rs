//! `compare --shift`: the same engines once more, with the scene moved by a part of a pixel.

use super::Failure;
use super::compare::Results;
use super::progress::Bar;
use crate::engine::{EngineKind, Job, Setup};
use crate::error::InputError;
use crate::picture::Picture;
use crate::report::motion::{Motion, motion};

/// Most pixels of a shift.
const MOST: f64 = 64.0;

/// Refuses a shift that is no number of pixels, or that there is no truth to judge.
pub(super) fn check_shift(shift: Option<f64>, kinds: &[EngineKind]) -> Result<(), InputError> {
    let Some(shift) = shift else { return Ok(()) };
    if !(-MOST..=MOST).contains(&shift) {
        let found = shift.to_string();
        return Err(InputError::new("--shift", "pixels from -64 to 64", found, "0.25 is usual"));
    }
    if !kinds.contains(&EngineKind::Truth) {
        let found = "engines without it";
        return Err(InputError::new(
            "--shift",
            "`truth` to judge by",
            found,
            "name it in --engines",
        ));
    }
    Ok(())
}

/// The motion of each engine that ran against that of `truth`.
pub(super) fn motions(
    job: &Job,
    shift: f64,
    setup: &Setup<'_>,
    results: &Results,
    exposure: f64,
) -> Result<Vec<(EngineKind, Motion)>, Failure> {
    let moved = job.shifted(shift);
    let mut after = Vec::new();
    for (kind, _) in &results.renderings {
        let bar = Bar::new(kind.name(), moved.total(*kind));
        after.push(moved.render(*kind, setup, &|n| bar.add(n))?.picture);
    }
    let renderings = results.renderings.iter().zip(&after);
    let pictures: Vec<(EngineKind, [&Picture; 2])> =
        renderings.map(|((kind, before), after)| (*kind, [&before.picture, after])).collect();
    let mut out = Vec::new();
    if let Some((_, truth)) = pictures.iter().find(|(kind, _)| *kind == EngineKind::Truth) {
        for (kind, own) in pictures.iter().filter(|(kind, _)| *kind != EngineKind::Truth) {
            out.push((*kind, motion(*own, *truth, exposure)?));
        }
    }
    Ok(out)
}

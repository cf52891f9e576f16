//! `--bump FILE`: heights or tangent-space normals.

use std::path::Path;

use crate::error::InputError;
use crate::image::{LoadOptions, load_bump_planes};
use crate::scene::bump::{BumpMap, BumpSource, MAX_OFFSET};
use crate::scene::bump_kind::{BumpChoice, BumpKind, source};
use crate::taken::Taken;

/// The bump map of a file, and what it was taken for.
pub(super) fn load(
    path: &Path,
    choice: BumpChoice,
    options: &LoadOptions,
) -> Result<(BumpSource, Taken), InputError> {
    let subject = path.display().to_string();
    if let Some(scale) = choice.scale
        && (scale.is_nan() || scale.abs() > 65536.0)
    {
        return Err(InputError::new(
            "--bump-scale",
            "a height in texels from -65536 to 65536",
            scale.to_string(),
            "leave it out for a 64th of the map's width",
        ));
    }
    let with_alpha = choice.kind == Some(BumpKind::NormalsTwoChannel);
    let mut file = load_bump_planes(path, with_alpha, options)?;
    let mut bad = 0u64;
    for sample in file.planes.iter_mut().flatten() {
        if !sample.is_finite() {
            *sample = 0.0;
            bad += 1;
        }
    }
    let (bump, kind) = source(file.width, file.height, &file.planes, choice, &subject)?;
    let mut taken = file.taken;
    taken.kind = kind;
    if bad > 0 {
        taken.remarks.push(format!("{bad} samples were infinite or not a number and count as 0"));
    }
    if choice.scale.is_some() && !matches!(bump, BumpSource::Height { .. }) {
        taken.remarks.push("holds normals, so --bump-scale has no effect".into());
    }
    let cleaned = BumpMap::new(&bump)?.cleaned();
    if cleaned > 0 {
        taken
            .remarks
            .push(format!("{cleaned} offsets longer than {MAX_OFFSET} were shortened to it"));
    }
    Ok((bump, taken))
}

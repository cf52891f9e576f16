//! From flags to a subject: environment, bump map, scene.

use super::args::SceneArgs;
use super::bump_file;
use crate::cube::CubeMap;
use crate::engine::EnvJob;
use crate::error::InputError;
use crate::image;
use crate::image::mips::build_mips;
use crate::image::{LoadOptions, load_environment};
use crate::planar::PlanarMap;
use crate::scene::bump::BumpSource;
use crate::scene::{self, DEFAULT_FACE_SIZE, SceneOptions, environment};
use crate::settings::Settings;

/// Refuses an exposure that no picture has a use for.
pub(super) fn check_exposure(stops: f64) -> Result<(), InputError> {
    if stops.abs() <= 64.0 {
        return Ok(());
    }
    Err(InputError::new(
        "--exposure",
        "stops from -64 to 64",
        stops.to_string(),
        "0 shows linear 1 as white",
    ))
}

/// The bump map that was named.
pub(super) fn load_bump(args: &SceneArgs) -> Result<Option<BumpSource>, InputError> {
    match &args.bump {
        None => Ok(None),
        Some(path) => bump_file::load(path, args.bump_scale, args.max_image_mb).map(Some),
    }
}

/// What a scene is built from.
pub(super) fn options(args: &SceneArgs) -> Result<SceneOptions, InputError> {
    check_exposure(args.exposure)?;
    Ok(SceneOptions {
        width: args.size.0,
        height: args.size.1,
        face_size: args.face_size,
        bump: load_bump(args)?,
        mesh: args.mesh.clone(),
    })
}

/// The environment that was named.
pub(super) fn load_map(args: &SceneArgs) -> Result<Option<CubeMap>, InputError> {
    let Some(path) = &args.env else {
        return Ok(None);
    };
    let options = LoadOptions { max_image_mb: args.max_image_mb, face_size: args.face_size };
    let (map, cleaned) = load_environment(path, &options)?;
    if let Some(note) = cleaned.note(&path.display().to_string()) {
        super::note(&note);
    }
    Ok(Some(map))
}

/// The 2-D texture that was named.
pub(super) fn load_texture(args: &SceneArgs) -> Result<Option<PlanarMap>, InputError> {
    let Some(path) = &args.texture else {
        return Ok(None);
    };
    let options = LoadOptions { max_image_mb: args.max_image_mb, face_size: None };
    let (map, cleaned) = image::load::load_texture(path, &options)?;
    if let Some(note) = cleaned.note(&path.display().to_string()) {
        super::note(&note);
    }
    Ok(Some(map))
}

/// The environment of a scene with ray cones: the file's own size, or the procedural one of the default size.
pub(super) fn load_sky(args: &SceneArgs) -> Result<CubeMap, InputError> {
    let args = SceneArgs { face_size: None, ..args.clone() };
    let procedural = || build_mips(environment::procedural(DEFAULT_FACE_SIZE));
    Ok(load_map(&args)?.unwrap_or_else(procedural))
}

/// Loads and builds what the flags ask for; warnings go to stderr.
pub(super) fn load(
    name: &str,
    args: &SceneArgs,
    settings: &Settings,
) -> Result<EnvJob, InputError> {
    // A wrong name or size fails before a large map is read.
    let scene = scene::build(name, &options(args)?, settings)?;
    for note in &scene.notes {
        super::note(note);
    }
    let map = load_map(args)?.unwrap_or_else(|| build_mips(scene.environment()));
    Ok(EnvJob::new(scene, map, settings))
}

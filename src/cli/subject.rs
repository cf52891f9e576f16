//! From flags to a subject: environment, bump map, scene.

use super::args::SceneArgs;
use super::bump_file;
use crate::cube::CubeMap;
use crate::engine::EnvJob;
use crate::error::InputError;
use crate::image;
use crate::image::{LoadOptions, Loaded, load_environment};
use crate::mips::build_mips;
use crate::planar::PlanarMap;
use crate::scene::{self, DEFAULT_FACE_SIZE, SceneOptions, environment};
use crate::settings::Settings;
use crate::taken::Taken;

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

/// What a scene is built from, and the inputs that were read for it.
pub(super) fn options(args: &SceneArgs) -> Result<(SceneOptions, Vec<Taken>), InputError> {
    check_exposure(args.exposure)?;
    let mut inputs = Vec::new();
    let bump = match &args.bump {
        None => None,
        Some(path) => {
            let bump = bump_file::load(path, args.bump_choice(), &args.load_options()?)?;
            Some(told(bump, &mut inputs))
        }
    };
    let options = SceneOptions {
        width: args.size.0,
        height: args.size.1,
        face_size: args.face_size,
        bump,
        mesh: args.mesh.clone(),
        mesh_up: args.mesh_up.unwrap_or_default(),
    };
    Ok((options, inputs))
}

/// Says what an input was taken for, and keeps it.
pub(super) fn told<T>((input, taken): (T, Taken), inputs: &mut Vec<Taken>) -> T {
    super::note(&taken.to_string());
    inputs.push(taken);
    input
}

/// The same for what a scene has read.
pub(super) fn said(taken: &[Taken], inputs: &mut Vec<Taken>) {
    taken.iter().for_each(|taken| told(((), taken.clone()), inputs));
}

/// The same for an image, with what was cleaned of it.
fn told_of<T>(loaded: Loaded<T>, inputs: &mut Vec<Taken>) -> T {
    if let Some(note) = loaded.cleaned.note(&loaded.taken.file) {
        super::note(&note);
    }
    told((loaded.map, loaded.taken), inputs)
}

/// The environment that was named.
pub(super) fn load_map(
    args: &SceneArgs,
    inputs: &mut Vec<Taken>,
) -> Result<Option<CubeMap>, InputError> {
    let options = args.load_options()?;
    let Some(path) = &args.env else {
        return Ok(None);
    };
    let options = LoadOptions { face_size: args.face_size, layout: args.env_layout, ..options };
    Ok(Some(told_of(load_environment(path, &options)?, inputs)))
}

/// The 2-D texture that was named.
pub(super) fn load_texture(
    args: &SceneArgs,
    inputs: &mut Vec<Taken>,
) -> Result<Option<PlanarMap>, InputError> {
    let Some(path) = &args.texture else {
        return Ok(None);
    };
    let loaded = image::load::load_texture(path, &args.load_options()?)?;
    Ok(Some(told_of(loaded, inputs)))
}

/// The environment of a scene with ray cones: the file's own size, or the procedural one of the default size.
pub(super) fn load_sky(args: &SceneArgs, inputs: &mut Vec<Taken>) -> Result<CubeMap, InputError> {
    let args = SceneArgs { face_size: None, ..args.clone() };
    let procedural = || build_mips(environment::procedural(DEFAULT_FACE_SIZE));
    Ok(load_map(&args, inputs)?.unwrap_or_else(procedural))
}

/// Loads and builds what the flags ask for; warnings go to stderr.
pub(super) fn load(
    name: &str,
    args: &SceneArgs,
    settings: &Settings,
) -> Result<(EnvJob, Vec<Taken>), InputError> {
    // A wrong name or size fails before a large map is read.
    let (options, mut inputs) = options(args)?;
    let scene = scene::build(name, &options, settings)?;
    said(&scene.inputs, &mut inputs);
    let map = load_map(args, &mut inputs)?.unwrap_or_else(|| build_mips(scene.environment()));
    Ok((EnvJob::new(scene, map, settings), inputs))
}

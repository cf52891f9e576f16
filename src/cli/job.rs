//! From flags to the job of a rendering command.

use std::collections::BTreeMap;

use super::args::SceneArgs;
use super::subject;
use crate::engine::ranges::losses;
use crate::engine::{EngineKind, HitJob, Job, TexJob};
use crate::error::InputError;
use crate::operation::Operation;
use crate::scene::registry::find;
use crate::scene::{hit, tex};
use crate::settings::Settings;
use crate::taken::Taken;
use crate::unit::UnitSpec;

/// Says what the unit's memories cannot hold of a job's maps, and counts it as flags.
pub(super) fn tell_losses(job: &Job, spec: &UnitSpec) -> Result<BTreeMap<String, u64>, InputError> {
    let losses = losses(job, spec)?;
    losses.iter().for_each(|loss| super::note(&format!("{}: {}", loss.event.name(), loss.note)));
    Ok(losses.iter().map(|loss| (loss.event.name().to_owned(), loss.count)).collect())
}

/// Refuses the engine that has no TEX operation for scenes of it.
pub(super) fn refuse_sampler(scene: &str, kinds: &[EngineKind]) -> Result<(), InputError> {
    if kinds.contains(&EngineKind::Sampler) && find(scene)?.operation() == Operation::Tex {
        return Err(InputError::new(
            "sampler",
            "a scene of the operations that it has, ENV and HIT",
            format!("`{scene}`, a scene of TEX"),
            "leave sampler out, or choose another scene",
        ));
    }
    Ok(())
}

/// Loads and builds what the flags ask for, and says what each input was taken for on stderr.
pub(super) fn load(
    name: &str,
    args: &SceneArgs,
    settings: &Settings,
) -> Result<(Job, Vec<Taken>), InputError> {
    let operation = find(name)?.operation();
    if operation != Operation::Tex {
        args.refuse_texture()?;
    }
    if operation != Operation::Hit {
        args.refuse_distance()?;
    }
    if let Operation::Env(_) = operation {
        let (job, inputs) = subject::load(name, args, settings)?;
        return Ok((Job::Env(Box::new(job)), inputs));
    }
    let (options, mut inputs) = subject::options(args)?;
    if operation == Operation::Hit {
        let scene = hit::build(name, &options)?;
        subject::said(&scene.inputs, &mut inputs);
        let (distance, taken) = args.distance()?.unzip();
        inputs.extend(taken.flatten());
        let map = subject::load_map(args, &mut inputs)?;
        return Ok((Job::Hit(Box::new(HitJob::with(scene, map, distance))), inputs));
    }
    let floor = subject::load_texture(args, &mut inputs)?;
    let mut scene = tex::build(name, &options, floor)?;
    args.bounces.into_iter().for_each(|bounces| scene.show_only(bounces));
    subject::said(&scene.inputs, &mut inputs);
    let sky = subject::load_sky(args, &mut inputs)?;
    Ok((Job::Tex(Box::new(TexJob::new(scene, sky))), inputs))
}

//! Every built-in scene, in one list: a row lies next to the function that says what it shows.

use super::bump::BumpMap;
use super::surface::{Camera, Shape};
use super::{built_in, hit, tex};
use crate::error::InputError;
use crate::operation::{Needs, Operation};
use crate::stage::Stage;

/// A built-in scene: its name and its content.
#[derive(Clone, Copy, Debug)]
pub struct SceneInfo {
    /// The name on the command line.
    pub name: &'static str,
    /// What it shows, in one line.
    pub description: &'static str,
    /// Its parts.
    pub plan: Plan,
}

/// The content of a scene, by the operation that it uses.
#[derive(Clone, Copy, Debug)]
pub enum Plan {
    /// A reflector: camera and surface by the picture's columns and rows, and its bump map.
    Env(fn(usize, usize) -> (Camera, Shape), Option<fn() -> BumpMap>),
    /// A reflector in a world.
    Hit(fn() -> hit::Plan),
    /// Textured surfaces.
    Tex(fn() -> tex::Plan),
}

/// Every built-in scene, by operation.
pub const REGISTRY: [&[SceneInfo]; 3] = [built_in::SCENES, hit::HIT_SCENES, tex::TEX_SCENES];

/// Every built-in scene.
pub fn all() -> impl Iterator<Item = &'static SceneInfo> {
    REGISTRY.into_iter().flatten()
}

/// The names of scenes, for people.
#[must_use]
pub fn names<'a>(scenes: impl IntoIterator<Item = &'a SceneInfo>) -> String {
    let names: Vec<&str> = scenes.into_iter().map(|info| info.name).collect();
    names.join(", ")
}

/// The scene of that name.
///
/// # Errors
/// There is none.
pub fn find(name: &str) -> Result<&'static SceneInfo, InputError> {
    all().find(|info| info.name == name).ok_or_else(|| {
        InputError::new(
            "scene",
            format!("one of {}", names(all())),
            format!("`{name}`"),
            "`tapline scenes` lists them",
        )
    })
}

/// The scene of that name among those of one operation, which `kind` describes and `pick` tells from others.
pub(super) fn find_in<T>(
    kind: &str,
    pick: impl Fn(Plan) -> Option<T>,
    name: &str,
) -> Result<(&'static SceneInfo, T), InputError> {
    let known = || all().filter(|info| pick(info.plan).is_some());
    let found = known().find(|info| info.name == name);
    found.and_then(|info| Some((info, pick(info.plan)?))).ok_or_else(|| {
        InputError::new(
            "scene",
            format!("{kind}: {}", names(known())),
            format!("`{name}`"),
            "`tapline scenes` lists them",
        )
    })
}

impl SceneInfo {
    /// The operation that it uses as it stands; a bump map of the user's asks for more.
    #[must_use]
    pub fn operation(&self) -> Operation {
        match self.plan {
            Plan::Env(_, bump) => Operation::Env(needs(bump.is_some())),
            Plan::Hit(_) => Operation::Hit,
            Plan::Tex(_) => Operation::Tex,
        }
    }

    /// The stages that it needs as it stands.
    #[must_use]
    pub fn stages(&self) -> Vec<Stage> {
        self.operation().stages()
    }
}

/// What reflections with or without a bump map need: offsets come with their roughness.
#[must_use]
pub(super) const fn needs(bump: bool) -> Needs {
    Needs { bump, rough: bump }
}

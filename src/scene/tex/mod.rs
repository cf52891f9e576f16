//! Built-in scenes of the TEX operation: small path traces whose hits ask textures through ray cones.
//!
//! Surfaces show their texture by a daylight that depends on the normal alone, and paths end there or go on with a
//! share that is the same whatever the texture shows. A pixel is therefore a fixed weighted sum of texture requests,
//! and every engine's error is that of its filters.

mod built_in;
pub mod camera;
pub mod paint;
pub mod path;
pub mod shape;

use std::sync::Arc;

use glam::DVec3;

use super::registry::{self, SceneInfo, find_in};
use super::{SceneOptions, check_size};
use crate::base::num;
use crate::error::InputError;
use crate::mesh::Mesh;
use crate::planar::PlanarMap;
use crate::taken::Taken;
pub use built_in::TEX_SCENES;
use camera::{Camera, Lens};
use paint::Paint;
use path::Finish;
use shape::Shape;

/// Columns and rows of a procedural texture where nothing else is asked for.
pub const DEFAULT_TEXTURE: usize = 2048;
/// Largest procedural texture.
const MAX_PROCEDURAL: usize = 8192;

/// A scene of the TEX operation that is ready to be traced.
#[derive(Clone, Debug)]
pub struct TexScene {
    /// Its row in the registry.
    pub info: &'static SceneInfo,
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// The camera.
    pub camera: Camera,
    /// Paths through each pixel's centre.
    pub samples: u32,
    /// Most bounces of a path.
    pub bounces: u32,
    /// First and last bounce whose light alone counts; paths then go on to the last however little they still weigh.
    pub only: Option<[u32; 2]>,
    /// Surfaces and their effects on paths.
    pub surfaces: Vec<(Shape, Finish)>,
    /// Textures; the first is the floor's.
    pub textures: Vec<PlanarMap>,
    /// What the mesh file was taken for, if there is one.
    pub inputs: Vec<Taken>,
}

impl TexScene {
    /// Leaves the light of the first to the last of these bounces alone.
    pub fn show_only(&mut self, bounces: [u32; 2]) {
        self.only = Some(bounces);
        self.bounces = bounces[1];
    }

    /// Whether light of a bounce counts.
    fn shows(&self, bounce: u32) -> bool {
        self.only.is_none_or(|[first, last]| (first..=last).contains(&bounce))
    }
}

/// The content of a scene. A mesh stands in for the main surfaces.
#[derive(Debug)]
pub struct Plan {
    /// Where the camera stands.
    pub eye: DVec3,
    /// Where it looks.
    pub aim: DVec3,
    /// Tangent of half the angle of view.
    pub tangent: f64,
    /// Its lens.
    pub lens: Lens,
    /// Paths of a pixel.
    pub samples: u32,
    /// Most bounces of a path.
    pub bounces: u32,
    /// Surfaces that are always there.
    pub surfaces: Vec<(Shape, Finish)>,
    /// Surfaces that a mesh replaces.
    pub main: Vec<(Shape, Finish)>,
    /// The ball that it is fitted into.
    pub bound: (DVec3, f64),
}

/// Builds a scene of the TEX operation; `floor` takes the place of its procedural floor.
///
/// # Errors
/// An unknown name, a size that is zero or too large, a bump map (these scenes take none), a mesh that cannot be read.
pub fn build(
    name: &str,
    options: &SceneOptions,
    floor: Option<PlanarMap>,
) -> Result<TexScene, InputError> {
    let pick = |plan| match plan {
        registry::Plan::Tex(plan) => Some(plan),
        registry::Plan::Env(..) | registry::Plan::Hit(_) => None,
    };
    let (info, plan) = find_in("one with ray cones", pick, name)?;
    if options.bump.is_some() {
        return Err(InputError::new(
            "--bump",
            "a scene of the ENV operation",
            format!("`{name}`, whose surfaces are smooth"),
            "leave it out",
        ));
    }
    let SceneOptions { width, height, .. } = *options;
    check_size(width, height, 1)?;
    let side = options.face_size.unwrap_or(DEFAULT_TEXTURE);
    if !(1..=MAX_PROCEDURAL).contains(&side) {
        return Err(InputError::new(
            "--face-size",
            format!("textures of 1 to {MAX_PROCEDURAL} columns and rows"),
            side.to_string(),
            "choose another size",
        ));
    }
    let plan = plan();
    let mut inputs = Vec::new();
    let mut surfaces = plan.surfaces;
    match &options.mesh {
        None => surfaces.extend(plan.main),
        Some(path) => {
            let (centre, radius) = plan.bound;
            let (mesh, _, taken) = Mesh::load(path, options.mesh_up, centre, radius)?;
            inputs.push(taken);
            surfaces.push((Shape::Mesh(Arc::new(mesh)), Finish::Mirror));
        }
    }
    let size = [width, height].map(num::u32);
    let used = |finish: &Finish| match finish {
        Finish::Lit { texture } | Finish::Glazed { texture, .. } => *texture,
        Finish::Mirror | Finish::Glass { .. } => 0,
    };
    let second = surfaces.iter().any(|(_, finish)| used(finish) == 1);
    let mut textures = vec![floor.unwrap_or_else(|| Paint::Fields.texture(side))];
    if second {
        textures.push(Paint::Glaze.texture((side / 2).max(1)));
    }
    Ok(TexScene {
        info,
        width,
        height,
        camera: Camera::looking(plan.eye, plan.aim, plan.tangent, size, plan.lens),
        samples: plan.samples,
        bounces: plan.bounces,
        only: None,
        surfaces,
        textures,
        inputs,
    })
}

//! Built-in scenes of the HIT operation: a reflective object in a world, seen by a camera.

mod built_in;
pub mod object;
pub mod view;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::registry::{self, SceneInfo, find_in};
use super::world::World;
use super::world::bodies::Ball;
use super::world::light::Lamp;
use super::{DEFAULT_FACE_SIZE, SceneOptions, check_size};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::mesh::Mesh;
use crate::taken::Taken;
pub use built_in::{GLASS, HIT_SCENES};
use view::{Finish, View, look_at};

/// The unit's input for one ray of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// Column and row of the image, (0, 0) top left.
    pub pixel: [u32; 2],
    /// The ray.
    pub fragment: HitFragment,
    /// Linear RGB factor of the light that it finds: a pixel's colour is the weighted sum over its rays.
    pub weight: [f64; 3],
}

/// A scene of the HIT operation that is ready to be rendered.
#[derive(Clone, Debug)]
pub struct HitScene {
    /// Its row in the registry.
    pub info: &'static SceneInfo,
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// Texels along an edge of the impostor.
    pub face_size: usize,
    /// Rays through the centre of every pixel that shows the object, row by row; those of one pixel
    /// follow each other.
    pub rays: Vec<PixelRay>,
    /// Eye, object and world.
    pub view: View,
    /// A lamp whose light the object throws onto the walls.
    pub lamp: Option<Lamp>,
    /// Middle and radius of a ball around the object.
    pub bound: (DVec3, f64),
    /// What the mesh file was taken for, if there is one.
    pub inputs: Vec<Taken>,
}

impl HitScene {
    /// Moves the scene to the right and down by so many pixels.
    pub fn shift(&mut self, pixels: f64) {
        self.view.camera.shift(pixels);
        self.rays = rays(&self.view, self.width, self.height);
    }

    /// The pixels that show the object, row by row.
    #[must_use]
    pub fn pixels(&self) -> Vec<[u32; 2]> {
        let mut pixels: Vec<[u32; 2]> = self.rays.iter().map(|ray| ray.pixel).collect();
        pixels.dedup();
        pixels
    }
}

/// The content of a scene: a reflective ball in a world.
#[derive(Debug)]
pub struct Plan {
    /// What surrounds the ball.
    pub world: World,
    /// Where the camera stands; it looks at the ball.
    pub eye: DVec3,
    /// The ball's middle.
    pub centre: DVec3,
    /// The ball's radius.
    pub radius: f64,
    /// Radius of the ball's silhouette as a share of the picture's shorter side.
    pub share: f64,
    /// The ball's effect on light.
    pub finish: Finish,
    /// A lamp whose light the ball throws onto the walls.
    pub lamp: Option<Lamp>,
}

impl Plan {
    fn view(self, width: usize, height: usize) -> View {
        let Self { world, eye, centre, radius, share, finish, .. } = self;
        let tangent = radius / (centre.distance_squared(eye) - radius * radius).sqrt();
        let side = width.min(height) as f64;
        View {
            camera: look_at(eye, centre, [width, height], share * side / tangent),
            eye,
            object: Arc::new(Ball { centre, radius }),
            finish,
            world,
        }
    }
}

/// Builds a scene of the HIT operation.
///
/// # Errors
/// An unknown name, a size that is zero or too large, a bump map (these scenes take none), a mesh that cannot
/// be read.
pub fn build(name: &str, options: &SceneOptions) -> Result<HitScene, InputError> {
    let pick = |plan| match plan {
        registry::Plan::Hit(plan) => Some(plan),
        registry::Plan::Env(..) | registry::Plan::Tex(_) => None,
    };
    let (info, plan) = find_in("one with an impostor", pick, name)?;
    if options.bump.is_some() {
        return Err(InputError::new(
            "--bump",
            "a scene of the ENV operation",
            format!("`{name}`, whose object is smooth"),
            "leave it out",
        ));
    }
    let face_size = options.face_size.unwrap_or(DEFAULT_FACE_SIZE);
    let SceneOptions { width, height, .. } = *options;
    check_size(width, height, face_size)?;
    let plan = plan();
    let (lamp, bound) = (plan.lamp, (plan.centre, plan.radius));
    let mut view = plan.view(width, height);
    let mut inputs = Vec::new();
    if let Some(path) = &options.mesh {
        let (mesh, _, taken) = Mesh::load(path, options.mesh_up, bound.0, bound.1)?;
        inputs.push(taken);
        view.object = Arc::new(mesh);
    }
    let rays = rays(&view, width, height);
    Ok(HitScene { info, width, height, face_size, rays, view, lamp, bound, inputs })
}

fn rays(view: &View, width: usize, height: usize) -> Vec<PixelRay> {
    let rows: Vec<Vec<PixelRay>> = (0..height)
        .into_par_iter()
        .map(|row| {
            let mut found = Vec::new();
            for column in 0..width {
                let (Ok(x), Ok(y)) = (u32::try_from(column), u32::try_from(row)) else {
                    continue;
                };
                view.leaving(column as f64 + 0.5, row as f64 + 0.5, &mut |leaving| {
                    found.push(PixelRay {
                        pixel: [x, y],
                        fragment: leaving.fragment,
                        weight: leaving.weight,
                    });
                });
            }
            found
        })
        .collect();
    rows.concat()
}

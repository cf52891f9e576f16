//! Built-in scenes of the HIT operation: a reflective object in a world, seen by a camera.

pub mod object;
pub mod view;

use std::sync::Arc;

use rayon::prelude::*;

use super::world::bodies::Ball;
use super::world::built_in;
use super::world::light::Lamp;
use super::{DEFAULT_FACE_SIZE, SceneInfo, SceneOptions, check_size};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::mesh::Mesh;
use crate::stage::Stage;
use view::{Finish, View, look_at};

/// The stages of a scene that only hits.
const HIT: &[Stage] = &[
    Stage::CubeFace,
    Stage::Jacobian,
    Stage::RayCone,
    Stage::Hit,
    Stage::Covariance,
    Stage::Eigen,
    Stage::Footprint,
    Stage::Address,
    Stage::Filter,
];

/// Every built-in scene of the HIT operation.
pub const HIT_SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "room",
        description: "a mirror ball in a box room, off the impostor's reference point",
        operations: &["hit"],
        stages: HIT,
    },
    SceneInfo {
        name: "columns",
        description: "the ball among columns whose tops and backs the reference point does not see",
        operations: &["hit"],
        stages: HIT,
    },
    SceneInfo {
        name: "doorway",
        description: "the ball beside a doorway: the next room is seen through it, the near wall hides it",
        operations: &["hit"],
        stages: HIT,
    },
    SceneInfo {
        name: "glass",
        description: "a glass ball (n = 1.3) that reflects, refracts and throws a lamp's caustic onto the walls",
        operations: &["hit"],
        stages: HIT,
    },
];

/// Index of refraction of the scene `glass`.
pub const GLASS: f64 = 1.3;

/// The unit's input for one ray of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// Column and row of the image, (0, 0) top left.
    pub pixel: [u32; 2],
    /// The ray.
    pub fragment: HitFragment,
    /// Linear RGB factor of what it finds: a pixel's colour is the weighted sum over its rays.
    pub weight: [f64; 3],
}

/// A scene of the HIT operation that is ready to be rendered.
#[derive(Clone, Debug)]
pub struct HitScene {
    /// Its entry in [`HIT_SCENES`].
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
    pub bound: ([f64; 3], f64),
    /// What had to be said about the mesh file, if there is one.
    pub notes: Vec<String>,
}

impl HitScene {
    /// The pixels that show the object, row by row.
    #[must_use]
    pub fn pixels(&self) -> Vec<[u32; 2]> {
        let mut pixels: Vec<[u32; 2]> = self.rays.iter().map(|ray| ray.pixel).collect();
        pixels.dedup();
        pixels
    }
}

/// Eye, ball and world of a scene. The ball's silhouette has 0.45 of the picture's shorter side as its
/// radius. Second: the ball.
fn view(name: &str, width: usize, height: usize) -> (View, ([f64; 3], f64)) {
    let (world, eye, centre, radius): (_, [f64; 3], [f64; 3], f64) = match name {
        "columns" => (built_in::columns(), [-0.9, 1.0, 4.0], [0.7, 0.9, -1.5], 0.7),
        "doorway" => (built_in::doorway(), [-0.9, 0.6, 4.2], [1.5, -0.3, -1.0], 0.8),
        "glass" => (built_in::room(), [-2.2, 0.9, 3.6], [0.6, -0.7, -0.8], 0.9),
        _ => (built_in::room(), [-1.4, 0.5, 3.8], [1.6, -0.7, -2.0], 1.0),
    };
    let to = [0, 1, 2].map(|i| centre[i] - eye[i]);
    let square = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
    let tangent = radius / (square - radius * radius).sqrt();
    let side = width.min(height) as f64;
    // The caustic lies beside the ball: it gets more of the picture.
    let share = if name == "glass" { 0.3 } else { 0.45 };
    let view = View {
        camera: look_at(eye, centre, [width, height], share * side / tangent),
        eye,
        object: Arc::new(Ball { centre, radius }),
        finish: if name == "glass" { Finish::Glass { index: GLASS } } else { Finish::Mirror },
        world,
    };
    (view, (centre, radius))
}

/// Whether a name is that of a scene of the HIT operation.
#[must_use]
pub fn is_hit_scene(name: &str) -> bool {
    HIT_SCENES.iter().any(|info| info.name == name)
}

/// Builds a scene of the HIT operation.
///
/// # Errors
/// An unknown name, a size that is zero or too large, a bump map (these scenes take none), a mesh that cannot
/// be read.
pub fn build(name: &str, options: &SceneOptions) -> Result<HitScene, InputError> {
    let Some(info) = HIT_SCENES.iter().find(|info| info.name == name) else {
        let names: Vec<_> = HIT_SCENES.iter().map(|info| info.name).collect();
        return Err(InputError::new(
            "scene",
            format!("one with an impostor: {}", names.join(", ")),
            format!("`{name}`"),
            "`tapline scenes` lists them",
        ));
    };
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
    let (mut view, bound) = view(name, width, height);
    let mut notes = Vec::new();
    if let Some(path) = &options.mesh {
        let (mesh, repairs) = Mesh::load(path, bound.0, bound.1)?;
        notes.extend(repairs.note(&path.display().to_string()));
        view.object = Arc::new(mesh);
    }
    let rays = rays(&view, width, height);
    Ok(HitScene {
        info,
        width,
        height,
        face_size,
        rays,
        view,
        lamp: (name == "glass")
            .then_some(Lamp { position: [2.4, 2.2, 1.2], power: [150.0, 142.0, 128.0] }),
        bound,
        notes,
    })
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

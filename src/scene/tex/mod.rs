//! Built-in scenes of the TEX operation: small path traces whose hits ask textures through ray cones.
//!
//! Surfaces show their texture by a daylight that depends on the normal alone, and paths end there or go on with a
//! share that is the same whatever the texture shows. A pixel is therefore a fixed weighted sum of texture requests,
//! and every engine's error is that of its filters.

pub mod camera;
pub mod paint;
pub mod path;
pub mod shape;

use std::sync::Arc;

use super::{SceneInfo, SceneOptions, check_size};
use crate::base::num;
use crate::error::InputError;
use crate::mesh::Mesh;
use crate::planar::PlanarMap;
use crate::stage::Stage;
use camera::{Camera, Lens};
use paint::Paint;
use path::Finish;
use shape::Shape;

/// The stages of a scene that asks textures and the environment through cones.
const TEX: &[Stage] = &[
    Stage::CubeFace,
    Stage::Jacobian,
    Stage::RayCone,
    Stage::SurfaceFootprint,
    Stage::Covariance,
    Stage::Eigen,
    Stage::Footprint,
    Stage::Address,
    Stage::Filter,
];

const OPERATIONS: &[&str] = &["tex"];

/// Every built-in scene of the TEX operation.
pub const TEX_SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "convex",
        description: "mirror balls on a textured floor: reflections need far coarser levels than their distance says",
        operations: OPERATIONS,
        stages: TEX,
    },
    SceneInfo {
        name: "concave",
        description: "a hollow mirror that magnifies the floor: reflections need finer levels than their distance says",
        operations: OPERATIONS,
        stages: TEX,
    },
    SceneInfo {
        name: "thin-lens",
        description: "balls, a glass ball and cards through a wide lens: one cone vanishes in focus, two do not",
        operations: OPERATIONS,
        stages: TEX,
    },
    SceneInfo {
        name: "vases",
        description: "glazed vases whose hollow insides make cones converge bounce by bounce",
        operations: OPERATIONS,
        stages: TEX,
    },
    SceneInfo {
        name: "vases-lined",
        description: "the vases with a matt lining, which scatters and widens the cones",
        operations: OPERATIONS,
        stages: TEX,
    },
];

/// Columns and rows of a procedural texture where nothing else is asked for.
pub const DEFAULT_TEXTURE: usize = 2048;
/// Largest procedural texture.
const MAX_PROCEDURAL: usize = 8192;

/// A scene of the TEX operation that is ready to be traced.
#[derive(Clone, Debug)]
pub struct TexScene {
    /// Its entry in [`TEX_SCENES`].
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
    /// Whether paths go on however little they still weigh.
    pub endless: bool,
    /// Surfaces and what they do.
    pub surfaces: Vec<(Shape, Finish)>,
    /// Textures; the first is the floor's.
    pub textures: Vec<PlanarMap>,
    /// What had to be said about the mesh file, if there is one.
    pub notes: Vec<String>,
}

/// Whether a name is that of a scene of the TEX operation.
#[must_use]
pub fn is_tex_scene(name: &str) -> bool {
    TEX_SCENES.iter().any(|info| info.name == name)
}

const FLOOR: (Shape, Finish) = (Shape::Floor { half: 6.0 }, Finish::Lit { texture: 0 });

fn ball(centre: [f64; 3], radius: f64, finish: Finish) -> (Shape, Finish) {
    let shape = Shape::Shell { centre, radius, axis: [0.0, 1.0, 0.0], keep: 1.0 };
    (shape, finish)
}

/// What a scene holds: the camera's eye, aim, tangent and lens, samples, bounces, surfaces. A mesh stands in for what
/// lies in the ball of the second part.
struct Plan {
    eye: [f64; 3],
    aim: [f64; 3],
    tangent: f64,
    lens: Lens,
    samples: u32,
    bounces: u32,
    surfaces: Vec<(Shape, Finish)>,
    /// Surfaces that a mesh replaces, and the ball that it is fitted into.
    main: Vec<(Shape, Finish)>,
    bound: ([f64; 3], f64),
}

fn convex() -> Plan {
    let mut main = Vec::new();
    for row in 0..3 {
        for column in 0..3 {
            let at = |i: i32| 1.5 * f64::from(i - 1);
            main.push(ball([at(column), 0.6, at(row)], 0.6, Finish::Mirror));
        }
    }
    Plan {
        eye: [0.4, 3.4, 6.2],
        aim: [0.0, 0.5, 0.0],
        tangent: 0.36,
        lens: Lens::Pinhole,
        samples: 1,
        bounces: 8,
        surfaces: vec![FLOOR],
        main,
        bound: ([0.0, 1.2, 0.0], 1.2),
    }
}

fn concave() -> Plan {
    // A mirror of radius 5 behind the middle of the floor, tilted down a little; its focus is 2.5 in front of it.
    let tilt: (f64, f64) = (0.28, 0.96);
    Plan {
        eye: [0.5, 2.2, 4.6],
        aim: [0.0, 1.1, -2.0],
        tangent: 0.34,
        lens: Lens::Pinhole,
        samples: 1,
        bounces: 8,
        surfaces: vec![FLOOR],
        main: vec![(
            Shape::Shell {
                centre: [0.0, 1.2 - 5.0 * tilt.0, -3.0 + 5.0 * tilt.1],
                radius: 5.0,
                // Only what lies against the axis stays: a cap of 22° about the middle.
                axis: [0.0, -tilt.0, tilt.1],
                keep: -0.927,
            },
            Finish::Mirror,
        )],
        bound: ([0.0, 1.5, -2.0], 1.5),
    }
}

fn thin_lens() -> Plan {
    let card = |x: f64, z: f64| {
        let shape = Shape::Card {
            corner: [x - 0.6, 1.3, z],
            across: [1.2, 0.0, 0.25],
            down: [0.0, -1.3, 0.0],
        };
        (shape, Finish::Lit { texture: 1 })
    };
    Plan {
        eye: [0.3, 1.9, 5.2],
        aim: [0.0, 0.6, 0.0],
        tangent: 0.34,
        lens: Lens::Thin { width: 0.2 },
        samples: 16,
        bounces: 8,
        surfaces: vec![
            FLOOR,
            card(-1.9, -1.2),
            card(1.9, 0.6),
            card(0.0, -4.0),
            ball([1.0, 0.45, 2.2], 0.45, Finish::Glass { index: 1.5 }),
            ball([-1.1, 0.5, 1.4], 0.5, Finish::Mirror),
        ],
        main: vec![ball([0.0, 0.8, -0.6], 0.8, Finish::Mirror)],
        bound: ([0.0, 0.8, -0.6], 0.8),
    }
}

fn vases(lined: bool) -> Plan {
    let mut main = Vec::new();
    for (x, z, radius) in [(-1.4, 0.3, 0.8), (0.3, -0.9, 1.0), (1.5, 0.7, 0.7)] {
        let finish = Finish::Glazed { texture: 1, share: 0.6, lined };
        // A belly with an opening of half its radius, and a neck on it.
        let keep: f64 = 0.866_025_403_784_438_6;
        main.push((
            Shape::Shell { centre: [x, radius, z], radius, axis: [0.0, 1.0, 0.0], keep },
            finish,
        ));
        main.push((
            Shape::Tube {
                base: [x, radius * (1.0 + keep), z],
                radius: 0.5 * radius,
                height: 0.25 * radius,
            },
            finish,
        ));
    }
    Plan {
        eye: [0.3, 5.2, 4.4],
        aim: [0.1, 0.9, 0.0],
        tangent: 0.36,
        lens: Lens::Pinhole,
        samples: 4,
        bounces: 16,
        surfaces: vec![FLOOR],
        main,
        bound: ([0.0, 1.2, 0.0], 1.2),
    }
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
    let Some(info) = TEX_SCENES.iter().find(|info| info.name == name) else {
        let names: Vec<_> = TEX_SCENES.iter().map(|info| info.name).collect();
        return Err(InputError::new(
            "scene",
            format!("one with ray cones: {}", names.join(", ")),
            format!("`{name}`"),
            "`tapline scenes` lists them",
        ));
    };
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
    let plan = match name {
        "concave" => concave(),
        "thin-lens" => thin_lens(),
        "vases" => vases(false),
        "vases-lined" => vases(true),
        _ => convex(),
    };
    let mut notes = Vec::new();
    let mut surfaces = plan.surfaces;
    match &options.mesh {
        None => surfaces.extend(plan.main),
        Some(path) => {
            let (centre, radius) = plan.bound;
            let (mesh, repairs) = Mesh::load(path, centre, radius)?;
            notes.extend(repairs.note(&path.display().to_string()));
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
        endless: false,
        surfaces,
        textures,
        notes,
    })
}

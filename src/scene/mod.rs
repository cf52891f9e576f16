//! Built-in scenes: an analytic surface, a camera and, where the scene has one, a bump map.

mod built_in;
pub mod bump;
pub mod bump_kind;
pub mod bump_maps;
pub mod environment;
pub mod hit;
pub mod moments;
pub mod pyramid;
pub mod registry;
pub mod surface;
pub mod tex;
pub mod world;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::base::dual::{Dual, values};
use crate::cube::CubeLevel;
use crate::error::InputError;
use crate::fragment::{Fragment, PixelFragment};
use crate::mesh::{Mesh, Up};
use crate::operation::Operation;
use crate::settings::Settings;
use crate::stage::Stage;
use crate::taken::Taken;
pub use built_in::SCENES;
use bump::{BumpMap, BumpSource};
use pyramid::Pyramid;
use registry::{Plan, find_in, needs};
pub use registry::{REGISTRY, SceneInfo};
use surface::{Camera, Shape};

/// Texels along an edge of the procedural environment where nothing else is asked for.
pub const DEFAULT_FACE_SIZE: usize = 256;

/// Columns and rows of a picture where nothing else is asked for.
pub const DEFAULT_SIZE: usize = 512;

/// Most columns or rows of a picture, and most pixels.
const MAX_SIDE: usize = 16384;
const MAX_PIXELS: usize = 1 << 26;

/// Largest procedural environment: 4096² × 6 texels of 12 bytes are 1.2 GB.
const MAX_FACE_SIZE: usize = 4096;

/// A user's choices about a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneOptions {
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// Texels along an edge of the procedural environment; `None` takes [`DEFAULT_FACE_SIZE`].
    pub face_size: Option<usize>,
    /// A bump map instead of the scene's own, or for a scene that has none.
    pub bump: Option<BumpSource>,
    /// A mesh file instead of the scene's ball.
    pub mesh: Option<PathBuf>,
    /// The axis of the mesh that points up.
    pub mesh_up: Up,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            width: DEFAULT_SIZE,
            height: DEFAULT_SIZE,
            face_size: None,
            bump: None,
            mesh: None,
            mesh_up: Up::Y,
        }
    }
}

/// A scene that is ready to be rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its row in the registry.
    pub info: &'static SceneInfo,
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// Texels along an edge of the procedural environment.
    pub face_size: usize,
    /// Inputs of the unit for every pixel whose centre meets the surface, row by row.
    pub fragments: Vec<PixelFragment>,
    /// The surface as rays see it.
    pub surface: Surface,
    /// What the mesh file was taken for, if there is one.
    pub inputs: Vec<Taken>,
}

impl Scene {
    /// The stages that this scene needs: with a bump map those of roughness, too.
    #[must_use]
    pub fn stages(&self) -> Vec<Stage> {
        Operation::Env(needs(self.surface.pyramid.is_some())).stages()
    }

    /// Moves the scene to the right and down by so many pixels.
    pub fn shift(&mut self, pixels: f64) {
        self.surface.camera.shift(pixels);
        self.fragments = fragments(&self.surface, self.width, self.height);
    }

    /// Level 0 of the procedural environment.
    #[must_use]
    pub fn environment(&self) -> CubeLevel {
        environment::procedural(self.face_size)
    }

    /// The viewing direction (from the eye) through the centre of a pixel: what the picture shows where
    /// there is no fragment. Not normalised.
    #[must_use]
    pub fn background(&self, column: usize, row: usize) -> [f64; 3] {
        self.surface.camera.ray(column as f64 + 0.5, row as f64 + 0.5)
    }
}

/// A camera, a shape and its bump map: everything that a ray needs.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The camera.
    pub camera: Camera,
    /// The shape.
    pub shape: Shape,
    /// The bump map with its filtered levels, if there is one.
    pub pyramid: Option<Arc<Pyramid>>,
}

impl Surface {
    /// Direction of the ray reflected at an image position (pixels from the top left corner), by the
    /// exact surface and the unfiltered bump map; `None` where the surface is missed. Not normalised.
    ///
    /// Unfiltered means: level 0, bilinear between texels.
    #[inline]
    #[must_use]
    pub fn shade_point(&self, px: f64, py: f64) -> Option<DVec3> {
        let ray = self.camera.ray(px, py);
        let hit = self.shape.hit(ray, self.pyramid.is_some())?;
        let (v, mut n) = (-DVec3::from(ray), DVec3::from(hit.n));
        if let Some(pyramid) = &self.pyramid {
            let [b1, b2] = pyramid.map().bilinear(hit.st[0], hit.st[1]);
            let (e1, e2) = local_frame(n, hit.h);
            let b2 = if hit.mirrored { -b2 } else { b2 };
            n = n + b1 * e1 + b2 * e2;
        }
        Some(2.0 * n * v.dot(n) - v * n.length_squared())
    }

    /// The unit's input at an image position; `None` where the surface is missed.
    #[must_use]
    pub fn fragment(&self, px: f64, py: f64) -> Option<Fragment> {
        let (dx, dy) = (Dual { value: px, dx: 1.0, dy: 0.0 }, Dual { value: py, dx: 0.0, dy: 1.0 });
        let ray = self.camera.ray(dx, dy);
        let hit = self.shape.hit(ray, self.pyramid.is_some())?;
        let n = values(hit.n);
        let mut fragment = Fragment {
            v: ray.map(|c| -c.value),
            n: n.to_array(),
            dv_dx: ray.map(|c| -c.dx),
            dv_dy: ray.map(|c| -c.dy),
            dn_dx: hit.n.map(|c| c.dx),
            dn_dy: hit.n.map(|c| c.dy),
            h: None,
            bump: None,
            rough: None,
        };
        if let Some(pyramid) = &self.pyramid {
            let h = hit.h;
            let [s, t] = hit.st;
            let lod = pyramid.lod([s.dx, t.dx], [s.dy, t.dy]);
            let mut filtered = pyramid.look_up(s.value, t.value, lod);
            if hit.mirrored {
                filtered.turn_b2();
            }
            let (e1, e2) = local_frame(n, h);
            let [by_s, by_t] = filtered.slope;
            let bend = |dn: &mut [f64; 3], ds: f64, dt: f64| {
                let [b1, b2] = [0, 1].map(|i| by_s[i] * ds + by_t[i] * dt);
                *dn = (DVec3::from(*dn) + (b1 * e1 + b2 * e2)).to_array();
            };
            bend(&mut fragment.dn_dx, s.dx, t.dx);
            bend(&mut fragment.dn_dy, s.dy, t.dy);
            fragment.h = Some(h.to_array());
            fragment.bump = Some(filtered.bump);
            fragment.rough = Some(filtered.rough);
        }
        Some(fragment)
    }
}

/// e1 = (h × n)/|h × n|·|n| and e2 = (n × e1)/|n|; for h parallel to n any orthogonal pair.
#[inline]
#[must_use]
pub fn local_frame(n: DVec3, h: DVec3) -> (DVec3, DVec3) {
    let mut side = h.cross(n);
    if side.length_squared() <= 0.0 {
        let other = if n.x.abs() < n.y.abs() { DVec3::X } else { DVec3::Y };
        side = other.cross(n);
    }
    let length = n.length();
    let e1 = side * (length / side.length());
    (e1, n.cross(e1) / length)
}

/// Builds a scene: its fragments depend on nothing but its name, the options and the two roughness
/// policies of the settings.
///
/// # Errors
/// An unknown name, a size that is zero or too large, a bump source that is not complete.
pub fn build(name: &str, options: &SceneOptions, settings: &Settings) -> Result<Scene, InputError> {
    let pick = |plan| match plan {
        Plan::Env(view, bump) => Some((view, bump)),
        Plan::Hit(_) | Plan::Tex(_) => None,
    };
    let (info, (view, own_bump)) = find_in("one of the ENV operation", pick, name)?;
    let SceneOptions { width, height, .. } = *options;
    let face_size = options.face_size.unwrap_or(DEFAULT_FACE_SIZE);
    check_size(width, height, face_size)?;
    let map = match &options.bump {
        Some(source) => Some(BumpMap::new(source)?),
        None => own_bump.map(|bump| bump()),
    };
    let pyramid = map.map(|map| {
        Arc::new(Pyramid::new(
            Arc::new(map),
            settings.policy.roughness.curvature,
            settings.policy.roughness.interpolate,
        ))
    });
    let (camera, mut shape) = view(width, height);
    let mut inputs = Vec::new();
    if let Some(path) = &options.mesh {
        let (mesh, taken) = mesh_for((path, options.mesh_up), info, &shape, pyramid.is_some())?;
        inputs.push(taken);
        shape = Shape::Mesh(Arc::new(mesh));
    }
    let surface = Surface { camera, shape, pyramid };
    let fragments = fragments(&surface, width, height);
    Ok(Scene { info, width, height, face_size, fragments, surface, inputs })
}

/// The mesh that takes the place of a scene's ball, and what its file was taken for.
fn mesh_for(
    (path, up): (&Path, Up),
    info: &SceneInfo,
    shape: &Shape,
    textured: bool,
) -> Result<(Mesh, Taken), InputError> {
    let Shape::Sphere { centre, radius, .. } = *shape else {
        return Err(InputError::new(
            "--mesh",
            "a scene whose reflector is a ball, such as sphere",
            format!("scene `{}`", info.name),
            "leave it out or choose another scene",
        ));
    };
    let subject = path.display().to_string();
    let (mesh, _, taken) = Mesh::load(path, up, centre, radius)?;
    if textured && mesh.untextured() > 0 {
        return Err(InputError::new(
            subject,
            "texture coordinates at every corner, for --bump",
            format!("{} of {} triangles without", mesh.untextured(), mesh.triangles().len()),
            "leave --bump out or export the mesh with texture coordinates",
        ));
    }
    Ok((mesh, taken))
}

/// Refuses pictures and procedural environments without texels or too large for memory.
fn check_size(width: usize, height: usize, face_size: usize) -> Result<(), InputError> {
    let side = 1..=MAX_SIDE;
    if !side.contains(&width) || !side.contains(&height) || width * height > MAX_PIXELS {
        return Err(InputError::new(
            "picture size",
            format!("1 to {MAX_SIDE} pixels a side, {MAX_PIXELS} in all"),
            format!("{width}x{height}"),
            "choose another --size",
        ));
    }
    if !(1..=MAX_FACE_SIZE).contains(&face_size) {
        return Err(InputError::new(
            "face size",
            format!("1 to {MAX_FACE_SIZE} texels"),
            face_size.to_string(),
            "choose another --face-size",
        ));
    }
    Ok(())
}

/// The fragments of every pixel whose centre meets the surface, row by row.
fn fragments(surface: &Surface, width: usize, height: usize) -> Vec<PixelFragment> {
    let rows: Vec<Vec<PixelFragment>> = (0..height)
        .into_par_iter()
        .map(|row| {
            (0..width)
                .filter_map(|column| {
                    let fragment = surface.fragment(column as f64 + 0.5, row as f64 + 0.5)?;
                    let pixel = [u32::try_from(column).ok()?, u32::try_from(row).ok()?];
                    Some(PixelFragment { pixel, fragment })
                })
                .collect()
        })
        .collect();
    rows.concat()
}

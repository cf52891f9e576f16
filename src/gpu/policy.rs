//! The uniform that every kernel reads: the unit's choices and the sizes of the maps, word by word.

use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::planar::PlanarMap;
use crate::policy::{ConeMetric, Weights};
use crate::scene::tex::camera::{Camera, Lens};
use crate::settings::Settings;

/// Most probes that a kernel takes, whatever the settings say.
pub const MOST_PROBES: u32 = 1024;

/// `Policy` of `policy.wgsl`. Numbers of the choices count as the enumerations of `rtl_model/src/policy.rs` do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Policy {
    rotation: [[f32; 4]; 3],
    half_edges: [f32; 4],
    camera: [[f32; 4]; 3],
    /// Fragments of the dispatch.
    pub fragments: u32,
    /// Words of a fragment's input.
    pub input_words: u32,
    /// Words of a fragment's output.
    pub output_words: u32,
    rotated: bool,
    /// Whether fragments have a bump.
    pub bump: bool,
    /// Whether fragments have a roughness.
    pub rough: bool,
    roughness_scale: f32,
    dnmod: u32,
    minor: u32,
    axis: u32,
    count: u32,
    /// Most probes of a fragment.
    pub max_probes: u32,
    /// Columns and rows of level 0.
    pub size: [u32; 2],
    /// Levels of the mip chain.
    pub levels: u32,
    weighted: bool,
    /// Where the probes' weights start in the tables.
    weights: u32,
    angled: bool,
    angles: u32,
    boundaries: u32,
    angle_order: u32,
    tan_step: f32,
    /// Most look-ups of a search.
    pub iterations: u32,
    method: u32,
    tau: f32,
    look_up: u32,
    hit_footprint: u32,
    outside: u32,
    distance_kind: u32,
    distance_size: u32,
    cone_env: u32,
    cone_rules: u32,
    set_diffuse: u32,
    max_anisotropy: u32,
    gradient: u32,
    wrap: [u32; 2],
    cones: u32,
    by_distance: bool,
    lens: u32,
    picture: [u32; 2],
}

/// The nearest f32, the largest one of its sign beyond the range, 0 for NaN.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "rounding to f32 is what is wanted")]
pub fn to_f32(x: f64) -> f32 {
    if x.is_nan() {
        return 0.0;
    }
    (x as f32).clamp(-f32::MAX, f32::MAX) + 0.0
}

fn row(v: [f64; 3], last: f64) -> [f32; 4] {
    [v[0], v[1], v[2], last].map(to_f32)
}

fn small(n: usize) -> u32 {
    num::u32(n)
}

/// Numbers that a float engine makes of a unit's tables: probe weights and the angle table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// Weights of 1, 2, 3, … probes one after the other; empty where all weigh the same.
    pub weights: Vec<f32>,
    /// Cosines and sines: bin boundaries, entries and the one after the last, those of twice the angle.
    pub angles: Vec<[f32; 2]>,
    /// Bins less one.
    pub boundaries: usize,
    /// 0: nearest entry; 1: linear.
    pub angle_order: u32,
    /// tan of a step of twice the angle.
    pub tan_step: f32,
}

impl Tables {
    /// The buffer `tables`: weights, then the angle table.
    #[must_use]
    pub fn words(&self) -> Vec<f32> {
        let angles = self.angles.as_flattened();
        self.weights.iter().chain(angles).copied().collect()
    }
}

impl Policy {
    /// The choices of the settings, without any map.
    #[must_use]
    pub fn new(settings: &Settings, tables: &Tables) -> Self {
        let (s, policy) = (settings, &settings.policy);
        Self {
            rotation: s.rotation.map(|r| row(r, 0.0)),
            rotated: s.rotation != crate::settings::IDENTITY,
            roughness_scale: to_f32(s.roughness_scale),
            dnmod: policy.jacobian.dnmod as u32,
            minor: policy.eigen.minor as u32,
            axis: policy.footprint.axis as u32,
            count: policy.footprint.count as u32,
            max_probes: policy.footprint.max_probes.clamp(1, MOST_PROBES),
            size: [1, 1],
            levels: 1,
            weighted: policy.footprint.weights == Weights::Gaussian,
            weights: 0,
            angled: !tables.angles.is_empty(),
            angles: small(tables.weights.len()),
            boundaries: small(tables.boundaries),
            angle_order: tables.angle_order,
            tan_step: tables.tan_step,
            iterations: policy.hit.iterations,
            method: policy.hit.method as u32,
            tau: policy
                .hit
                .tolerance_bits
                .map_or(0.0, |bits| to_f32(1.0 / f64::from(1u32 << bits.min(31)))),
            look_up: policy.hit.lookup as u32,
            hit_footprint: policy.hit.footprint as u32,
            outside: policy.hit.outside as u32,
            distance_size: 1,
            cone_env: policy.cone.env as u32,
            cone_rules: policy.cone.rules as u32,
            set_diffuse: policy.cone.set_diffuse as u32,
            max_anisotropy: policy.surface_footprint.max_anisotropy.max(1),
            gradient: policy.cone.gradient as u32,
            wrap: policy.address.wrap().map(|wrap| wrap as u32),
            cones: policy.cone.count,
            by_distance: policy.cone.metric == ConeMetric::Distance,
            picture: [1, 1],
            ..Self::default()
        }
    }

    /// With a cube map of colours.
    #[must_use]
    pub fn with_cube(self, map: &CubeMap) -> Self {
        self.with_size([map.size(); 2], map.levels.len())
    }

    /// With a 2-D texture.
    #[must_use]
    pub fn with_planar(self, map: &PlanarMap) -> Self {
        self.with_size(map.size(), map.levels.len())
    }

    /// With a chain of `levels` whose level 0 has `size` texels.
    #[must_use]
    pub fn with_size(mut self, size: [usize; 2], levels: usize) -> Self {
        self.size = size.map(small);
        self.levels = small(levels).max(1);
        self
    }

    /// With a map of distances.
    #[must_use]
    pub fn with_distance(mut self, distance: &Distance) -> Self {
        match distance {
            Distance::Cube(cube) => {
                self.distance_kind = 0;
                self.distance_size = small(cube.size);
            }
            Distance::Box(half_edges) => {
                self.distance_kind = 1;
                self.half_edges = row(*half_edges, 0.0);
            }
            Distance::Sphere(radius) => {
                self.distance_kind = 2;
                self.half_edges = [to_f32(*radius), 0.0, 0.0, 0.0];
            }
        }
        self
    }

    /// With the camera whose rays start the cones.
    #[must_use]
    pub fn with_camera(mut self, camera: &Camera) -> Self {
        let (lens, width) = match camera.lens {
            Lens::Pinhole => (0, 0.0),
            Lens::Thin { width } => (1, width),
            Lens::Orthographic => (2, 0.0),
        };
        self.lens = lens;
        self.camera =
            [row(camera.u.into(), 0.0), row(camera.v.into(), 0.0), row(camera.w.into(), width)];
        self.picture = camera.size.map(|n| n.max(1));
        self
    }

    /// Every member of `Policy` in `policy.wgsl`, in order, with its words.
    #[must_use]
    pub fn members(&self) -> Vec<(&'static str, Vec<u32>)> {
        let floats = |v: [f32; 4]| v.map(f32::to_bits).to_vec();
        let one = |n: u32| vec![n];
        let flag = |b: bool| vec![u32::from(b)];
        let float = |x: f32| vec![x.to_bits()];
        vec![
            ("rotation_0", floats(self.rotation[0])),
            ("rotation_1", floats(self.rotation[1])),
            ("rotation_2", floats(self.rotation[2])),
            ("half_edges", floats(self.half_edges)),
            ("camera_u", floats(self.camera[0])),
            ("camera_v", floats(self.camera[1])),
            ("camera_w", floats(self.camera[2])),
            ("fragments", one(self.fragments)),
            ("input_words", one(self.input_words)),
            ("output_words", one(self.output_words)),
            ("rotated", flag(self.rotated)),
            ("bump", flag(self.bump)),
            ("rough", flag(self.rough)),
            ("roughness_scale", float(self.roughness_scale)),
            ("dnmod", one(self.dnmod)),
            ("minor", one(self.minor)),
            ("axis", one(self.axis)),
            ("count", one(self.count)),
            ("max_probes", one(self.max_probes)),
            ("size_x", one(self.size[0])),
            ("size_y", one(self.size[1])),
            ("levels", one(self.levels)),
            ("weighted", flag(self.weighted)),
            ("weights", one(self.weights)),
            ("angled", flag(self.angled)),
            ("angles", one(self.angles)),
            ("boundaries", one(self.boundaries)),
            ("angle_order", one(self.angle_order)),
            ("tan_step", float(self.tan_step)),
            ("iterations", one(self.iterations)),
            ("hit_method", one(self.method)),
            ("tau", float(self.tau)),
            ("look_up", one(self.look_up)),
            ("hit_footprint", one(self.hit_footprint)),
            ("outside", one(self.outside)),
            ("distance_kind", one(self.distance_kind)),
            ("distance_size", one(self.distance_size)),
            ("cone_env", one(self.cone_env)),
            ("cone_rules", one(self.cone_rules)),
            ("set_diffuse", one(self.set_diffuse)),
            ("max_anisotropy", one(self.max_anisotropy)),
            ("gradient", one(self.gradient)),
            ("wrap_x", one(self.wrap[0])),
            ("wrap_y", one(self.wrap[1])),
            ("cones", one(self.cones)),
            ("by_distance", flag(self.by_distance)),
            ("lens", one(self.lens)),
            ("columns", one(self.picture[0])),
            ("rows", one(self.picture[1])),
            ("unused_0", one(0)),
            ("unused_1", one(0)),
        ]
    }

    /// The bytes of the uniform.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let members = self.members().into_iter();
        members.flat_map(|(_, words)| words).flat_map(u32::to_le_bytes).collect()
    }
}

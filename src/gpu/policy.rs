//! The uniform that every kernel reads: the sizes of the maps and the unit's knobs, one list each.
//!
//! The WGSL struct and the constants of the choices are printed from the same lists as the bytes.

use std::fmt::Write as _;

use crate::base::num;
use crate::distance::Distance;
use crate::policy::{HitStatus, Legal, Place, Policy as Knobs, ROWS, Row};
use crate::scene::tex::camera::{Camera, Lens};
use crate::settings::Settings;

/// Most probes that a kernel takes, whatever the settings say.
pub const MOST_PROBES: u32 = 1024;

/// Numbers of the choices that are no knobs, by their place: prefix and names.
const CONSTANTS: [(&str, &[&str]); 3] = [
    ("STATUS", HitStatus::NAMES),
    ("DISTANCE", &["cube", "box", "sphere"]),
    ("LENS", &["pinhole", "thin", "orthographic"]),
];

/// A type of a member of the uniform: its name in WGSL and its words.
trait Member: Copy {
    const WGSL: &'static str;
    fn words(self) -> Vec<u32>;
}

impl Member for u32 {
    const WGSL: &'static str = "u32";
    fn words(self) -> Vec<u32> {
        vec![self]
    }
}

impl Member for bool {
    const WGSL: &'static str = "u32";
    fn words(self) -> Vec<u32> {
        vec![self.into()]
    }
}

impl Member for f32 {
    const WGSL: &'static str = "f32";
    fn words(self) -> Vec<u32> {
        vec![self.to_bits()]
    }
}

impl Member for [f32; 4] {
    const WGSL: &'static str = "vec4f";
    fn words(self) -> Vec<u32> {
        self.map(f32::to_bits).to_vec()
    }
}

/// A member of the uniform as it is printed and written.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it says.
    pub meaning: String,
    /// Name in WGSL.
    pub name: String,
    /// Type in WGSL.
    pub wgsl: &'static str,
    /// Its words.
    pub words: Vec<u32>,
}

macro_rules! uniform {
    ($($(#[doc = $doc:literal])* $name:ident: $ty:ty,)+) => {
        /// `Policy` of the kernels.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Policy {
            $($(#[doc = $doc])* pub $name: $ty,)+
            /// The knobs; kernels see those that all engines honour.
            pub knobs: Knobs,
        }

        impl Policy {
            fn own(&self) -> Vec<Entry> {
                vec![$(Entry {
                    meaning: concat!($($doc),*).trim().into(),
                    name: stringify!($name).into(),
                    wgsl: <$ty as Member>::WGSL,
                    words: self.$name.words(),
                }),+]
            }
        }
    };
}

uniform! {
    /// A row of the environment's rotation; used where `rotated` is not 0.
    rotation_0: [f32; 4],
    /// The next row.
    rotation_1: [f32; 4],
    /// The last row.
    rotation_2: [f32; 4],
    /// Half edges of a box of distances; x is a sphere's radius.
    half_edges: [f32; 4],
    /// The camera: half the view rectangle to the right.
    camera_u: [f32; 4],
    /// Half of it upwards.
    camera_v: [f32; 4],
    /// From the eye to its middle; w is the lens's width.
    camera_w: [f32; 4],
    /// Fragments of the dispatch.
    fragments: u32,
    /// Words of a fragment's input.
    input_words: u32,
    /// Words of a fragment's output.
    output_words: u32,
    /// Whether the environment is turned.
    rotated: bool,
    /// Whether fragments have a bump.
    bump: bool,
    /// Whether fragments have a roughness.
    rough: bool,
    /// s of K = D Dᵀ + s² K3.
    roughness_scale: f32,
    /// Columns of level 0.
    size_x: u32,
    /// Rows of level 0.
    size_y: u32,
    /// Levels of the mip chain.
    levels: u32,
    /// Whether the axis is to come from the angle table.
    angled: bool,
    /// Where that starts in `tables`, behind the probes' weights.
    angles: u32,
    /// Its bins less one.
    boundaries: u32,
    /// 0: nearest entry; 1: linear.
    angle_order: u32,
    /// tan of a step of twice the angle.
    tan_step: f32,
    /// τ of the search.
    tau: f32,
    /// Of which kind the distances are.
    distance_kind: u32,
    /// Texels along an edge of a cube of distances.
    distance_size: u32,
    /// Of which kind the camera's lens is.
    lens: u32,
    /// Columns of the picture.
    columns: u32,
    /// Rows of the picture.
    rows: u32,
}

/// Knobs that kernels see, with their names in WGSL.
fn shared() -> impl Iterator<Item = (String, &'static Row, fn(&Knobs) -> u32)> {
    ROWS.iter().filter(|row| row.all_engines).filter_map(|row| match row.place {
        Place::Policy(get, _) => Some((row.path.replace('.', "_"), row, get)),
        Place::Table(_) | Place::Scale | Place::Rotation => None,
    })
}

/// The struct `Policy` and the constants of the choices, for every kernel.
#[must_use]
pub fn wgsl() -> String {
    let mut out = String::from("struct Policy {\n");
    for Entry { meaning, name, wgsl, .. } in Policy::default().members() {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "    /// {meaning}\n    {name}: {wgsl},");
    }
    out.push_str("}\n");
    let mut constants = |prefix: &str, names: &[&str]| {
        for (number, name) in names.iter().enumerate() {
            let name = format!("{prefix}_{name}").to_uppercase().replace('-', "_");
            let _ = writeln!(out, "const {name}: u32 = {number}u;");
        }
    };
    for (name, row, _) in shared() {
        if let Legal::Names(names) = row.legal {
            constants(&name, names);
        }
    }
    for (prefix, names) in CONSTANTS {
        constants(prefix, names);
    }
    out
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
        let mut knobs = settings.policy;
        let probes = &mut knobs.footprint.max_probes;
        *probes = (*probes).clamp(1, MOST_PROBES);
        let anisotropy = &mut knobs.surface_footprint.max_anisotropy;
        *anisotropy = (*anisotropy).max(1);
        let tau = |bits: u32| to_f32(1.0 / f64::from(1u32 << bits.min(31)));
        let [rotation_0, rotation_1, rotation_2] = settings.rotation.map(|r| row(r, 0.0));
        Self {
            rotation_0,
            rotation_1,
            rotation_2,
            rotated: settings.rotation != crate::settings::IDENTITY,
            roughness_scale: to_f32(settings.roughness_scale),
            size_x: 1,
            size_y: 1,
            levels: 1,
            angled: !tables.angles.is_empty(),
            angles: num::u32(tables.weights.len()),
            boundaries: num::u32(tables.boundaries),
            angle_order: tables.angle_order,
            tan_step: tables.tan_step,
            tau: knobs.hit.tolerance_bits.map_or(0.0, tau),
            distance_size: 1,
            columns: 1,
            rows: 1,
            knobs,
            ..Self::default()
        }
    }

    /// With a chain of `levels` whose level 0 has `size` texels.
    #[must_use]
    pub fn with_size(mut self, size: [usize; 2], levels: usize) -> Self {
        [self.size_x, self.size_y] = size.map(num::u32);
        self.levels = num::u32(levels).max(1);
        self
    }

    /// With a map of distances.
    #[must_use]
    pub fn with_distance(mut self, distance: &Distance) -> Self {
        match distance {
            Distance::Cube(cube) => {
                self.distance_kind = 0;
                self.distance_size = num::u32(cube.size);
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
        self.camera_u = row(camera.u.into(), 0.0);
        self.camera_v = row(camera.v.into(), 0.0);
        self.camera_w = row(camera.w.into(), width);
        [self.columns, self.rows] = camera.size.map(|n| n.max(1));
        self
    }

    /// Every member, in order: those of this struct, the knobs, and what fills it to a multiple of 16 bytes.
    #[must_use]
    pub fn members(&self) -> Vec<Entry> {
        let mut out = self.own();
        let word = |meaning: &str, name, word| {
            let words = vec![word];
            Entry { meaning: meaning.into(), name, wgsl: "u32", words }
        };
        out.extend(shared().map(|(name, row, get)| word(row.meaning, name, get(&self.knobs))));
        let words: usize = out.iter().map(|entry| entry.words.len()).sum();
        let unused = 0..(4 - words % 4) % 4;
        out.extend(unused.map(|i| word("Fills the struct.", format!("unused_{i}"), 0)));
        out
    }

    /// The bytes of the uniform.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let members = self.members().into_iter();
        members.flat_map(|entry| entry.words).flat_map(u32::to_le_bytes).collect()
    }
}

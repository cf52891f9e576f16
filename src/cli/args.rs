//! Flags that several commands share.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::distance::Distance;
use crate::error::InputError;
use crate::gpu::Gpu;
use crate::image::{Layout, LoadOptions, Transfer, load_distance};
use crate::mesh::Up;
use crate::scene::bump_kind::{BumpChoice, BumpKind, Green};
use crate::scene::registry::names;
use crate::scene::tex::TEX_SCENES;
use crate::settings::Settings;
use crate::taken::Taken;
use crate::unit::{ReferenceAxis, UnitSpec, check, file};

/// Which unit.
#[derive(Clone, Debug, Args)]
pub(super) struct UnitArgs {
    /// Unit file in TOML (`-`: standard input), or preset:default, preset:schilling.
    #[arg(long, value_name = "FILE")]
    pub(super) unit: Option<String>,
    /// Change one path of the unit, such as footprint.max_probes=8; repeatable.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(super) sets: Vec<String>,
}

impl UnitArgs {
    /// The unit, checked: its configuration can be exact inside with every stage built.
    pub(super) fn load(&self) -> Result<UnitSpec, InputError> {
        let (spec, origins) = file::load(self.unit.as_deref(), &self.sets)?;
        origins.check(&spec, check)?;
        Ok(spec)
    }
}

/// Which scene, environment, bump map and size.
#[derive(Clone, Debug, Args)]
pub(super) struct SceneArgs {
    /// Environment map: EXR, HDR, PNG or JPEG; lat-long or cube.
    #[arg(long, value_name = "FILE")]
    pub(super) env: Option<PathBuf>,
    /// Shape of the environment map, instead of what its size, attributes and empty cells say.
    #[arg(long, value_enum, value_name = "LAYOUT", requires = "env")]
    pub(super) env_layout: Option<Layout>,
    /// Curve of the samples of --env and --texture, instead of what the file says.
    #[arg(long, value_enum, value_name = "CURVE")]
    pub(super) transfer: Option<Transfer>,
    /// Colour of what the data window of an EXR file leaves empty of its display window.
    #[arg(long, value_name = "R,G,B", value_parser = colour, allow_hyphen_values = true)]
    pub(super) fill: Option<[f32; 3]>,
    /// 2-D texture of the floor in scenes with ray cones: EXR, HDR, PNG or JPEG.
    #[arg(long, value_name = "FILE")]
    pub(super) texture: Option<PathBuf>,
    /// Light of these bounces alone in scenes with ray cones; paths go on to the last however little they weigh.
    #[arg(long, value_name = "FIRST-LAST", value_parser = crate::study::plan::bounces)]
    pub(super) bounces: Option<[u32; 2]>,
    /// Bump map: a height map (grey) or tangent-space normals (RGB).
    #[arg(long, value_name = "FILE")]
    pub(super) bump: Option<PathBuf>,
    /// What the bump map holds, instead of what the bulk of its texels shows.
    #[arg(long, value_enum, value_name = "KIND", requires = "bump")]
    pub(super) bump_kind: Option<BumpKind>,
    /// Where the green channel of a normal map points.
    #[arg(long, value_enum, value_name = "WAY", requires = "bump")]
    pub(super) bump_green: Option<Green>,
    /// Texels per unit of height (white) of a height map; a 64th of its width if not given.
    #[arg(long, value_name = "TEXELS", requires = "bump", allow_negative_numbers = true)]
    pub(super) bump_scale: Option<f64>,
    /// Texels along an edge of the cube map.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(super) face_size: Option<usize>,
    /// Picture size.
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size, allow_hyphen_values = true)]
    pub(super) size: (usize, usize),
    /// Exposure in stops for PNG files and for the metrics.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) exposure: f64,
    /// Largest image to read, in MiB of pixels.
    #[arg(long, value_name = "MIB", default_value_t = 512, allow_negative_numbers = true)]
    pub(super) max_image_mb: u64,
    /// Mesh instead of a scene's ball: Wavefront .obj, or glTF as .glb or .gltf.
    #[arg(long, value_name = "FILE")]
    pub(super) mesh: Option<PathBuf>,
    /// Axis of the mesh that points up.
    #[arg(long, value_enum, value_name = "AXIS", requires = "mesh")]
    pub(super) mesh_up: Option<Up>,
    /// Distances from the reference point for `hit` lines: box:HX,HY,HZ, sphere:R, or an EXR file
    /// (FILE.exr:CHANNEL names a channel; else `distance`, `Z` or `A`).
    #[arg(long, value_name = "MAP", num_args = 0..=1, allow_hyphen_values = true)]
    pub(super) distance: Option<Option<String>>,
    /// Distances of a file from here on mean that nothing is there.
    #[arg(long, value_name = "D", requires = "distance", allow_hyphen_values = true)]
    pub(super) distance_far: Option<f64>,
}

impl SceneArgs {
    /// A scene as it is built in, at no size.
    pub(super) fn plain() -> Self {
        Self {
            env: None,
            env_layout: None,
            transfer: None,
            fill: None,
            texture: None,
            bounces: None,
            bump: None,
            bump_kind: None,
            bump_green: None,
            bump_scale: None,
            face_size: None,
            size: (0, 0),
            exposure: 0.0,
            max_image_mb: 512,
            mesh: None,
            mesh_up: None,
            distance: None,
            distance_far: None,
        }
    }

    /// How images are loaded; a face size and a layout belong to the environment alone.
    pub(super) fn load_options(&self) -> Result<LoadOptions, InputError> {
        let images = [&self.env, &self.texture, &self.bump].iter().any(|path| path.is_some());
        let idle = match (self.transfer, self.fill) {
            (Some(_), _) if self.env.is_none() && self.texture.is_none() => "--transfer",
            (_, Some(_)) if !images => "--fill",
            _ => {
                return Ok(LoadOptions {
                    max_image_mb: self.max_image_mb,
                    transfer: self.transfer,
                    fill: self.fill,
                    ..LoadOptions::default()
                });
            }
        };
        let found = "no image that it is for";
        Err(InputError::new(idle, "--env or --texture beside it", found, "leave it out"))
    }

    /// The user's word about the bump map.
    pub(super) fn bump_choice(&self) -> BumpChoice {
        BumpChoice {
            kind: self.bump_kind,
            green: self.bump_green.unwrap_or_default(),
            scale: self.bump_scale,
        }
    }

    /// Refuses the first of `flags` that was given: nothing would read it without `expected`.
    pub(super) fn refuse_idle(&self, flags: &[&str], expected: &str) -> Result<(), InputError> {
        let given = [
            ("--env", self.env.is_some()),
            ("--texture", self.texture.is_some()),
            ("--bounces", self.bounces.is_some()),
            ("--bump", self.bump.is_some()),
            ("--face-size", self.face_size.is_some()),
            ("--mesh", self.mesh.is_some()),
            ("--distance", self.distance.is_some()),
        ];
        match given.into_iter().find(|(flag, given)| *given && flags.contains(flag)) {
            Some((flag, _)) => {
                Err(InputError::new(flag, expected, "nothing that reads it", "leave it out"))
            }
            None => Ok(()),
        }
    }

    /// Refuses `--texture` and `--bounces` where nothing would read them.
    pub(super) fn refuse_texture(&self) -> Result<(), InputError> {
        let flag = match (&self.texture, self.bounces) {
            (None, None) => return Ok(()),
            (Some(_), _) => "--texture",
            (None, Some(_)) => "--bounces",
        };
        Err(InputError::new(
            flag,
            "a scene with ray cones",
            "one that has no 2-D texture",
            format!("leave it out, or choose one of {}", names(TEX_SCENES)),
        ))
    }

    /// Refuses `--distance` where nothing would read it.
    pub(super) fn refuse_distance(&self) -> Result<(), InputError> {
        if self.distance.is_none() {
            return Ok(());
        }
        Err(InputError::new(
            "--distance",
            "`trace` with `hit` lines beside it",
            "a command whose scenes have no distances",
            "leave it out",
        ))
    }

    /// The distance map that was named: `box:…`, `sphere:…`, or an EXR file, `FILE.exr:CHANNEL` for one
    /// of its channels.
    pub(super) fn distance(&self) -> Result<Option<(Distance, Option<Taken>)>, InputError> {
        let Some(text) = &self.distance else {
            return Ok(None);
        };
        let text = text.as_deref().unwrap_or("");
        let far = self.distance_far;
        if let Some(far) = far
            && !(far.is_finite() && far > 0.0)
        {
            let found = far.to_string();
            return Err(InputError::new("--distance-far", "a distance above 0", found, ""));
        }
        if let Some(distance) = Distance::analytic(text) {
            if far.is_some() {
                return Err(InputError::new(
                    "--distance-far",
                    "a file of distances",
                    format!("`{text}`, which is exact everywhere"),
                    "leave it out",
                ));
            }
            return Ok(Some((distance?, None)));
        }
        if text.is_empty() {
            return Err(InputError::new(
                "--distance",
                "box:HX,HY,HZ, sphere:R, or an EXR file with distances",
                "nothing",
                "write for instance --distance box:3,2,4",
            ));
        }
        let options =
            LoadOptions { max_image_mb: self.max_image_mb, far, ..LoadOptions::default() };
        let loaded = load_distance(Path::new(text), &options)?;
        if let Some(note) = loaded.cleaned.note(text) {
            super::note(&note);
        }
        super::note(&loaded.taken.to_string());
        Ok(Some((Distance::Cube(loaded.map), Some(loaded.taken))))
    }
}

/// How the engines run.
#[derive(Clone, Debug, Args)]
pub(super) struct RunArgs {
    /// Threads; 0 takes all cores.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub(super) threads: usize,
    /// Axis of the float reference where the unit's comes from the table.
    #[arg(long, value_enum, default_value_t = ReferenceAxis::Exact)]
    pub(super) reference_axis: ReferenceAxis,
    #[command(flatten)]
    pub(super) adapter: AdapterArgs,
}

/// Which GPU.
#[derive(Clone, Debug, Args)]
pub(super) struct AdapterArgs {
    /// GPU adapter: its index in `tapline gpu list` or a part of its name.
    #[arg(long = "adapter", value_name = "NAME")]
    name: Option<String>,
}

impl AdapterArgs {
    /// Opens the adapter that was named, or the best one.
    pub(super) fn open(&self) -> Result<Gpu, InputError> {
        Ok(Gpu::open(self.name.as_deref())?)
    }

    /// Whether an adapter was named.
    pub(super) const fn is_named(&self) -> bool {
        self.name.is_some()
    }

    /// Refuses `--adapter` where nothing runs on a GPU.
    pub(super) fn refuse(&self) -> Result<(), InputError> {
        let Some(name) = &self.name else {
            return Ok(());
        };
        Err(InputError::new(
            "--adapter",
            "no adapter: nothing that was asked for runs on a GPU",
            format!("`{name}`"),
            "leave it out",
        ))
    }
}

/// Most threads that `--threads` takes.
const MAX_THREADS: usize = 1024;

/// Sets the number of threads; 0 takes all cores.
pub(super) fn threads(threads: usize) -> Result<(), InputError> {
    if threads > MAX_THREADS {
        return Err(InputError::new(
            "--threads",
            format!("0 to {MAX_THREADS} threads"),
            threads.to_string(),
            "0 takes all cores",
        ));
    }
    if threads > 0 {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|e| {
            InputError::new(
                "--threads",
                "a number of threads that can be started",
                e.to_string(),
                "ask for fewer",
            )
        })?;
    }
    Ok(())
}

impl RunArgs {
    /// Sets the number of threads.
    pub(super) fn prepare(&self) -> Result<(), InputError> {
        threads(self.threads)
    }

    /// The float engines' policies.
    pub(super) fn settings(&self, spec: &UnitSpec) -> Settings {
        spec.settings(self.reference_axis)
    }
}

pub(super) fn size(text: &str) -> Result<(usize, usize), String> {
    let parse = |t: &str| t.parse::<usize>().ok().filter(|n| *n > 0);
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((parse(w)?, parse(h)?)))
        .ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 512x512".into())
}

/// Three numbers, such as 0,0.5,1.
fn colour(text: &str) -> Result<[f32; 3], String> {
    let numbers: Option<Vec<f32>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|x: &f32| x.is_finite() && *x >= 0.0))
        .collect();
    numbers
        .and_then(|n| n.try_into().ok())
        .ok_or_else(|| "expected R,G,B in linear light, such as 0,0,0".into())
}

//! A study file: which unit, which scenes, which knobs over which values.
//!
//! Every key is known or refused with its line and column; every value of every axis is tried on the unit when the
//! file is read, so that a misspelt path fails before the first point.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::axis::{Axis, Values};
use super::measures::{COLUMNS, names};
use super::read::Reader;
use crate::base::hash::{hash_text, text_hash};
use crate::base::named::named;
use crate::base::num;
use crate::conformance::suite::matches;
use crate::engine::EngineKind;
use crate::error::InputError;
use crate::operation::Operation;
use crate::scene::registry::find;
use crate::unit::knobs::Value;
use crate::unit::{ReferenceAxis, UnitSpec, file};

named! {
    /// How points come from axes.
    pub enum Mode {
        /// Every combination.
        Grid = "grid",
        /// The first values of all axes, then the second ones, and so on.
        Zip = "zip",
        /// The unit itself, then every value of every axis alone.
        OneAtATime = "one-at-a-time",
        /// A number of points, each with a value of every axis drawn from the seed.
        Random = "random",
    }
}

/// One picture to render: a scene with its maps and sizes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The scene.
    pub scene: String,
    /// Columns and rows.
    pub size: (usize, usize),
    /// Environment file; the scene's own if not given.
    pub env: Option<PathBuf>,
    /// Texels along an edge of the cube map (or of the texture); the scene's default if not given.
    pub face_size: Option<usize>,
    /// First and last bounce whose light alone is seen.
    pub bounces: Option<[u32; 2]>,
}

/// Most bounces of a path.
const MOST_BOUNCES: u32 = 256;

/// A bounce, or the first and the last of several: `8`, `8-15`.
///
/// # Errors
/// What was expected.
pub fn bounces(text: &str) -> Result<[u32; 2], String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (first.parse(), last.parse()) {
        (Ok(first), Ok(last)) if first <= last && last <= MOST_BOUNCES => Ok([first, last]),
        _ => Err(format!("a bounce or FIRST-LAST, up to {MOST_BOUNCES}, such as 8-15")),
    }
}

/// A study, as its file says.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its name.
    pub title: String,
    /// The unit that axes change.
    pub unit: UnitSpec,
    /// The unit's file or preset, for commands; none for the default.
    pub unit_name: Option<String>,
    /// Settings that hold for all points, after the unit's own.
    pub sets: Vec<(String, Value)>,
    /// Pictures, in the order of the results.
    pub places: Vec<Place>,
    /// Axis of the float reference.
    pub reference_axis: ReferenceAxis,
    /// What the unit is compared with: f64 always, and the engines that the file names in addition.
    pub against: Vec<EngineKind>,
    /// Samples a pixel of `truth`.
    pub samples: u32,
    /// Exposure of the metrics in stops.
    pub exposure: f64,
    /// How points come from axes.
    pub mode: Mode,
    /// Points of [`Mode::Random`].
    pub count: usize,
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// The axes, in the order of the file.
    pub axes: Vec<Axis>,
    /// The figure that units are judged by; PSNR against truth, else f64, if not given.
    pub error: Option<String>,
    /// Columns to keep.
    pub metrics: Vec<String>,
    /// Hash of the file's text and of the unit: results of one study have the same.
    pub hash: String,
}

/// Most points of a study.
const MOST_POINTS: usize = 1_000_000;

impl Plan {
    /// Reads a study file.
    ///
    /// # Errors
    /// Whatever in it is not as it should be, with line and column.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        let text = file::read_text(path, "study file")?;
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        Self::parse(&file::name(path), &text, folder)
    }

    /// Reads a study file's text; names of files in it are relative to `folder`.
    ///
    /// # Errors
    /// Whatever in it is not as it should be, with line and column.
    pub fn parse(subject: &str, text: &str, folder: &Path) -> Result<Self, InputError> {
        let table = DeTable::parse(text).map_err(|e| {
            InputError::new(subject, "TOML", e.message(), "docs/studies.md has examples")
                .at(file::place(text, e.span().map_or(0, |s| s.start)))
        })?;
        let r = Reader::new(subject, text);
        let root = table.get_ref();
        r.only(root, KEYS)?;

        let unit_name = r.text(root, "unit")?.map(|name| {
            let is_file = !name.starts_with("preset:") && Path::new(&name).is_relative();
            if is_file { folder.join(name).display().to_string() } else { name }
        });
        let (mut unit, origins) = file::load(unit_name.as_deref(), &[])?;
        origins.check(&unit, crate::unit::check)?;
        let sets = sets(&r, root, &mut unit)?;

        let mut axes = Vec::new();
        for (entry, offset) in r.tables(root, "axis")? {
            axes.push(Axis::read(&r, entry, offset, &unit)?);
        }
        let named = r.literal(root, "mode", &Mode::ALL.map(Mode::name))?;
        let mode = Mode::ALL.into_iter().find(|mode| Some(mode.name()) == named);
        let mode = mode.unwrap_or(Mode::Grid);
        let count = r.whole(root, "count", 1, MOST_POINTS)?;
        if (mode == Mode::Random) != count.is_some() {
            let found = if count.is_some() { "a count" } else { "none" };
            return Err(r.error(
                root,
                "count",
                "a count of points with mode = \"random\", and only there",
                found,
            ));
        }
        check_axes(&r, root, mode, &axes)?;

        let seed = r.whole(root, "seed", 0, usize::MAX >> 1)?.unwrap_or(0);
        let mut plan = Self {
            title: r.text(root, "title")?.unwrap_or_else(|| "study".into()),
            unit_name,
            sets,
            places: places(&r, root, folder)?,
            reference_axis: match r.literal(root, "reference_axis", &["exact", "table"])? {
                Some("table") => ReferenceAxis::Table,
                Some(_) | None => ReferenceAxis::Exact,
            },
            against: against(&r, root)?,
            samples: u32::try_from(r.whole(root, "samples", 4, 65536)?.unwrap_or(256))
                .unwrap_or(256),
            exposure: r.real(root, "exposure", -64.0, 64.0)?.unwrap_or(0.0),
            mode,
            count: count.unwrap_or(0),
            seed: num::u64(seed),
            axes,
            error: figures(&r, root, "error")?.pop(),
            metrics: match figures(&r, root, "metrics")? {
                none if none.is_empty() => COLUMNS.iter().map(|c| c.name.into()).collect(),
                named => named,
            },
            hash: hash_text(text_hash(&format!("{}\n{}", unit.hash(), meaning(text)))),
            unit,
        };
        if plan.sets.is_empty() && plan.unit_name.as_deref() == Some("preset:default") {
            plan.unit_name = None;
        }
        Ok(plan)
    }
}

/// A study file without comments, line ends and order of keys.
fn meaning(text: &str) -> String {
    let table = toml::from_str::<toml::Table>(text);
    table.map_or_else(|_| text.to_string(), |table| table.to_string())
}

/// Keys of a study file.
const KEYS: &[&str] = &[
    "title",
    "unit",
    "set",
    "scenes",
    "size",
    "sizes",
    "envs",
    "face_sizes",
    "bounces",
    "reference_axis",
    "against",
    "samples",
    "exposure",
    "mode",
    "count",
    "seed",
    "metrics",
    "error",
    "axis",
];

/// Settings of `[set]`: full paths as quoted keys, or nested tables as in a unit file.
fn sets(
    r: &Reader<'_>,
    root: &DeTable<'_>,
    unit: &mut UnitSpec,
) -> Result<Vec<(String, Value)>, InputError> {
    let mut out: Vec<(String, Value, usize)> = Vec::new();
    let Some((table, _)) = r.table(root, "set")? else {
        return Ok(Vec::new());
    };
    flatten(r, "", table, &mut out)?;
    let mut tried = unit.clone();
    for (path, value, offset) in &out {
        tried.set_all([(path.as_str(), value)]).map_err(|e| r.located(*offset, path, e))?;
    }
    *unit = tried;
    Ok(out.into_iter().map(|(path, value, _)| (path, value)).collect())
}

fn flatten(
    r: &Reader<'_>,
    prefix: &str,
    table: &DeTable<'_>,
    out: &mut Vec<(String, Value, usize)>,
) -> Result<(), InputError> {
    for (key, value) in table {
        let path = if prefix.is_empty() {
            key.get_ref().to_string()
        } else {
            format!("{prefix}.{}", key.get_ref())
        };
        if let DeValue::Table(inner) = value.get_ref() {
            flatten(r, &path, inner, out)?;
        } else {
            let converted = r.value(value.get_ref(), value.span().start, &path)?;
            out.push((path, converted, value.span().start));
        }
    }
    Ok(())
}

/// Scenes × environments × face sizes × sizes × bounces.
fn places(r: &Reader<'_>, root: &DeTable<'_>, folder: &Path) -> Result<Vec<Place>, InputError> {
    let scenes = r.texts(root, "scenes")?;
    if scenes.is_empty() {
        return Err(r.error(
            root,
            "scenes",
            "one scene or more, such as scenes = [\"sphere\"]",
            "none",
        ));
    }
    for (scene, offset) in &scenes {
        if let Err(error) = find(scene) {
            return Err(r.at(*offset, "scenes", error.expected, error.found));
        }
    }
    let mut sizes = r.texts(root, "sizes")?;
    if let Some(size) = r.text(root, "size")? {
        if !sizes.is_empty() {
            return Err(r.error(root, "size", "`size` or `sizes`", "both"));
        }
        sizes.push((size, r.offset(root, "size")));
    }
    if sizes.is_empty() {
        sizes.push(("256x256".into(), 0));
    }
    let size = |(text, offset): &(String, usize)| {
        let part = |t: &str| t.parse::<usize>().ok().filter(|n| *n > 0);
        let parts = text.split_once(['x', 'X']).and_then(|(w, h)| Some((part(w)?, part(h)?)));
        parts.ok_or_else(|| {
            r.at(*offset, "size", "WIDTHxHEIGHT in pixels, such as 256x256", format!("`{text}`"))
        })
    };
    let sizes = sizes.iter().map(size).collect::<Result<Vec<_>, _>>()?;
    let env = |(name, _): &(String, usize)| match name.as_str() {
        "" | "procedural" => None,
        name => Some(folder.join(name)),
    };
    let mut envs: Vec<Option<PathBuf>> = r.texts(root, "envs")?.iter().map(env).collect();
    let mut faces: Vec<Option<usize>> =
        r.wholes(root, "face_sizes", 1, 16384)?.into_iter().map(Some).collect();
    if envs.is_empty() {
        envs.push(None);
    }
    if faces.is_empty() {
        faces.push(None);
    }
    let range = |(text, offset): &(String, usize)| {
        bounces(text).map_err(|expected| r.at(*offset, "bounces", expected, format!("`{text}`")))
    };
    let flat = |scene: &str| find(scene).is_ok_and(|info| info.operation() != Operation::Tex);
    let texts = r.texts(root, "bounces")?;
    let mut parts =
        texts.iter().map(|text| range(text).map(Some)).collect::<Result<Vec<_>, _>>()?;
    if parts.is_empty() {
        parts.push(None);
    } else if let Some((scene, offset)) = scenes.iter().find(|(scene, _)| flat(scene)) {
        let expected = "scenes with ray cones, which have bounces";
        return Err(r.at(*offset, "scenes", expected, format!("`{scene}`")));
    }
    let mut out = Vec::new();
    for (scene, _) in &scenes {
        for env in &envs {
            for face_size in &faces {
                for size in &sizes {
                    out.extend(parts.iter().map(|bounces| Place {
                        scene: scene.clone(),
                        size: *size,
                        env: env.clone(),
                        face_size: *face_size,
                        bounces: *bounces,
                    }));
                }
            }
        }
    }
    Ok(out)
}

fn against(r: &Reader<'_>, root: &DeTable<'_>) -> Result<Vec<EngineKind>, InputError> {
    let mut out = vec![EngineKind::F64];
    for (name, offset) in r.texts(root, "against")? {
        match name.as_str() {
            "f64" => {}
            "ewa" => out.push(EngineKind::Ewa),
            "truth" => out.push(EngineKind::Truth),
            _ => return Err(r.at(offset, "against", "f64, ewa or truth", format!("`{name}`"))),
        }
    }
    out.sort_unstable();
    out.dedup();
    Ok(out)
}

/// Names of figures; `*` stands for any characters.
fn figures(r: &Reader<'_>, root: &DeTable<'_>, key: &str) -> Result<Vec<String>, InputError> {
    let mut out = Vec::new();
    for (pattern, offset) in r.texts(root, key)? {
        let before = out.len();
        let named = names().into_iter().filter(|name| matches(&pattern, name));
        out.extend(named.map(String::from));
        if out.len() == before {
            let expected = format!("one of {}", names().join(", "));
            return Err(r.at(offset, key, expected, format!("`{pattern}`")));
        }
    }
    Ok(out)
}

/// What only all axes together can break.
fn check_axes(
    r: &Reader<'_>,
    root: &DeTable<'_>,
    mode: Mode,
    axes: &[Axis],
) -> Result<(), InputError> {
    if axes.is_empty() {
        return Err(r.error(
            root,
            "axis",
            "one axis or more: [[axis]] with a path and its values",
            "none",
        ));
    }
    for (index, axis) in axes.iter().enumerate() {
        let before = &axes[..index];
        if let Some(path) = axis.paths.iter().find(|p| before.iter().any(|a| a.paths.contains(p))) {
            return Err(r.at(
                axis.offset,
                "axis",
                "each path on one axis",
                format!("`{path}` on two"),
            ));
        }
        if mode == Mode::Zip && axis.len() != axes[0].len() {
            let expected = format!(
                "as many values as the first axis of mode = \"zip\" has, {}",
                axes[0].len()
            );
            return Err(r.at(axis.offset, "axis", expected, axis.len().to_string()));
        }
        if mode != Mode::Random && matches!(axis.values, Values::Drawn { .. }) && axis.is_empty() {
            let expected = "random = { from, to, count }: a count outside of mode = \"random\"";
            return Err(r.at(axis.offset, "axis", expected, "no count"));
        }
    }
    let points = axes.iter().map(Axis::len).try_fold(1usize, usize::checked_mul);
    if mode == Mode::Grid && points.is_none_or(|n| n > MOST_POINTS) {
        let found = points.map_or("more than can be counted".into(), |n| n.to_string());
        return Err(r.error(root, "axis", format!("at most {MOST_POINTS} points"), found));
    }
    Ok(())
}

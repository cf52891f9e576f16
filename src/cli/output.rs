//! Where results go: stdout, `--json`, picture files with a note of their origin.

use std::io::Write as _;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::Failure;
use crate::error::InputError;
use crate::image::write::{Sample, write_exr, write_png};
use crate::image::{OutputFolder, WholeFile};
use crate::picture::Picture;
use crate::unit::UnitSpec;
use crate::unit::knobs::Value as KnobValue;

/// What every output says about its origin.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    /// Hash of the unit.
    pub(super) unit_hash: String,
    /// Seed of whatever is random: truth's strata.
    pub(super) seed: u64,
}

impl Origin {
    pub(super) fn new(spec: &UnitSpec) -> Self {
        Self { unit_hash: spec.hash(), seed: 0 }
    }

    /// As attributes of an EXR or text of a PNG.
    pub(super) fn attributes(&self, what: &str) -> Vec<(String, String)> {
        [
            ("tapline.version", env!("CARGO_PKG_VERSION").to_string()),
            ("tapline.unit", self.unit_hash.clone()),
            ("tapline.seed", self.seed.to_string()),
            ("tapline.picture", what.to_string()),
        ]
        .map(|(k, v)| (k.to_string(), v))
        .to_vec()
    }

    /// As the first keys of a JSON object.
    pub(super) fn json(&self) -> Map<String, Value> {
        let mut map = Map::new();
        map.insert("version".into(), json!(env!("CARGO_PKG_VERSION")));
        map.insert("unit_hash".into(), json!(self.unit_hash));
        map.insert("seed".into(), json!(self.seed));
        map
    }

    /// An object with these keys behind the origin's.
    pub(super) fn object(&self, rest: Value) -> Value {
        let mut map = self.json();
        map.extend(rest.as_object().cloned().into_iter().flatten());
        Value::Object(map)
    }
}

/// Kinds of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Exr,
    Png,
}

impl Kind {
    pub(super) fn of(path: &Path) -> Result<Self, InputError> {
        if path.as_os_str() == "-" {
            return Ok(Self::Exr);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            other => Err(InputError::new(
                path.display().to_string(),
                "a name that ends in .exr or .png, or `-` for an EXR on stdout",
                other.map_or("no ending".into(), |e| format!(".{e}")),
                "choose one of the two",
            )),
        }
    }
}

/// Writes and commits a picture.
pub(super) fn write_picture(
    mut file: WholeFile,
    kind: Kind,
    picture: &Picture,
    exposure: f64,
    attributes: &[(String, String)],
    sample: Sample,
) -> Result<(), InputError> {
    file.write_with(|w| match kind {
        Kind::Exr => write_exr(w, picture, attributes, sample),
        Kind::Png => write_png(w, picture, exposure, attributes),
    })?;
    file.commit()?;
    Ok(())
}

/// The target of `--json`: a file whose path is checked at once, or stdout.
pub(super) enum JsonTarget {
    None,
    Stdout,
    File(WholeFile),
}

impl JsonTarget {
    pub(super) fn open(path: Option<&Path>) -> Result<Self, InputError> {
        Self::beside(path, None)
    }

    /// A target that may lie in a folder which the run makes.
    pub(super) fn beside(
        path: Option<&Path>,
        folder: Option<&OutputFolder>,
    ) -> Result<Self, InputError> {
        Ok(match (path, folder) {
            (None, _) => Self::None,
            (Some(path), _) if path.as_os_str() == "-" => Self::Stdout,
            (Some(path), None) => Self::File(WholeFile::create(path)?),
            (Some(path), Some(folder)) => Self::File(folder.at(path)?),
        })
    }

    /// Whether stdout belongs to the JSON, so that tables stay away.
    pub(super) fn takes_stdout(&self) -> bool {
        matches!(self, Self::Stdout)
    }

    pub(super) fn write(self, value: &Value) -> Result<(), Failure> {
        let text = format!("{value:#}");
        match self {
            Self::None => {}
            Self::Stdout => writeln!(std::io::stdout().lock(), "{text}")?,
            Self::File(mut file) => {
                file.write_with(|w| writeln!(w, "{text}"))?;
                file.commit()?;
            }
        }
        Ok(())
    }
}

/// A unit as nested JSON objects, as its TOML file has it.
pub(super) fn unit_json(spec: &UnitSpec) -> Value {
    let mut root = Map::new();
    for knob in spec.knobs() {
        let value = match knob.value {
            KnobValue::Integer(n) => json!(n),
            KnobValue::Float(x) => json!(x),
            KnobValue::Text(t) => json!(t),
            KnobValue::Numbers(v) => json!(v),
        };
        let parts: Vec<&str> = knob.path.split('.').collect();
        put(&mut root, &parts, value);
    }
    Value::Object(root)
}

/// Puts a value under a path of nested objects.
fn put(into: &mut Map<String, Value>, path: &[&str], value: Value) {
    match path {
        [] => {}
        [key] => {
            into.insert((*key).to_string(), value);
        }
        [table, rest @ ..] => {
            let slot =
                into.entry((*table).to_string()).or_insert_with(|| Value::Object(Map::new()));
            if let Value::Object(inner) = slot {
                put(inner, rest, value);
            }
        }
    }
}

/// The folder of `--out`, which is there or can be made.
pub(super) fn output_folder(path: &Path) -> Result<OutputFolder, InputError> {
    OutputFolder::create(path).map_err(|e| {
        InputError::new(
            path.display().to_string(),
            "a folder that can be made",
            e.to_string(),
            "check the path of --out",
        )
    })
}

//! All readers of user data, as functions of bytes.
//!
//! Fuzzing and the test that replays its corpus call the commands' own readers through this one door, so that a
//! reader which is not listed here is one that nobody attacks.

use std::io::Write as _;
use std::path::Path;

use crate::error::InputError;
use crate::image::{
    LoadOptions, load_bump_planes, load_distance, load_environment, load_planar_levels,
};
use crate::mesh::{Mesh, Up};
use crate::scene::bump_kind::{BumpChoice, source};
use crate::study::cost::CostModel;
use crate::study::plan::Plan;
use crate::unit::file;

/// One reader of user data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    /// `trace --input`: JSON lines, answered by `rtl` and `f64`.
    TraceLines,
    /// `--unit`: TOML, loaded, checked, written and loaded again.
    Unit,
    /// `--env`, `--texture` and `--bump`: EXR, Radiance, PNG and JPEG, told apart by their contents.
    Image,
    /// `--distance`: an EXR file of distances.
    Distance,
    /// `--mesh FILE.obj`.
    Obj,
    /// `--mesh FILE.glb`.
    Glb,
    /// `study FILE.toml`.
    Study,
    /// `--cost`: TOML, read, written and read again.
    Cost,
    /// `vectors check`: hexadecimal, JSON lines or words for `$readmemh`, against `rtl` and exact arithmetic.
    Vectors,
}

impl Reader {
    /// Every reader.
    pub const ALL: [Self; 9] = [
        Self::TraceLines,
        Self::Unit,
        Self::Image,
        Self::Distance,
        Self::Obj,
        Self::Glb,
        Self::Study,
        Self::Cost,
        Self::Vectors,
    ];

    /// The folder of its corpus, and its name for the fuzzer.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::TraceLines => "trace-lines",
            Self::Unit => "unit",
            Self::Image => "image",
            Self::Distance => "distance",
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::Study => "study",
            Self::Cost => "cost",
            Self::Vectors => "vectors",
        }
    }

    /// Reads `bytes` as the command would, with at most `max_image_mb` MiB of pixels in an image.
    ///
    /// # Errors
    /// What a user would be told.
    ///
    /// # Panics
    /// Where a unit or a cost model that loads does not load again from its own text: a defect, for a fuzzer to find.
    pub fn read(self, bytes: &[u8], max_image_mb: u64) -> Result<(), InputError> {
        let options = LoadOptions { max_image_mb, ..LoadOptions::default() };
        match self {
            Self::TraceLines => super::trace::answer(bytes),
            Self::Unit => {
                let text = String::from_utf8_lossy(bytes);
                let spec = file::from_toml("unit", &text)?;
                let again = file::from_toml("unit", &file::to_toml(&spec));
                assert_eq!(again.as_ref(), Ok(&spec), "a unit changes on its way through a file");
                crate::unit::check(&spec)
            }
            Self::Image => with_file("", bytes, |path| {
                load_planar_levels(path, &options)?;
                let _ = load_bump_planes(path, false, &options).map(|bump| {
                    source(bump.width, bump.height, &bump.planes, BumpChoice::default(), "bump")
                });
                load_environment(path, &options).map(|_| ())
            }),
            Self::Distance => {
                with_file(".exr", bytes, |path| load_distance(path, &options).map(|_| ()))
            }
            Self::Obj => with_file(".obj", bytes, load_mesh),
            Self::Glb => with_file(".glb", bytes, load_mesh),
            Self::Study => {
                let text = String::from_utf8_lossy(bytes);
                Plan::parse("study", &text, Path::new("")).map(|_| ())
            }
            Self::Cost => {
                let model = CostModel::parse("cost", &String::from_utf8_lossy(bytes))?;
                let again = CostModel::parse("cost", &model.to_toml());
                assert_eq!(again, Ok(model), "knobs change on their way through a file");
                Ok(())
            }
            Self::Vectors => super::vectors::answer(bytes),
        }
    }
}

fn load_mesh(path: &Path) -> Result<(), InputError> {
    Mesh::load(path, Up::Y, glam::DVec3::ZERO, 1.0).map(|_| ())
}

/// Readers of files get one, whose name ends like theirs.
fn with_file(
    ending: &str,
    bytes: &[u8],
    read: impl FnOnce(&Path) -> Result<(), InputError>,
) -> Result<(), InputError> {
    let unwritable = |e: std::io::Error| {
        InputError::new(
            "temporary file",
            "a folder for temporary files with room",
            e.to_string(),
            "set TMPDIR to another folder",
        )
    };
    let mut file = tempfile::Builder::new().suffix(ending).tempfile().map_err(unwritable)?;
    file.write_all(bytes).map_err(unwritable)?;
    read(file.path())
}

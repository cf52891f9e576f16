//! `impostor`: a scene's distance impostor as a file.

use std::path::PathBuf;

use super::Failure;
use super::output::Origin;
use crate::engine::job::lit::lit;
use crate::error::InputError;
use crate::image::whole::WholeFile;
use crate::impostor::write_impostor;
use crate::mesh::Up;
use crate::scene::SceneOptions;
use crate::scene::hit;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene with a world around it: room, columns, doorway.
    scene: Option<String>,
    /// EXR file: six faces stacked vertically; channels R G B, distance, wall.index, wall.u, wall.v.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Texels along an edge of a face.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    face_size: Option<usize>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let usage = |expected: &str| {
        InputError::new("impostor", expected, "none", "write `tapline impostor room -o room.exr`")
    };
    let scene = args.scene.as_ref().ok_or_else(|| usage("a scene"))?;
    let output = args.output.as_ref().ok_or_else(|| usage("an output file by -o"))?;
    let is_exr = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    if !is_exr {
        return Err(InputError::new(
            output.display().to_string(),
            "a name that ends in .exr",
            "another ending",
            "distances need a float format",
        )
        .into());
    }
    let options = SceneOptions {
        // The impostor does not depend on the picture.
        width: 1,
        height: 1,
        face_size: args.face_size,
        bump: None,
        mesh: None,
        mesh_up: Up::Y,
    };
    let mut scene = hit::build(scene, &options)?;
    let mut file = WholeFile::create(output)?;
    let impostor = lit(&mut scene).0;
    let origin = Origin::new(&UnitSpec::default());
    let attributes = origin.attributes(&format!("impostor of {}", scene.info.name));
    file.write_with(|w| write_impostor(w, &impostor, &attributes))?;
    file.commit()?;
    Ok(())
}

//! A mesh file of any kind, by its first bytes or by its name.

use std::io::Read as _;
use std::path::Path;

use super::{Soup, gltf_file, obj};
use crate::error::InputError;

/// Largest file in bytes.
pub(super) const MAX_BYTES: u64 = 256 << 20;

/// Most triangles of a mesh, after polygons are cut and instances repeated.
pub const MAX_TRIANGLES: usize = 1 << 22;

/// Reads a file of either kind.
pub(super) fn read(path: &Path, subject: &str) -> Result<(Soup, &'static str), InputError> {
    let unreadable = |e: std::io::Error| {
        InputError::new(subject, "a readable mesh file", e.to_string(), "check the path")
    };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(InputError::new(
            subject,
            format!("a file of at most {} MiB", MAX_BYTES >> 20),
            "a larger one",
            "simplify the mesh",
        ));
    }
    parse(&bytes, path, subject)
}

/// The soup of a file's bytes and its format: glTF binary by its magic, the others by their names.
fn parse(bytes: &[u8], path: &Path, subject: &str) -> Result<(Soup, &'static str), InputError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    if bytes.starts_with(b"glTF") {
        return Ok((gltf_file::parse(bytes, path, subject)?, "glTF binary"));
    }
    match extension.as_deref() {
        Some("obj") => Ok((obj::parse(bytes, subject)?, "Wavefront OBJ")),
        Some("gltf") => Ok((gltf_file::parse(bytes, path, subject)?, "glTF")),
        Some("glb") => Err(InputError::new(
            subject,
            "a glTF binary file, which begins with `glTF`",
            "other bytes",
            "export the mesh again as .glb",
        )
        .at("byte 0")),
        other => Err(InputError::new(
            subject,
            "a mesh in .obj, .glb or .gltf",
            other.map_or("a name without ending".into(), |e| format!(".{e}")),
            "convert the mesh to one of these",
        )),
    }
}

/// Refuses a triangle too many.
pub(super) fn admit(
    triangles: usize,
    subject: &str,
    place: impl Fn() -> String,
) -> Result<(), InputError> {
    if triangles <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(InputError::new(
        subject,
        format!("at most {MAX_TRIANGLES} triangles"),
        "more",
        "simplify the mesh",
    )
    .at(place()))
}

//! The bytes of glTF buffers: the binary chunk, inline, or files beside the mesh.

use std::borrow::Cow;
use std::io::Read as _;
use std::path::Path;

use base64::Engine as _;

use super::MAX_BYTES;
use crate::error::InputError;

/// Reads every buffer of a document. A file must lie in the mesh's own folder or below it.
///
/// # Errors
/// An inline buffer that is no base64, a file that is elsewhere or cannot be read, more than the size limit in all.
pub(super) fn read<'a>(
    document: &gltf::Document,
    chunk: Option<Cow<'a, [u8]>>,
    path: &Path,
    subject: &str,
) -> Result<Vec<Cow<'a, [u8]>>, InputError> {
    let mut chunk = chunk;
    let mut left = MAX_BYTES;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let fail = |expected: &str, found: String, remedy: &str| {
            InputError::new(subject, expected, found, remedy)
                .at(format!("buffers[{}].uri", buffer.index()))
        };
        let bytes: Cow<'a, [u8]> = match buffer.source() {
            gltf::buffer::Source::Bin => chunk.take().unwrap_or_default(),
            gltf::buffer::Source::Uri(uri) => {
                let start: String = uri.chars().take(40).collect();
                let bytes = match uri.strip_prefix("data:") {
                    Some(data) => data
                        .split_once(";base64,")
                        .and_then(|(_, text)| base64::prelude::BASE64_STANDARD.decode(text).ok())
                        .ok_or_else(|| {
                            fail("base64 data", start.clone(), "export the mesh again")
                        })?,
                    None => beside(path, uri, left).map_err(|found| {
                        let expected = "a file in the folder of the mesh, or below it";
                        let remedy = "put the buffer beside the mesh, or export as .glb";
                        fail(expected, format!("`{start}`: {found}"), remedy)
                    })?,
                };
                bytes.into()
            }
        };
        left = left.saturating_sub(bytes.len() as u64);
        if left == 0 {
            let expected = format!("at most {} MiB of buffers", MAX_BYTES >> 20);
            return Err(fail(&expected, "more".into(), "simplify the mesh"));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// The bytes of a file named relative to the mesh, percent-encoded.
fn beside(mesh: &Path, uri: &str, most: u64) -> Result<Vec<u8>, String> {
    let name = percent_decoded(uri).ok_or("no name of a file")?;
    let folder = mesh.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let text = |e: std::io::Error| e.to_string();
    let folder = folder.canonicalize().map_err(text)?;
    let path = folder.join(name).canonicalize().map_err(text)?;
    if !path.starts_with(&folder) {
        return Err("outside of the folder".into());
    }
    if !path.is_file() {
        return Err("no plain file".into());
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path).map_err(text)?.take(most).read_to_end(&mut bytes).map_err(text)?;
    Ok(bytes)
}

/// A name without its %XX; `None` where it is no UTF-8 or has a scheme.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut out = Vec::new();
    let mut bytes = uri.bytes();
    while let Some(byte) = bytes.next() {
        let digit = |b: Option<u8>| char::from(b?).to_digit(16);
        out.push(match byte {
            b'%' => u8::try_from(digit(bytes.next())? << 4 | digit(bytes.next())?).ok()?,
            other => other,
        });
    }
    String::from_utf8(out).ok().filter(|name| !name.contains("://") && !name.contains('\0'))
}

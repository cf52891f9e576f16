//! The planes of a bump map: one of heights, two or three of vectors.

use std::path::Path;

use super::limits::LoadOptions;
use super::load::{has_light, load_planar_for};
use super::planar::Colour;
use super::{colours, window};
use crate::error::InputError;
use crate::taken::Taken;

/// The planes of a bump map, as stored.
#[derive(Clone, Debug)]
pub struct BumpPlanes {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane (grey), two (R G, X Y, or grey and alpha) or three.
    pub planes: Vec<Vec<f32>>,
    /// What is known of the file; its kind is not.
    pub taken: Taken,
}

/// Loads the planes of a bump map. `with_alpha` takes alpha for the second of two channels where the picture is grey.
///
/// # Errors
/// As [`load_planar`](super::load_planar), and where neither a colour, nor a vector, nor a single channel is found.
pub fn load_bump_planes(
    path: &Path,
    with_alpha: bool,
    options: &LoadOptions,
) -> Result<BumpPlanes, InputError> {
    let subject = path.display().to_string();
    let suits = |names: &[&str], layer: Option<&str>| {
        has_light(names, layer).max(u8::from(colours::vector(names, layer).is_some()))
    };
    let mut planar = load_planar_for(path, options, &suits)?;
    let names: Vec<&str> = planar.channels.iter().map(|(n, _)| n.as_str()).collect();
    let layer = planar.layer.as_deref();
    let indices = match (colours::find(&names, layer), colours::vector(&names, layer)) {
        (Ok(Colour::Rgb(rgb)), _) => rgb.to_vec(),
        (Ok(Colour::Grey(y)), _) => {
            let alpha = names.iter().position(|n| *n == "A").filter(|a| with_alpha && *a != y);
            std::iter::once(y).chain(alpha).collect()
        }
        (Err(_), Some(vector)) => vector,
        (Err(_), None) if names.len() == 1 => vec![0],
        (Err(_), None) => planar.colour(&subject).map(|c| c.planes().to_vec())?,
    };
    let list = indices.iter().map(|i| names[*i]).collect::<Vec<_>>().join(" ");
    let fitted = window::fitted(&planar, options, &subject)?;
    let part = planar.part.as_ref().map(|p| format!(" of part \"{p}\"")).unwrap_or_default();
    let taken = Taken {
        option: "--bump",
        file: subject.clone(),
        from: format!("channels {list}{part}"),
        transfer: "codes as stored".into(),
        window: fitted.words.clone(),
        remarks: std::mem::take(&mut planar.remarks),
        flags: &["--bump-kind", "--bump-green", "--bump-scale", "FILE.exr:NAME"],
        ..Taken::default()
    };
    let fill = options.fill.unwrap_or_default();
    let mut planes = Vec::new();
    for (index, fill) in indices.into_iter().zip(fill) {
        let plane = std::mem::take(&mut planar.channels[index].1);
        planes.push(fitted.plane(plane, fill, &subject)?);
    }
    let [width, height] = fitted.size;
    Ok(BumpPlanes { width, height, planes, taken })
}

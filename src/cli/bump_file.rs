//! `--bump FILE`: heights or tangent-space normals.

use std::path::Path;

use crate::error::InputError;
use crate::image::planar::Colour;
use crate::image::{LoadOptions, load_planar};
use crate::scene::bump::{BumpMap, BumpSource, Difference, MAX_OFFSET, default_height_scale};

/// A grey image (or RGB with three equal planes) holds heights; any other RGB image holds normals: as
/// 0…1 codes of −1…1, or as they are where a sample is negative.
pub(super) fn load(
    path: &Path,
    scale: Option<f64>,
    max_image_mb: u64,
) -> Result<BumpSource, InputError> {
    let subject = path.display().to_string();
    if let Some(scale) = scale
        && (scale.is_nan() || scale.abs() > 65536.0)
    {
        return Err(InputError::new(
            "--bump-scale",
            "a height in texels from -65536 to 65536",
            scale.to_string(),
            "leave it out for a 64th of the map's width",
        ));
    }
    let options = LoadOptions { max_image_mb, face_size: None };
    let mut image = load_planar(path, &options)?;
    let colour = image.colour(&subject)?;
    let (width, height) = (image.width, image.height);
    let mut bad = 0u64;
    for sample in image.channels.iter_mut().flat_map(|(_, samples)| samples) {
        if !sample.is_finite() {
            *sample = 0.0;
            bad += 1;
        }
    }
    if bad > 0 {
        super::note(&format!(
            "{subject}: {bad} samples were infinite or not a number and count as 0"
        ));
    }
    let plane = |i: usize| image.channels[i].1.as_slice();
    let (r, g, b) = match colour {
        Colour::Grey(y) => (plane(y), plane(y), plane(y)),
        Colour::Rgb([r, g, b]) => (plane(r), plane(g), plane(b)),
    };
    if r == g && g == b {
        let source = BumpSource::Height {
            width,
            height,
            values: r.to_vec(),
            scale: scale.unwrap_or_else(|| default_height_scale(width)),
            difference: Difference::default(),
        };
        tell(&subject, &source)?;
        return Ok(source);
    }
    let signed = [r, g, b].into_iter().flatten().any(|x| *x < 0.0);
    let decode = |x: f32| if signed { x } else { 2.0 * x - 1.0 };
    let values =
        r.iter().zip(g).zip(b).map(|((r, g), b)| [decode(*r), decode(*g), decode(*b)]).collect();
    if scale.is_some() {
        super::note(&format!("{subject}: holds normals, so --bump-scale has no effect"));
    }
    let source = BumpSource::Normals { width, height, values };
    tell(&subject, &source)?;
    Ok(source)
}

/// Says how many offsets are too long for the unit.
fn tell(subject: &str, source: &BumpSource) -> Result<(), InputError> {
    let cleaned = BumpMap::new(source)?.cleaned();
    if cleaned > 0 {
        super::note(&format!(
            "{subject}: {cleaned} offsets longer than {MAX_OFFSET} were shortened to it"
        ));
    }
    Ok(())
}

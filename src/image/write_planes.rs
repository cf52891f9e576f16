//! Named float planes as a linear EXR file.

use std::io::{Cursor, Error, Write};

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::Text;
use exr::prelude::{SmallVec, WritableImage};

use super::write::{invalid, own_attributes, sort_attributes};

/// Writes planes of f32 samples, row by row from the top left, as a scan-line EXR (ZIP) with string
/// attributes. Channels come out in alphabetical order, as the format has it.
///
/// # Errors
/// The target's error; `InvalidInput` for planes of another size, none at all, or a bad name.
pub fn write_planes(
    target: &mut impl Write,
    [width, height]: [usize; 2],
    planes: Vec<(String, Vec<f32>)>,
    attributes: &[(String, String)],
) -> std::io::Result<()> {
    let mut list: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (name, samples) in planes {
        if samples.is_empty() || samples.len() != width * height {
            return Err(invalid("plane size"));
        }
        let name = Text::new_or_none(name.as_str())
            .filter(|_| (1..=31).contains(&name.len()))
            .ok_or_else(|| invalid("channel name"))?;
        list.push(AnyChannel::new(name, FlatSamples::F32(samples)));
    }
    if list.is_empty() {
        return Err(invalid("number of planes"));
    }
    let encoding = Encoding {
        compression: exr::compression::Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: exr::meta::attribute::LineOrder::Increasing,
    };
    let layer = Layer::new(
        Vec2(width, height),
        own_attributes(attributes)?,
        encoding,
        AnyChannels::sort(list),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::other(e.to_string()))?;
    target.write_all(&sort_attributes(bytes.into_inner()))
}

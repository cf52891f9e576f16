//! Files that the image tests make for themselves.
#![allow(dead_code, reason = "each test binary takes the makers that it needs")]
#![allow(
    clippy::cast_possible_truncation,
    reason = "small made-up numbers that are exact in every format they pass through"
)]

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, Vec2, WritableImage,
};
use std::io::Cursor;
use std::path::PathBuf;
use tapline::cube::CubeLevel;
use tapline::error::InputError;
use tapline::image::{Cleaned, LoadOptions, Planar, load_environment, load_planar};

/// A folder for one test's files.
pub(crate) struct Folder(pub(crate) tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    pub(crate) fn planar(&self, bytes: &[u8]) -> Result<Planar, InputError> {
        load_planar(&self.file("planar", bytes), &LoadOptions::default())
    }

    pub(crate) fn environment(&self, bytes: &[u8]) -> Result<(CubeLevel, Cleaned), InputError> {
        let options = LoadOptions::default();
        let loaded = load_environment(&self.file("environment", bytes), &options)?;
        let (map, cleaned) = (loaded.map, loaded.cleaned);
        Ok((map.levels.into_iter().next().unwrap(), cleaned))
    }
}

pub(crate) const COMPRESSIONS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

pub(crate) fn encoding(compression: Compression, tile: Option<(usize, usize)>) -> Encoding {
    Encoding {
        compression,
        blocks: tile
            .map_or(exr::image::Blocks::ScanLines, |(w, h)| exr::image::Blocks::Tiles(Vec2(w, h))),
        line_order: LineOrder::Increasing,
    }
}

/// An EXR file of float channels R, G, B (or what is named), made by the `exr` crate.
pub(crate) fn exr_file(
    width: usize,
    height: usize,
    channels: Vec<(&str, FlatSamples)>,
    encoding: Encoding,
    attributes: LayerAttributes,
) -> Vec<u8> {
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let layer = Layer::new(Vec2(width, height), attributes, encoding, AnyChannels::sort(list));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// Small whole numbers, exact in half, float and u32, that differ from pixel to pixel.
pub(crate) fn ramp(width: usize, height: usize, start: usize) -> Vec<f32> {
    (0..width * height).map(|i| f32::from(((i * 37 + start * 11) % 1021) as u16)).collect()
}

pub(crate) fn rgb(width: usize, height: usize) -> Vec<(&'static str, FlatSamples)> {
    ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| (name, FlatSamples::F32(ramp(width, height, i))))
        .collect()
}

pub(crate) fn simple_exr(width: usize, height: usize, compression: Compression) -> Vec<u8> {
    let attributes = LayerAttributes::default();
    exr_file(width, height, rgb(width, height), encoding(compression, None), attributes)
}

pub(crate) fn png_file(
    width: u32,
    height: u32,
    colour: png::ColorType,
    depth: png::BitDepth,
    data: &[u8],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    bytes
}

/// A Radiance file of flat (unpacked) pixels.
pub(crate) fn hdr_file(width: usize, height: usize, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend(pixels.iter().flatten());
    bytes
}

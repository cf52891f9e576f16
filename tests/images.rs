//! Images in and out, on files made here: formats, layouts, hostile input, the cube's edges.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    reason = "small made-up numbers that are exact in every format they pass through"
)]

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, Levels, LineOrder, Text, Vec2, WritableImage, attribute, f16,
};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use tapline::cube::{CubeLevel, FACE_AXES, across_edge};
use tapline::error::InputError;
use tapline::image::{
    Cleaned, EnvLayout, LoadOptions, Planar, Sample, WholeFile, build_mips,
    install_quiet_panic_hook, load_environment, load_planar, load_planar_levels, srgb_decode,
    srgb_encode, write_exr, write_png,
};
use tapline::picture::Picture;

/// A folder for one test's files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn planar(&self, bytes: &[u8]) -> Result<Planar, InputError> {
        load_planar(&self.file("planar", bytes), &LoadOptions::default())
    }

    fn environment(&self, bytes: &[u8]) -> Result<(CubeLevel, Cleaned), InputError> {
        let options = LoadOptions::default();
        let (map, cleaned) = load_environment(&self.file("environment", bytes), &options)?;
        Ok((map.levels.into_iter().next().unwrap(), cleaned))
    }
}

const COMPRESSIONS: [Compression; 10] = [
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

fn encoding(compression: Compression, tile: Option<(usize, usize)>) -> Encoding {
    Encoding {
        compression,
        blocks: tile.map_or(exr::image::Blocks::ScanLines, |(w, h)| {
            exr::image::Blocks::Tiles(Vec2(w, h))
        }),
        line_order: LineOrder::Increasing,
    }
}

/// An EXR file of float channels R, G, B (or what is named), made by the `exr` crate.
fn exr_file(
    width: usize,
    height: usize,
    channels: Vec<(&str, FlatSamples)>,
    encoding: Encoding,
    attributes: LayerAttributes,
) -> Vec<u8> {
    let list = channels
        .into_iter()
        .map(|(name, samples)| AnyChannel::new(name, samples))
        .collect();
    let layer = Layer::new(
        Vec2(width, height),
        attributes,
        encoding,
        AnyChannels::sort(list),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .unwrap();
    bytes.into_inner()
}

/// Small whole numbers, exact in half, float and u32, that differ from pixel to pixel.
fn ramp(width: usize, height: usize, start: usize) -> Vec<f32> {
    (0..width * height)
        .map(|i| f32::from(((i * 37 + start * 11) % 1021) as u16))
        .collect()
}

fn rgb(width: usize, height: usize) -> Vec<(&'static str, FlatSamples)> {
    ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| (name, FlatSamples::F32(ramp(width, height, i))))
        .collect()
}

fn simple_exr(width: usize, height: usize, compression: Compression) -> Vec<u8> {
    let attributes = LayerAttributes::default();
    exr_file(
        width,
        height,
        rgb(width, height),
        encoding(compression, None),
        attributes,
    )
}

#[test]
fn every_exr_compression_and_sample_type_reads_what_was_written() {
    let folder = Folder::new();
    let (width, height) = (45, 70);
    for compression in COMPRESSIONS {
        for tile in [None, Some((16, 32)), Some((64, 64))] {
            let (a, b, c) = (
                ramp(width, height, 0),
                ramp(width, height, 5),
                ramp(width, height, 9),
            );
            let lossy_dct = matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
            let whole = c.iter().map(|v| *v as u32).collect();
            let channels = vec![
                (
                    "R",
                    FlatSamples::F16(a.iter().map(|v| f16::from_f32(*v)).collect()),
                ),
                ("Z", FlatSamples::F32(b.clone())),
                ("id", FlatSamples::U32(whole)),
            ];
            let attributes = LayerAttributes::default();
            let bytes = exr_file(
                width,
                height,
                channels,
                encoding(compression, tile),
                attributes,
            );
            let planar = folder.planar(&bytes).unwrap();
            assert_eq!((planar.width, planar.height), (width, height));
            assert!(planar.linear && planar.envmap.is_none());
            assert_eq!(planar.channel("id").unwrap(), c, "{compression:?} {tile:?}");
            assert_eq!(planar.channel("Z").unwrap(), b, "{compression:?} {tile:?}");
            let lossy = lossy_dct || matches!(compression, Compression::B44 | Compression::B44A);
            let r = planar.channel("R").unwrap();
            if lossy {
                // Noise is the worst case of these codecs: only the mean level is checked.
                let mean = |s: &[f32]| s.iter().map(|v| f64::from(*v)).sum::<f64>() / 3150.0;
                assert!(
                    (mean(r) - mean(&a)).abs() < 0.1 * mean(&a),
                    "{compression:?}"
                );
            } else {
                assert_eq!(r, a, "{compression:?} {tile:?}");
            }
        }
    }
}

#[test]
fn stored_mip_levels_are_read_each_at_its_size() {
    let folder = Folder::new();
    for (rounding, sizes) in [
        (
            exr::math::RoundingMode::Down,
            [(13, 6), (6, 3), (3, 1), (1, 1)].as_slice(),
        ),
        (
            exr::math::RoundingMode::Up,
            &[(13, 6), (7, 3), (4, 2), (2, 1), (1, 1)],
        ),
    ] {
        let level_data: Vec<FlatSamples> = sizes
            .iter()
            .enumerate()
            .map(|(i, (w, h))| FlatSamples::F32(ramp(*w, *h, i)))
            .collect();
        let levels = Levels::Mip {
            rounding_mode: rounding,
            level_data,
        };
        let list = [AnyChannel::new("Y", levels)].into_iter().collect();
        let layer = Layer::new(
            Vec2(13, 6),
            LayerAttributes::default(),
            encoding(Compression::ZIP16, Some((4, 4))),
            AnyChannels::sort(list),
        );
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .to_buffered(&mut bytes)
            .unwrap();
        let path = folder.file("mips.exr", &bytes.into_inner());
        let read = load_planar_levels(&path, &LoadOptions::default()).unwrap();
        assert_eq!(read.len(), sizes.len());
        for (i, (level, (w, h))) in read.iter().zip(sizes).enumerate() {
            assert_eq!((level.width, level.height), (*w, *h));
            assert_eq!(level.channel("Y").unwrap(), ramp(*w, *h, i));
        }
        assert_eq!(
            load_planar(&path, &LoadOptions::default()).unwrap(),
            read[0]
        );
    }
}

#[test]
fn the_data_window_counts_wherever_it_lies() {
    let folder = Folder::new();
    for position in [Vec2(-40, 7), Vec2(0, 1000), Vec2(-1000, -1)] {
        let attributes = LayerAttributes {
            layer_position: position,
            ..LayerAttributes::default()
        };
        let bytes = exr_file(
            8,
            4,
            rgb(8, 4),
            encoding(Compression::ZIP16, None),
            attributes,
        );
        let planar = folder.planar(&bytes).unwrap();
        assert_eq!(planar.channel("G").unwrap(), ramp(8, 4, 1));
    }
}

#[test]
fn exr_pictures_come_back_with_their_attributes_and_the_same_bytes_each_time() {
    let folder = Folder::new();
    let mut picture = Picture::new(5, 3);
    for (i, pixel) in picture.rgb.iter_mut().enumerate() {
        let v = f64::from(i as u32);
        *pixel = [v / 7.0, -v, 1.0e6 * v];
    }
    let attributes: Vec<(String, String)> =
        ["tapline:version", "tapline:unit", "tapline:seed", "z", "a"]
            .iter()
            .map(|name| ((*name).to_owned(), format!("value of {name}")))
            .collect();
    let write = |sample| {
        let mut bytes = Vec::new();
        write_exr(&mut bytes, &picture, &attributes, sample).unwrap();
        bytes
    };
    let bytes = write(Sample::Float);
    for _ in 0..8 {
        assert_eq!(bytes, write(Sample::Float));
    }
    let planar = folder.planar(&bytes).unwrap();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected: Vec<f32> = picture.rgb.iter().map(|p| p[c] as f32).collect();
        assert_eq!(planar.channel(name).unwrap(), expected);
    }
    let meta = exr::meta::MetaData::read_from_buffered(bytes.as_slice(), true).unwrap();
    for (name, value) in &attributes {
        let stored = &meta.headers[0].own_attributes.other[&Text::from(name.as_str())];
        assert_eq!(*stored, AttributeValue::Text(Text::from(value.as_str())));
    }
    let planar = folder.planar(&write(Sample::Half)).unwrap();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let half = |v: f64| f16::from_f64(v.clamp(-65504.0, 65504.0)).to_f32();
        let expected: Vec<f32> = picture.rgb.iter().map(|p| half(p[c])).collect();
        assert_eq!(planar.channel(name).unwrap(), expected);
    }
    let mut sink = Vec::new();
    assert!(write_exr(&mut sink, &Picture::new(0, 3), &[], Sample::Half).is_err());
    let nameless = [(String::new(), String::new())];
    assert!(write_exr(&mut sink, &picture, &nameless, Sample::Half).is_err());
}

#[test]
fn png_pictures_hold_rounded_srgb_codes_and_text() {
    let folder = Folder::new();
    let mut picture = Picture::new(256, 2);
    for code in 0..256usize {
        let linear = srgb_decode(f64::from(code as u8) / 255.0);
        picture.rgb[code] = [linear; 3];
        picture.rgb[256 + code] = [-linear - 0.1, linear + 1.0, f64::NAN];
    }
    let text = [
        ("Software".to_owned(), "tapline".to_owned()),
        ("unit".to_owned(), "größe".to_owned()),
    ];
    let mut bytes = Vec::new();
    write_png(&mut bytes, &picture, 0.0, &text).unwrap();
    for part in ["tEXtSoftware\0tapline", "iTXtunit\0", "größe", "sRGB"] {
        let found = bytes.windows(part.len()).any(|w| w == part.as_bytes());
        assert!(found, "{part}");
    }
    let planar = folder.planar(&bytes).unwrap();
    assert!(!planar.linear);
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        let codes: Vec<f32> = planar.channel(name).unwrap().to_vec();
        for (code, got) in codes.iter().enumerate().take(256) {
            assert_eq!(*got, f32::from(code as u8) / 255.0);
        }
        let beyond = [0.0, 1.0, 0.0][c];
        assert!(codes[256..].iter().all(|v| *v == beyond), "{name}");
    }
    // Two stops up: 0.25 becomes 1.
    picture.rgb[0] = [0.25, 0.05, 0.0];
    let mut bytes = Vec::new();
    write_png(&mut bytes, &picture, 2.0, &[]).unwrap();
    let planar = folder.planar(&bytes).unwrap();
    let expected = (srgb_encode(0.2) * 255.0).round() / 255.0;
    let got = ["R", "G", "B"].map(|name| f64::from(planar.channel(name).unwrap()[0]));
    assert!((got[0] - 1.0).abs() < 1e-7 && (got[1] - expected).abs() < 1e-7 && got[2] == 0.0);
    let no_keyword = [(String::new(), String::new())];
    assert!(write_png(&mut Vec::new(), &picture, 0.0, &no_keyword).is_err());
}

fn png_file(
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

#[test]
fn png_planes_are_raw_codes_of_eight_and_sixteen_bits() {
    use png::{BitDepth, ColorType};
    let folder = Folder::new();
    let data: Vec<u8> = (0..16).map(|i| i * 17).collect();
    let planar = folder
        .planar(&png_file(
            4,
            4,
            ColorType::Grayscale,
            BitDepth::Eight,
            &data,
        ))
        .unwrap();
    let expected: Vec<f32> = data.iter().map(|v| f32::from(*v) / 255.0).collect();
    assert_eq!(planar.channel("Y").unwrap(), expected);
    assert!(!planar.linear);
    let planar = folder
        .planar(&png_file(
            2,
            4,
            ColorType::Grayscale,
            BitDepth::Sixteen,
            &data,
        ))
        .unwrap();
    let expected: Vec<f32> = data
        .chunks(2)
        .map(|v| f32::from(u16::from_be_bytes([v[0], v[1]])) / 65535.0)
        .collect();
    assert_eq!(planar.channel("Y").unwrap(), expected);
    let planar = folder
        .planar(&png_file(2, 2, ColorType::Rgba, BitDepth::Eight, &data))
        .unwrap();
    let names: Vec<&str> = planar.channels.iter().map(|c| c.0.as_str()).collect();
    assert_eq!(names, ["R", "G", "B", "A"]);
    assert_eq!(planar.channel("B").unwrap()[3], f32::from(data[14]) / 255.0);
}

#[test]
fn a_jpeg_is_read_as_raw_codes() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
    let flat = vec![200u8; 16 * 8];
    image::ImageEncoder::write_image(encoder, &flat, 16, 8, image::ExtendedColorType::L8).unwrap();
    let planar = folder.planar(&bytes).unwrap();
    assert_eq!((planar.width, planar.height, planar.linear), (16, 8, false));
    // One quantisation step of a flat block at quality 100 is 1 code; rounding may move it by one.
    let y = planar.channel("Y").unwrap();
    assert!(y.iter().all(|v| (v * 255.0 - 200.0).abs() <= 1.01));
}

/// A Radiance file of flat (unpacked) pixels.
fn hdr_file(width: usize, height: usize, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend(pixels.iter().flatten());
    bytes
}

#[test]
fn radiance_pixels_are_mantissa_times_a_power_of_two() {
    let folder = Folder::new();
    let pixels = [
        [128, 64, 1, 129],
        [255, 3, 4, 136],
        [10, 20, 30, 0],
        [200, 100, 50, 137],
    ];
    let planar = folder.planar(&hdr_file(2, 2, &pixels)).unwrap();
    assert!(planar.linear);
    assert_eq!(planar.channel("R").unwrap(), [1.0, 255.0, 0.0, 400.0]);
    assert_eq!(planar.channel("G").unwrap(), [0.5, 3.0, 0.0, 200.0]);
    assert_eq!(planar.channel("B").unwrap(), [1.0 / 128.0, 4.0, 0.0, 100.0]);
}

#[test]
fn damaged_radiance_files_are_errors() {
    let folder = Folder::new();
    let whole = hdr_file(4, 2, &[[3, 2, 1, 128]; 8]);
    assert!(folder.planar(&whole).is_ok());
    for length in 0..whole.len() {
        assert!(folder.planar(&whole[..length]).is_err(), "{length}");
    }
    for line in [
        "-Y 40000 +X 40000",
        "-Y 4 +X 8888888",
        "-Y 0 +X 4",
        "-Y 99999999999 +X 4",
        "+Y 2 +X 4",
        "-Y -2 +X 4",
        "-Y 2",
        "",
        "-Y 2 +X 4 5",
    ] {
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n").into_bytes();
        bytes.extend([3, 2, 1, 128].repeat(8));
        assert!(folder.planar(&bytes).is_err(), "{line}");
    }
    let xyz = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x01\x02\x03\x80";
    let error = folder.planar(xyz).unwrap_err();
    assert!(error.found.contains("xyze"), "{error}");
}

fn with_envmap(kind: attribute::EnvironmentMap) -> LayerAttributes {
    LayerAttributes {
        environment_map: Some(kind),
        ..LayerAttributes::default()
    }
}

#[test]
fn shapes_decide_what_an_environment_is() {
    let folder = Folder::new();
    let none = LayerAttributes::default;
    let latlong = || with_envmap(attribute::EnvironmentMap::LatitudeLongitude);
    let cube = || with_envmap(attribute::EnvironmentMap::Cube);
    for (width, height, attributes, size) in [
        (16, 8, none(), Some(4)),
        (20, 10, none(), Some(8)),
        (2, 1, none(), Some(1)),
        (3, 18, none(), Some(3)),
        (18, 3, none(), Some(3)),
        (16, 12, none(), Some(4)),
        (12, 16, none(), Some(4)),
        (7, 7, none(), None),
        (16, 9, none(), None),
        (1, 1, none(), None),
        (9, 7, latlong(), Some(4)),
        (1, 1, latlong(), Some(1)),
        (5, 30, cube(), Some(5)),
        (1, 6, cube(), Some(1)),
        (16, 8, cube(), None),
        (30, 5, cube(), None),
    ] {
        let encoding = encoding(Compression::ZIP16, None);
        let bytes = exr_file(width, height, rgb(width, height), encoding, attributes);
        let found = folder.environment(&bytes);
        match (found, size) {
            (Ok((cube, cleaned)), Some(size)) => {
                assert_eq!((cube.size, cube.texels.len()), (size, 6 * size * size));
                assert_eq!(cleaned, Cleaned::default());
            }
            (Err(error), None) => assert_eq!(error.place.as_deref(), Some("size")),
            (found, _) => panic!("{width}x{height}: {found:?}"),
        }
    }
}

#[test]
fn a_gpu_strip_is_copied_texel_for_texel() {
    let folder = Folder::new();
    let encoding = encoding(Compression::ZIP16, None);
    let bytes = exr_file(4, 24, rgb(4, 24), encoding, LayerAttributes::default());
    let (cube, _) = folder.environment(&bytes).unwrap();
    let [r, g, b] = [0, 1, 2].map(|i| ramp(4, 24, i));
    for (i, texel) in cube.texels.iter().enumerate() {
        assert_eq!(*texel, [r[i], g[i], b[i]]);
    }
}

#[test]
fn the_asked_face_size_is_honoured_and_limited() {
    let folder = Folder::new();
    let load = |bytes: &[u8], size, mb| {
        let options = LoadOptions {
            max_image_mb: mb,
            face_size: Some(size),
        };
        load_environment(&folder.file("sized", bytes), &options)
    };
    let strip = exr_file(
        4,
        24,
        rgb(4, 24),
        encoding(Compression::ZIP16, None),
        LayerAttributes::default(),
    );
    for bytes in [simple_exr(16, 8, Compression::ZIP16), strip] {
        for size in [1, 3, 8] {
            let (map, _) = load(&bytes, size, 512).unwrap();
            assert_eq!(map.size(), size);
            assert_eq!(map.levels.last().unwrap().size, 1);
        }
        assert!(load(&bytes, 0, 512).is_err_and(|e| e.subject == "--face-size"));
        // 4 MiB hold 58,254 texels of a face at 72 bytes: 241² but not 242².
        assert!(load(&bytes, 241, 1).is_ok());
        assert!(load(&bytes, 242, 1).is_err_and(|e| e.subject == "--face-size"));
        assert!(load(&bytes, usize::MAX, 512).is_err_and(|e| e.subject == "--face-size"));
    }
}

#[test]
fn a_strong_reduction_keeps_the_mean_of_the_sphere() {
    // A map of alternating black and white columns, far finer than a 2×2 cube: its mean is 0.5 in
    // every direction, and sampling every half source texel leaves at most the error of one column
    // out of those under a texel (256 columns / 8 texels around the belt = 32): 1/32.
    let folder = Folder::new();
    let (width, height) = (256, 128);
    let stripes: Vec<f32> = (0..width * height)
        .map(|i| f32::from((i % 2) as u8))
        .collect();
    let channels = vec![("Y", FlatSamples::F32(stripes))];
    let encoding = encoding(Compression::ZIP16, None);
    let bytes = exr_file(
        width,
        height,
        channels,
        encoding,
        LayerAttributes::default(),
    );
    let options = LoadOptions {
        face_size: Some(2),
        ..LoadOptions::default()
    };
    let (map, _) = load_environment(&folder.file("stripes", &bytes), &options).unwrap();
    for texel in &map.levels[0].texels {
        assert!((texel[0] - 0.5).abs() <= 1.0 / 32.0, "{texel:?}");
        assert!(texel[0] == texel[1] && texel[1] == texel[2]);
    }
}

#[test]
fn colours_come_from_the_unnamed_layer_and_bad_samples_are_counted() {
    let folder = Folder::new();
    let plane = |values: [f32; 2]| FlatSamples::F32(values.to_vec());
    let channels = vec![
        ("A", plane([f32::NAN, 0.5])),
        ("B", plane([f32::NAN, 3.0])),
        ("G", plane([f32::INFINITY, 1.0e9])),
        ("R", plane([-2.0, f32::NEG_INFINITY])),
        ("diffuse.R", plane([7.0, 7.0])),
    ];
    let bytes = exr_file(
        2,
        1,
        channels,
        encoding(Compression::Uncompressed, None),
        LayerAttributes::default(),
    );
    let (cube, cleaned) = folder.environment(&bytes).unwrap();
    let expected = Cleaned {
        nan: 1,
        inf: 2,
        negative: 1,
    };
    assert_eq!(cleaned, expected);
    for texel in &cube.texels {
        assert!(texel.iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(texel[0] == 0.0 && texel[1] >= 65504.0 && texel[2] <= 3.0);
    }
    // Finite values beyond a half's range stay.
    assert!(cube.texels.iter().any(|t| t[1] > 1.0e6));
}

#[test]
fn a_png_environment_is_decoded_from_srgb() {
    let folder = Folder::new();
    let data = [188u8; 2 * 3];
    let bytes = png_file(2, 1, png::ColorType::Rgb, png::BitDepth::Eight, &data);
    let (cube, _) = folder.environment(&bytes).unwrap();
    let expected = srgb_decode(f64::from(188.0f32 / 255.0)) as f32;
    assert!(cube.texels.iter().flatten().all(|v| *v == expected));
}

/// An attribute as stored in an EXR header.
fn attr(name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
    bytes.extend((value.len() as u32).to_le_bytes());
    bytes.extend(value);
    bytes
}

fn words(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// What a hand-made header says.
struct Header {
    flags: u32,
    window: [i32; 4],
    compression: u8,
    sampling: [i32; 2],
    tiles: Option<([i32; 2], u8)>,
    kind: Option<&'static str>,
}

impl Default for Header {
    fn default() -> Self {
        Self {
            flags: 2,
            window: [0, 0, 7, 3],
            compression: 0,
            sampling: [1, 1],
            tiles: None,
            kind: None,
        }
    }
}

impl Header {
    fn bytes(&self) -> Vec<u8> {
        let mut channels = b"Y\0".to_vec();
        channels.extend(words(&[1, 0, self.sampling[0], self.sampling[1]]));
        channels.push(0);
        let mut bytes = words(&[20_000_630]);
        bytes.extend(self.flags.to_le_bytes());
        bytes.extend(attr("channels", "chlist", &channels));
        bytes.extend(attr("compression", "compression", &[self.compression]));
        bytes.extend(attr("dataWindow", "box2i", &words(&self.window)));
        bytes.extend(attr("displayWindow", "box2i", &words(&[0, 0, 7, 3])));
        bytes.extend(attr("lineOrder", "lineOrder", &[0]));
        bytes.extend(attr("pixelAspectRatio", "float", &1.0f32.to_le_bytes()));
        if let Some((size, mode)) = self.tiles {
            let mut value = words(&size);
            value.push(mode);
            bytes.extend(attr("tiles", "tiledesc", &value));
        }
        if let Some(kind) = self.kind {
            bytes.extend(attr("type", "string", kind.as_bytes()));
        }
        bytes.push(0);
        bytes
    }

    /// The header with one chunk per offset: its words and data.
    fn with_chunks(&self, chunks: &[(&[i32], &[u8])]) -> Vec<u8> {
        let mut bytes = self.bytes();
        let mut at = bytes.len() + 8 * chunks.len();
        for (head, data) in chunks {
            bytes.extend((at as u64).to_le_bytes());
            at += 4 * head.len() + data.len();
        }
        for (head, data) in chunks {
            bytes.extend(words(head));
            bytes.extend(*data);
        }
        bytes
    }
}

#[test]
fn a_hand_made_exr_is_read_and_its_hostile_sisters_are_refused_by_name() {
    let folder = Folder::new();
    let place = |bytes: &[u8]| {
        let error = folder.planar(bytes).unwrap_err();
        (error.place.unwrap_or_default(), error.found)
    };
    let row = [0u8, 0x3c].repeat(8);
    let lines: [(&[i32], &[u8]); 4] = [
        (&[0, 16], &row),
        (&[1, 16], &row),
        (&[2, 16], &row),
        (&[3, 16], &row),
    ];
    let good = Header::default().with_chunks(&lines);
    assert_eq!(
        folder.planar(&good).unwrap().channel("Y").unwrap(),
        [1.0; 32]
    );

    // Windows.
    for (window, expected) in [
        ([0, 0, 999_999_999, 999_999_999], "size"),
        ([0, 0, 0, 452_984_832], "size"),
        ([-83_886_080, 0, 500_000_000, 0], "size"),
        ([0, 0, 40_000, 5_000], "chunk table"),
        ([5, 0, 4, 3], "dataWindow"),
        ([0, 9, 7, 3], "dataWindow"),
        ([i32::MIN, i32::MIN, i32::MAX, i32::MAX], "dataWindow"),
    ] {
        let header = Header {
            window,
            ..Header::default()
        };
        let (found, _) = place(&header.with_chunks(&lines));
        assert_eq!(found, expected, "{window:?}");
    }

    // Tiles.
    for (size, mode, expected) in [
        ([0, 4], 0, "tiles"),
        ([4, -1], 0, "tiles"),
        ([4, 4], 9, "tiles"),
        ([64, 1 << 30], 0, "size"),
        ([i32::MAX, i32::MAX], 0, "size"),
    ] {
        let header = Header {
            flags: 2 | 1 << 9,
            tiles: Some((size, mode)),
            ..Header::default()
        };
        assert_eq!(
            place(&header.with_chunks(&[])).0,
            expected,
            "{size:?} {mode}"
        );
    }

    // Kinds that are not read.
    let deep = Header {
        flags: 2 | 1 << 11,
        ..Header::default()
    };
    assert_eq!(place(&deep.with_chunks(&lines)).1, "deep data");
    let deep = Header {
        kind: Some("deepscanline"),
        ..Header::default()
    };
    assert_eq!(place(&deep.with_chunks(&lines)).1, "deep data");
    let chroma = Header {
        sampling: [2, 2],
        ..Header::default()
    };
    assert_eq!(place(&chroma.with_chunks(&lines)).0, "channel \"Y\"");
    for compression in [10, 11, 12, 255] {
        let header = Header {
            compression,
            ..Header::default()
        };
        assert_eq!(place(&header.with_chunks(&lines)).0, "compression");
    }

    // Chunks: twice, missing, outside, cut off, oversized.
    let twice: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[1], lines[3]];
    let outside: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[9, 16], &row)];
    let negative: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[-1, 16], &row)];
    let huge: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[3, i32::MAX], &row)];
    for chunks in [twice, outside, negative, huge] {
        assert_eq!(
            place(&Header::default().with_chunks(&chunks)).0,
            "chunk table"
        );
    }
    let short: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[3, 4], &row[..4])];
    assert_eq!(place(&Header::default().with_chunks(&short)).0, "pixels");
    let mut far = good.clone();
    let table = Header::default().bytes().len();
    far[table..table + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    assert_eq!(place(&far).0, "chunk table");
}

#[test]
fn dwa_chunks_that_claim_exabytes_are_refused_before_they_are_taken_at_their_word() {
    let folder = Folder::new();
    let header = Header {
        compression: 8,
        ..Header::default()
    };
    for counter in 1..10 {
        for claim in [1u64 << 62, 1 << 40, 1 << 33] {
            let mut data = vec![0u8; 88];
            data[..8].copy_from_slice(&2u64.to_le_bytes());
            data[8 * counter..8 * counter + 8].copy_from_slice(&claim.to_le_bytes());
            let bytes = header.with_chunks(&[(&[0, 88], &data)]);
            let error = folder.planar(&bytes).unwrap_err();
            assert_eq!(error.found, "impossible sizes", "{counter}");
        }
    }
}

#[test]
fn every_beginning_of_every_kind_of_file_is_an_error_and_not_a_panic() {
    install_quiet_panic_hook();
    let folder = Folder::new();
    for bytes in sample_files() {
        let path = folder.file("whole", &bytes);
        assert!(load_planar(&path, &LoadOptions::default()).is_ok());
        for length in (0..bytes.len()).step_by(bytes.len() / 200 + 1) {
            // A PNG or JPEG without its very end may still decode; nothing else may.
            let result = folder.planar(&bytes[..length]);
            if bytes[0] == 0x76 || length < bytes.len() / 2 {
                assert!(result.is_err(), "{length} of {}", bytes.len());
            }
        }
    }
}

#[test]
fn files_with_random_damage_give_pixels_or_an_error() {
    install_quiet_panic_hook();
    let folder = Folder::new();
    // More rounds by hand: TAPLINE_DAMAGE_ROUNDS=10000.
    let rounds = std::env::var("TAPLINE_DAMAGE_ROUNDS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(150);
    // A small limit keeps even a believed lie cheap.
    let options = LoadOptions {
        max_image_mb: 1,
        face_size: Some(2),
    };
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let (mut errors, mut pixels) = (0u32, 0u32);
    for bytes in sample_files() {
        for _ in 0..rounds {
            let mut bytes = bytes.clone();
            for _ in 0..=random(4) {
                let at = random(bytes.len());
                bytes[at] = [0, 1, 0x7f, 0x80, 0xff, random(256) as u8][random(6)];
            }
            let path = folder.file("damaged", &bytes);
            match load_environment(&path, &options) {
                Ok((map, _)) => {
                    pixels += 1;
                    let sane = |v: &f32| v.is_finite() && *v >= 0.0;
                    assert!(map.levels[0].texels.iter().flatten().all(sane));
                }
                Err(_) => errors += 1,
            }
        }
    }
    // Both ends of the coin must have come up, or the test proves nothing.
    assert!(
        errors > 100 && pixels > 100,
        "{errors} errors, {pixels} pictures"
    );
}

/// A 2:1 picture in every format and EXR compression.
fn sample_files() -> Vec<Vec<u8>> {
    let mut files: Vec<Vec<u8>> = COMPRESSIONS
        .into_iter()
        .flat_map(|compression| {
            [None, Some((8, 8))].map(|tile| {
                let channels = ["R", "G", "B"]
                    .into_iter()
                    .enumerate()
                    .map(|(i, name)| {
                        let half = ramp(24, 12, i).iter().map(|v| f16::from_f32(*v)).collect();
                        (name, FlatSamples::F16(half))
                    })
                    .collect();
                let attributes = LayerAttributes::default();
                exr_file(24, 12, channels, encoding(compression, tile), attributes)
            })
        })
        .collect();
    let pixels: Vec<[u8; 4]> = (0..32u8).map(|i| [i, 9, 200 - i, 130]).collect();
    files.push(hdr_file(8, 4, &pixels));
    let data: Vec<u8> = (0..96).map(|i| i * 2).collect();
    files.push(png_file(
        8,
        4,
        png::ColorType::Rgb,
        png::BitDepth::Eight,
        &data,
    ));
    let mut jpeg = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new(&mut jpeg);
    image::ImageEncoder::write_image(encoder, &data, 8, 4, image::ExtendedColorType::Rgb8).unwrap();
    files.push(jpeg);
    files
}

#[test]
fn unreadable_and_unknown_files_are_errors() {
    let folder = Folder::new();
    let options = LoadOptions::default();
    let missing = folder.0.path().join("none.exr");
    assert!(load_planar(&missing, &options).is_err());
    assert!(load_planar(folder.0.path(), &options).is_err());
    for bytes in [&b""[..], b"v/1", b"GIF89a", b"<html>"] {
        assert!(folder.planar(bytes).is_err());
    }
    let small = LoadOptions {
        max_image_mb: 0,
        face_size: None,
    };
    let path = folder.file("small.exr", &simple_exr(2, 1, Compression::RLE));
    assert!(load_planar(&path, &small).is_err());
}

#[test]
fn the_image_limit_is_in_mebibytes_of_pixels() {
    let folder = Folder::new();
    // 512 × 256 × 3 floats are 1.5 MiB.
    let path = folder.file("limit.exr", &simple_exr(512, 256, Compression::RLE));
    let load = |mb| {
        let options = LoadOptions {
            max_image_mb: mb,
            face_size: None,
        };
        load_planar(&path, &options)
    };
    assert!(load(2).is_ok());
    let error = load(1).unwrap_err();
    assert!(error.remedy.contains("--max-image-mb 2"), "{error}");
}

#[test]
fn whole_files_written_through_the_picture_writers_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("picture.exr");
    let picture = Picture::new(4, 2);
    let mut file = WholeFile::create(path).unwrap();
    file.write_with(|w| write_exr(w, &picture, &[], Sample::Half))
        .unwrap();
    file.commit().unwrap();
    let planar = load_planar(path, &LoadOptions::default()).unwrap();
    assert_eq!(planar.envmap, None::<EnvLayout>);
    assert_eq!(planar.channel("B").unwrap(), [0.0; 8]);
}

/// The middles of a texel's four sides in 3-D, times `size`: whole numbers.
fn side_middles(size: usize, face: usize, x: usize, y: usize) -> [[i64; 3]; 4] {
    let n = i64::try_from(size).unwrap();
    let centre = |t: usize| 2 * i64::try_from(t).unwrap() + 1 - n;
    [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| {
        let mut point = [0; 3];
        for ((axis, sign), value) in
            FACE_AXES[face]
                .into_iter()
                .zip([centre(x) + dx, centre(y) + dy, n])
        {
            point[axis] = if sign < 0.0 { -value } else { value };
        }
        point
    })
}

#[test]
fn the_texel_across_an_edge_shares_the_side_that_was_crossed() {
    for size in [1usize, 2, 3, 5, 8] {
        let n = i64::try_from(size).unwrap();
        for face in 0..6 {
            for t in 0..size {
                let w = i64::try_from(t).unwrap();
                for (side, x, y, dx, dy) in [
                    (0, 0, t, -1, w),
                    (1, size - 1, t, n, w),
                    (2, t, 0, w, -1),
                    (3, t, size - 1, w, n),
                ] {
                    let crossed = side_middles(size, face, x, y)[side];
                    let (other, ox, oy) = across_edge(size, face, dx, dy).unwrap();
                    assert_ne!(other, face);
                    let shared: Vec<usize> = (0..4)
                        .filter(|s| side_middles(size, other, ox, oy)[*s] == crossed)
                        .collect();
                    assert_eq!(shared.len(), 1, "size {size} face {face} ({dx}, {dy})");
                    // Back over that side lies the texel we came from.
                    let i = |t: usize| i64::try_from(t).unwrap();
                    let (bx, by) = match shared[0] {
                        0 => (-1, i(oy)),
                        1 => (n, i(oy)),
                        2 => (i(ox), -1),
                        _ => (i(ox), n),
                    };
                    assert_eq!(across_edge(size, other, bx, by), Some((face, x, y)));
                }
            }
            for (x, y) in [(-1, -1), (-1, n), (n, -1), (n, n), (-2, 0), (0, n + 1)] {
                assert_eq!(across_edge(size, face, x, y), None);
            }
            assert_eq!(across_edge(size, face, n - 1, 0), Some((face, size - 1, 0)));
        }
    }
}

#[test]
fn mips_of_a_loaded_map_are_the_boxes_of_its_level_0() {
    let folder = Folder::new();
    let path = folder.file("map.exr", &simple_exr(24, 12, Compression::PIZ));
    let (map, _) = load_environment(&path, &LoadOptions::default()).unwrap();
    assert_eq!(map, build_mips(map.levels[0].clone()));
    assert_eq!(map.levels.len(), 4);
}

#[test]
#[ignore = "a measurement: time and memory of a 4096x2048 map"]
fn a_map_of_4096_by_2048_loads() {
    let folder = Folder::new();
    let (width, height) = (4096, 2048);
    let channels = ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| {
            let half = ramp(width, height, i)
                .into_iter()
                .map(f16::from_f32)
                .collect();
            (name, FlatSamples::F16(half))
        })
        .collect();
    let encoding = encoding(Compression::ZIP16, None);
    let bytes = exr_file(
        width,
        height,
        channels,
        encoding,
        LayerAttributes::default(),
    );
    let path = folder.file("large.exr", &bytes);
    let start = std::time::Instant::now();
    let (map, _) = load_environment(&path, &LoadOptions::default()).unwrap();
    eprintln!(
        "{} MiB file, {:.2} s",
        bytes.len() >> 20,
        start.elapsed().as_secs_f64()
    );
    assert_eq!((map.size(), map.levels.len()), (1024, 11));
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    eprintln!(
        "{}",
        status
            .lines()
            .find(|l| l.starts_with("VmHWM"))
            .unwrap_or("no memory figure")
    );
}

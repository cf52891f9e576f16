//! Images in and out: every format, on files made here.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    reason = "small made-up numbers that are exact in every format they pass through"
)]

use crate::made::{COMPRESSIONS, Folder, encoding, exr_file, hdr_file, png_file, ramp, rgb};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, FlatSamples, Image, Layer,
    LayerAttributes, Levels, Text, Vec2, WritableImage, f16,
};
use std::io::Cursor;
use std::path::Path;
use tapline::image::{
    EnvLayout, LoadOptions, Sample, WholeFile, load_planar, load_planar_levels, write_exr,
    write_png,
};
use tapline::picture::Picture;
use tapline::srgb::{srgb_decode, srgb_encode};

#[test]
fn every_exr_compression_and_sample_type_reads_what_was_written() {
    let folder = Folder::new();
    let (width, height) = (45, 70);
    for compression in COMPRESSIONS {
        for tile in [None, Some((16, 32)), Some((64, 64))] {
            let (a, b, c) =
                (ramp(width, height, 0), ramp(width, height, 5), ramp(width, height, 9));
            let lossy_dct = matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
            let whole = c.iter().map(|v| *v as u32).collect();
            let channels = vec![
                ("R", FlatSamples::F16(a.iter().map(|v| f16::from_f32(*v)).collect())),
                ("Z", FlatSamples::F32(b.clone())),
                ("id", FlatSamples::U32(whole)),
            ];
            let attributes = LayerAttributes::default();
            let bytes = exr_file(width, height, channels, encoding(compression, tile), attributes);
            let planar = folder.planar(&bytes).unwrap();
            assert_eq!((planar.width, planar.height), (width, height));
            assert!(planar.is_linear() && planar.envmap.is_none());
            assert_eq!(planar.channel("id").unwrap(), c, "{compression:?} {tile:?}");
            assert_eq!(planar.channel("Z").unwrap(), b, "{compression:?} {tile:?}");
            let lossy = lossy_dct || matches!(compression, Compression::B44 | Compression::B44A);
            let r = planar.channel("R").unwrap();
            if lossy {
                // Noise is the worst case of these codecs: only the mean level is checked.
                let mean = |s: &[f32]| s.iter().map(|v| f64::from(*v)).sum::<f64>() / 3150.0;
                assert!((mean(r) - mean(&a)).abs() < 0.1 * mean(&a), "{compression:?}");
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
        (exr::math::RoundingMode::Down, [(13, 6), (6, 3), (3, 1), (1, 1)].as_slice()),
        (exr::math::RoundingMode::Up, &[(13, 6), (7, 3), (4, 2), (2, 1), (1, 1)]),
    ] {
        let level_data: Vec<FlatSamples> =
            sizes.iter().enumerate().map(|(i, (w, h))| FlatSamples::F32(ramp(*w, *h, i))).collect();
        let levels = Levels::Mip { rounding_mode: rounding, level_data };
        let list = [AnyChannel::new("Y", levels)].into_iter().collect();
        let layer = Layer::new(
            Vec2(13, 6),
            LayerAttributes::default(),
            encoding(Compression::ZIP16, Some((4, 4))),
            AnyChannels::sort(list),
        );
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        let path = folder.file("mips.exr", &bytes.into_inner());
        let read = load_planar_levels(&path, &LoadOptions::default()).unwrap();
        assert_eq!(read.len(), sizes.len());
        for (i, (level, (w, h))) in read.iter().zip(sizes).enumerate() {
            assert_eq!((level.width, level.height), (*w, *h));
            assert_eq!(level.channel("Y").unwrap(), ramp(*w, *h, i));
        }
        assert_eq!(load_planar(&path, &LoadOptions::default()).unwrap(), read[0]);
    }
}

#[test]
fn the_data_window_counts_wherever_it_lies() {
    let folder = Folder::new();
    for position in [Vec2(-40, 7), Vec2(0, 1000), Vec2(-1000, -1)] {
        let attributes = LayerAttributes { layer_position: position, ..LayerAttributes::default() };
        let bytes = exr_file(8, 4, rgb(8, 4), encoding(Compression::ZIP16, None), attributes);
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
    let text =
        [("Software".to_owned(), "tapline".to_owned()), ("unit".to_owned(), "größe".to_owned())];
    let mut bytes = Vec::new();
    write_png(&mut bytes, &picture, 0.0, &text).unwrap();
    for part in ["tEXtSoftware\0tapline", "iTXtunit\0", "größe", "sRGB"] {
        let found = bytes.windows(part.len()).any(|w| w == part.as_bytes());
        assert!(found, "{part}");
    }
    let planar = folder.planar(&bytes).unwrap();
    assert!(!planar.is_linear());
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

#[test]
fn png_planes_are_raw_codes_of_eight_and_sixteen_bits() {
    use png::{BitDepth, ColorType};
    let folder = Folder::new();
    let data: Vec<u8> = (0..16).map(|i| i * 17).collect();
    let planar =
        folder.planar(&png_file(4, 4, ColorType::Grayscale, BitDepth::Eight, &data)).unwrap();
    let expected: Vec<f32> = data.iter().map(|v| f32::from(*v) / 255.0).collect();
    assert_eq!(planar.channel("Y").unwrap(), expected);
    assert!(!planar.is_linear());
    let planar =
        folder.planar(&png_file(2, 4, ColorType::Grayscale, BitDepth::Sixteen, &data)).unwrap();
    let expected: Vec<f32> =
        data.chunks(2).map(|v| f32::from(u16::from_be_bytes([v[0], v[1]])) / 65535.0).collect();
    assert_eq!(planar.channel("Y").unwrap(), expected);
    let planar = folder.planar(&png_file(2, 2, ColorType::Rgba, BitDepth::Eight, &data)).unwrap();
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
    assert_eq!((planar.width, planar.height, planar.is_linear()), (16, 8, false));
    // One quantisation step of a flat block at quality 100 is 1 code; rounding may move it by one.
    let y = planar.channel("Y").unwrap();
    assert!(y.iter().all(|v| (v * 255.0 - 200.0).abs() <= 1.01));
}

#[test]
fn radiance_pixels_are_mantissa_times_a_power_of_two() {
    let folder = Folder::new();
    let pixels = [[128, 64, 1, 129], [255, 3, 4, 136], [10, 20, 30, 0], [200, 100, 50, 137]];
    let planar = folder.planar(&hdr_file(2, 2, &pixels)).unwrap();
    assert!(planar.is_linear());
    assert_eq!(planar.channel("R").unwrap(), [1.0, 255.0, 0.0, 400.0]);
    assert_eq!(planar.channel("G").unwrap(), [0.5, 3.0, 0.0, 200.0]);
    assert_eq!(planar.channel("B").unwrap(), [1.0 / 128.0, 4.0, 0.0, 100.0]);
}

#[test]
fn whole_files_written_through_the_picture_writers_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("picture.exr");
    let picture = Picture::new(4, 2);
    let mut file = WholeFile::create(path).unwrap();
    file.write_with(|w| write_exr(w, &picture, &[], Sample::Half)).unwrap();
    file.commit().unwrap();
    let planar = load_planar(path, &LoadOptions::default()).unwrap();
    assert_eq!(planar.envmap, None::<EnvLayout>);
    assert_eq!(planar.channel("B").unwrap(), [0.0; 8]);
}

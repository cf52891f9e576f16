//! Damaged and hostile images end in an error or in pixels, never in a panic or without memory.
#![expect(
    clippy::cast_possible_truncation,
    reason = "small made-up numbers that are exact in every format they pass through"
)]

use crate::made::{COMPRESSIONS, Folder, encoding, exr_file, hdr_file, png_file, ramp, simple_exr};
use exr::prelude::{Compression, FlatSamples, LayerAttributes, f16};
use tapline::base::quiet::install_quiet_panic_hook;
use tapline::base::random::Random;
use tapline::image::{LoadOptions, Loaded, load_environment, load_planar};

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
        "+Y 2 +Y 4",
        "-Y -2 +X 4",
        "-Y 2",
        "",
        "-Y 2 +X 4 5",
    ] {
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n").into_bytes();
        bytes.extend([3, 2, 1, 128].repeat(8));
        assert!(folder.planar(&bytes).is_err(), "{line}");
    }
    let xyz = b"#?RADIANCE\nFORMAT=32-bit_rle_spectral\n\n-Y 1 +X 1\n\x01\x02\x03\x80";
    let error = folder.planar(xyz).unwrap_err();
    assert!(error.found.contains("spectral"), "{error}");
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
    let lines: [(&[i32], &[u8]); 4] =
        [(&[0, 16], &row), (&[1, 16], &row), (&[2, 16], &row), (&[3, 16], &row)];
    let good = Header::default().with_chunks(&lines);
    assert_eq!(folder.planar(&good).unwrap().channel("Y").unwrap(), [1.0; 32]);

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
        let header = Header { window, ..Header::default() };
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
        let header = Header { flags: 2 | 1 << 9, tiles: Some((size, mode)), ..Header::default() };
        assert_eq!(place(&header.with_chunks(&[])).0, expected, "{size:?} {mode}");
    }

    // Kinds that are not read.
    let deep = Header { flags: 2 | 1 << 11, ..Header::default() };
    assert_eq!(place(&deep.with_chunks(&lines)).1, "deep data");
    let deep = Header { kind: Some("deepscanline"), ..Header::default() };
    assert_eq!(place(&deep.with_chunks(&lines)).1, "deep data");
    let chroma = Header { sampling: [2, 2], ..Header::default() };
    assert_eq!(place(&chroma.with_chunks(&lines)).0, "channel \"Y\"");
    for compression in [10, 11, 12, 255] {
        let header = Header { compression, ..Header::default() };
        assert_eq!(place(&header.with_chunks(&lines)).0, "compression");
    }

    // Chunks: twice, missing, outside, cut off, oversized.
    let twice: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[1], lines[3]];
    let outside: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[9, 16], &row)];
    let negative: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[-1, 16], &row)];
    let huge: [(&[i32], &[u8]); 4] = [lines[0], lines[1], lines[2], (&[3, i32::MAX], &row)];
    for chunks in [twice, outside, negative, huge] {
        assert_eq!(place(&Header::default().with_chunks(&chunks)).0, "chunk table");
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
    let header = Header { compression: 8, ..Header::default() };
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
    let rounds =
        std::env::var("TAPLINE_DAMAGE_ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(150);
    // A small limit keeps even a believed lie cheap.
    let options = LoadOptions { max_image_mb: 1, face_size: Some(2), ..LoadOptions::default() };
    let mut random = Random::new(1);
    let mut random = |below: usize| random.index(below);
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
                Ok(Loaded { map, .. }) => {
                    pixels += 1;
                    let sane = |v: &f32| v.is_finite() && *v >= 0.0;
                    assert!(map.levels[0].texels.iter().flatten().all(sane));
                }
                Err(_) => errors += 1,
            }
        }
    }
    // Both ends of the coin must have come up, or the test proves nothing.
    assert!(errors > 100 && pixels > 100, "{errors} errors, {pixels} pictures");
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
    files.push(png_file(8, 4, png::ColorType::Rgb, png::BitDepth::Eight, &data));
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
    let small = LoadOptions { max_image_mb: 0, ..LoadOptions::default() };
    let path = folder.file("small.exr", &simple_exr(2, 1, Compression::RLE));
    assert!(load_planar(&path, &small).is_err());
}

#[test]
fn the_image_limit_is_in_mebibytes_of_pixels() {
    let folder = Folder::new();
    // 512 × 256 × 3 floats are 1.5 MiB.
    let path = folder.file("limit.exr", &simple_exr(512, 256, Compression::RLE));
    let load = |mb| {
        let options = LoadOptions { max_image_mb: mb, ..LoadOptions::default() };
        load_planar(&path, &options)
    };
    assert!(load(2).is_ok());
    let error = load(1).unwrap_err();
    assert!(error.remedy.contains("--max-image-mb 2"), "{error}");
}

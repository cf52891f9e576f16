//! What files are taken for: kinds of input that public reports of this field describe, made small here.
#![allow(
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "small made-up numbers; equal bits are what is asked for"
)]

use std::io::Cursor;
use std::path::Path;

use crate::made::{COMPRESSIONS, Folder, encoding, exr_file, hdr_file, png_file};
use exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, Vec2, WritableImage,
};
use tapline::error::InputError;
use tapline::image::{
    Layout, LoadOptions, Loaded, Transfer, load_bump_planes, load_distance, load_environment,
    load_planar,
};
use tapline::scene::bump::BumpSource;
use tapline::scene::bump_kind::{BumpChoice, BumpKind, Green, source};

type Cube = tapline::cube::CubeMap;

/// x, y, z of the direction of each pixel of a lat-long picture, plus 2: any pixel tells its place.
fn directions(width: usize, height: usize) -> Vec<[f32; 3]> {
    let pi = std::f64::consts::PI;
    let one = |i: usize| {
        let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let (lon, lat) = (pi - 2.0 * pi * x / width as f64, pi / 2.0 - pi * y / height as f64);
        [lon.sin() * lat.cos() + 2.0, lat.sin() + 2.0, lon.cos() * lat.cos() + 2.0]
    };
    (0..width * height).map(|i| one(i).map(|c| c as f32)).collect()
}

fn channels(texels: &[[f32; 3]], names: [&'static str; 3]) -> Vec<(&'static str, FlatSamples)> {
    let plane = |c: usize| FlatSamples::F32(texels.iter().map(|t| t[c]).collect());
    names.into_iter().enumerate().map(|(c, name)| (name, plane(c))).collect()
}

fn picture(width: usize, height: usize, texels: &[[f32; 3]], names: [&'static str; 3]) -> Vec<u8> {
    let (way, plain) = (encoding(COMPRESSIONS[0], None), LayerAttributes::default());
    exr_file(width, height, channels(texels, names), way, plain)
}

/// Several parts, each with a name, channels, size and place, in one display window.
type PartOf<'a> = (&'a str, Vec<(&'a str, FlatSamples)>, [usize; 2], [i32; 2]);

fn parts(display: [usize; 2], parts: Vec<PartOf<'_>>) -> Vec<u8> {
    let layers = parts.into_iter().map(|(name, channels, [w, h], [x, y])| {
        let list = channels.into_iter().map(|(n, s)| AnyChannel::new(n, s)).collect();
        let mut attributes = LayerAttributes::named(name);
        attributes.layer_position = Vec2(x, y);
        Layer::new(Vec2(w, h), attributes, encoding(COMPRESSIONS[2], None), AnyChannels::sort(list))
    });
    let window = IntegerBounds::from_dimensions(Vec2(display[0], display[1]));
    let image = Image::from_layers(ImageAttributes::new(window), layers.collect::<Vec<_>>());
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn load(folder: &Folder, bytes: &[u8], options: &LoadOptions) -> Result<Loaded<Cube>, InputError> {
    load_environment(&folder.file("env.exr", bytes), options)
}

fn texels(map: &Cube) -> &[[f32; 3]] {
    &map.levels[0].texels
}

fn worst(a: &Cube, b: &Cube) -> f32 {
    assert_eq!(a.size(), b.size());
    let pairs = texels(a).iter().flatten().zip(texels(b).iter().flatten());
    pairs.fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

/// The lat-long map of directions of 64 × 32, as a cube.
fn reference(folder: &Folder) -> Cube {
    let bytes = picture(64, 32, &directions(64, 32), ["R", "G", "B"]);
    load(folder, &bytes, &LoadOptions::default()).unwrap().map
}

#[test]
fn depth_is_never_light_and_a_part_with_colours_is_found_and_named() {
    let folder = Folder::new();
    let wanted = reference(&folder);
    let (plain, all) = (LoadOptions::default(), directions(64, 32));
    let depth = || vec![("Z", FlatSamples::F32(vec![7.0; 64 * 32]))];
    let light = || channels(&all, ["R", "G", "B"]);
    let two = vec![("depth", depth(), [64, 32], [0; 2]), ("rgb", light(), [64, 32], [0; 2])];
    let bytes = parts([64, 32], two);
    let loaded = load(&folder, &bytes, &plain).unwrap();
    assert_eq!(loaded.map, wanted);
    assert!(
        loaded.taken.to_string().contains("channels R G B of part \"rgb\""),
        "{}",
        loaded.taken
    );
    let named = load_environment(&folder.0.path().join("env.exr:depth"), &plain).unwrap();
    assert!(texels(&named.map).iter().flatten().all(|c| (c - 7.0).abs() < 1e-6));
    let error = load_environment(&folder.0.path().join("env.exr:none"), &plain).unwrap_err();
    assert!(error.found.contains("part \"depth\": Z; part \"rgb\": B, G, R"), "{error}");
    // Distances are looked for in the parts, too.
    let distance = load_distance(&folder.0.path().join("env.exr"), &plain).unwrap();
    assert!(distance.map.texels.iter().all(|d| (d - 7.0).abs() < 1e-6));

    for names in [
        ["r", "g", "b"],
        ["red", "green", "blue"],
        ["V.Combined.R", "V.Combined.G", "V.Combined.B"],
    ] {
        assert_eq!(load(&folder, &picture(64, 32, &all, names), &plain).unwrap().map, wanted);
    }
    let error = load(&folder, &picture(64, 32, &all, ["X", "Y", "Z"]), &plain).unwrap_err();
    assert!(error.found.contains("X, Y, Z"), "{error}");
    let alone =
        exr_file(64, 32, depth(), encoding(COMPRESSIONS[0], None), LayerAttributes::default());
    assert!(load(&folder, &alone, &plain).is_err());
}

#[test]
fn the_display_window_counts_and_gaps_are_refused_or_filled() {
    let folder = Folder::new();
    let (wanted, all) = (reference(&folder), directions(64, 32));
    // Overscan of eight pixels on every side is cropped.
    let wide = (0..80 * 48).map(|i: usize| {
        let (x, y) = ((i % 80).wrapping_sub(8), (i / 80).wrapping_sub(8));
        if x < 64 && y < 32 { all[y * 64 + x] } else { [99.0; 3] }
    });
    let wide: Vec<[f32; 3]> = wide.collect();
    let over = parts([64, 32], vec![("a", channels(&wide, ["R", "G", "B"]), [80, 48], [-8, -8])]);
    let loaded = load(&folder, &over, &LoadOptions::default()).unwrap();
    assert_eq!(loaded.map, wanted);
    assert!(loaded.taken.window.contains("(-8, -8)-(71, 39) cropped"), "{}", loaded.taken);
    // The right half alone.
    let half: Vec<[f32; 3]> = all.chunks(64).flat_map(|row| row[32..].to_vec()).collect();
    let right = parts([64, 32], vec![("a", channels(&half, ["R", "G", "B"]), [32, 32], [32, 0])]);
    let error = load(&folder, &right, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("(0, 0)-(63, 31)") && error.contains("(32, 0)-(63, 31)"), "{error}");
    let filled = LoadOptions { fill: Some([5.0, 6.0, 7.0]), ..LoadOptions::default() };
    let map = load(&folder, &right, &filled).unwrap().map;
    // −x lies in the right half of the picture, +x in the left one.
    assert_eq!(
        map.levels[0].texel(0, 8, 8).map(f32::to_bits),
        [5.0f32, 6.0, 7.0].map(f32::to_bits)
    );
    assert_eq!(map.levels[0].texel(1, 8, 8), wanted.levels[0].texel(1, 8, 8));
}

/// A cross of faces of `n` texels whose colours are directions; `upright` leaves −z of a tall one unturned.
fn cross(n: usize, tall: bool, upright: bool, empty: f32) -> ([usize; 2], Vec<[f32; 3]>) {
    let mut cells = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
    let [columns, rows] = if tall { [3, 4] } else { [4, 3] };
    if tall {
        cells[5] = [1, 3];
    }
    let mut out = vec![[empty; 3]; columns * rows * n * n];
    for (face, [column, row]) in cells.into_iter().enumerate() {
        for (y, x) in (0..n * n).map(|i| (i / n, i % n)) {
            let turned = tall && face == 5 && !upright;
            let (u, v) = if turned { (n - 1 - x, n - 1 - y) } else { (x, y) };
            let place = |t: usize| (2.0 * t as f64 + 1.0) / n as f64 - 1.0;
            let d = tapline::cube::direction(face, place(u), place(v));
            let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
            out[(row * n + y) * columns * n + column * n + x] =
                d.map(|c| (c / length + 2.0) as f32);
        }
    }
    ([columns * n, rows * n], out)
}

#[test]
fn a_cross_has_empty_cells_and_its_last_face_is_found_by_its_seams() {
    let folder = Folder::new();
    let plain = LoadOptions::default();
    let of = |(size, texels): ([usize; 2], Vec<[f32; 3]>), options: &LoadOptions| {
        load(&folder, &picture(size[0], size[1], &texels, ["R", "G", "B"]), options)
    };
    let wide = of(cross(16, false, false, 0.0), &plain).unwrap();
    for (upright, words) in [(false, "by its seams"), (true, "-Z upright")] {
        let tall = of(cross(16, true, upright, 0.25), &plain).unwrap();
        assert_eq!(tall.map, wide.map);
        assert!(tall.taken.kind.contains(words), "{}", tall.taken);
    }
    // A photograph in 4:3 has something everywhere.
    let (size, mut photo) = cross(16, false, false, 0.0);
    photo.iter_mut().enumerate().for_each(|(i, t)| *t = [(i % 61) as f32, (i % 7) as f32, 1.0]);
    let error = of((size, photo.clone()), &plain).unwrap_err().to_string();
    assert!(error.contains("empty cells are not empty"), "{error}");
    let named = LoadOptions { layout: Some(Layout::Cross), ..plain.clone() };
    assert!(of((size, photo), &named).unwrap().taken.kind.contains("by --env-layout"));
    // 2:1 but for rounding.
    let odd = of(([551, 276], vec![[1.0; 3]; 551 * 276]), &plain).unwrap();
    assert!(odd.taken.kind.starts_with("lat-long"), "{}", odd.taken);
    assert!(of(([550, 276], vec![[1.0; 3]; 550 * 276]), &plain).is_err());
}

#[test]
fn radiance_files_are_read_in_every_order_with_exposure_and_in_xyz() {
    let folder = Folder::new();
    let pixel = |x: usize, y: usize| [x as u8 + 1, y as u8 + 1, 9, 129];
    let upright: Vec<[u8; 4]> = (0..24).map(|i| pixel(i % 6, i / 6)).collect();
    let wanted = folder.planar(&hdr_file(6, 4, &upright)).unwrap();
    for (first, second) in [("Y", "X"), ("X", "Y")] {
        for signs in ["--", "-+", "+-", "++"] {
            let (one, two) = signs.split_at(1);
            let [rows, columns] = if first == "Y" { [4, 6] } else { [6, 4] };
            let stored = (0..24).map(|i: usize| {
                let along = |axis: &str, sign: &str, at: usize, size: usize| {
                    // Y counts upwards, X to the right.
                    if (axis == "Y") == (sign == "-") { at } else { size - 1 - at }
                };
                let a = along(first, one, i / columns, rows);
                let b = along(second, two, i % columns, columns);
                if first == "Y" { pixel(b, a) } else { pixel(a, b) }
            });
            let mut bytes = format!(
                "#?RADIANCE\nlong={}\nFORMAT=32-bit_rle_rgbe\n\n{one}{first} {rows} {two}{second} {columns}\n",
                "x".repeat(9000)
            )
            .into_bytes();
            bytes.extend(stored.flatten());
            let read = folder.planar(&bytes).unwrap();
            assert_eq!(read.channels, wanted.channels, "{one}{first} {two}{second}");
        }
    }
    let with = |header: &str| {
        let mut bytes = format!("#?RADIANCE\n{header}\n\n-Y 1 +X 1\n").into_bytes();
        bytes.extend([128, 64, 32, 129]);
        let planar = folder.planar(&bytes);
        planar.map(|p| [0, 1, 2].map(|i| p.channels[i].1[0]))
    };
    // 128·2⁻⁷ and so on, divided by 2·2 and the colour correction.
    assert_eq!(with("EXPOSURE=2\nEXPOSURE= 2\nCOLORCORR=1 2 4"), Ok([0.25, 0.0625, 0.015625]));
    let error = with("FORMAT=32-bit_rle_spectral").unwrap_err();
    assert!(!error.to_string().contains("damaged"), "{error}");
    // Equal energy is white of Radiance's primaries: sums of the matrix's rows, each within 1e-6 of 1.
    let mut white = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n".to_vec();
    white.extend([128, 128, 128, 129]);
    let planar = folder.planar(&white).unwrap();
    assert!(planar.channels.iter().all(|(_, p)| (p[0] - 1.0).abs() < 1e-6), "{planar:?}");
}

/// A PNG file with one more chunk behind its header.
fn with_chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let codes: Vec<u8> = (0..8).flat_map(|i: u8| [i * 32; 3]).collect();
    let mut bytes = png_file(4, 2, png::ColorType::Rgb, png::BitDepth::Eight, &codes);
    let mut chunk = u32::try_from(data.len()).unwrap().to_be_bytes().to_vec();
    chunk.extend(kind);
    chunk.extend(data);
    let mut crc = u32::MAX;
    for byte in &chunk[4..] {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 };
        }
    }
    chunk.extend((!crc).to_be_bytes());
    // Signature and IHDR are 33 bytes.
    bytes.splice(33..33, chunk);
    bytes
}

#[test]
fn the_curve_of_a_png_is_its_own_word_or_the_flags() {
    let folder = Folder::new();
    let of = |bytes: &[u8], transfer| {
        let options = LoadOptions { transfer, face_size: Some(1), ..LoadOptions::default() };
        let loaded = load_environment(&folder.file("a.png", bytes), &options)?;
        Ok::<_, InputError>((texels(&loaded.map)[2][0], loaded.taken.transfer))
    };
    let gama = |scaled: u32| with_chunk(b"gAMA", &scaled.to_be_bytes());
    let (linear, words) = of(&gama(100_000), None).unwrap();
    assert_eq!(words, "linear by gAMA");
    let (srgb, words) = of(&gama(45_455), None).unwrap();
    assert_eq!(words, "sRGB curve by gAMA");
    assert!(srgb < linear / 2.0);
    assert_eq!(of(&gama(100_000), Some(Transfer::Srgb)).unwrap().0.to_bits(), srgb.to_bits());
    assert_eq!(of(&gama(45_455), Some(Transfer::Linear)).unwrap().0.to_bits(), linear.to_bits());
    assert!(of(&gama(55_556), None).unwrap().1.starts_with("power 1.8"));
    assert_eq!(of(&with_chunk(b"cICP", &[1, 8, 0, 1]), None).unwrap().1, "linear by cICP");
    let error = of(&with_chunk(b"cICP", &[9, 16, 0, 1]), None).unwrap_err().to_string();
    assert!(error.contains("PQ") && !error.contains("damaged"), "{error}");
}

#[test]
fn the_orientation_of_a_jpeg_is_applied() {
    // A picture of two by one is written by the decoder's own crate; its EXIF says 6: turn right.
    let folder = Folder::new();
    let mut jpeg = Cursor::new(Vec::new());
    let pixels = [[0u8; 8 * 8].as_slice(), &[255; 8 * 8]].concat();
    let pixels: Vec<u8> = (0..128).map(|i| if i % 16 < 8 { 0 } else { pixels[127] }).collect();
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg)
        .encode(&pixels, 16, 8, image::ExtendedColorType::L8)
        .unwrap();
    let mut jpeg = jpeg.into_inner();
    let exif = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    let mut segment = vec![0xff, 0xe1];
    segment.extend(u16::try_from(exif.len() + 2).unwrap().to_be_bytes());
    segment.extend(exif);
    jpeg.splice(2..2, segment);
    let planar = load_planar(&folder.file("a.jpg", &jpeg), &LoadOptions::default()).unwrap();
    assert_eq!((planar.width, planar.height), (8, 16));
    let plane = &planar.channels[0].1;
    assert!(plane[0] < 0.1 && plane[8 * 16 - 1] > 0.9, "the left half is on top");
}

/// A source of three planes, its kind in words.
fn bump(texels: &[[f32; 3]], choice: BumpChoice) -> Result<(BumpSource, String), InputError> {
    let planes = [0, 1, 2].map(|c| texels.iter().map(|t| t[c]).collect::<Vec<f32>>());
    source(texels.len() / 8, 8, &planes, choice, "map")
}

fn normals() -> Vec<[f32; 3]> {
    (0..64u8)
        .map(|i| {
            let (x, y) = (f64::from(i % 8) / 10.0 - 0.35, f64::from(i / 8) / 12.0 - 0.3);
            [x, y, (1.0 - x * x - y * y).sqrt()].map(|c| c as f32)
        })
        .collect()
}

#[test]
fn bump_maps_are_taken_by_their_bulk() {
    let plain = BumpChoice::default();
    let code = |t: &[f32; 3]| t.map(|c| (c + 1.0) / 2.0);
    let heights: Vec<[f32; 3]> = (0..64u8).map(|i| [f32::from(i) / 64.0; 3]).collect();
    let (wanted, _) = source(8, 8, &[heights.iter().map(|t| t[0]).collect()], plain, "").unwrap();
    // One code off in one channel of one texel, and the tint of a lossy file.
    let mut off = heights.clone();
    off[5][2] += 1.0 / 255.0;
    assert_eq!(bump(&off, plain).unwrap().0, wanted);
    let tinted: Vec<[f32; 3]> =
        heights.iter().map(|[r, g, b]| [r + 5.0 / 255.0, *g, b - 4.0 / 255.0]).collect();
    assert_eq!(bump(&tinted, plain).unwrap().0, wanted);
    let sepia: Vec<[f32; 3]> = heights.iter().map(|[h, ..]| [*h, 0.8 * h, 0.5 * h]).collect();
    assert!(bump(&sepia, plain).unwrap().1.contains("one tint"));

    let signed = normals();
    let coded: Vec<[f32; 3]> = signed.iter().map(code).collect();
    let of = |texels: &[[f32; 3]]| match bump(texels, plain).unwrap() {
        (BumpSource::Normals { values, .. }, words) => (values, words),
        other => panic!("{other:?}"),
    };
    let near = |a: &[[f32; 3]], b: &[[f32; 3]], skip: usize| {
        let pairs = a.iter().zip(b).enumerate().filter(|(i, _)| *i != skip);
        // Codes halve and double numbers below 1: two roundings of 2⁻²⁴, four times as large.
        pairs.flat_map(|(_, (a, b))| a.iter().zip(b)).all(|(a, b)| (a - b).abs() < 5e-7)
    };
    assert!(near(&of(&signed).0, &signed, 99) && near(&of(&coded).0, &signed, 99));
    let mut negative = coded.clone();
    negative[9][0] = -0.002;
    let (values, words) = of(&negative);
    assert!(near(&values, &signed, 9) && words.contains("coded"), "{words}");
    for blue in [0.0, 1.0] {
        let two: Vec<[f32; 3]> = coded.iter().map(|t| [t[0], t[1], blue]).collect();
        let (values, words) = of(&two);
        // Z is a root of what 5e-7 may be off: derivative at most 0.6/0.8.
        let all = values.iter().flatten().zip(signed.iter().flatten());
        assert!(all.fold(0.0f32, |w, (a, b)| w.max((a - b).abs())) < 2e-6, "{words}");
        assert!(words.contains("two channels, Z from X and Y"), "{words}");
    }
    // A colour picture is neither, until a flag says so.
    let colours: Vec<[f32; 3]> = (0..64u8).map(|i| [f32::from(i % 8) / 8.0, 0.5, 0.3]).collect();
    let error = bump(&colours, plain).unwrap_err().to_string();
    assert!(error.contains("--bump-kind"), "{error}");
    let named = |kind| BumpChoice { kind: Some(kind), ..plain };
    assert!(bump(&colours, named(BumpKind::Heights)).unwrap().1.contains("by --bump-kind"));
    assert!(bump(&colours, named(BumpKind::Normals)).is_ok());
    let down = BumpChoice { green: Green::Down, ..plain };
    let BumpSource::Normals { values, .. } = bump(&signed, down).unwrap().0 else { panic!() };
    let turned: Vec<[f32; 3]> = signed.iter().map(|[x, y, z]| [*x, -y, *z]).collect();
    assert!(near(&values, &turned, 99));
}

#[test]
fn far_distances_are_nothing_where_the_flag_says_so() {
    let folder = Folder::new();
    let plane = |i: usize| if i == 0 { 1e10 } else { i as f32 - 1.0 };
    let samples = FlatSamples::F32((0..6).map(plane).collect());
    let way = encoding(COMPRESSIONS[0], None);
    let bytes = exr_file(1, 6, vec![("distance", samples)], way, LayerAttributes::default());
    let path = folder.file("d.exr", &bytes);
    let loaded = load_distance(&path, &LoadOptions::default()).unwrap();
    assert!(loaded.taken.to_string().contains("1 distances are 0"), "{}", loaded.taken);
    let far = LoadOptions { far: Some(100.0), ..LoadOptions::default() };
    let loaded = load_distance(&path, &far).unwrap();
    assert!(
        loaded.map.texels[0].is_infinite() && loaded.map.texels[1..].iter().all(|d| d.is_finite())
    );
    assert!(loaded.taken.to_string().contains("1 distances of 100 or more"), "{}", loaded.taken);
}

/// The shared inputs of these kinds lie beside the project, or nowhere.
fn field(name: &str) -> Option<std::path::PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/field").join(name);
    if !path.is_file() {
        eprintln!("skipped: no {}", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn the_shared_inputs_show_the_directions_that_they_hold() {
    let folder = Folder::new();
    let plain = LoadOptions::default();
    let bytes = picture(128, 64, &directions(128, 64), ["R", "G", "B"]);
    let wanted = load(&folder, &bytes, &plain).unwrap().map;
    let sized = LoadOptions { face_size: Some(wanted.size()), ..plain.clone() };
    // A mantissa of eight bits of numbers up to 4 that share an exponent: 2⁻⁷, and as much again by bilinear look-ups.
    for (name, tolerance) in [
        ("env-multipart-depth-first.exr", 2e-3),
        ("env-radiance-plusY-plusX.hdr", 1.6e-2),
        ("env-vertical-cross-minus-z-upright.exr", 2e-2),
    ] {
        let Some(path) = field(name) else { return };
        let loaded = load_environment(&path, &sized).unwrap();
        let worst = worst(&loaded.map, &wanted);
        assert!(worst < tolerance, "{name}: {worst}; {}", loaded.taken);
    }
    let loaded = load_environment(&field("env-png16-gama-1.png").unwrap(), &sized).unwrap();
    for (got, want) in texels(&loaded.map).iter().flatten().zip(texels(&wanted).iter().flatten()) {
        assert!((got * 2.0 + 1.0 - want).abs() < 2e-3, "{got} {want}");
    }
    let loaded = load_environment(&field("env-radiance-xyze.hdr").unwrap(), &plain).unwrap();
    assert!(loaded.taken.to_string().contains("XYZ converted"), "{}", loaded.taken);
    for name in ["env-window-crop-2to1.exr", "env-channels-xyz.exr"] {
        assert!(load_environment(&field(name).unwrap(), &plain).is_err(), "{name}");
    }
    let bump = |name: &str| {
        let file = load_bump_planes(&field(name).unwrap(), false, &plain).unwrap();
        source(file.width, file.height, &file.planes, BumpChoice::default(), name).unwrap()
    };
    let same = |a: &BumpSource, b: &BumpSource, tolerance: f32| match (a, b) {
        (BumpSource::Height { values: a, .. }, BumpSource::Height { values: b, .. }) => {
            a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance)
        }
        (BumpSource::Normals { values: a, .. }, BumpSource::Normals { values: b, .. }) => {
            a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < tolerance)
        }
        _ => false,
    };
    let pair = [bump("bump-height-rgb-one-code-off.png"), bump("bump-height-reference-16bit.png")];
    // Half a step of 8 bits.
    assert!(same(&pair[0].0, &pair[1].0, 0.51 / 255.0));
    let pair = [
        bump("bump-normal-coded-one-negative-sample.exr"),
        bump("bump-normal-coded-reference.exr"),
    ];
    let (BumpSource::Normals { values: a, .. }, BumpSource::Normals { values: b, .. }) =
        (&pair[0].0, &pair[1].0)
    else {
        panic!("{} {}", pair[0].1, pair[1].1)
    };
    assert!(
        a.iter().flatten().zip(b.iter().flatten()).filter(|(a, b)| (*a - *b).abs() > 1e-6).count()
            <= 1
    );
    assert!(bump("bump-normal-two-channel-blue-0.png").1.contains("Z from X and Y"));
}

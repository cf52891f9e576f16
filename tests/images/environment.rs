//! Pictures as environments: shapes, colours, sizes, and the cube's edges.
#![expect(
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "small made-up numbers that are exact in every format they pass through"
)]

use crate::made::{Folder, encoding, exr_file, png_file, ramp, rgb, simple_exr};
use exr::prelude::{Compression, FlatSamples, LayerAttributes, attribute, f16};
use tapline::cube::{FACE_AXES, across_edge};
use tapline::image::{Cleaned, LoadOptions, load_environment};
use tapline::mips::build_mips;
use tapline::srgb::srgb_decode;

fn with_envmap(kind: attribute::EnvironmentMap) -> LayerAttributes {
    LayerAttributes { environment_map: Some(kind), ..LayerAttributes::default() }
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
        // Crosses by their shape, but no cell of theirs is empty.
        (16, 12, none(), None),
        (12, 16, none(), None),
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
        let options =
            LoadOptions { max_image_mb: mb, face_size: Some(size), ..LoadOptions::default() };
        load_environment(&folder.file("sized", bytes), &options)
    };
    let strip =
        exr_file(4, 24, rgb(4, 24), encoding(Compression::ZIP16, None), LayerAttributes::default());
    for bytes in [simple_exr(16, 8, Compression::ZIP16), strip] {
        for size in [1, 3, 8] {
            let map = load(&bytes, size, 512).unwrap().map;
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
    let stripes: Vec<f32> = (0..width * height).map(|i| f32::from((i % 2) as u8)).collect();
    let channels = vec![("Y", FlatSamples::F32(stripes))];
    let encoding = encoding(Compression::ZIP16, None);
    let bytes = exr_file(width, height, channels, encoding, LayerAttributes::default());
    let options = LoadOptions { face_size: Some(2), ..LoadOptions::default() };
    let map = load_environment(&folder.file("stripes", &bytes), &options).unwrap().map;
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
    let expected = Cleaned { nan: 1, inf: 2, negative: 1 };
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

/// The middles of a texel's four sides in 3-D, times `size`: whole numbers.
fn side_middles(size: usize, face: usize, x: usize, y: usize) -> [[i64; 3]; 4] {
    let n = i64::try_from(size).unwrap();
    let centre = |t: usize| 2 * i64::try_from(t).unwrap() + 1 - n;
    [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| {
        let mut point = [0; 3];
        for ((axis, sign), value) in
            FACE_AXES[face].into_iter().zip([centre(x) + dx, centre(y) + dy, n])
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
    let map = load_environment(&path, &LoadOptions::default()).unwrap().map;
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
            let half = ramp(width, height, i).into_iter().map(f16::from_f32).collect();
            (name, FlatSamples::F16(half))
        })
        .collect();
    let encoding = encoding(Compression::ZIP16, None);
    let bytes = exr_file(width, height, channels, encoding, LayerAttributes::default());
    let path = folder.file("large.exr", &bytes);
    let start = std::time::Instant::now();
    let map = load_environment(&path, &LoadOptions::default()).unwrap().map;
    eprintln!("{} MiB file, {:.2} s", bytes.len() >> 20, start.elapsed().as_secs_f64());
    assert_eq!((map.size(), map.levels.len()), (1024, 11));
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    eprintln!("{}", status.lines().find(|l| l.starts_with("VmHWM")).unwrap_or("no memory figure"));
}

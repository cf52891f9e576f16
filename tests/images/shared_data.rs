//! Image loading on the shared test data, which lies beside the project and not in it.
//!
//! Without that folder every test here says so on stderr and passes.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "texel indices and statistics over small sizes"
)]

use std::path::{Path, PathBuf};
use tapline::cube::{CubeLevel, FACE_NAMES, face_uv};
use tapline::image::planar::Colour;
use tapline::image::{
    Cleaned, EnvLayout, LoadOptions, Sample, load_environment, load_planar, load_planar_levels,
    write_exr,
};
use tapline::srgb::srgb_encode;

/// The shared data, or nothing and a line on stderr.
fn data(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(folder);
    if path.is_dir() {
        Some(path)
    } else {
        eprintln!("skipped: no shared test data at {}", path.display());
        None
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn level0(path: &Path, face_size: usize) -> CubeLevel {
    let options = LoadOptions { face_size: Some(face_size), ..LoadOptions::default() };
    let map = load_environment(path, &options).unwrap().map;
    map.levels.into_iter().next().unwrap()
}

/// PSNR in dB per face after clamping to 0..1 and sRGB encoding, peak 1.
fn psnr_per_face(a: &CubeLevel, b: &CubeLevel) -> [f64; 6] {
    let n = a.size * a.size;
    assert_eq!(a.size, b.size);
    std::array::from_fn(|face| {
        let texels = face * n..(face + 1) * n;
        let sum: f64 = a.texels[texels.clone()]
            .iter()
            .flatten()
            .zip(b.texels[texels].iter().flatten())
            .map(|(a, b)| {
                let d = srgb_encode(f64::from(*a).min(1.0)) - srgb_encode(f64::from(*b).min(1.0));
                d * d
            })
            .sum();
        -10.0 * (sum / (3 * n) as f64).log10()
    })
}

/// The six faces beside each other as a PNG, for people.
fn write_faces(cube: &CubeLevel, path: &Path) {
    let n = cube.size;
    let mut picture = tapline::picture::Picture::new(6 * n, n);
    for face in 0..6 {
        for y in 0..n {
            for x in 0..n {
                picture.rgb[y * 6 * n + face * n + x] = cube.texel(face, x, y).map(f64::from);
            }
        }
    }
    let mut file = tapline::image::WholeFile::create(path).unwrap();
    file.write_with(|w| tapline::image::write_png(w, &picture, 0.0, &[])).unwrap();
    file.commit().unwrap();
}

/// The face's eight orientations: exchanged axes, mirrored columns, mirrored rows.
fn turned(cube: &CubeLevel, [swap, mirror_x, mirror_y]: [bool; 3]) -> CubeLevel {
    let n = cube.size;
    let mut out = cube.clone();
    for (i, texel) in out.texels.iter_mut().enumerate() {
        let (face, y, x) = (i / (n * n), i / n % n, i % n);
        let (x, y) = if swap { (y, x) } else { (x, y) };
        let x = if mirror_x { n - 1 - x } else { x };
        let y = if mirror_y { n - 1 - y } else { y };
        *texel = cube.texel(face, x, y);
    }
    out
}

#[test]
fn cube_and_latlong_versions_of_a_scene_agree_on_every_face_in_this_orientation_only() {
    let Some(env) = data("env") else { return };
    let out = std::env::var_os("TAPLINE_TEST_PICTURES").map(PathBuf::from);
    for name in ["Orientation", "KernerEnv", "StageEnv"] {
        let cube = level0(&env.join(format!("{name}Cube.exr")), 256);
        let latlong = level0(&env.join(format!("{name}LatLong.exr")), 256);
        if let Some(out) = &out {
            write_faces(&cube, &out.join(format!("{name}-cube.png")));
            write_faces(&latlong, &out.join(format!("{name}-latlong.png")));
        }
        let psnr = psnr_per_face(&cube, &latlong);
        eprintln!("{name}: {psnr:.1?} dB");
        // Both files were filtered from one source by others, so their difference is theirs. What
        // is ours, the orientation, must stand out: an error energy ten times smaller (10 dB) than
        // in each of the seven other orientations of the face.
        for wrong in 1..8 {
            let wrong = [wrong & 1 != 0, wrong & 2 != 0, wrong & 4 != 0];
            let other = psnr_per_face(&turned(&cube, wrong), &latlong);
            for face in 0..6 {
                let label = FACE_NAMES[face];
                assert!(psnr[face] > other[face] + 10.0, "{name} {label} {wrong:?}: {other:?}");
            }
        }
    }
}

#[test]
fn samples_of_marked_latlong_maps_lie_on_the_poles() {
    // The same pixels without the attribute are read at half-texel centres: that must fit the cube
    // version of the scene worse than the poles do.
    let Some(env) = data("env") else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in ["Orientation", "KernerEnv", "StageEnv"] {
        let cube = level0(&env.join(format!("{name}Cube.exr")), 256);
        let path = env.join(format!("{name}LatLong.exr"));
        let marked = level0(&path, 256);
        let planar = load_planar(&path, &LoadOptions::default()).unwrap();
        assert_eq!(planar.envmap, Some(EnvLayout::LatLong));
        let mut picture = tapline::picture::Picture::new(planar.width, planar.height);
        for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let samples = planar.channel(channel).unwrap();
            for (pixel, v) in picture.rgb.iter_mut().zip(samples) {
                pixel[c] = f64::from(*v);
            }
        }
        let mut bytes = Vec::new();
        write_exr(&mut bytes, &picture, &[], Sample::Float).unwrap();
        let unmarked = folder.path().join("unmarked.exr");
        std::fs::write(&unmarked, bytes).unwrap();
        let (right, wrong) =
            (psnr_per_face(&marked, &cube), psnr_per_face(&level0(&unmarked, 256), &cube));
        eprintln!("{name}: on the poles {right:.1?}, at halves {wrong:.1?} dB");
        let mean = |p: [f64; 6]| p.iter().sum::<f64>() / 6.0;
        assert!(mean(right) > mean(wrong) + 1.0, "{name}");
    }
}

/// The lowest blue value along the ray from the centre of a face towards an axis: the chart's axes
/// are black, its text and grid are light blue and pink.
fn darkest_towards(cube: &CubeLevel, face: usize, axis: usize, sign: f64) -> usize {
    let mut dark = 0;
    for step in 6..30 {
        let mut d = [0.0; 3];
        let major = face / 2;
        d[major] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        d[axis] = sign * f64::from(step) / 100.0;
        let (found, u, v) = face_uv(d);
        assert_eq!(found, face);
        let texel =
            |t: f64| (((t + 1.0) / 2.0 * cube.size as f64).floor() as usize).min(cube.size - 1);
        // The line is a few pixels wide and may lie beside the exact centre.
        let (x, y) = (texel(u), texel(v));
        let near = |t: usize| t.saturating_sub(1)..=t + 1;
        let lowest = near(y)
            .flat_map(|y| near(x).map(move |x| cube.texel(face, x, y)))
            .map(|c| c[2])
            .fold(f32::MAX, f32::min);
        dark += usize::from(lowest < 0.25);
    }
    dark
}

#[test]
fn the_axes_drawn_in_the_orientation_chart_point_where_they_should() {
    let Some(env) = data("env") else { return };
    for name in ["OrientationCube.exr", "OrientationLatLong.exr"] {
        let cube = level0(&env.join(name), 256);
        for (face, label) in FACE_NAMES.iter().enumerate() {
            for axis in (0..3).filter(|axis| *axis != face / 2) {
                let towards = darkest_towards(&cube, face, axis, 1.0);
                let away = darkest_towards(&cube, face, axis, -1.0);
                // Of the 24 places the axis darkens all without a gap; on the other side lies at most
                // a letter, less than half as long.
                assert!(
                    towards == 24 && away < 12,
                    "{name} {label} axis {axis}: {towards} dark places towards +, {away} away"
                );
            }
        }
    }
}

#[test]
fn bad_samples_are_counted_as_the_data_says() {
    let Some(env) = data("env") else { return };
    for (name, negative) in [
        ("blender-city.exr", 506),
        ("blender-forest.exr", 784),
        ("blender-interior.exr", 8980),
        ("blender-studio.exr", 3),
        ("pmndrs-sky.exr", 33),
        ("pmndrs-esplanade.hdr", 0),
        ("KernerEnvCube.exr", 0),
    ] {
        let loaded = load_environment(&env.join(name), &LoadOptions::default()).unwrap();
        let (map, cleaned) = (loaded.map, loaded.cleaned);
        let expected = Cleaned { negative, ..Cleaned::default() };
        assert_eq!(cleaned, expected, "{name}");
        assert_eq!(map.size(), if name == "pmndrs-sky.exr" { 128 } else { 256 });
        let sane = |v: &f32| v.is_finite() && *v >= 0.0;
        for level in &map.levels {
            assert!(level.texels.iter().flatten().all(sane), "{name}");
        }
    }
    let valid = env.join("../exr-odd/valid");
    for (name, nan, inf, negative) in [
        ("AllHalfValues.exr", 6138, 6, 95_229),
        ("BrightRingsNanInf.exr", 6, 12, 0),
        ("WideFloatRange.exr", 0, 0, 125_000),
        ("WideColorGamut.exr", 0, 0, 128_284),
    ] {
        let mut planar = load_planar(&valid.join(name), &LoadOptions::default()).unwrap();
        let mut cleaned = Cleaned::default();
        for (_, samples) in &mut planar.channels {
            cleaned.clean(samples);
        }
        assert_eq!((cleaned.nan, cleaned.inf, cleaned.negative), (nan, inf, negative), "{name}");
    }
}

#[test]
fn stored_mip_chains_are_read_whole() {
    let Some(root) = data("bump") else { return };
    let options = LoadOptions::default();
    for (name, size) in [
        ("oiio-bumpslope.exr", 64),
        ("oiio-bumpslope-central.exr", 64),
        ("oiio-bumpslope-normal.exr", 128),
    ] {
        let levels = load_planar_levels(&root.join(name), &options).unwrap();
        let sizes: Vec<usize> = levels.iter().map(|l| l.width).collect();
        let expected: Vec<usize> = (0..8).map(|l| size >> l).filter(|n| *n > 0).collect();
        assert_eq!(sizes, expected, "{name}");
        for level in &levels {
            let names: Vec<&str> = level.channels.iter().map(|c| c.0.as_str()).collect();
            let six = ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];
            assert_eq!(names, six, "{name}");
        }
    }
    let levels = load_planar_levels(&root.join("oiio-bumpslope.exr"), &options).unwrap();
    let (mut low, mut high) = (f32::MAX, f32::MIN);
    for v in levels[0].channels.iter().flat_map(|c| &c.1) {
        (low, high) = (low.min(*v), high.max(*v));
    }
    // The data's README gives the range to four digits.
    assert!((low + 53.6).abs() < 0.05 && (high - 112.6).abs() < 0.05, "{low} {high}");

    // Every level of this chart has a colour of its own.
    let chart = root.join("../exr-odd/valid/ColorCodedLevels.exr");
    let levels = load_planar_levels(&chart, &options).unwrap();
    assert_eq!(levels.len(), 10);
    let colours: Vec<[u64; 3]> = levels
        .iter()
        .map(|level| {
            ["R", "G", "B"].map(|c| {
                let samples = level.channel(c).unwrap();
                let mean =
                    samples.iter().map(|v| f64::from(*v)).sum::<f64>() / samples.len() as f64;
                (mean * 1000.0).round() as u64
            })
        })
        .collect();
    for pair in colours.windows(2) {
        assert_ne!(pair[0], pair[1], "{colours:?}");
    }
}

#[test]
fn bump_maps_of_every_kind_are_read_as_raw_codes() {
    let Some(root) = data("bump") else { return };
    for (name, width, channels, low, high) in [
        ("brushed-aluminium_normal.png", 745, 3, 14.0, 255.0),
        ("wool_depth.png", 1024, 1, 2.0, 161.0),
        ("mesh_wire_norm.png", 512, 3, 0.0, 255.0),
        ("plain_heightmap.png", 512, 1, 0.0, 252.0),
        ("BoomBox_normal.png", 2048, 3, 0.0, 255.0),
        ("fabric_pattern_07_nor_gl_1k.jpg", 1024, 3, 41.0, 255.0),
        ("brass_roughness.jpg", 2048, 1, 10.0, 255.0),
    ] {
        let planar = load_planar(&root.join(name), &LoadOptions::default()).unwrap();
        assert_eq!((planar.width, planar.height), (width, width), "{name}");
        assert_eq!(planar.channels.len(), channels, "{name}");
        let samples = || planar.channels.iter().flat_map(|c| &c.1).copied();
        let found = (samples().fold(f32::MAX, f32::min), samples().fold(f32::MIN, f32::max));
        // JPEG decoders may differ by a few codes where the chroma is sub-sampled; PNG is exact.
        let slack = if name.ends_with(".jpg") { 3.0 } else { 1e-3 };
        assert!((found.0 * 255.0 - low).abs() <= slack, "{name} {found:?}");
        assert!((found.1 * 255.0 - high).abs() <= slack, "{name} {found:?}");
    }
}

#[test]
fn every_unusual_but_valid_exr_is_read_or_refused_by_name() {
    let Some(folder) = data("exr-odd/valid") else {
        return;
    };
    let refused = |name: &str| match name {
        "Rec709_YC.exr" => Some("sub-sampling 2x2"),
        "tinydeep.exr" | "deep-nosamples.exr" => Some("deep data"),
        _ => None,
    };
    for file in files(&folder) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        match (load_planar_levels(&file, &LoadOptions::default()), refused(&name)) {
            (Ok(levels), None) => assert!(!levels.is_empty()),
            (Err(error), Some(why)) => assert_eq!(error.found, why, "{name}"),
            (result, _) => panic!("{name}: {result:?}"),
        }
    }
    for name in ["DisplayWindow-t08.exr", "DisplayWindow-t12.exr"] {
        let planar = load_planar(&folder.join(name), &LoadOptions::default()).unwrap();
        assert_eq!((planar.width, planar.height), (400, 300), "{name}");
    }
    let planar = load_planar(&folder.join("layers.exr"), &LoadOptions::default()).unwrap();
    assert_eq!(planar.colour("layers").unwrap(), Colour::Rgb([3, 2, 1]));
    let planar = load_planar(&folder.join("WideFloatRange.exr"), &LoadOptions::default()).unwrap();
    assert_eq!(planar.colour("range").unwrap(), Colour::Grey(0));
    let highest = planar.channels[0].1.iter().copied().fold(0.0f32, f32::max);
    assert!((1.6e38..1.8e38).contains(&highest));
}

/// Loads every file of exr-odd; run in a child process with a memory limit by the test below.
#[test]
fn hostile_files_end_in_an_error_or_in_pixels() {
    for folder in ["exr-odd/damaged", "exr-odd/valid"] {
        let Some(folder) = data(folder) else { return };
        for file in files(&folder) {
            let start = std::time::Instant::now();
            let options = LoadOptions::default();
            let results = [
                load_planar_levels(&file, &options).map(|_| ()),
                load_environment(&file, &options).map(|_| ()),
            ];
            for error in results.into_iter().filter_map(Result::err) {
                assert!(!error.expected.is_empty() && !error.found.is_empty());
                assert!(!error.to_string().contains("fault in the decoder"), "{error}");
            }
            let seconds = start.elapsed().as_secs_f64();
            assert!(seconds < 20.0, "{}: {seconds} s", file.display());
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn hostile_files_need_less_than_one_and_a_half_gigabytes() {
    if data("exr-odd/damaged").is_none() {
        return;
    }
    // Two threads: each reserves address space, which is what the limit counts.
    let name = concat!(module_path!(), "::hostile_files_end_in_an_error_or_in_pixels");
    let (_, name) = name.split_once("::").unwrap();
    let run = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 1572864 && exec \"$0\" \"$@\""])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", name, "--test-threads", "1"])
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && said.contains("1 passed"), "{}: {said}", run.status);
}

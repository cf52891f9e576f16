//! Image loading on the shared test data, which lies beside the project and not in it.
//!
//! Without that folder every test here says so on stderr and passes.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "pictures for people and statistics over small sizes"
)]

use std::path::{Path, PathBuf};
use tapline::cube::{CubeLevel, FACE_NAMES};
use tapline::error::InputError;
use tapline::image::{
    Cleaned, EnvLayout, LoadOptions, load_environment, load_planar, load_planar_levels, srgb_encode,
};

/// The shared data, or nothing and a line on stderr.
fn data(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data")
        .join(folder);
    if path.is_dir() {
        Some(path)
    } else {
        eprintln!("skipped: no shared test data at {}", path.display());
        None
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn level0(path: &Path, face_size: usize) -> CubeLevel {
    let options = LoadOptions {
        face_size: Some(face_size),
        ..LoadOptions::default()
    };
    let (map, _) = load_environment(path, &options).unwrap();
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
    file.write_with(|w| tapline::image::write_png(w, &picture, 0.0, &[]))
        .unwrap();
    file.commit().unwrap();
}

#[test]
fn cube_and_latlong_versions_of_a_scene_agree_on_every_face() {
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
        for (face, mine) in psnr.iter().enumerate() {
            assert!(*mine > 20.0, "{name} {}", FACE_NAMES[face]);
        }
    }
}

#[test]
fn print_odd() {
    for folder in ["exr-odd/valid", "exr-odd/damaged"] {
        let Some(folder) = data(folder) else { return };
        for file in files(&folder) {
            let t = std::time::Instant::now();
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            match load_planar_levels(&file, &LoadOptions::default()) {
                Ok(l) => eprintln!(
                    "P {name}: {} levels {}x{} {:?}",
                    l.len(),
                    l[0].width,
                    l[0].height,
                    l[0].channels
                        .iter()
                        .map(|c| c.0.clone())
                        .collect::<Vec<_>>()
                ),
                Err(e) => eprintln!("P {name}: {e}"),
            }
            match load_environment(&file, &LoadOptions::default()) {
                Ok((m, c)) => eprintln!("E {name}: {} {c:?}  {:?}", m.size(), t.elapsed()),
                Err(e) => eprintln!("E {name}: {e}  {:?}", t.elapsed()),
            }
        }
    }
    let Some(env) = data("env") else { return };
    for file in files(&env) {
        let t = std::time::Instant::now();
        let (m, c) = load_environment(&file, &LoadOptions::default()).unwrap();
        let t = t.elapsed();
        let p = load_planar(&file, &LoadOptions::default()).unwrap();
        let (mut lo, mut hi) = (f32::MAX, f32::MIN);
        for (_, s) in p.channels.iter().filter(|c| c.0 != "A") {
            for v in s {
                lo = lo.min(*v);
                hi = hi.max(*v);
            }
        }
        eprintln!("{}: {} {c:?} {t:?} {lo} {hi}", file.display(), m.size());
    }
    let _ = (Cleaned::default(), EnvLayout::Cube, None::<InputError>);
}

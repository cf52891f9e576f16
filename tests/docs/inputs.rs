//! The conventions that docs/inputs.md states: its tables, and its chart, which loads as the environment that it shows.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "places of a picture of a few hundred pixels"
)]

use std::path::{Path, PathBuf};

use support::{golden, house};
use tapline::cube::{CubeLevel, FACE_NAMES, direction, major_face};
use tapline::image::{LoadOptions, load_environment, load_planar, write_planes, write_png};
use tapline::picture::Picture;
use tapline::report::font::{draw_text, fill, text_width};
use tapline::srgb::linear_of_bytes;

/// The rows of the document's tables whose first cell passes.
fn rows(first: impl Fn(&str) -> bool) -> Vec<Vec<String>> {
    let text = house::read(&house::root("docs/inputs.md"));
    let lines = text.lines().filter(|line| line.starts_with('|'));
    let cells = lines.map(|line| {
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>()
    });
    cells.filter(|row| first(&row[0])).collect()
}

fn numbers<T: std::str::FromStr>(cell: &str) -> Vec<T> {
    cell.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

fn exr(folder: &Path, size: [usize; 2], lit: impl Fn(usize, usize) -> bool) -> PathBuf {
    let path = folder.join("a.exr");
    let plane: Vec<f32> = (0..size[0] * size[1])
        .map(|i| f32::from(u8::from(lit(i % size[0], i / size[0]))))
        .collect();
    let planes = ["R", "G", "B"].map(|name| (name.to_owned(), plane.clone()));
    let mut file = std::fs::File::create(&path).unwrap();
    write_planes(&mut file, size, planes.to_vec(), &[]).unwrap();
    path
}

/// The face whose centre is brightest.
fn brightest(path: &Path) -> usize {
    let loaded = load_environment(path, &LoadOptions::default()).unwrap();
    let level: &CubeLevel = &loaded.map.levels[0];
    let at = level.size / 2;
    (0..6).max_by(|a, b| level.texel(*a, at, at)[0].total_cmp(&level.texel(*b, at, at)[0])).unwrap()
}

#[test]
fn a_bright_spot_at_each_stated_place_is_on_the_stated_face() {
    let folder = tempfile::tempdir().unwrap();
    let table = rows(|first| FACE_NAMES.contains(&first));
    assert_eq!(table.len(), 6);
    for row in table {
        let face = FACE_NAMES.iter().position(|name| *name == row[0]).unwrap();
        let toward: Vec<f64> = numbers(&row[1]);
        assert_eq!(major_face([toward[0], toward[1], toward[2]]), face);
        let [across, down] = [2, 3].map(|i: usize| row[i].parse::<f64>().unwrap());
        let near = |at: usize, size: f64, centre: f64, wraps: bool| {
            let d = ((at as f64 + 0.5) / size - centre).abs();
            (if wraps { d.min(1.0 - d) } else { d }) < 3.0 / size
        };
        let lit = |x, y| {
            (near(x, 64.0, across, true) || (y + 16) % 32 == 15) && near(y, 32.0, down, false)
        };
        assert_eq!(
            brightest(&exr(folder.path(), [64, 32], lit)),
            face,
            "{row:?} in a lat-long map"
        );
        let place: usize = row[4].parse().unwrap();
        let strip = exr(folder.path(), [4, 24], |_, y| y / 4 == place);
        assert_eq!(brightest(&strip), face, "{row:?} in a strip");
        let strip = exr(folder.path(), [24, 4], |x, _| x / 4 == place);
        assert_eq!(brightest(&strip), face, "{row:?} in a strip");
        let cell: Vec<usize> = numbers(&row[5]);
        let cross = exr(folder.path(), [16, 12], |x, y| [x / 4, y / 4] == [cell[0], cell[1]]);
        assert_eq!(brightest(&cross), face, "{row:?} in a cross");
        for (cell, [u, v]) in [(&row[6], [1.0, 0.0]), (&row[7], [0.0, 1.0])] {
            let (there, centre) = (direction(face, u, v), direction(face, 0.0, 0.0));
            let way = [0, 1, 2].map(|i| there[i] - centre[i]);
            assert_eq!(FACE_NAMES[major_face(way)], cell, "{row:?}");
        }
    }
}

#[test]
fn the_stated_values_are_those_of_the_flags() {
    let command = tapline::cli::command();
    let compare = command.find_subcommand("compare").unwrap();
    let table = rows(|first| first.starts_with("`--"));
    let listed = |flag: &str| compare.get_arguments().find(|a| a.get_long() == Some(flag));
    assert_eq!(table.len(), 5);
    for row in table {
        let flag = row[0].trim_matches('`').trim_start_matches("--");
        let values = listed(flag).expect("a flag of compare").get_possible_values();
        let values: Vec<String> = values.iter().map(|v| format!("`{}`", v.get_name())).collect();
        assert_eq!(row[1], values.join(" "), "{flag}");
    }
}

/// Colour of a direction on the chart: a hue for each axis, light on its positive side, with a grid.
fn chart_colour(d: [f64; 3]) -> [u8; 3] {
    let face = major_face(d);
    let largest = d.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    let lines = d.iter().filter(|c| c.abs() < largest).any(|c| {
        let place = (c / largest * 4.0).abs();
        (place - place.round()).abs() < 0.06 && place < 3.9
    });
    let strong = if lines {
        255
    } else if face.is_multiple_of(2) {
        220
    } else {
        120
    };
    let mut colour = [if lines { 200 } else { 60 }; 3];
    colour[face / 2] = strong;
    colour
}

/// Columns, rows and places of the three pictures of the chart.
const LAT_LONG: [usize; 4] = [512, 256, 8, 8];
const CROSS: [usize; 4] = [512, 384, 8, 280];
const STRIP: [usize; 4] = [528, 88, 8, 680];

fn label(picture: &mut Picture, face: usize, (x, y): (usize, usize)) {
    let text = FACE_NAMES[face].to_uppercase();
    let left = x.saturating_sub(text_width(&text, 3) / 2).max(10);
    draw_text(picture, (left, y.saturating_sub(10)), &text, 3, [1.0; 3]);
}

fn chart() -> Picture {
    let mut picture = Picture::new(STRIP[0] + 16, STRIP[3] + STRIP[1] + 8);
    let size = (picture.width, picture.height);
    fill(&mut picture, (0, 0), size, [1.0; 3]);
    let pi = std::f64::consts::PI;
    let [w, h, left, top] = LAT_LONG;
    for (y, x) in (0..w * h).map(|i| (i / w, i % w)) {
        let (lon, lat) = (
            pi - 2.0 * pi * (x as f64 + 0.5) / w as f64,
            pi / 2.0 - pi * (y as f64 + 0.5) / h as f64,
        );
        let (sin, cos, up, flat) = (libm::sin(lon), libm::cos(lon), libm::sin(lat), libm::cos(lat));
        let colour = linear_of_bytes(chart_colour([sin * flat, up, cos * flat]));
        fill(&mut picture, (left + x, top + y), (1, 1), colour);
    }
    let [_, _, left, top] = CROSS;
    fill(&mut picture, (left, top), (CROSS[0], CROSS[1]), [0.0; 3]);
    for row in rows(|first| FACE_NAMES.contains(&first)) {
        let face = FACE_NAMES.iter().position(|name| *name == row[0]).unwrap();
        let cell: Vec<usize> = numbers(&row[5]);
        let places = [
            (CROSS[1] / 3, CROSS[2] + cell[0] * CROSS[1] / 3, CROSS[3] + cell[1] * CROSS[1] / 3),
            (STRIP[1], STRIP[2] + row[4].parse::<usize>().unwrap() * STRIP[1], STRIP[3]),
        ];
        for (side, left, top) in places {
            let place = |t: usize| (2.0 * t as f64 + 1.0) / side as f64 - 1.0;
            for (y, x) in (0..side * side).map(|i| (i / side, i % side)) {
                let colour = linear_of_bytes(chart_colour(direction(face, place(x), place(y))));
                fill(&mut picture, (left + x, top + y), (1, 1), colour);
            }
            label(&mut picture, face, (left + side / 2, top + side / 2));
        }
        let [across, down] = [2, 3].map(|i: usize| row[i].parse::<f64>().unwrap());
        let at = |share: f64, size: usize| (share * size as f64) as usize;
        let y = at(down, LAT_LONG[1]).clamp(18, LAT_LONG[1] - 18);
        label(&mut picture, face, (LAT_LONG[2] + at(across, LAT_LONG[0]), LAT_LONG[3] + y));
    }
    picture
}

#[test]
fn the_chart_is_drawn_by_the_table_and_its_pictures_are_one_environment() {
    let path = house::root("docs/images/orientation.png");
    let drawn = chart();
    if std::env::var_os(golden::BLESS).is_some() {
        let mut bytes = Vec::new();
        write_png(&mut bytes, &drawn, 0.0, &[]).unwrap();
        std::fs::write(&path, bytes).unwrap();
        panic!("{} written; run again without {}", path.display(), golden::BLESS);
    }
    let stored = load_planar(&path, &LoadOptions::default()).unwrap();
    assert_eq!((stored.width, stored.height), (drawn.width, drawn.height));
    // Half a step of 8 bits, and the rounding of a single.
    let light = |i: usize, c: usize| {
        let code = f64::from(stored.channels[c].1[i]);
        (code - tapline::srgb::srgb_encode(drawn.rgb[i][c])).abs()
    };
    assert!((0..drawn.rgb.len()).all(|i| (0..3).all(|c| light(i, c) < 0.51 / 255.0)));
    // Cut out of the committed picture, all three give the same colours at the middles of the faces' quarters.
    let folder = tempfile::tempdir().unwrap();
    let cut = |[w, h, left, top]: [usize; 4]| {
        let planes = [0, 1, 2].map(|c: usize| {
            let row = |y: usize| &stored.channels[c].1[(top + y) * stored.width + left..][..w];
            let plane: Vec<f32> = (0..h).flat_map(|y| row(y).to_vec()).collect();
            (["R", "G", "B"][c].to_owned(), plane)
        });
        let path = folder.path().join("cut.exr");
        let mut file = std::fs::File::create(&path).unwrap();
        write_planes(&mut file, [w, h], planes.to_vec(), &[]).unwrap();
        let options = LoadOptions { face_size: Some(32), ..LoadOptions::default() };
        load_environment(&path, &options).unwrap()
    };
    let all = [LAT_LONG, CROSS, STRIP].map(cut);
    for (loaded, kind) in all.iter().zip(["lat-long", "cube cross", "cube strip"]) {
        assert!(loaded.taken.kind.starts_with(kind), "{}", loaded.taken);
        for face in 0..6 {
            for (x, y) in [(6, 6), (26, 6), (6, 26), (26, 26)] {
                let (got, want) =
                    [loaded, &all[1]].map(|l| l.map.levels[0].texel(face, x, y)).into();
                // A grid line may run through part of a texel; the hue of another face would differ by 0.4.
                let far = got.iter().zip(want).any(|(a, b): (&f32, f32)| (a - b).abs() > 0.25);
                assert!(!far, "{kind}, face {face}: {got:?} {want:?}");
            }
        }
    }
}

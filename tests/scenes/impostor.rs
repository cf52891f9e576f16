//! Impostor files: written, read back, refused.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use std::fs::File;
use std::path::PathBuf;

use glam::{DVec3, dvec3};
use tapline::image::{LoadOptions, load_distance, load_environment, load_planar, write_planes};
use tapline::impostor::{Impostor, write_impostor};
use tapline::scene::world::World;
use tapline::scene::world::bodies::{Ball, Cuboid};
use tapline::scene::world::{built_in, paint::Paint};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn planes(&self, size: [usize; 2], planes: &[(&str, Vec<f32>)]) -> PathBuf {
        let path = self.0.path().join("planes.exr");
        let planes = planes.iter().map(|(n, s)| ((*n).to_string(), s.clone()));
        let mut file = File::create(&path).unwrap();
        write_planes(&mut file, size, planes.collect(), &[]).unwrap();
        path
    }
}

fn bits(samples: &[f32]) -> Vec<u32> {
    samples.iter().map(|s| s.to_bits()).collect()
}

#[test]
fn an_impostor_comes_back_without_a_changed_bit() {
    let folder = Folder::new();
    let path = folder.0.path().join("room.exr");
    // A ball alone: most directions see nothing and are infinite.
    let ball = World::default().with(
        Ball { centre: dvec3(0.5, 0.0, -2.0), radius: 1.0 },
        Paint::Tiled { colour: [0.5; 3] },
    );
    for (world, infinite) in [(ball, true), (built_in::columns(), false)] {
        let impostor = Impostor::build(&world, DVec3::ZERO, 24);
        let mut file = File::create(&path).unwrap();
        write_impostor(&mut file, &impostor, &[]).unwrap();
        let options = LoadOptions::default();
        let loaded = load_distance(&path, &options).unwrap();
        let (distance, cleaned) = (loaded.map, loaded.cleaned);
        assert_eq!(distance.size, 24);
        assert_eq!(bits(&distance.texels), bits(&impostor.distance.texels));
        assert_eq!(distance.texels.iter().any(|d| d.is_infinite()), infinite);
        assert_eq!(cleaned.note("f"), None);
        let colour = load_environment(&path, &options).unwrap().map;
        assert_eq!(colour, impostor.colour);
        let planar = load_planar(&path, &options).unwrap();
        let wall = planar.channel("wall.index").unwrap();
        let seen = impostor.walls.texels.iter().map(|w| f64::from(w.wall));
        assert!(wall.iter().map(|w| f64::from(*w)).eq(seen));
    }
}

#[test]
fn the_channel_is_found_by_name_and_a_missing_one_lists_those_present() {
    let folder = Folder::new();
    let plane = |value: f32| vec![value; 6];
    let load = |path: &PathBuf, channel: Option<&str>| {
        let named = channel.map(|c| PathBuf::from(format!("{}:{c}", path.display())));
        let path = named.as_ref().unwrap_or(path);
        load_distance(path, &LoadOptions::default()).map(|loaded| loaded.map.texels[0])
    };
    let path = folder.planes([1, 6], &[("A", plane(1.0)), ("Z", plane(2.0))]);
    assert_eq!(load(&path, None), Ok(2.0));
    assert_eq!(load(&path, Some("A")), Ok(1.0));
    let path = folder.planes([1, 6], &[("R", plane(1.0)), ("depth.Z", plane(3.0))]);
    assert_eq!(load(&path, None), Ok(3.0));
    let path = folder.planes([1, 6], &[("G", plane(1.0)), ("R", plane(3.0))]);
    for channel in [None, Some("Z")] {
        let text = load(&path, channel).unwrap_err().to_string();
        assert!(text.contains("found G, R") && text.contains('Z'), "{text}");
    }
}

#[test]
fn distances_that_are_none_become_infinite_and_are_counted() {
    let folder = Folder::new();
    let samples = vec![1.0, f32::NAN, -1.0, f32::NEG_INFINITY, f32::INFINITY, -0.0];
    let path = folder.planes([1, 6], &[("Z", samples)]);
    let loaded = load_distance(&path, &LoadOptions::default()).unwrap();
    let (cube, cleaned) = (loaded.map, loaded.cleaned);
    assert_eq!((cleaned.nan, cleaned.negative), (1, 2));
    let infinite = f32::INFINITY;
    let want = [1.0, infinite, infinite, infinite, infinite, 0.0];
    assert_eq!(bits(&cube.texels), bits(&want));
}

#[test]
fn resampling_keeps_infinite_texels_infinite_and_never_makes_a_nan() {
    let folder = Folder::new();
    let mut samples = vec![2.0f32; 6 * 64];
    samples[..32].fill(f32::INFINITY);
    let path = folder.planes([8, 48], &[("Z", samples)]);
    for face_size in [4, 16] {
        let options = LoadOptions { face_size: Some(face_size), ..LoadOptions::default() };
        let cube = load_distance(&path, &options).unwrap().map;
        assert_eq!(cube.texels.len(), 6 * face_size * face_size);
        assert!(cube.texels.iter().all(|d| d.is_infinite() || (d - 2.0).abs() < 1e-6));
        // Only the upper half of +x is infinite: its taps reach every face but −x, which it does not touch.
        let opposite = face_size * face_size..2 * face_size * face_size;
        assert!(cube.texels[0].is_infinite());
        assert!(cube.texels[opposite].iter().all(|d| d.is_finite()));
    }
}

#[test]
fn damaged_and_unfit_files_are_errors() {
    let folder = Folder::new();
    let options = LoadOptions::default();
    let impostor = Impostor::build(&built_in::room(), DVec3::ZERO, 8);
    let mut whole = Vec::new();
    write_impostor(&mut whole, &impostor, &[]).unwrap();
    let path = folder.0.path().join("cut.exr");
    for length in (0..whole.len()).step_by(97) {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(load_distance(&path, &options).is_err(), "{length} bytes");
    }
    let odd = folder.planes([5, 7], &[("Z", vec![1.0; 35])]);
    assert!(load_distance(&odd, &options).is_err());
    let small = LoadOptions { max_image_mb: 0, ..options };
    assert!(load_distance(&odd, &small).is_err());
}

#[test]
fn worlds_are_closed_and_only_the_room_is_convex_from_the_reference_point() {
    for (world, convex) in
        [(built_in::room(), true), (built_in::columns(), false), (built_in::doorway(), false)]
    {
        let impostor = Impostor::build(&world, DVec3::ZERO, 32);
        assert!(impostor.distance.texels.iter().all(|d| d.is_finite()));
        let walls: std::collections::BTreeSet<i32> =
            impostor.walls.texels.iter().map(|w| w.wall).collect();
        assert_eq!(walls.len() == 6 && walls.iter().all(|w| *w < 6), convex);
    }
    // A box of the room's size and nothing else.
    let [low, high] = [dvec3(-4.0, -2.0, -5.0), dvec3(4.0, 3.0, 5.0)];
    assert_eq!(built_in::ROOM, Cuboid { low, high });
}

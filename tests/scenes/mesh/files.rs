//! Reading against the crate `tobj`, transforms, and the shared meshes where they are present.

use std::path::{Path, PathBuf};

use glam::DVec3;
use tapline::mesh::{Mesh, Up};
use tapline::scene::bump::BumpSource;
use tapline::scene::{SceneOptions, build};
use tapline::settings::Settings;

fn shared() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/mesh");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: no shared test data at {}", folder.display());
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.sort();
    assert_eq!(files.len(), 5);
    files
}

#[test]
fn every_shared_mesh_loads_in_its_published_size_and_fills_the_view() {
    let sizes = [
        ("boombox.glb", 6036),
        ("shaderball.glb", 70808 + 17456),
        ("sphere.obj", 0),
        ("spot_triangulated.obj", 5856),
        ("teapot.obj", 0),
    ];
    for (file, (name, triangles)) in shared().iter().zip(sizes) {
        assert!(file.ends_with(name));
        let (mesh, repairs, _) = Mesh::load(file, Up::Y, DVec3::ZERO, 1.0).unwrap();
        let all = mesh.triangles().len() + repairs.degenerate;
        assert!(triangles == 0 || all == triangles, "{name}: {all}");
        assert_eq!(mesh.untextured(), 0, "{name}");
        let options = SceneOptions {
            width: 64,
            height: 64,
            mesh: Some(file.clone()),
            ..SceneOptions::default()
        };
        let scene = build("sphere", &options, &Settings::default()).unwrap();
        // The ball that a mesh is fitted into has a silhouette of 0.48·64 pixels' radius: π·30.72² centres,
        // give or take √2·π·30.72 (those within half a diagonal of the rim). Every file fills a fifth of it.
        let count = scene.fragments.len();
        assert!((593..=3101).contains(&count), "{name}: {count}");
        for f in &scene.fragments {
            let all = [f.fragment.n, f.fragment.dn_dx, f.fragment.dn_dy].concat();
            assert!(all.iter().all(|c| c.is_finite()));
        }
    }
}

#[test]
fn obj_triangles_are_those_of_another_reader() {
    for file in shared() {
        if file.extension().is_none_or(|e| e != "obj") {
            continue;
        }
        let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
        let (models, _) = tobj::load_obj(&file, &options).unwrap();
        let theirs: Vec<[f64; 3]> = models
            .iter()
            .flat_map(|m| {
                let p = &m.mesh.positions;
                m.mesh.indices.iter().map(move |i| {
                    let i = 3 * *i as usize;
                    [p[i], p[i + 1], p[i + 2]].map(f64::from)
                })
            })
            .collect();
        let (mesh, repairs, _) = Mesh::load(&file, Up::Y, DVec3::ZERO, 1.0).unwrap();
        if repairs.degenerate > 0 {
            assert!(theirs.len() / 3 == mesh.triangles().len() + repairs.degenerate);
            continue;
        }
        assert_eq!(theirs.len(), 3 * mesh.triangles().len());
        // The fit is one scale and one move: all differences keep their ratio.
        let ours: Vec<[f64; 3]> =
            mesh.triangles().iter().flat_map(|t| t.positions.map(DVec3::into)).collect();
        let far =
            |all: &[[f64; 3]], i: usize| (0..3).map(|k| all[i][k] - all[0][k]).collect::<Vec<_>>();
        let far_one = (0..ours.len())
            .max_by(|a, b| far(&ours, *a)[0].abs().total_cmp(&far(&ours, *b)[0].abs()))
            .unwrap();
        let scale = far(&ours, far_one)[0] / far(&theirs, far_one)[0];
        for i in 0..ours.len() {
            for (a, b) in far(&ours, i).iter().zip(far(&theirs, i)) {
                // tobj reads singles: 2^-24 of coordinates up to 2, of two places and in the scale.
                assert!((a - scale * b).abs() < 8.0 * f64::from(f32::EPSILON));
            }
        }
    }
}

#[test]
fn a_normal_map_goes_on_a_mesh_with_texture_coordinates_only() {
    let folder = tempfile::tempdir().unwrap();
    let load = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let options = SceneOptions {
            width: 33,
            height: 33,
            mesh: Some(path),
            // Every normal leans to the right by b1 = 0.5 and upwards by b2 = 0.25.
            bump: Some(BumpSource::Offsets { width: 1, height: 1, values: vec![[0.5, 0.25]] }),
            ..SceneOptions::default()
        };
        build("sphere", &options, &Settings::default())
    };
    let plate = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    let error = load("plain.obj", &format!("{plate}f 1 2 3 4\n")).unwrap_err();
    assert!(error.to_string().contains("2 of 2 triangles without"));
    for (name, texture, mirrored) in [
        ("straight.obj", "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n", false),
        ("mirrored.obj", "vt 1 0\nvt 0 0\nvt 0 1\nvt 1 1\n", true),
    ] {
        let text = format!("{plate}{texture}f 1/1 2/2 3/3 4/4\n");
        let scene = load(name, &text).unwrap();
        assert!(scene.fragments.len() > 200);
        for f in &scene.fragments {
            let f = f.fragment;
            let (e1, e2) = tapline::scene::local_frame(f.n.into(), f.h.unwrap().into());
            let [b1, b2] = f.bump.unwrap();
            let lean = [0, 1].map(|i| b1 * e1[i] + b2 * e2[i]);
            // Right as the map sees it, and up in both.
            let right = if mirrored { -0.5 } else { 0.5 };
            assert!((lean[0] - right).abs() < 1e-12 && (lean[1] - 0.25).abs() < 1e-12, "{lean:?}");
        }
    }
}

#[test]
fn a_mesh_needs_a_scene_with_a_ball() {
    let options = SceneOptions { mesh: Some("any.obj".into()), ..SceneOptions::default() };
    let error = build("waves", &options, &Settings::default()).unwrap_err();
    assert!(error.to_string().contains("--mesh"));
}

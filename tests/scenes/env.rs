//! The built-in scenes: derivatives against differences, what covers the picture.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use glam::DVec3;
use tapline::base::dual::Dual;
use tapline::cube::face_uv;
use tapline::fragment::{Fragment, PixelFragment};
use tapline::policy::Curvature;
use tapline::scene::bump::BumpSource;
use tapline::scene::{SCENES, Scene, SceneOptions, build, local_frame};
use tapline::settings::Settings;
use tapline::stage::Stage;

const EPS: f64 = f64::EPSILON;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn options(width: usize, height: usize) -> SceneOptions {
    SceneOptions { width, height, ..SceneOptions::default() }
}

fn scene(name: &str) -> Scene {
    build(name, &options(96, 64), &Settings::default()).unwrap()
}

/// A 4 × 4 map with offsets that differ.
fn small_bump() -> BumpSource {
    BumpSource::Offsets {
        width: 4,
        height: 4,
        values: (0..16u8)
            .map(|i| [f32::from(i % 5) / 8.0 - 0.25, f32::from(i % 3) / 4.0 - 0.25])
            .collect(),
    }
}

#[test]
fn derivatives_of_normals_and_texture_coordinates_match_differences() {
    // Central differences with steps h and h/2 are off by c·h² and c·h²/4: their own difference is
    // three times the error of the finer one, so that it bounds that error as long as the cubic term
    // leads. Rounding: a coordinate of size m is wrong by at most some 16 eps·m, made larger by
    // 1/cos near a silhouette (the root in the ray-ball formula); twice that over h.
    let h = 0.125;
    let mut compared = 0;
    for info in SCENES {
        let scene = scene(info.name);
        let at = |x: f64, y: f64| {
            let hit = scene.surface.shape.hit(scene.surface.camera.ray(x, y), true)?;
            let [a, b, c] = hit.n;
            Some([a, b, c, hit.st[0], hit.st[1]])
        };
        for pixel in scene.fragments.iter().step_by(7) {
            let [px, py] = pixel.pixel.map(|c| f64::from(c) + 0.5);
            let f = pixel.fragment;
            let cosine = dot(f.v, f.n) / (dot(f.v, f.v) * dot(f.n, f.n)).sqrt();
            if cosine < 0.1 {
                continue;
            }
            let x = Dual { value: px, dx: 1.0, dy: 0.0 };
            let y = Dual { value: py, dx: 0.0, dy: 1.0 };
            let ray = scene.surface.camera.ray(x, y);
            let hit = scene.surface.shape.hit(ray, true).unwrap();
            let [a, b, c] = hit.n;
            let exact = [a, b, c, hit.st[0], hit.st[1]];
            for down in [false, true] {
                let difference = |h: f64| {
                    let (dx, dy) = if down { (0.0, h) } else { (h, 0.0) };
                    let (far, near) = (at(px + dx, py + dy)?, at(px - dx, py - dy)?);
                    Some([0, 1, 2, 3, 4].map(|i| (far[i] - near[i]) / (2.0 * h)))
                };
                let (Some(coarse), Some(fine)) = (difference(h), difference(h / 2.0)) else {
                    continue;
                };
                for i in 0..5 {
                    let got = if down { exact[i].dy } else { exact[i].dx };
                    let size = match i {
                        0..3 => dot(f.n, f.n).sqrt(),
                        _ => exact[i].value.abs().max(1.0),
                    };
                    let rounding = 2.0 * 16.0 * EPS * size / cosine / h;
                    let bound = (coarse[i] - fine[i]).abs() + rounding;
                    assert!(
                        (got - fine[i]).abs() <= bound,
                        "{} pixel {:?} component {i} down {down}: {got} against {} within {bound}",
                        info.name,
                        pixel.pixel,
                        fine[i]
                    );
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 10_000, "only {compared} derivatives were compared");
}

#[test]
fn fragments_follow_the_camera_convention() {
    for info in SCENES {
        let scene = scene(info.name);
        let camera = scene.surface.camera;
        for PixelFragment { pixel, fragment } in &scene.fragments {
            let [x, y] = [0, 1].map(|i| f64::from(pixel[i]) + 0.5 - camera.centre[i]);
            for i in 0..3 {
                let want =
                    -(x * camera.right[i] + y * camera.down[i] + camera.focal * camera.forward[i]);
                let size = x.abs() + y.abs() + camera.focal;
                assert!((fragment.v[i] - want).abs() <= 4.0 * EPS * size);
                // Exact but for the sign of zero.
                assert!((fragment.dv_dx[i] + camera.right[i]).abs() <= 0.0);
                assert!((fragment.dv_dy[i] + camera.down[i]).abs() <= 0.0);
            }
            assert!(dot(fragment.v, fragment.n) > 0.0, "{} {pixel:?} looks away", info.name);
        }
        // Right-handed: right × down = forward, to the rounding of products of unit vectors.
        assert!(camera.right.cross(camera.down).abs_diff_eq(camera.forward, 4.0 * EPS));
    }
}

/// One column of J_v ∂v + J_n ∂n and the sum of the magnitudes of its terms, component by component.
fn reflected_derivative(f: &Fragment, dv: [f64; 3], dn: [f64; 3]) -> [(f64, f64); 3] {
    let (v, n) = (f.v, f.n);
    let magnitude = |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|i| (a[i] * b[i]).abs()).sum() };
    [0, 1, 2].map(|i| {
        let terms = [
            (2.0 * n[i] * dot(n, dv), 2.0 * n[i].abs() * magnitude(n, dv)),
            (-dot(n, n) * dv[i], dot(n, n) * dv[i].abs()),
            (2.0 * dot(n, v) * dn[i], 2.0 * magnitude(n, v) * dn[i].abs()),
            (2.0 * n[i] * dot(v, dn), 2.0 * n[i].abs() * magnitude(v, dn)),
            (-2.0 * v[i] * dot(n, dn), 2.0 * v[i].abs() * magnitude(n, dn)),
        ];
        let value = terms.iter().map(|(value, _)| value).sum();
        (value, terms.iter().map(|(_, size)| size).sum())
    })
}

#[test]
fn the_parabola_seen_from_its_focus_has_no_footprint() {
    let scene = scene("parabola");
    let mut largest_term = 0.0f64;
    for PixelFragment { pixel, fragment: f } in &scene.fragments {
        let (along, square) = (dot(f.v, f.n), dot(f.n, f.n));
        let reflected = [0, 1, 2].map(|i| 2.0 * f.n[i] * along - f.v[i] * square);
        let (face, u, v) = face_uv(reflected);
        assert_eq!(face, 4, "all rays leave along (3, 4, 12)/13, towards +z");
        let ma = reflected[2].abs();
        for (dv, dn) in [(f.dv_dx, f.dn_dx), (f.dv_dy, f.dn_dy)] {
            let d = reflected_derivative(f, dv, dn);
            // Face +z: u = x/z, v = −y/z. Each term is a product of at most five numbers; n and ∂n
            // carry a few roundings each themselves: 32 in all.
            for (component, coordinate) in [(0, u), (1, -v)] {
                let derivative = (d[component].0 - coordinate * d[2].0) / ma;
                let terms = (d[component].1 + coordinate.abs() * d[2].1) / ma;
                largest_term = largest_term.max(terms);
                assert!(
                    derivative.abs() <= 32.0 * EPS * terms,
                    "{pixel:?}: D has {derivative}, terms {terms}"
                );
            }
        }
    }
    assert!(largest_term > 1e-3, "the terms that cancel are not trivial");
}

#[test]
fn a_fragment_and_a_sample_at_its_centre_reflect_alike() {
    // Magnified (a map of 4 × 4 texels), so that the filtered map is the unfiltered one: bit for bit the
    // same normal without a map, and 16 roundings of an offset below 1 with one.
    for info in SCENES {
        for bump in [None, Some(small_bump())] {
            if bump.is_none() && info.stages().contains(&Stage::Bump) {
                continue;
            }
            let smooth = bump.is_none();
            let scene =
                build(info.name, &SceneOptions { bump, ..options(48, 32) }, &Settings::default());
            let scene = scene.unwrap();
            let mut magnified = 0;
            for PixelFragment { pixel, fragment: f } in &scene.fragments {
                let [px, py] = pixel.map(|c| f64::from(c) + 0.5);
                let (mut n, v) = (DVec3::from(f.n), DVec3::from(f.v));
                if let (Some(h), Some([b1, b2])) = (f.h, f.bump) {
                    let (e1, e2) = local_frame(n, h.into());
                    n = n + b1 * e1 + b2 * e2;
                    // Level 0 only: it has no covariance of its own, so at texel centres and under the
                    // least derivative the roughness is the spread between taps alone.
                    let x = Dual { value: px, dx: 1.0, dy: 0.0 };
                    let y = Dual { value: py, dx: 0.0, dy: 1.0 };
                    let [s, t] =
                        scene.surface.shape.hit(scene.surface.camera.ray(x, y), true).unwrap().st;
                    let longer = (s.dx * s.dx + t.dx * t.dx).max(s.dy * s.dy + t.dy * t.dy);
                    if longer.sqrt() * 4.0 > 1.0 {
                        continue;
                    }
                    magnified += 1;
                }
                let want = 2.0 * n * v.dot(n) - v * n.length_squared();
                let got = scene.surface.shade_point(px, py).unwrap();
                let size = v.length() * n.length_squared();
                let bound = if smooth { 0.0 } else { 8.0 * 16.0 * EPS * size };
                assert!(got.abs_diff_eq(want, bound), "{} {pixel:?}", info.name);
            }
            assert!(smooth || magnified > 100, "{}: {magnified} magnified", info.name);
        }
    }
}

#[test]
fn every_scene_has_fragments_in_order_and_background_where_due() {
    for info in SCENES {
        let scene = scene(info.name);
        let covered = scene.fragments.len();
        let all = scene.width * scene.height;
        // 96 × 64: a disc of 0.96 of the height covers 48 % of it at most.
        assert!(covered > all / 5, "{} covers {covered} of {all}", info.name);
        assert!(covered < all * 9 / 10, "{} covers {covered} of {all}", info.name);
        let order: Vec<_> = scene.fragments.iter().map(|f| (f.pixel[1], f.pixel[0])).collect();
        assert!(order.windows(2).all(|pair| pair[0] < pair[1]));
        let (top, bottom) = (scene.background(0, 0), scene.background(0, 63));
        assert!(top[1] > bottom[1], "the picture's top looks up");
        assert!(scene.background(95, 0)[0] > top[0], "its right looks to +x");
    }
}

#[test]
fn scenes_need_the_bump_stages_only_with_a_bump_map() {
    for info in SCENES {
        let own = scene(info.name);
        let bumpy = matches!(info.name, "scratches" | "waves");
        assert_eq!(own.stages(), info.stages());
        assert_eq!(info.stages().contains(&Stage::Bump), bumpy);
        for PixelFragment { fragment: f, .. } in &own.fragments {
            assert_eq!([f.h.is_some(), f.bump.is_some(), f.rough.is_some()], [bumpy; 3]);
        }
        let with = SceneOptions { bump: Some(small_bump()), ..options(96, 64) };
        let with = build(info.name, &with, &Settings::default()).unwrap();
        let bumpy = SCENES.iter().find(|info| info.name == "waves").unwrap();
        assert_eq!(with.stages(), bumpy.stages());
        let moved = |f: &&PixelFragment| f.fragment.bump.unwrap().iter().any(|b| b.abs() > 0.01);
        assert!(with.fragments.iter().filter(moved).count() > with.fragments.len() / 4);
    }
}

#[test]
fn texture_coordinates_grow_along_the_local_frame() {
    // e1 must point the way s grows on the surface and e2 against t. Moving by a small step along a
    // screen direction changes the surface point by dP; s changes by ∂s. The sign of the frame's
    // orientation shows without P: ∂(s, −t)/∂(x, y) keeps the orientation of the screen seen from the
    // eye, (x right, y down) ↔ (e1, e2) turned over once: its determinant is negative.
    for info in SCENES {
        let scene = scene(info.name);
        for pixel in scene.fragments.iter().step_by(5) {
            let [px, py] = pixel.pixel.map(|c| f64::from(c) + 0.5);
            let x = Dual { value: px, dx: 1.0, dy: 0.0 };
            let y = Dual { value: py, dx: 0.0, dy: 1.0 };
            let ray = scene.surface.camera.ray(x, y);
            let [s, t] = scene.surface.shape.hit(ray, true).unwrap().st;
            let determinant = -(s.dx * t.dy - s.dy * t.dx);
            assert!(determinant < 0.0, "{} {:?}", info.name, pixel.pixel);
            // And e1, as the screen sees it, is on the side where s grows.
            let h = scene.surface.shape.main_direction();
            let (e1, e2) = local_frame(pixel.fragment.n.into(), h);
            assert!(e1.dot(e2).abs() <= 16.0 * EPS * e1.length_squared());
            let v = DVec3::from(pixel.fragment.v);
            // Project a step along e1 from the point seen at this pixel: image motion is e1 less its
            // part along the ray.
            let camera = scene.surface.camera;
            let depth = -v.dot(camera.forward);
            let ahead = e1.dot(camera.forward) / depth;
            let image = [camera.right, camera.down].map(|axis| e1.dot(axis) + ahead * v.dot(axis));
            let growth = s.dx * image[0] + s.dy * image[1];
            assert!(growth > 0.0, "{} {:?}: s shrinks along e1", info.name, pixel.pixel);
        }
    }
}

#[test]
fn the_bump_maps_own_slope_moves_from_roughness_to_the_normal() {
    let surface = Settings::default().with(|p| p.roughness.curvature = Curvature::Surface);
    for name in ["scratches", "waves"] {
        let (plain, bent) = (scene(name), build(name, &options(96, 64), &surface).unwrap());
        let (mut rougher, mut moved) = (0.0, 0);
        for (a, b) in plain.fragments.iter().zip(&bent.fragments) {
            assert_eq!(a.fragment.bump, b.fragment.bump);
            let power = |f: &Fragment| f.rough.unwrap().iter().map(|d| d * d).sum::<f64>();
            let (with, without) = (power(&a.fragment), power(&b.fragment));
            // A least-squares plane never leaves more than the mean does; some 64 roundings.
            assert!(without <= with * (1.0 + 64.0 * EPS), "{name} {:?}", a.pixel);
            rougher += with - without;
            let added = [0, 1, 2].map(|i| b.fragment.dn_dx[i] - a.fragment.dn_dx[i]);
            moved += usize::from(dot(added, added) > 0.0);
            // What is added lies in the tangent plane.
            let n = a.fragment.n;
            let bound = 64.0
                * EPS
                * dot(n, n).sqrt()
                * (dot(added, added).sqrt() + dot(b.fragment.dn_dx, b.fragment.dn_dx).sqrt());
            assert!(dot(added, n).abs() <= bound);
        }
        assert!(rougher > 0.0, "{name}: taking the trend out leaves less roughness");
        assert!(moved > plain.fragments.len() / 2);
    }
}

#[test]
fn fails_when_the_scene_or_its_size_is_not_there() {
    let settings = Settings::default();
    let error = build("spere", &SceneOptions::default(), &settings).unwrap_err();
    for info in tapline::scene::registry::REGISTRY[0] {
        assert!(error.to_string().contains(info.name), "{error}");
    }
    for (width, height) in [(0, 4), (4, 0), (20_000, 1), (16_384, 16_384), (usize::MAX, usize::MAX)]
    {
        assert!(build("sphere", &options(width, height), &settings).is_err());
    }
    for face_size in [0, 1 << 20] {
        let options = SceneOptions { face_size: Some(face_size), ..options(4, 4) };
        assert!(build("sphere", &options, &settings).is_err());
    }
    let broken = SceneOptions {
        bump: Some(BumpSource::Normals { width: 2, height: 2, values: vec![] }),
        ..options(4, 4)
    };
    assert!(build("sphere", &broken, &settings).is_err());
}

#[test]
fn every_size_down_to_one_pixel_builds() {
    for info in SCENES {
        for (width, height) in [(1, 1), (1, 7), (7, 1), (2, 2)] {
            let scene = build(info.name, &options(width, height), &Settings::default()).unwrap();
            for f in &scene.fragments {
                let all = [f.fragment.n, f.fragment.dn_dx, f.fragment.dn_dy];
                assert!(all.iter().flatten().all(|c| c.is_finite()), "{}", info.name);
            }
        }
    }
}

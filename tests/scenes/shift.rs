//! A scene that is moved shows the same, elsewhere.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use tapline::base::random::Keyed;
use tapline::scene::{SceneOptions, build, hit, tex};
use tapline::settings::Settings;

fn options() -> SceneOptions {
    SceneOptions { width: 24, height: 24, face_size: Some(16), ..SceneOptions::default() }
}

#[test]
fn a_shift_by_a_whole_pixel_gives_each_fragment_to_the_next_pixel() {
    // Positions are halves of small whole numbers, so that the fragments are equal to the last bit.
    let still = build("scratches", &options(), &Settings::default()).unwrap();
    let mut moved = still.clone();
    moved.shift(1.0);
    let mut compared = 0;
    for f in &still.fragments {
        let pixel = f.pixel.map(|x| x + 1);
        if let Some(other) = moved.fragments.iter().find(|g| g.pixel == pixel) {
            assert_eq!(f.fragment, other.fragment);
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared}");

    let still = hit::build("room", &options()).unwrap();
    let mut moved = still.clone();
    moved.shift(1.0);
    let ray = |scene: &hit::HitScene, pixel: [u32; 2]| {
        scene.rays.iter().find(|r| r.pixel == pixel).map(|r| r.fragment)
    };
    assert!(ray(&still, [11, 12]).is_some());
    assert_eq!(ray(&still, [11, 12]), ray(&moved, [12, 13]));

    let still = tex::build("convex", &options(), None).unwrap().camera;
    let mut moved = still;
    moved.shift = 0.25;
    let through = |camera: tex::camera::Camera, at: [f64; 2]| {
        camera.ray(at, 0, 1, &mut Keyed::new(1, [0.0; 2], 0))
    };
    assert_eq!(through(still, [3.5, 7.5]), through(moved, [3.75, 7.75]));
    assert_ne!(through(still, [3.5, 7.5]), through(moved, [3.5, 7.5]));
}

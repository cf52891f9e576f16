//! The built-in scenes of the TEX operation.

use glam::{DVec3, dvec3};

use super::Plan;
use super::camera::Lens;
use super::path::Finish;
use super::shape::Shape;
use crate::scene::registry::{self, SceneInfo};

/// Every built-in scene of the TEX operation.
pub const TEX_SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "convex",
        description: "mirror balls on a textured floor: reflections need far coarser levels than their distance says",
        plan: registry::Plan::Tex(convex),
    },
    SceneInfo {
        name: "concave",
        description: "a hollow mirror that magnifies the floor: reflections need finer levels than their distance says",
        plan: registry::Plan::Tex(concave),
    },
    SceneInfo {
        name: "thin-lens",
        description: "balls, a glass ball and cards through a wide lens: one cone vanishes in focus, two do not",
        plan: registry::Plan::Tex(thin_lens),
    },
    SceneInfo {
        name: "vases",
        description: "glazed vases whose hollow insides make cones converge bounce by bounce",
        plan: registry::Plan::Tex(vases),
    },
    SceneInfo {
        name: "vases-lined",
        description: "the vases with a matt lining, which scatters and widens the cones",
        plan: registry::Plan::Tex(vases_lined),
    },
];

const FLOOR: (Shape, Finish) = (Shape::Floor { half: 6.0 }, Finish::Lit { texture: 0 });

fn ball(centre: DVec3, radius: f64, finish: Finish) -> (Shape, Finish) {
    let shape = Shape::Shell { centre, radius, axis: DVec3::Y, keep: 1.0 };
    (shape, finish)
}

fn convex() -> Plan {
    let mut main = Vec::new();
    for row in 0..3 {
        for column in 0..3 {
            let at = |i: i32| 1.5 * f64::from(i - 1);
            main.push(ball(dvec3(at(column), 0.6, at(row)), 0.6, Finish::Mirror));
        }
    }
    Plan {
        eye: dvec3(0.4, 3.4, 6.2),
        aim: dvec3(0.0, 0.5, 0.0),
        tangent: 0.36,
        lens: Lens::Pinhole,
        samples: 1,
        bounces: 8,
        surfaces: vec![FLOOR],
        main,
        bound: (dvec3(0.0, 1.2, 0.0), 1.2),
    }
}

fn concave() -> Plan {
    // A mirror of radius 5 behind the middle of the floor, tilted down a little; its focus is 2.5 in front of it.
    let tilt: (f64, f64) = (0.28, 0.96);
    Plan {
        eye: dvec3(0.5, 2.2, 4.6),
        aim: dvec3(0.0, 1.1, -2.0),
        tangent: 0.34,
        lens: Lens::Pinhole,
        samples: 1,
        bounces: 8,
        surfaces: vec![FLOOR],
        main: vec![(
            Shape::Shell {
                centre: dvec3(0.0, 1.2 - 5.0 * tilt.0, -3.0 + 5.0 * tilt.1),
                radius: 5.0,
                // Only what lies against the axis stays: a cap of 22° about the middle.
                axis: dvec3(0.0, -tilt.0, tilt.1),
                keep: -0.927,
            },
            Finish::Mirror,
        )],
        bound: (dvec3(0.0, 1.5, -2.0), 1.5),
    }
}

fn thin_lens() -> Plan {
    let card = |x: f64, z: f64| {
        let shape = Shape::Card {
            corner: dvec3(x - 0.6, 1.3, z),
            across: dvec3(1.2, 0.0, 0.25),
            down: dvec3(0.0, -1.3, 0.0),
        };
        (shape, Finish::Lit { texture: 1 })
    };
    Plan {
        eye: dvec3(0.3, 1.9, 5.2),
        aim: dvec3(0.0, 0.6, 0.0),
        tangent: 0.34,
        lens: Lens::Thin { width: 0.2 },
        samples: 16,
        bounces: 8,
        surfaces: vec![
            FLOOR,
            card(-1.9, -1.2),
            card(1.9, 0.6),
            card(0.0, -4.0),
            ball(dvec3(1.0, 0.45, 2.2), 0.45, Finish::Glass { index: 1.5 }),
            ball(dvec3(-1.1, 0.5, 1.4), 0.5, Finish::Mirror),
        ],
        main: vec![ball(dvec3(0.0, 0.8, -0.6), 0.8, Finish::Mirror)],
        bound: (dvec3(0.0, 0.8, -0.6), 0.8),
    }
}

fn vases() -> Plan {
    glazed(false)
}

fn vases_lined() -> Plan {
    glazed(true)
}

fn glazed(lined: bool) -> Plan {
    let mut main = Vec::new();
    for (x, z, radius) in [(-1.4, 0.3, 0.8), (0.3, -0.9, 1.0), (1.5, 0.7, 0.7)] {
        let finish = Finish::Glazed { texture: 1, share: 0.6, lined };
        // A belly with an opening of half its radius, and a neck on it.
        let keep: f64 = 0.866_025_403_784_438_6;
        main.push((
            Shape::Shell { centre: dvec3(x, radius, z), radius, axis: DVec3::Y, keep },
            finish,
        ));
        main.push((
            Shape::Tube {
                base: dvec3(x, radius * (1.0 + keep), z),
                radius: 0.5 * radius,
                height: 0.25 * radius,
            },
            finish,
        ));
    }
    Plan {
        eye: dvec3(0.3, 5.2, 4.4),
        aim: dvec3(0.1, 0.9, 0.0),
        tangent: 0.36,
        lens: Lens::Pinhole,
        samples: 4,
        bounces: 16,
        surfaces: vec![FLOOR],
        main,
        bound: (dvec3(0.0, 1.2, 0.0), 1.2),
    }
}

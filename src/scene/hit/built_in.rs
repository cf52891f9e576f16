//! The built-in scenes of the HIT operation. Lengths are metres; the impostor's reference point is the origin.

use glam::dvec3;

use super::Plan;
use super::view::Finish;
use crate::scene::registry::{self, SceneInfo};
use crate::scene::world::built_in as worlds;
use crate::scene::world::light::Lamp;

/// Every built-in scene of the HIT operation.
pub const HIT_SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "room",
        description: "a mirror ball in a box room, off the impostor's reference point",
        plan: registry::Plan::Hit(room),
    },
    SceneInfo {
        name: "columns",
        description: "the ball among columns whose tops and backs the reference point does not see",
        plan: registry::Plan::Hit(columns),
    },
    SceneInfo {
        name: "doorway",
        description: "the ball beside a doorway: the next room is seen through it, the near wall hides it",
        plan: registry::Plan::Hit(doorway),
    },
    SceneInfo {
        name: "glass",
        description: "a glass ball (n = 1.3) that reflects, refracts and throws a lamp's caustic onto the walls",
        plan: registry::Plan::Hit(glass),
    },
];

/// Index of refraction of the scene `glass`.
pub const GLASS: f64 = 1.3;

fn room() -> Plan {
    Plan {
        world: worlds::room(),
        eye: dvec3(-1.4, 0.5, 3.8),
        centre: dvec3(1.6, -0.7, -2.0),
        radius: 1.0,
        share: 0.45,
        finish: Finish::Mirror,
        lamp: None,
    }
}

fn columns() -> Plan {
    Plan {
        world: worlds::columns(),
        eye: dvec3(-0.9, 1.0, 4.0),
        centre: dvec3(0.7, 0.9, -1.5),
        radius: 0.7,
        ..room()
    }
}

fn doorway() -> Plan {
    Plan {
        world: worlds::doorway(),
        eye: dvec3(-0.9, 0.6, 4.2),
        centre: dvec3(1.5, -0.3, -1.0),
        radius: 0.8,
        ..room()
    }
}

fn glass() -> Plan {
    Plan {
        world: worlds::room(),
        eye: dvec3(-2.2, 0.9, 3.6),
        centre: dvec3(0.6, -0.7, -0.8),
        radius: 0.9,
        // The caustic lies beside the ball: it gets more of the picture.
        share: 0.3,
        finish: Finish::Glass { index: GLASS },
        lamp: Some(Lamp { position: dvec3(2.4, 2.2, 1.2), power: [150.0, 142.0, 128.0] }),
    }
}

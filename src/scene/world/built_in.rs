//! The built-in worlds. Lengths are metres; the reference point of the impostor is the origin.

use glam::dvec3;

use super::World;
use super::bodies::{Column, Cuboid};
use super::paint::Paint;

/// The room that all worlds share: 8 wide, 5 high, 10 deep; the reference point is 2 above its floor.
pub const ROOM: Cuboid = Cuboid { low: dvec3(-4.0, -2.0, -5.0), high: dvec3(4.0, 3.0, 5.0) };

/// A box room without anything in it: convex, every wall seen from the reference point.
#[must_use]
pub fn room() -> World {
    World::default().with(ROOM, Paint::Room)
}

/// The room with four thick columns and two blocks: their backs, their tops and the walls behind them are
/// not seen from the reference point.
#[must_use]
pub fn columns() -> World {
    let mut world = room();
    for (axis, top, colour) in [
        ([-2.2, -2.6], 1.2, [0.60, 0.30, 0.22]),
        ([2.3, -2.8], 0.4, [0.30, 0.45, 0.62]),
        ([-2.5, 2.4], 0.8, [0.32, 0.55, 0.30]),
        ([2.6, 2.2], 1.6, [0.62, 0.58, 0.30]),
    ] {
        world =
            world.with(Column { axis, radius: 0.55, span: [-2.0, top] }, Paint::Banded { colour });
    }
    for (low, high) in [
        (dvec3(-0.5, -2.0, -4.2), dvec3(0.6, -0.6, -3.4)),
        (dvec3(3.0, -2.0, -0.6), dvec3(3.7, 0.2, 0.5)),
    ] {
        world = world.with(Cuboid { low, high }, Paint::Tiled { colour: [0.55, 0.50, 0.60] });
    }
    world
}

/// The room with a wall across it that has a doorway; behind it lies a second room.
///
/// The wall has three blocks: left and right of the opening (1.6 wide, 3.2 high) and above it.
#[must_use]
pub fn doorway() -> World {
    let mut world = World::default()
        .with(Cuboid { low: dvec3(-4.0, -2.0, -12.0), high: dvec3(4.0, 3.0, 5.0) }, Paint::Room);
    for (low, high) in [
        (dvec3(-4.0, -2.0, -2.6), dvec3(-0.4, 3.0, -2.3)),
        (dvec3(1.2, -2.0, -2.6), dvec3(4.0, 3.0, -2.3)),
        (dvec3(-0.4, 1.2, -2.6), dvec3(1.2, 3.0, -2.3)),
    ] {
        world = world.with(Cuboid { low, high }, Paint::BackRoom);
    }
    world
}

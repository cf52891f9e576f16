//! Studies: many units on the same scenes, what each is worth and what it costs.

pub mod axis;
pub mod bench;
pub mod cost;
pub mod front;
pub mod measures;
pub mod plan;
pub mod points;
mod read;
pub mod report;
pub mod rows;
pub mod runner;
mod scene;
pub mod size;
pub mod store;

use crate::scene::SCENES;
use crate::scene::hit::HIT_SCENES;
use crate::scene::tex::TEX_SCENES;

/// The names of all built-in scenes.
#[must_use]
pub fn known_scenes() -> Vec<&'static str> {
    SCENES.iter().chain(HIT_SCENES).chain(TEX_SCENES).map(|s| s.name).collect()
}

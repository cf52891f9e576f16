//! Studies: many units on the same scenes, with the error and the cost of each.

pub mod axis;
pub mod bench;
mod cones;
pub mod cost;
mod edges;
mod footprints;
pub mod front;
pub mod measures;
pub mod plan;
pub mod points;
mod read;
pub mod report;
pub mod rows;
pub mod runner;
mod scene;
pub mod searches;
pub mod size;
pub mod store;

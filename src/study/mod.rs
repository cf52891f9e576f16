//! Studies: many units on the same scenes, with the error and the cost of each.

pub mod axis;
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
pub mod searches;
pub mod size;
pub mod store;
pub mod sweep;

//! The integer model: its parts against exact arithmetic, its operations against the float reference.

mod cube;
mod eigen;
mod extremes;
mod extremes_texture;
mod filter;
mod hit;
mod invariants;
mod knobs;
mod ports;
mod ray_cone;
mod tables;
mod tex;
mod texels;
mod trace_batch;
mod unit_bounds;
mod unit_bounds_color;
mod unit_files;

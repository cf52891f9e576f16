//! The built-in scenes, the worlds and meshes behind them, and what their pictures must be.

mod accuracy;
mod env;
mod golden;
mod impostor;
mod mesh;
mod picture_hashes;
mod shift;
mod tex;

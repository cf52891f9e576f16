//! Studies of ray cones: what they save in texture tiles, what their format costs, what a constant gradient on a cube
//! map gets wrong.

pub mod cube;
pub mod formats;
pub mod tiles;

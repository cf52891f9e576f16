//! Meshes: reading, fitting, rays, and pictures of the shared files.

mod files;
mod hostile;
mod inputs;
mod optics;
mod rays;

//! Pictures and textures in and out: EXR, Radiance HDR, PNG and JPEG to cube maps or planes of
//! floats; linear EXR and sRGB PNG out; files that appear whole or not at all.
//!
//! Every reader treats its file as hostile: sizes are checked against the limit and against the
//! file's own length before memory is taken for them, and a fault inside a decoder becomes an
//! [`InputError`](crate::error::InputError).

mod colours;
mod cross;
mod cubes;
mod exr_header;
mod exr_in;
mod latlong;
mod ldr;
mod radiance;
mod resample;
mod turn;

pub mod bump;
pub mod curve;
pub mod distance;
pub mod layout;
pub mod limits;
pub mod load;
pub mod planar;
pub mod whole;
pub mod window;
pub mod write;
pub mod write_planes;

pub use bump::load_bump_planes;
pub use curve::{Curve, Transfer};
pub use distance::{CleanedDistances, load_distance};
pub use layout::Layout;
pub use limits::LoadOptions;
pub use load::{Cleaned, Loaded, load_environment, load_planar, load_planar_levels};
pub use planar::{EnvLayout, Planar};
pub use whole::{OutputFolder, WholeFile};
pub use write::{Sample, write_exr, write_png};
pub use write_planes::write_planes;

//! The results of a run as a user sees them: metrics, tables, error maps, hashes and the HTML page.

pub mod hash;
pub mod metrics;
pub mod motion;
pub mod shown;

#[cfg(feature = "files")]
pub mod error_map;
#[cfg(feature = "files")]
pub mod escape;
#[cfg(feature = "files")]
pub mod flip;
#[cfg(feature = "files")]
pub mod font;
#[cfg(feature = "files")]
pub mod html;
#[cfg(feature = "files")]
pub mod page;
#[cfg(feature = "files")]
pub mod table;

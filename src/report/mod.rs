//! The results of a run as a user sees them: metrics, tables, error maps, hashes and the HTML page.

pub mod error_map;
pub mod escape;
pub mod flip;
pub mod font;
pub mod hash;
pub mod html;
pub mod metrics;
pub mod page;
pub mod shown;
pub mod table;

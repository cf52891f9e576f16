//! House rules, held by a scan of the project's own files.

mod changelog;
mod errata;
mod golden;
mod no_floats;
mod twins;

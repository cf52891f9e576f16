//! House rules, held by a scan of the project's own files.

mod changelog;
mod code;
mod errata;
mod floors;
mod golden;
mod markdown;
mod no_floats;
mod programs;
mod twins;
mod wide;

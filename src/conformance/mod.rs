//! Conformance: test vectors, named suites, and judges of a device's results.
//!
//! A [`field::Shape`] describes a stage once: what goes in, which registers come out and in which formats. Everything
//! else follows from it: benches fill its numbers, [`text`] writes and reads them, [`header`] declares them for C and
//! SystemVerilog, [`cases`] sweeps their patterns, and the judges name the field that is wrong.

pub mod attribution;
pub mod bench;
pub mod budget;
pub mod cases;
pub mod certify;
pub mod check;
pub mod env;
pub mod exact;
pub mod extremes;
pub mod field;
pub mod gpu;
pub mod header;
pub mod hit;
pub mod memory;
pub mod patterns;
pub mod ray_cone;
pub mod run;
pub mod stimuli;
pub mod subject;
pub mod suite;
pub mod tex;
pub mod text;

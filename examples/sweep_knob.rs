//! What a table of angles costs and brings: its size against the distance from the float reference.
//!
//!     cargo run --release --example sweep_knob

use tapline::engine::EngineKind::{F64, Rtl};
use tapline::error::InputError;
use tapline::{Scene, Unit, compare};

fn main() -> Result<(), InputError> {
    let scene = Scene::built_in("scratches", [128, 128])?;
    println!("{} fragments\nentries  rtl against f64", scene.requests());
    for entries in [4, 8, 16, 32, 64] {
        let unit = Unit::default().with(&format!("eigen.entries={entries}"))?;
        let pair = compare(&unit, &scene, &[Rtl, F64])?.pair(Rtl, F64)?;
        match pair.psnr_db {
            Some(db) => println!("{entries:7}  {db:.2} dB"),
            None => println!("{entries:7}  equal"),
        }
    }
    Ok(())
}

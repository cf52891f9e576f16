//! One fragment through the integer model: its colour, its footprint, and every register.
//!
//!     cargo run --release --example filter_fragment

use tapline::error::InputError;
use tapline::fragment::Fragment;
use tapline::{Scene, Unit, filter};

fn main() -> Result<(), InputError> {
    // A curved mirror seen at 37°: the derivatives are per pixel, and nothing needs to be normalised.
    let fragment = Fragment {
        v: [0.0, 0.0, 1.0],
        n: [0.0, 0.6, 0.8],
        dv_dx: [0.002, 0.0, 0.0],
        dv_dy: [0.0, 0.002, 0.0],
        dn_dx: [0.01, 0.0, 0.0],
        dn_dy: [0.0, 0.008, -0.006],
        h: None,
        bump: None,
        rough: None,
    };
    // The procedural environment of the built-in scenes.
    let scene = Scene::built_in("sphere", [1, 1])?;
    let trace = filter(&Unit::default(), &fragment, scene.map())?;
    for register in trace.registers() {
        println!("{:<24} {:?}", register.name(), register.values());
    }
    if let Some(color) = trace.color() {
        println!("colour {color:.6?}, flags {:?}", trace.flags);
    }
    Ok(())
}

//! The whole unit: any bits in, units at the limits of the model's integers, scales of the inputs.
//!
//! One test binary, because every stage is inlined into each size of lane block that it runs.

mod any_bits;
mod limits;
mod scale;

use crate::common::Record;
use rtl_model::Texture;
use rtl_model::unit::{Ports, Results, State, Unit, Words};

/// One fragment through a unit: its register writes and results.
fn run_one(unit: &Unit, texture: Option<&Texture>, words: &Words) -> (Record, Results<1>) {
    let mut record = Record::default();
    let mut ports = Ports::<1>::default();
    unit.load(&mut ports, words);
    let mut results = Results::default();
    let mut state = State::default();
    unit.env(&ports, texture, &mut state, &mut results, &mut record);
    (record, results)
}

//! The whole unit: any bits in, units at the limits of the model's integers, scales of the inputs.
//!
//! One test binary, because every stage is inlined into each size of lane block that it runs.

mod any_bits;
mod limits;
mod scale;

use crate::common::Record;
use rtl_model::unit::{EnvBlock, Memory, Operation as _, Results, Unit, Words};

/// One fragment through a unit without a texture: its register writes and results.
fn run_one(unit: &Unit, words: &Words) -> (Record, Results<1>) {
    let mut record = Record::default();
    let (mut block, mut results) = (EnvBlock::default(), Results::default());
    unit.load(std::slice::from_ref(words), &mut block);
    unit.run(&Memory::default(), &mut block, &mut results, &mut record);
    (record, results)
}

//! Attribution: the share of each stage's word lengths in a scene's error.
//!
//! Formats are data, so a unit in which every register is as wide as the model can hold stands for exact arithmetic in
//! the same circuit. One stage at a time gets the unit's own words back; the difference of the two pictures is that
//! stage's part. What the widest unit still differs from the float reference by (8-bit weights, sub-texels) is a part of
//! its own.

use rtl_model::Config;
use rtl_model::Unit;
use rtl_model::regs::{Kind, Reg};
use rtl_model::unit::{Needs, Words};

use super::field::registers;
use crate::base::num;
use crate::engine::float::F64Engine;
use crate::engine::rtl::RtlEngine;
use crate::engine::{Engine as _, EnvJob, encode};
use crate::error::InputError;
use crate::picture::Picture;
use crate::policy::Axis;
use crate::report::metrics::compare;
use crate::stage::Stage;
use crate::unit::{ReferenceAxis, UnitSpec};

/// One part of a picture's error.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The stage, or what else differs.
    pub name: String,
    /// RMS difference in the display's units (peak 1).
    pub rmse: f64,
    /// Largest difference.
    pub max_abs: f64,
}

/// The part of the angle table.
pub const ANGLE_TABLE: &str = "tables.eigen";
/// The error of the unit as it is.
pub const WHOLE: &str = "all of the unit";

/// Most bits that a register gets in addition to its own.
const MOST: u32 = 12;

/// Whether the unit can be built.
fn fits(config: &Config, needs: Needs, size: u32) -> bool {
    Unit::new(config, needs, size).is_ok()
}

/// Every register a bit wider by turns, as long as the model's sums hold it; tables as fine as they get.
fn widest(spec: &UnitSpec, needs: Needs, size: u32) -> UnitSpec {
    let mut wide = spec.clone();
    let tables = &mut wide.config.tables;
    for table in [&mut tables.recip, &mut tables.rsqrt, &mut tables.sqrt] {
        (table.entries, table.order, table.frac, table.newton) = (1024, 2, 28, 1);
    }
    (tables.log2.entries, tables.log2.order, tables.log2.frac) = (1024, 2, 28);
    if wide.config.policy.footprint.axis == Axis::EigenTable {
        wide.config.policy.footprint.axis = Axis::EigenExact;
    }
    if !fits(&wide.config, needs, size) {
        return spec.clone();
    }
    let mut open: Vec<Reg> = Reg::ALL.to_vec();
    for _ in 0..MOST {
        open.retain(|reg| {
            let block = reg.info().kind == Kind::Block;
            let format = &mut wide.config.formats[reg.index()];
            if block && format.magnitude_bits() >= 31 {
                return false;
            }
            format.frac += 1;
            if fits(&wide.config, needs, size) {
                return true;
            }
            wide.config.formats[reg.index()].frac -= 1;
            false
        });
    }
    wide
}

/// The widest unit with one stage's own words.
fn with_stage(spec: &UnitSpec, wide: &UnitSpec, stage: Stage) -> UnitSpec {
    let mut out = wide.clone();
    for reg in registers(stage) {
        out.config.formats[reg.index()] = spec.config.formats[reg.index()];
    }
    out
}

/// A picture by a unit; `None` where its words do not fit together.
fn picture(spec: &UnitSpec, subject: &EnvJob, words: &[Words]) -> Option<Picture> {
    let engine = RtlEngine::new(spec, subject.needs(), &subject.map).ok()?;
    let filtered = engine.filter(words, &|_| ());
    let colors: Vec<[f64; 3]> = filtered.colors.iter().map(|c| engine.color(*c)).collect();
    Some(subject.picture(&colors))
}

fn part(name: String, a: &Picture, b: &Picture) -> Result<Part, InputError> {
    let pair = compare(a, b, 0.0)?;
    Ok(Part { name, rmse: pair.rmse, max_abs: pair.max_abs })
}

/// The parts of an ENV scene's error: stages, tables, the part that no word can mend; and the whole, last.
pub fn attribute(spec: &UnitSpec, subject: &EnvJob) -> Result<Vec<Part>, InputError> {
    let size = num::u32(subject.map.size());
    let needs = subject.needs();
    let words: Vec<Words> =
        subject.scene.fragments.iter().map(|f| encode::words(&f.fragment)).collect();
    let wide = widest(spec, needs, size);
    let settings = spec.settings(ReferenceAxis::Exact);
    let exact = F64Engine { settings }.render(subject, &|_| ())?.picture;
    let own = picture(spec, subject, &words).ok_or_else(|| {
        InputError::new(
            "unit",
            "one that serves the scene",
            "one that the model refuses",
            "see `tapline unit check`",
        )
    })?;
    let mut parts = Vec::new();
    if let Some(reference) = picture(&wide, subject, &words) {
        let mut add = |name: String, changed: &UnitSpec| -> Result<(), InputError> {
            if let Some(picture) = picture(changed, subject, &words) {
                parts.push(part(name, &picture, &reference)?);
            }
            Ok(())
        };
        for stage in super::subject::Subject::Env.stages() {
            add(stage.name().into(), &with_stage(spec, &wide, stage))?;
        }
        let tables = spec.config.tables;
        for name in ["recip", "rsqrt", "sqrt", "log2"] {
            let mut changed = wide.clone();
            match name {
                "recip" => changed.config.tables.recip = tables.recip,
                "rsqrt" => changed.config.tables.rsqrt = tables.rsqrt,
                "sqrt" => changed.config.tables.sqrt = tables.sqrt,
                _ => changed.config.tables.log2 = tables.log2,
            }
            add(format!("tables.{name}"), &changed)?;
        }
        if spec.config.policy.footprint.axis == Axis::EigenTable {
            let mut changed = wide.clone();
            changed.config.policy.footprint.axis = Axis::EigenTable;
            add(ANGLE_TABLE.into(), &changed)?;
        }
        parts.push(part("weights and sub-texels".into(), &reference, &exact)?);
    }
    parts.push(part(WHOLE.into(), &own, &exact)?);
    Ok(parts)
}

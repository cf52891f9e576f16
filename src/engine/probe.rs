//! One fragment's registers, as the integer model and the float reference write them.

use std::collections::HashMap;

use rtl_model::regs::Reg;
use rtl_model::unit::{Results, State};
use rtl_model::{Config, Tap, Texture, Unit};

use super::encode;
use super::rtl::flag_names;
use crate::base::num;
use crate::fragment::Fragment;
use crate::reference;
use crate::stage::Stage;

/// A register component of the integer model: value = `raw · 2^−frac`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code {
    /// Integer.
    pub raw: i64,
    /// Fraction bits, powers of two of the pre-normalisation included; may be negative.
    pub frac: i64,
}

impl Code {
    /// The placeholder of a component that was skipped: a second level without weight.
    pub const SKIPPED: Self = Self { raw: 0, frac: i64::MIN };

    /// Whether the component was written.
    #[must_use]
    pub fn is_written(self) -> bool {
        self != Self::SKIPPED
    }

    /// The value to the nearest double.
    #[must_use]
    pub fn value(self) -> f64 {
        to_f64(self.raw, num::i32(self.frac.clamp(-4000, 4000)))
    }
}

/// raw · 2^−frac to the nearest double (subnormals round once more).
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "rounding to nearest is what is wanted")]
pub fn to_f64(raw: i64, frac: i32) -> f64 {
    libm::ldexp(raw as f64, -frac)
}

/// Everything that one lane wrote.
#[derive(Clone, Debug)]
pub struct RtlProbe {
    /// Components of each register in the order written, by `Reg::index`.
    pub registers: Vec<Vec<Code>>,
}

impl Default for RtlProbe {
    fn default() -> Self {
        Self { registers: vec![Vec::new(); Reg::COUNT] }
    }
}

impl RtlProbe {
    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.registers.iter_mut().for_each(Vec::clear);
    }

    /// The components of a register; empty where its stage was not built.
    #[must_use]
    pub fn get(&self, reg: Reg) -> &[Code] {
        &self.registers[reg.index()]
    }
}

impl Tap for RtlProbe {
    fn put(&mut self, _: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        let slots = &mut self.registers[reg.index()];
        if slots.len() <= component {
            slots.resize(component + 1, Code::SKIPPED);
        }
        slots[component] = Code { raw, frac };
    }
}

/// The integer model's result for one fragment.
#[derive(Clone, Debug)]
pub struct RtlFragment {
    /// Face 0…5.
    pub face: usize,
    /// Probes.
    pub probes: i64,
    /// RGB codes.
    pub color: [i64; 3],
    /// Flag names.
    pub flags: Vec<String>,
}

/// Runs one fragment through the integer model with a recording tap.
pub fn rtl(
    unit: &Unit,
    config: &Config,
    fragment: &Fragment,
    texture: Option<&Texture>,
    probe: &mut RtlProbe,
) -> RtlFragment {
    probe.clear();
    let mut out = Results::<1>::default();
    let mut state = State::<1>::default();
    let words = encode::words(fragment);
    let set = unit.one(&words, None, texture, &mut state, &mut out, probe);
    let flags = flag_names(config, set);
    RtlFragment { face: state.face_of(0), probes: out.probes[0], color: out.color[0], flags }
}

/// Everything that the float reference put for one fragment.
#[derive(Clone, Debug)]
pub struct FloatProbe {
    /// Components of each register, by `Reg::index`.
    pub registers: Vec<Vec<f64>>,
    known: HashMap<(Stage, &'static str), Option<Reg>>,
}

impl Default for FloatProbe {
    fn default() -> Self {
        Self { registers: vec![Vec::new(); Reg::COUNT], known: HashMap::new() }
    }
}

impl FloatProbe {
    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.registers.iter_mut().for_each(Vec::clear);
    }

    /// The components of a register; empty where the reference has no such register.
    #[must_use]
    pub fn get(&self, reg: Reg) -> &[f64] {
        &self.registers[reg.index()]
    }
}

impl reference::Tap for FloatProbe {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        let reg = *self
            .known
            .entry((stage, register))
            .or_insert_with(|| Reg::find(stage.name(), register));
        let Some(reg) = reg else { return };
        let slots = &mut self.registers[reg.index()];
        if slots.len() <= component {
            slots.resize(component + 1, 0.0);
        }
        slots[component] = value;
    }

    fn event(&mut self, _: &'static str) {}
}

//! The one description of a stage's inputs and outputs: a list of fields, from which the formats of the
//! vectors, the headers for C and SystemVerilog, the generators and the judge all follow.

use std::fmt::Write as _;

use rtl_model::Config;
use rtl_model::fx::Format;
use rtl_model::regs::{Event, Kind, Reg};
use rtl_model::unit::{Wire, WireKind};

use crate::base::num;
use crate::stage::Stage;

/// Bits of a power of two or of fraction bits that travel with mantissas, the sign included.
pub const POWER_BITS: u32 = 16;

/// The kind of a field's numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// The 64 bits of a binary64 number.
    Word,
    /// Codes of a fixed register.
    Code(Reg),
    /// Mantissas of a block register.
    Mantissa(Reg),
    /// Fraction bits of a block register's mantissas in true units, one for every group of components.
    Fraction(Reg),
    /// A power of two.
    Power,
    /// One of a few, by number.
    Choice(Vec<&'static str>),
    /// A count from the first to the second.
    Count(i64, i64),
    /// Sticky flags, bit 0 first.
    Flags(Vec<&'static str>),
    /// The bits of a small float: a cone's angle or width.
    Small,
}

impl Meaning {
    /// The register whose codes or mantissas they are.
    #[must_use]
    pub fn register(&self) -> Option<Reg> {
        if let Self::Code(reg) | Self::Mantissa(reg) = self { Some(*reg) } else { None }
    }

    /// Names of choices or flags.
    #[must_use]
    pub fn names(&self) -> &[&'static str] {
        if let Self::Choice(names) | Self::Flags(names) = self { names } else { &[] }
    }
}

/// A field: some numbers of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name: letters, digits and underscores, after a dot in the whole unit's.
    pub name: String,
    /// The stage that writes it (that reads it, for an input).
    pub stage: Stage,
    /// Numbers.
    pub components: usize,
    /// Bits of each, the sign included.
    pub bits: u32,
    /// Whether the top bit is a sign.
    pub signed: bool,
    /// Smallest and largest legal number.
    pub range: [i64; 2],
    /// What they are.
    pub meaning: Meaning,
    /// Fraction bits in the nominal scale, where the field is a fixed register.
    pub frac: Option<u32>,
    /// One sentence.
    pub text: String,
}

impl Field {
    /// A field of `components` numbers that fill `bits`.
    #[must_use]
    pub fn new(
        stage: Stage,
        name: impl Into<String>,
        components: usize,
        (signed, bits): (bool, u32),
        meaning: Meaning,
        text: impl Into<String>,
    ) -> Self {
        let range = match (signed, bits) {
            (_, 64) => [i64::MIN, i64::MAX],
            (true, bits) => [-(1 << (bits - 1)), (1 << (bits - 1)) - 1],
            (false, bits) => [0, (1 << bits) - 1],
        };
        Self {
            name: name.into(),
            stage,
            components,
            bits,
            signed,
            range,
            meaning,
            frac: None,
            text: text.into(),
        }
    }

    /// Words of binary64.
    #[must_use]
    pub fn words(stage: Stage, name: &str, components: usize, text: &str) -> Self {
        Self::new(stage, name, components, (false, 64), Meaning::Word, text)
    }

    /// A number from `low` to `high`, both at least 0.
    #[must_use]
    pub fn count(stage: Stage, name: &str, [low, high]: [i64; 2], text: &str) -> Self {
        let bits = u64::BITS - high.max(1).unsigned_abs().leading_zeros();
        let meaning = Meaning::Count(low, high);
        let mut field = Self::new(stage, name, 1, (false, bits), meaning, text);
        field.range = [low, high];
        field
    }

    /// One of a few names.
    #[must_use]
    pub fn choice(stage: Stage, name: &str, names: Vec<&'static str>, text: &str) -> Self {
        let last = num::i64(names.len()) - 1;
        let mut field = Self::count(stage, name, [0, last], text);
        field.meaning = Meaning::Choice(names);
        field
    }

    /// A register's codes or mantissas.
    #[must_use]
    pub fn register(
        config: &Config,
        stage: Stage,
        name: &str,
        reg: Reg,
        components: usize,
    ) -> Self {
        let format = config.format(reg);
        let info = reg.info();
        let meaning = match info.kind {
            Kind::Fixed => Meaning::Code(reg),
            Kind::Block => Meaning::Mantissa(reg),
        };
        let bits = (format.signed, format.width());
        let mut field = Self::new(stage, name, components, bits, meaning, info.meaning);
        field.range = [format.min_raw(), format.max_raw()];
        field.frac = (info.kind == Kind::Fixed).then_some(format.frac);
        field
    }

    /// The fields of a register that a stage writes: codes, or mantissas with their fraction bits.
    pub fn written(
        config: &Config,
        stage: Stage,
        reg: Reg,
        components: usize,
        out: &mut Vec<Self>,
    ) {
        let info = reg.info();
        out.push(Self::register(config, stage, info.name, reg, components));
        if info.kind == Kind::Block {
            let name = format!("{}_frac", info.name);
            let text = format!("fraction bits of {} in true units", info.name);
            let groups = components / group(reg);
            let bits = (true, POWER_BITS);
            out.push(Self::new(stage, name, groups, bits, Meaning::Fraction(reg), text));
        }
    }

    /// The field of a wire.
    #[must_use]
    pub fn wire(config: &Config, stage: Stage, wire: Wire) -> Self {
        let (name, text) = (wire.name(), wire.meaning());
        match wire.kind() {
            WireKind::Power => {
                let bits = (true, POWER_BITS);
                let mut field = Self::new(stage, name, 1, bits, Meaning::Power, text);
                // What the ports can take out of binary64 numbers, three times over, and a register's bits.
                field.range = [-4096, 4095];
                field
            }
            WireKind::Face => Self::choice(stage, name, crate::cube::FACE_NAMES.to_vec(), text),
            WireKind::Bit => Self::count(stage, name, [0, 1], text),
            WireKind::Count => {
                Self::count(stage, name, [1, i64::from(config.policy.footprint.max_probes)], text)
            }
            WireKind::Codes(_) | WireKind::Mantissas(_) | WireKind::Floating(_) => {
                let reg = wire.register(0).map_or(Reg::ReflectV, |(reg, _)| reg);
                // Shared between registers: the widest field, each component within its own.
                let mut field = Self::register(config, stage, name, reg, wire.components());
                for c in 0..wire.components() {
                    let format = wire.format(config, c).unwrap_or(Format::signed(1, 22));
                    field.bits = field.bits.max(format.width());
                    field.signed |= format.signed;
                    let [low, high] = field.range;
                    field.range = [low.max(format.min_raw()), high.min(format.max_raw())];
                }
                if !matches!(wire.kind(), WireKind::Codes(_)) {
                    field.range[0] = -field.range[1];
                }
                field.text = text.into();
                field
            }
        }
    }

    /// A cone's code.
    pub(super) fn small(config: &Config, stage: Stage, name: &str, text: &str) -> Self {
        let bits = config.policy.cone.format.float().width();
        Self::new(stage, name, 1, (false, bits), Meaning::Small, text)
    }

    /// Sticky flags of a stage.
    #[must_use]
    pub fn flags(stage: Stage, registers: &[Reg]) -> Self {
        let names: Vec<&'static str> = registers
            .iter()
            .map(|reg| reg.info().name)
            .chain(events(stage).map(Event::name))
            .collect();
        let bits = u32::try_from(names.len().max(1)).unwrap_or(63);
        let text = "sticky flags: bit k is set where the k-th register left its range or the event happened";
        Self::new(stage, "flags", 1, (false, bits), Meaning::Flags(names), text)
    }

    /// Fields of the stages behind an operation's own, as HIT and TEX have them.
    pub(super) fn behind(config: &Config, own: Stage, stages: &[Stage], out: &mut Vec<Self>) {
        for stage in stages.iter().filter(|stage| **stage != own) {
            let first = out.len();
            others(config, *stage, out);
            // A ray without a cone takes no probe.
            out.extend(beside(config, *stage, 0));
            for field in &mut out[first..] {
                field.name = format!("{}.{}", stage.name(), field.name);
            }
        }
    }

    /// Hexadecimal digits of one number in a vector file.
    #[must_use]
    pub fn digits(&self) -> usize {
        usize::try_from(self.bits.div_ceil(4)).unwrap_or(16)
    }

    /// Bits of one number in a vector file: whole digits.
    #[must_use]
    pub fn padded_bits(&self) -> usize {
        4 * self.digits()
    }

    /// The name with underscores alone, as C and SystemVerilog take it.
    #[must_use]
    pub fn identifier(&self) -> String {
        self.name.replace('.', "_")
    }
}

/// Registers that the footprint at the hit writes of other stages, and those of the back end.
fn others(config: &Config, stage: Stage, out: &mut Vec<Field>) {
    let mut regs = Vec::new();
    for reg in registers(stage) {
        let turned = reg == Reg::FaceRotated && config.rotation.is_none();
        let written = [Reg::JacDvr, Reg::JacNumerator, Reg::JacD].contains(&reg);
        if turned || (stage == Stage::Jacobian && !written) {
            continue;
        }
        regs.push(reg);
        Field::written(config, stage, reg, components(config, stage, reg), out);
    }
    out.push(Field::flags(stage, &regs));
}

/// Components of a block register that share an exponent.
#[must_use]
pub fn group(reg: Reg) -> usize {
    if [Reg::SurfInvLength, Reg::SurfInvSquare].contains(&reg) {
        1
    } else if reg == Reg::SurfTurned {
        3
    } else {
        reg.info().components
    }
}

/// Events of a stage, in order.
pub fn events(stage: Stage) -> impl Iterator<Item = Event> {
    Event::ALL
        .iter()
        .copied()
        .filter(move |event| event.name().split('.').next() == Some(stage.name()))
}

/// Registers of a stage, in order.
pub fn registers(stage: Stage) -> impl Iterator<Item = Reg> {
    Reg::ALL.iter().copied().filter(move |reg| reg.info().stage == stage)
}

/// The outputs of a stage that are no registers: a face, or a count of at least `least` probes.
#[must_use]
pub fn beside(config: &Config, stage: Stage, least: i64) -> Option<Field> {
    if stage == Stage::CubeFace {
        let names = crate::cube::FACE_NAMES.to_vec();
        Some(Field::choice(stage, "face", names, "face that the direction meets"))
    } else if stage == Stage::Footprint {
        let most = i64::from(config.policy.footprint.max_probes);
        Some(Field::count(stage, "count", [least, most], "probes"))
    } else {
        None
    }
}

/// Numbers of a register: those of one probe for each probe that a fragment may have.
#[must_use]
pub fn components(config: &Config, stage: Stage, reg: Reg) -> usize {
    let per_probe = matches!(stage, Stage::Address | Stage::Filter) && reg != Reg::FilterColor;
    let probes = if per_probe { num::usize(config.policy.footprint.max_probes) } else { 1 };
    probes * reg.info().components
}

/// Inputs and outputs of a stage or of the unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// The inputs.
    pub inputs: Vec<Field>,
    /// The outputs: every register, in the order in which they are written.
    pub outputs: Vec<Field>,
}

impl Shape {
    /// Numbers of all inputs.
    #[must_use]
    pub fn input_len(&self) -> usize {
        self.inputs.iter().map(|f| f.components).sum()
    }

    /// Numbers of all outputs.
    #[must_use]
    pub fn output_len(&self) -> usize {
        self.outputs.iter().map(|f| f.components).sum()
    }

    /// The field and component of each number, inputs first.
    pub fn numbers(&self) -> impl Iterator<Item = (&Field, usize)> {
        let all = self.inputs.iter().chain(&self.outputs);
        all.flat_map(|field| (0..field.components).map(move |c| (field, c)))
    }

    /// Where an output's first number lies among the outputs.
    #[must_use]
    pub fn output_at(&self, name: &str) -> Option<usize> {
        let mut at = 0;
        for field in &self.outputs {
            if field.name == name {
                return Some(at);
            }
            at += field.components;
        }
        None
    }
}

/// Where a shape's flags lie among its outputs.
#[must_use]
pub fn flag_places(shape: &Shape) -> Vec<usize> {
    let mut at = 0;
    let mut out = Vec::new();
    for field in &shape.outputs {
        if matches!(field.meaning, Meaning::Flags(_)) {
            out.push(at);
        }
        at += field.components;
    }
    out
}

/// Appends a number's digits.
pub fn digits(field: &Field, number: i64, out: &mut String) {
    let bits = field.padded_bits();
    let word = number.cast_unsigned();
    let word = if bits < 64 { word & ((1 << bits) - 1) } else { word };
    let width = field.digits();
    let _ = write!(out, "{word:0width$x}");
}

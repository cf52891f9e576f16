//! The knobs of a unit: the rows of `rtl_model::policy` and the parts of every register, with what is said of a path or a
//! value that is none.

use rtl_model::fx::{Format, Overflow, Rounding};
use rtl_model::policy::{Legal, Place, ROWS, Row, Setting};
use rtl_model::regs::{Kind, Reg};

use super::UnitSpec;
use crate::error::InputError;
use crate::settings::IDENTITY;

/// A value of a knob, as TOML has it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A decimal.
    Float(f64),
    /// A literal.
    Text(String),
    /// A row-by-row matrix.
    Numbers(Vec<f64>),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(n) => write!(f, "{n}"),
            Self::Float(x) => write!(f, "{x:?}"),
            Self::Text(t) => write!(f, "{t:?}"),
            Self::Numbers(v) => write!(f, "{v:?}"),
        }
    }
}

/// A path with what there is to say about it.
#[derive(Clone, Debug)]
pub struct Knob {
    /// The path, such as `footprint.max_probes`.
    pub path: String,
    /// Its value in this unit.
    pub value: Value,
    /// Legal values.
    pub legal: String,
    /// Whether the float engines honour it; words, roundings and tables are the rtl engine's own.
    pub all_engines: bool,
    /// What it does.
    pub meaning: String,
}

/// The knob that a path names.
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// A row of the table of knobs.
    Row(&'static Row),
    /// A part of a register's format.
    Register(Reg, Part),
}

/// The parts of a register's format that are knobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Integer bits.
    Int,
    /// Fraction bits.
    Frac,
    /// Rounding.
    Rounding,
    /// What happens to a value beyond the range; blocks have none, for they share an exponent.
    Overflow,
}

/// Every part with its name.
const PARTS: [(Part, &str); 4] = [
    (Part::Int, "int"),
    (Part::Frac, "frac"),
    (Part::Rounding, "rounding"),
    (Part::Overflow, "overflow"),
];

/// Most bits of a register without its sign, and of each of its two parts.
const MOST_BITS: u32 = 58;

impl Path {
    /// Every path that is listed, in the order of unit files.
    pub fn all() -> impl Iterator<Item = Self> {
        let rows = ROWS.iter().filter(|row| row.is_listed()).map(Self::Row);
        let parts = |reg: &'static Reg| PARTS.map(|(part, _)| Self::Register(*reg, part));
        rows.chain(Reg::ALL.iter().flat_map(parts).filter(|path| path.is_listed()))
    }

    /// What a path names; the angle table's entries go by two names.
    #[must_use]
    pub fn find(path: &str) -> Option<Self> {
        let path = if path == "tables.eigen.entries" { "eigen.entries" } else { path };
        if let Some(rest) = path.strip_prefix("registers.") {
            let [stage, name, part] = *rest.split('.').collect::<Vec<_>>() else { return None };
            let (part, _) = PARTS.into_iter().find(|(_, known)| *known == part)?;
            return Some(Self::Register(Reg::find(stage, name)?, part));
        }
        ROWS.iter().find(|row| row.path == path).map(Self::Row)
    }

    fn is_listed(self) -> bool {
        match self {
            Self::Row(row) => row.is_listed(),
            Self::Register(reg, part) => part != Part::Overflow || reg.info().kind != Kind::Block,
        }
    }

    /// The path as unit files have it.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::Row(row) => row.path.into(),
            Self::Register(reg, part) => {
                let (_, part) = PARTS[part as usize];
                format!("registers.{reg}.{part}")
            }
        }
    }

    /// Legal values.
    #[must_use]
    pub fn legal(self) -> Legal {
        match self {
            Self::Row(row) => row.legal,
            Self::Register(_, Part::Int | Part::Frac) => Legal::Range(0, MOST_BITS),
            Self::Register(_, Part::Rounding) => Legal::Names(Rounding::NAMES),
            Self::Register(_, Part::Overflow) => Legal::Names(Overflow::NAMES),
        }
    }

    /// The first stage that it reaches; `scene` for what changes what is rendered.
    #[must_use]
    pub fn reach(self) -> &'static str {
        match self {
            Self::Row(row) => row.reach,
            // Distances in memory.
            Self::Register(Reg::HitDistance, _) => "scene",
            Self::Register(reg, _) => reg.info().stage.name(),
        }
    }

    /// The knob with its value in a unit.
    fn knob(self, spec: &UnitSpec) -> Knob {
        let (all_engines, meaning) = match self {
            Self::Row(row) => (row.all_engines, row.meaning),
            Self::Register(reg, _) => (false, reg.info().meaning),
        };
        let (path, value) = (self.text(), self.get(spec));
        Knob { path, value, legal: self.legal().listed(), all_engines, meaning: meaning.into() }
    }

    /// Its value in a unit.
    #[must_use]
    pub fn get(self, spec: &UnitSpec) -> Value {
        let number = match self {
            Self::Row(row) => match row.place {
                Place::Scale => return Value::Float(spec.roughness_scale),
                Place::Rotation => {
                    return Value::Numbers(spec.rotation.unwrap_or(IDENTITY).concat());
                }
                Place::Policy(..) | Place::Table(_) => row.get(&spec.config).unwrap_or(0),
            },
            Self::Register(reg, part) => {
                let format = spec.config.format(reg);
                match part {
                    Part::Int => format.int,
                    Part::Frac => format.frac,
                    Part::Rounding => format.rounding.number(),
                    Part::Overflow => format.overflow.number(),
                }
            }
        };
        let legal = self.legal();
        if let Legal::Names(names) = legal {
            return Value::Text(names[number as usize].into());
        }
        let off = number == 0 && matches!(legal, Legal::OrOff(..));
        if off { Value::Text("off".into()) } else { Value::Integer(number.into()) }
    }

    /// The number of a legal value that is a whole number or a literal.
    fn number(self, value: &Value) -> Option<u32> {
        let legal = self.legal();
        match (value, legal) {
            (Value::Text(text), Legal::Names(names)) => {
                names.iter().position(|name| name == text).and_then(|n| u32::try_from(n).ok())
            }
            (Value::Text(text), Legal::OrOff(..)) => (text == "off").then_some(0),
            (Value::Integer(0), Legal::OrOff(..)) | (Value::Integer(_), Legal::Names(_)) => None,
            (Value::Integer(n), _) => u32::try_from(*n).ok().filter(|n| legal.takes(*n)),
            (Value::Float(_) | Value::Text(_) | Value::Numbers(_), _) => None,
        }
    }

    /// Sets a value; where it is not legal, says what is.
    fn set(self, spec: &mut UnitSpec, value: &Value) -> Result<(), String> {
        match (self, value) {
            (Self::Row(Row { place: Place::Scale, legal, .. }), _) => {
                let [low, high] = legal.ends().map(f64::from);
                let scale = match value {
                    Value::Float(x) => Some(*x),
                    Value::Integer(n) => i32::try_from(*n).ok().map(f64::from),
                    Value::Text(_) | Value::Numbers(_) => None,
                };
                let scale = scale.filter(|x| (low..=high).contains(x));
                spec.set_scale(scale.ok_or_else(|| legal.expected())?);
            }
            (Self::Row(Row { place: Place::Rotation, .. }), Value::Numbers(numbers)) => {
                let expected = "nine numbers row by row whose rows are orthonormal to 2^-10 and turn right-handed";
                spec.set_rotation(rotation(numbers).ok_or(expected)?);
            }
            (Self::Register(reg, Part::Overflow), _) if reg.info().kind == Kind::Block => {
                return Err(
                    "no overflow mode: the register shares an exponent and never overflows".into(),
                );
            }
            _ => {
                let number = self.number(value).ok_or_else(|| self.legal().expected())?;
                match self {
                    Self::Row(row) => row.set(&mut spec.config, number),
                    Self::Register(reg, part) => {
                        let format = &mut spec.config.formats[reg.index()];
                        match part {
                            Part::Int => format.int = number,
                            Part::Frac => format.frac = number,
                            Part::Rounding => format.rounding = Setting::of(number),
                            Part::Overflow => format.overflow = Setting::of(number),
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

impl UnitSpec {
    /// Every knob with its value, in the order in which files list them.
    #[must_use]
    pub fn knobs(&self) -> Vec<Knob> {
        Path::all().map(|path| path.knob(self)).collect()
    }

    /// The value of a knob.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<Value> {
        Path::find(path).filter(|path| path.is_listed()).map(|path| path.get(self))
    }

    /// Sets a knob. The error names the path, what it takes and what was given.
    ///
    /// # Errors
    /// The path or the value is none, or the register gets too wide.
    pub fn set(&mut self, path: &str, value: &Value) -> Result<(), InputError> {
        let before = self.config.formats;
        self.assign(path, value)?;
        // What is refused leaves the unit as it was.
        self.check_widths().inspect_err(|_| self.config.formats = before)
    }

    /// Sets several knobs, which are checked together: a register's two parts may pass through a width that it could not
    /// have.
    ///
    /// # Errors
    /// Those of [`UnitSpec::set`]; the unit is then as far as it came.
    pub fn set_all<'a>(
        &mut self,
        sets: impl IntoIterator<Item = (&'a str, &'a Value)>,
    ) -> Result<(), InputError> {
        for (path, value) in sets {
            self.assign(path, value)?;
        }
        self.check_widths()
    }

    /// [`UnitSpec::set`] without the check of a register's width, which may be too large between the
    /// settings of its two parts.
    pub(super) fn assign(&mut self, path: &str, value: &Value) -> Result<(), InputError> {
        let found = Path::find(path).ok_or_else(|| unknown(path))?;
        found.set(self, value).map_err(|expected| {
            InputError::new("unit", expected, shown(value), "see `tapline unit show`")
                .at(found.text())
        })
    }

    /// The first register with more bits than the model has room for.
    pub(super) fn check_widths(&self) -> Result<(), InputError> {
        for reg in Reg::ALL {
            let format: Format = self.config.format(*reg);
            if format.magnitude_bits() > MOST_BITS {
                return Err(InputError::new(
                    "unit",
                    format!("int + frac of at most {MOST_BITS} bits"),
                    format.magnitude_bits().to_string(),
                    "shorten the register",
                )
                .at(format!("registers.{reg}")));
            }
        }
        Ok(())
    }
}

/// A value as a message shows it: its beginning.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Nine numbers as a rotation: `Some(None)` for the identity, `None` if they are no rotation.
fn rotation(v: &[f64]) -> Option<Option<[[f64; 3]; 3]>> {
    let rows: Vec<[f64; 3]> =
        v.chunks_exact(3).filter_map(|r| <[f64; 3]>::try_from(r).ok()).collect();
    let a = <[[f64; 3]; 3]>::try_from(rows).ok().filter(|_| v.len() == 9)?;
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let slack = 1.0 / 1024.0;
    for i in 0..3 {
        for j in 0..3 {
            let expected = if i == j { 1.0 } else { 0.0 };
            let error = (dot(a[i], a[j]) - expected).abs();
            if error.is_nan() || error > slack {
                return None;
            }
        }
    }
    let [x, y, z] = a;
    let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    if dot(cross, z) < 0.0 {
        return None;
    }
    let identity = a == IDENTITY;
    Some((!identity).then_some(a))
}

/// The error for a path that no unit of this version has.
pub(super) fn unknown(path: &str) -> InputError {
    InputError::new(
        "unit",
        "a path that `tapline unit show` lists",
        "an unknown path",
        "check the spelling",
    )
    .at(path)
}

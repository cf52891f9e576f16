//! Every path of a unit: how it is read, set, explained.

use rtl_model::TexelFormat;
use rtl_model::fx::{Format, Overflow, Rounding};
use rtl_model::regs::{Kind, Reg};
use rtl_model::tables::TableSpec;

use super::UnitSpec;
use crate::error::InputError;
use crate::policy::{
    Axis, Count, Curvature, Dnmod, Minor, Placement, RoughnessInterpolation, Weights,
};

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

fn names<T: Copy>(all: &[T], name: impl Fn(T) -> &'static str) -> String {
    all.iter().map(|v| name(*v)).collect::<Vec<_>>().join(" | ")
}

const TABLES: [&str; 4] = ["recip", "rsqrt", "sqrt", "log2"];

fn table<'a>(spec: &'a mut UnitSpec, name: &str) -> Option<&'a mut TableSpec> {
    let tables = &mut spec.config.tables;
    Some(match name {
        "recip" => &mut tables.recip,
        "rsqrt" => &mut tables.rsqrt,
        "sqrt" => &mut tables.sqrt,
        "log2" => &mut tables.log2,
        "eigen" => &mut tables.eigen,
        _ => return None,
    })
}

impl UnitSpec {
    /// Every knob with its value, in the order in which files list them.
    #[must_use]
    pub fn knobs(&self) -> Vec<Knob> {
        let mut out = Vec::new();
        let mut add = |path: &str, value: Value, legal: &str, all_engines: bool, meaning: &str| {
            out.push(Knob {
                path: path.into(),
                value,
                legal: legal.into(),
                all_engines,
                meaning: meaning.into(),
            });
        };
        let text = |t: &str| Value::Text(t.into());
        let int = |n: u32| Value::Integer(n.into());
        let c = &self.config;
        add(
            "footprint.max_probes",
            int(c.max_probes),
            "1…64",
            true,
            "most probes of a fragment",
        );
        add(
            "footprint.count",
            text(c.count.name()),
            &names(Count::ALL, Count::name),
            true,
            "rule of the probe count",
        );
        add(
            "footprint.axis",
            text(c.axis.name()),
            &names(Axis::ALL, Axis::name),
            true,
            "direction of the probe line",
        );
        add(
            "footprint.weights",
            text(c.weights.name()),
            &names(Weights::ALL, Weights::name),
            true,
            "weights of the probes",
        );
        add(
            "footprint.weight_bits",
            int(c.probe_weight_bits),
            "1…12",
            true,
            "gaussian probe weights sum to 2^bits",
        );
        add(
            "roughness.scale",
            Value::Float(self.roughness_scale),
            "0…8",
            true,
            "s in K = D Dᵀ + s² K3",
        );
        add(
            "roughness.interpolate",
            text(self.roughness_interpolation.name()),
            &names(RoughnessInterpolation::ALL, RoughnessInterpolation::name),
            true,
            "what the roughness pyramid interpolates",
        );
        add(
            "roughness.curvature",
            text(self.roughness_curvature.name()),
            &names(Curvature::ALL, Curvature::name),
            true,
            "where the bump map's own curvature is counted",
        );
        add(
            "jacobian.dnmod",
            text(c.dnmod.name()),
            &names(Dnmod::ALL, Dnmod::name),
            true,
            "what stands for the derivative of the modified normal",
        );
        add(
            "eigen.entries",
            int(c.tables.eigen.entries),
            "even, 2…1024",
            false,
            "angle-table entries over 90°",
        );
        add(
            "eigen.placement",
            text(c.placement.name()),
            &names(Placement::ALL, Placement::name),
            false,
            "where the angle table's entries lie",
        );
        add(
            "eigen.minor",
            text(c.minor.name()),
            &names(Minor::ALL, Minor::name),
            true,
            "how λ2 is found",
        );
        add(
            "filter.weight_bits",
            int(c.weight_bits),
            "1…8",
            false,
            "bits of a bilinear weight",
        );
        add(
            "filter.lod_bits",
            int(c.lod_bits),
            "1…8",
            false,
            "bits of the weight between two levels",
        );
        add(
            "texel.format",
            text(c.texel_format.name()),
            &names(TexelFormat::ALL, TexelFormat::name),
            false,
            "how texels are stored",
        );
        add(
            "texel.int",
            int(c.texel_int),
            "1…17",
            false,
            "integer bits of a decoded texel",
        );
        add(
            "texel.frac",
            int(c.texel_frac),
            "4…24",
            false,
            "fraction bits of a decoded texel",
        );
        let rotation = self
            .rotation
            .unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        add(
            "transform.rotation",
            Value::Numbers(rotation.concat()),
            "nine numbers, a rotation",
            true,
            "rotation A of the environment, row by row",
        );
        let t = &c.tables;
        for (name, spec) in TABLES.iter().zip([t.recip, t.rsqrt, t.sqrt, t.log2]) {
            let path = |knob: &str| format!("tables.{name}.{knob}");
            add(
                &path("entries"),
                int(spec.entries),
                "a power of two, 2…4096",
                false,
                "intervals",
            );
            add(
                &path("order"),
                int(spec.order),
                "0 | 1 | 2",
                false,
                "interpolation: none, linear, quadratic",
            );
            add(
                &path("frac"),
                int(spec.frac),
                "2…28",
                false,
                "fraction bits of an entry",
            );
            if *name != "log2" {
                add(
                    &path("newton"),
                    int(spec.newton),
                    "0…3",
                    false,
                    "Newton steps after the look-up",
                );
            }
        }
        add(
            "tables.eigen.order",
            int(t.eigen.order),
            "0 | 1",
            false,
            "interpolation between angle entries",
        );
        add(
            "tables.eigen.frac",
            int(t.eigen.frac),
            "4…28",
            false,
            "fraction bits of sine and cosine",
        );
        for reg in Reg::ALL {
            let info = reg.info();
            let format = c.format(*reg);
            let path = |knob: &str| format!("registers.{}.{}.{knob}", info.stage, info.name);
            add(&path("int"), int(format.int), "0…58", false, info.meaning);
            add(&path("frac"), int(format.frac), "0…58", false, info.meaning);
            add(
                &path("rounding"),
                text(format.rounding.name()),
                &names(Rounding::ALL, Rounding::name),
                false,
                info.meaning,
            );
            if info.kind == Kind::Fixed {
                add(
                    &path("overflow"),
                    text(format.overflow.name()),
                    &names(Overflow::ALL, Overflow::name),
                    false,
                    info.meaning,
                );
            }
        }
        out
    }

    /// Sets a knob. The error names the path, what it takes and what was given.
    pub fn set(&mut self, path: &str, value: &Value) -> Result<(), InputError> {
        let before = self.config.formats;
        self.assign(path, value)?;
        // What is refused leaves the unit as it was.
        self.check_widths()
            .inspect_err(|_| self.config.formats = before)
    }

    /// [`UnitSpec::set`] without the check of a register's width, which may be too large between the
    /// settings of its two parts.
    pub(super) fn assign(&mut self, path: &str, value: &Value) -> Result<(), InputError> {
        let path = if path == "tables.eigen.entries" {
            "eigen.entries"
        } else {
            path
        };
        let wrong = |expected: &str| {
            Err(InputError::new("unit", expected, shown(value), "see `tapline unit show`").at(path))
        };
        let c = &mut self.config;
        macro_rules! literal {
            ($type:ty, $target:expr) => {
                match value {
                    Value::Text(t) => match <$type>::parse(t) {
                        Some(v) => {
                            $target = v;
                            Ok(())
                        }
                        None => wrong(&names(<$type>::ALL, <$type>::name)),
                    },
                    _ => wrong(&names(<$type>::ALL, <$type>::name)),
                }
            };
        }
        let whole = |low: u32, high: u32| match value {
            Value::Integer(n) => u32::try_from(*n).ok().filter(|n| (low..=high).contains(n)),
            Value::Float(_) | Value::Text(_) | Value::Numbers(_) => None,
        };
        macro_rules! number {
            ($target:expr, $low:expr, $high:expr) => {
                match whole($low, $high) {
                    Some(n) => {
                        $target = n;
                        Ok(())
                    }
                    None => wrong(&format!("a whole number from {} to {}", $low, $high)),
                }
            };
        }
        match path {
            "footprint.max_probes" => number!(c.max_probes, 1, 64),
            "footprint.count" => literal!(Count, c.count),
            "footprint.axis" => literal!(Axis, c.axis),
            "footprint.weights" => literal!(Weights, c.weights),
            "footprint.weight_bits" => number!(c.probe_weight_bits, 1, 12),
            "roughness.scale" => match value {
                Value::Float(x) if (0.0..=8.0).contains(x) => {
                    self.set_scale(*x);
                    Ok(())
                }
                Value::Integer(n) if (0..=8).contains(n) => {
                    self.set_scale(f64::from(whole(0, 8).unwrap_or(0)));
                    Ok(())
                }
                Value::Integer(_) | Value::Float(_) | Value::Text(_) | Value::Numbers(_) => {
                    wrong("a number from 0 to 8")
                }
            },
            "roughness.interpolate" => {
                literal!(RoughnessInterpolation, self.roughness_interpolation)
            }
            "roughness.curvature" => literal!(Curvature, self.roughness_curvature),
            "jacobian.dnmod" => literal!(Dnmod, c.dnmod),
            "eigen.entries" => match whole(2, 1024) {
                Some(n) if n % 2 == 0 => {
                    c.tables.eigen.entries = n;
                    Ok(())
                }
                _ => wrong("an even number from 2 to 1024"),
            },
            "eigen.placement" => literal!(Placement, c.placement),
            "eigen.minor" => literal!(Minor, c.minor),
            "filter.weight_bits" => number!(c.weight_bits, 1, 8),
            "filter.lod_bits" => number!(c.lod_bits, 1, 8),
            "texel.format" => literal!(TexelFormat, c.texel_format),
            "texel.int" => number!(c.texel_int, 1, 17),
            "texel.frac" => number!(c.texel_frac, 4, 24),
            "transform.rotation" => match value {
                Value::Numbers(v) => match rotation(v) {
                    Some(a) => {
                        self.set_rotation(a);
                        Ok(())
                    }
                    None => wrong(
                        "nine numbers row by row whose rows are orthonormal to 2^-10 and turn right-handed",
                    ),
                },
                Value::Integer(_) | Value::Float(_) | Value::Text(_) => {
                    wrong("an array of nine numbers, row by row")
                }
            },
            _ => self.set_nested(path, value),
        }
    }

    fn set_nested(&mut self, path: &str, value: &Value) -> Result<(), InputError> {
        let wrong = |expected: String| {
            Err(InputError::new("unit", expected, shown(value), "see `tapline unit show`").at(path))
        };
        let whole = |high: u32| match value {
            Value::Integer(n) => u32::try_from(*n).ok().filter(|n| *n <= high),
            Value::Float(_) | Value::Text(_) | Value::Numbers(_) => None,
        };
        let parts: Vec<&str> = path.split('.').collect();
        match parts.as_slice() {
            ["tables", name, knob] => {
                let angle = *name == "eigen";
                let Some(spec) = table(self, name) else {
                    return Err(unknown(path));
                };
                let (legal, target, text): (fn(u32) -> bool, _, _) = match *knob {
                    "entries" => (
                        |n| n.is_power_of_two() && (2..=4096).contains(&n),
                        &mut spec.entries,
                        "a power of two from 2 to 4096",
                    ),
                    "order" if angle => (|n| n <= 1, &mut spec.order, "0 or 1"),
                    "order" => (|n| n <= 2, &mut spec.order, "0, 1 or 2"),
                    "frac" if angle => (|n| (4..=28).contains(&n), &mut spec.frac, "4 to 28 bits"),
                    "frac" => (|n| (2..=28).contains(&n), &mut spec.frac, "2 to 28 bits"),
                    "newton" if angle || *name == "log2" => (
                        |n| n == 0,
                        &mut spec.newton,
                        "0: this table has no Newton step",
                    ),
                    "newton" => (|n| n <= 3, &mut spec.newton, "0 to 3 steps"),
                    _ => return Err(unknown(path)),
                };
                match whole(4096).filter(|n| legal(*n)) {
                    Some(n) => {
                        *target = n;
                        Ok(())
                    }
                    None => wrong(text.into()),
                }
            }
            ["registers", stage, name, knob] => {
                let Some(reg) = Reg::find(stage, name) else {
                    return Err(unknown(path));
                };
                let Some(format) = self.config.formats.get_mut(reg.index()) else {
                    return Err(unknown(path));
                };
                match (*knob, value) {
                    ("int", _) if whole(58).is_some() => format.int = whole(58).unwrap_or(0),
                    ("frac", _) if whole(58).is_some() => format.frac = whole(58).unwrap_or(0),
                    ("int" | "frac", _) => return wrong("a whole number from 0 to 58".into()),
                    ("rounding", Value::Text(t)) if Rounding::parse(t).is_some() => {
                        format.rounding = Rounding::parse(t).unwrap_or(Rounding::HalfEven);
                    }
                    ("rounding", _) => return wrong(names(Rounding::ALL, Rounding::name)),
                    ("overflow", _) if reg.info().kind == Kind::Block => {
                        return wrong(
                            "no overflow mode: the register shares an exponent and never overflows"
                                .into(),
                        );
                    }
                    ("overflow", Value::Text(t)) if Overflow::parse(t).is_some() => {
                        format.overflow = Overflow::parse(t).unwrap_or(Overflow::Saturate);
                    }
                    ("overflow", _) => return wrong(names(Overflow::ALL, Overflow::name)),
                    _ => return Err(unknown(path)),
                }
                Ok(())
            }
            _ => Err(unknown(path)),
        }
    }

    /// The first register with more bits than the model has room for.
    pub(super) fn check_widths(&self) -> Result<(), InputError> {
        for reg in Reg::ALL {
            let format: Format = self.config.format(*reg);
            if format.magnitude_bits() > 58 {
                let info = reg.info();
                return Err(InputError::new(
                    "unit",
                    "int + frac of at most 58 bits",
                    format.magnitude_bits().to_string(),
                    "shorten the register",
                )
                .at(format!("registers.{}.{}", info.stage, info.name)));
            }
        }
        Ok(())
    }

    /// The value of a knob.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<Value> {
        let path = if path == "tables.eigen.entries" {
            "eigen.entries"
        } else {
            path
        };
        self.knobs()
            .into_iter()
            .find(|k| k.path == path)
            .map(|k| k.value)
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
    let rows: Vec<[f64; 3]> = v
        .chunks_exact(3)
        .filter_map(|r| <[f64; 3]>::try_from(r).ok())
        .collect();
    let a = <[[f64; 3]; 3]>::try_from(rows)
        .ok()
        .filter(|_| v.len() == 9)?;
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
    let cross = [
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    ];
    if dot(cross, z) < 0.0 {
        return None;
    }
    let identity = a == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    Some((!identity).then_some(a))
}

/// The error for a path that no unit of this version has.
pub(super) fn unknown(path: &str) -> InputError {
    let later = ["hit", "cone", "surface_footprint", "ray_cone"];
    let head = path.split('.').next().unwrap_or("");
    let stage = path
        .strip_prefix("registers.")
        .and_then(|p| p.split('.').next())
        .unwrap_or(head);
    if later.contains(&stage) {
        return InputError::new(
            "unit",
            "a path of the ENV operation",
            format!("a path of `{stage}`, which this version does not build"),
            "leave it out; `tapline unit show` lists what is there",
        )
        .at(path);
    }
    InputError::new(
        "unit",
        "a path that `tapline unit show` lists",
        "an unknown path",
        "check the spelling",
    )
    .at(path)
}

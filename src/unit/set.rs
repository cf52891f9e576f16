//! Setting a knob: what a path takes, and what is said of a value or a path that it does not.

use rtl_model::TexelFormat;
use rtl_model::cone::{ConeFormat, LaneOrder, StoreRounding};
use rtl_model::fx::{Format, Overflow, Rounding};
use rtl_model::regs::{Kind, Reg};
use rtl_model::tables::TableSpec;

use super::UnitSpec;
use super::knobs::{Value, canonical, names};
use crate::error::InputError;
use crate::policy::{
    Axis, ConeEnv, ConeGradient, ConeMetric, ConeRules, Count, Curvature, Dnmod, HitFootprint,
    LookUp, MAX_ANISOTROPY, MAX_ITERATIONS, MAX_TOLERANCE_BITS, Method, Minor, Outside, Placement,
    RoughnessInterpolation, SetDiffuse, Weights, Wrap,
};
use crate::settings::IDENTITY;

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
    /// Sets a knob. The error names the path, what it takes and what was given.
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
        let path = canonical(path);
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
            "hit.iterations" => number!(c.hit.iterations, 0, MAX_ITERATIONS),
            "hit.method" => literal!(Method, c.hit.method),
            "hit.tolerance_bits" => match (value, whole(1, MAX_TOLERANCE_BITS)) {
                (Value::Text(t), _) if t == "off" => {
                    c.hit.tolerance_bits = None;
                    Ok(())
                }
                (_, Some(bits)) => {
                    c.hit.tolerance_bits = Some(bits);
                    Ok(())
                }
                (_, None) => wrong("\"off\" or a whole number from 1 to 24"),
            },
            "hit.lookup" => literal!(LookUp, c.hit.look_up),
            "hit.footprint" => literal!(HitFootprint, c.hit.footprint),
            "hit.outside" => literal!(Outside, c.hit.outside),
            "eigen.placement" => literal!(Placement, c.placement),
            "eigen.minor" => literal!(Minor, c.minor),
            "filter.weight_bits" => number!(c.weight_bits, 1, 8),
            "filter.lod_bits" => number!(c.lod_bits, 1, 8),
            "texel.format" => literal!(TexelFormat, c.texel_format),
            "texel.int" => number!(c.texel_int, 1, 17),
            "texel.frac" => number!(c.texel_frac, 4, 24),
            "cone.format" => literal!(ConeFormat, c.cone.format),
            "cone.rounding" => literal!(StoreRounding, c.cone.rounding),
            "cone.lane_order" => literal!(LaneOrder, c.cone.order),
            "cone.seed" => number!(c.cone.seed, 0, u32::MAX),
            "cone.rules" => literal!(ConeRules, c.cone.rules),
            "cone.set_diffuse" => literal!(SetDiffuse, c.cone.set_diffuse),
            "cone.count" => number!(c.tex.cones, 1, 2),
            "cone.metric" => literal!(ConeMetric, c.tex.metric),
            "cone.gradient" => literal!(ConeGradient, c.tex.gradient),
            "cone.env" => literal!(ConeEnv, c.tex.env),
            "surface_footprint.max_anisotropy" => number!(c.tex.max_anisotropy, 1, MAX_ANISOTROPY),
            "address.wrap_s" => literal!(Wrap, c.tex.wrap[0]),
            "address.wrap_t" => literal!(Wrap, c.tex.wrap[1]),
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
                    "newton" if angle || *name == "log2" => {
                        (|n| n == 0, &mut spec.newton, "0: this table has no Newton step")
                    }
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

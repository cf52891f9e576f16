//! An axis of a study: one path (or several that move together) and the values that it takes.

use toml::de::DeTable;

use super::read::Reader;
use crate::base::num;
use crate::base::random::Random;
use crate::error::InputError;
use crate::unit::UnitSpec;
use crate::unit::knobs::Value;

/// Values of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// These.
    Listed(Vec<Value>),
    /// Drawn evenly from a range.
    Drawn {
        /// Least value.
        from: f64,
        /// Greatest value.
        to: f64,
        /// Whether only whole numbers are drawn.
        whole: bool,
        /// How many the axis has outside of [`super::plan::Mode::Random`].
        count: usize,
    },
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Paths that all get the same value.
    pub paths: Vec<String>,
    /// Values.
    pub values: Values,
    /// Where the file has it.
    pub offset: usize,
}

/// Most values of an axis.
const MOST_VALUES: usize = 100_000;

impl Axis {
    /// Reads an axis and tries its values on a unit.
    pub(super) fn read(
        r: &Reader<'_>,
        table: &DeTable<'_>,
        offset: usize,
        unit: &UnitSpec,
    ) -> Result<Self, InputError> {
        r.only(table, &["path", "list", "range", "grid", "random"])?;
        let paths = r.texts(table, "path")?;
        if paths.is_empty() {
            return Err(r.at(offset, "path", "a path of the unit, or several", "none"));
        }
        let kinds = ["list", "range", "grid", "random"];
        let given: Vec<&str> = kinds.into_iter().filter(|k| table.contains_key(*k)).collect();
        let [kind] = given.as_slice() else {
            let found = if given.is_empty() { "none".into() } else { given.join(" and ") };
            return Err(r.at(offset, "axis", "one of list, range, grid, random", found));
        };
        let values = match *kind {
            "list" => {
                let listed = r.values(table, "list")?;
                if listed.is_empty() {
                    return Err(r.error(table, "list", "one value or more", "none"));
                }
                for (value, at) in &listed {
                    try_on(r, unit, &paths, value, *at)?;
                }
                Values::Listed(listed.into_iter().map(|(value, _)| value).collect())
            }
            kind => {
                let Some((range, at)) = r.table(table, kind)? else {
                    return Err(r.at(offset, kind, "a table", "nothing"));
                };
                let values = span(r, range, at, kind)?;
                let ends = match &values {
                    Values::Listed(listed) => listed.clone(),
                    Values::Drawn { from, to, whole, .. } => {
                        vec![number(*from, *whole), number(*to, *whole)]
                    }
                };
                for value in &ends {
                    try_on(r, unit, &paths, value, at)?;
                }
                values
            }
        };
        Ok(Self { paths: paths.into_iter().map(|(path, _)| path).collect(), values, offset })
    }

    /// Values outside of the random mode.
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.values {
            Values::Listed(values) => values.len(),
            Values::Drawn { count, .. } => *count,
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All values; drawn ones from a generator.
    #[must_use]
    pub fn all(&self, random: &mut Random) -> Vec<Value> {
        match &self.values {
            Values::Listed(values) => values.clone(),
            Values::Drawn { count, .. } => (0..*count).map(|_| self.draw(random)).collect(),
        }
    }

    /// One value.
    #[must_use]
    pub fn draw(&self, random: &mut Random) -> Value {
        match &self.values {
            Values::Listed(values) => {
                let index = random.index(values.len());
                values.get(index).cloned().unwrap_or(Value::Integer(0))
            }
            Values::Drawn { from, to, whole, .. } => {
                // One more than the last whole number, so that all are equally likely.
                let width = to - from + if *whole { 1.0 } else { 0.0 };
                let drawn = from + random.unit() * width;
                number(if *whole { drawn.floor().min(*to) } else { drawn }, *whole)
            }
        }
    }
}

/// Tries a value on a unit.
fn try_on(
    r: &Reader<'_>,
    unit: &UnitSpec,
    paths: &[(String, usize)],
    value: &Value,
    offset: usize,
) -> Result<(), InputError> {
    for (path, at) in paths {
        let mut tried = unit.clone();
        if let Err(error) = tried.set_all([(path.as_str(), value)]) {
            let known = unit.get(path).is_some();
            return Err(r.located(if known { offset } else { *at }, path, error));
        }
    }
    Ok(())
}

fn number(x: f64, whole: bool) -> Value {
    if whole {
        #[expect(clippy::cast_possible_truncation, reason = "a whole number within ±2^31")]
        Value::Integer(x as i64)
    } else {
        Value::Float(x)
    }
}

/// `range = { from, to, step | factor }`, `grid = { from, to, count }` or `random = { from, to, count }`.
fn span(
    r: &Reader<'_>,
    table: &DeTable<'_>,
    offset: usize,
    kind: &str,
) -> Result<Values, InputError> {
    let keys: &[&str] =
        if kind == "range" { &["from", "to", "step", "factor"] } else { &["from", "to", "count"] };
    r.only(table, keys)?;
    let limit = f64::from(i32::MAX);
    let needed = |key: &str| {
        let x = r.real(table, key, -limit, limit)?;
        x.ok_or_else(|| r.at(offset, kind, format!("`{key}`"), "none"))
    };
    let (from, to) = (needed("from")?, needed("to")?);
    if to < from {
        return Err(r.error(table, "to", format!("at least {from}"), to.to_string()));
    }
    let is_whole = |x: f64| x.fract() == 0.0;
    let written_whole = |key: &str| {
        let value = table.get(key).and_then(|v| crate::unit::file::convert(v.get_ref()));
        matches!(value, None | Some(Value::Integer(_)))
    };
    let whole = ["from", "to", "step", "factor"].iter().all(|key| written_whole(key));
    let count = r.whole(table, "count", 1, MOST_VALUES)?;
    match kind {
        "random" => Ok(Values::Drawn { from, to, whole, count: count.unwrap_or(0) }),
        "grid" => {
            let Some(count) = count else {
                return Err(r.at(offset, kind, "`count`", "none"));
            };
            let steps = f64::from(num::u32(count - 1)).max(1.0);
            let value = |i: usize| {
                let x = from + (to - from) * f64::from(num::u32(i)) / steps;
                if whole { number(x.round(), true) } else { number(x, false) }
            };
            let mut values: Vec<Value> = (0..count).map(value).collect();
            values.dedup();
            Ok(Values::Listed(values))
        }
        _ => {
            let (step, factor) =
                (r.real(table, "step", 0.0, limit)?, r.real(table, "factor", 1.0, limit)?);
            let next: Box<dyn Fn(f64, usize) -> f64> = match (step, factor) {
                (Some(step), None) if step > 0.0 => {
                    Box::new(move |_, i| from + step * f64::from(num::u32(i)))
                }
                (None, Some(factor)) if factor > 1.0 && from > 0.0 => {
                    Box::new(move |x, _| x * factor)
                }
                (None, None) => Box::new(|x, _| x + 1.0),
                _ => {
                    let expected = "a step above 0, or a factor above 1 from a number above 0";
                    return Err(r.at(offset, kind, expected, "another"));
                }
            };
            let mut values = Vec::new();
            let mut x = from;
            while x <= to * (1.0 + f64::EPSILON * to.signum()) {
                if values.len() == MOST_VALUES {
                    return Err(r.at(
                        offset,
                        kind,
                        format!("at most {MOST_VALUES} values"),
                        "more",
                    ));
                }
                values.push(number(x, whole && is_whole(x)));
                x = next(x, values.len());
            }
            Ok(Values::Listed(values))
        }
    }
}

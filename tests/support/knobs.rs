//! The search for dead knobs: paths of a unit that no legal value makes visible.

use rtl_model::fx::Overflow;
use rtl_model::regs::{Kind, Reg};
use tapline::unit::UnitSpec;
use tapline::unit::file::from_toml;
use tapline::unit::knobs::Value;

/// Settings that switch a path on: (the path or its beginning, paths and values as in a unit file).
pub type Enables = [(&'static str, &'static [(&'static str, &'static str)])];

/// Other values of a knob to try, not all of them legal: whole numbers near by, every other literal.
#[must_use]
pub fn others(path: &str, value: &Value, legal: &str) -> Vec<Value> {
    match value {
        Value::Integer(n) if path == "footprint.max_probes" => vec![Value::Integer(n - 8)],
        Value::Integer(_) if path.ends_with(".entries") => [2, 4, 8].map(Value::Integer).into(),
        Value::Integer(n) => (1..=20)
            .flat_map(|d| [n - d, n + d])
            .chain([n / 2, n * 2])
            .filter(|m| *m >= 0 && m != n)
            .map(Value::Integer)
            .chain([Value::Text("off".into())])
            .collect(),
        Value::Float(x) => vec![Value::Float(x + 0.5)],
        Value::Text(t) => {
            legal.split(" | ").filter(|l| *l != t).map(|l| Value::Text(l.into())).collect()
        }
        Value::Numbers(_) => {
            vec![Value::Numbers(vec![0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0])]
        }
    }
}

/// Units and what a test sees of them.
pub trait Sight {
    /// All that is seen of a unit.
    type Seen;

    /// The settings in which a path is of any use.
    fn enables(&self) -> &Enables;
    /// Registers that hold nothing below the symmetric range: for them `saturate-symmetric` is `saturate`.
    fn never_below(&self) -> &[Reg];
    /// What is seen of a unit; `None` if it is refused.
    fn see(&self, spec: &UnitSpec) -> Option<Self::Seen>;
    /// Whether anything of another unit is different; `None` if it is refused.
    fn differs(&self, base: &Self::Seen, other: &UnitSpec) -> Option<bool>;
    /// Whether a register left its range.
    fn saturated(&self, seen: &Self::Seen, reg: Reg) -> bool;
}

/// The default unit with what `path` needs to be of any use.
fn enabled(sight: &impl Sight, path: &str) -> UnitSpec {
    let mut spec = UnitSpec::default();
    for (start, settings) in sight.enables() {
        if !path.strip_prefix(start).is_some_and(|rest| rest.is_empty() || rest.starts_with('.')) {
            continue;
        }
        for (path, value) in *settings {
            let (section, key) = path.rsplit_once('.').unwrap();
            let one = from_toml("enable", &format!("[{section}]\n{key} = {value}\n")).unwrap();
            spec.set(path, &one.get(path).unwrap()).unwrap();
        }
    }
    spec
}

/// The register of a path of its format.
fn register_of(path: &str) -> Option<Reg> {
    let mut parts = path.strip_prefix("registers.")?.split('.');
    Reg::find(parts.next()?, parts.next()?)
}

/// Overflow modes of a register that show nowhere.
///
/// The register is shortened bit by bit; wherever it overflows, the modes are compared.
fn dead_modes(sight: &impl Sight, reg: Reg, path: &str) -> Vec<String> {
    assert_eq!(reg.info().kind, Kind::Fixed, "{path}");
    let mut spec = enabled(sight, path);
    let mut left: Vec<Overflow> = Overflow::ALL
        .iter()
        .copied()
        .filter(|m| *m != Overflow::Saturate)
        .filter(|m| *m != Overflow::SaturateSymmetric || !sight.never_below().contains(&reg))
        .collect();
    for int in (0..spec.config.format(reg).int.max(1)).rev() {
        spec.config.formats[reg.index()].int = int;
        let Some(base) = sight.see(&spec) else { continue };
        if !sight.saturated(&base, reg) {
            continue;
        }
        left.retain(|mode| {
            let mut other = spec.clone();
            other.config.formats[reg.index()].overflow = *mode;
            sight.differs(&base, &other) != Some(true)
        });
        if left.is_empty() {
            break;
        }
    }
    left.iter().map(|m| format!("{path} = {}", m.name())).collect()
}

/// Fails if one of `ours`, at least `least` paths of the default unit, shows in nothing that is seen.
///
/// Each literal of a policy has a meaning of its own, so each must show; of other knobs one value is enough.
pub fn assert_none_dead(sight: &impl Sight, ours: impl Fn(&str) -> bool, least: usize) {
    let mut dead = Vec::new();
    let mut tried = 0;
    for knob in UnitSpec::default().knobs() {
        let path = knob.path.as_str();
        if !ours(path) {
            continue;
        }
        tried += 1;
        let reg = register_of(path);
        if let (Some(reg), true) = (reg, path.ends_with(".overflow")) {
            dead.extend(dead_modes(sight, reg, path));
            continue;
        }
        let spec = enabled(sight, path);
        let base = sight.see(&spec).unwrap();
        let value = spec.get(path).unwrap();
        let all_must_show = matches!(value, Value::Text(_)) && reg.is_none();
        let mut shown = false;
        for value in others(path, &value, &knob.legal) {
            let mut other = spec.clone();
            if other.set(path, &value).is_err() {
                continue;
            }
            match sight.differs(&base, &other) {
                Some(true) => shown = true,
                Some(false) if all_must_show => dead.push(format!("{path} = {value}")),
                Some(false) | None => {}
            }
            if shown && !all_must_show {
                break;
            }
        }
        if !shown {
            dead.push(path.into());
        }
    }
    assert!(tried >= least, "only {tried} paths");
    assert!(dead.is_empty(), "{} dead of {tried}: {dead:#?}", dead.len());
}

//! What the tests of knobs share.

use tapline::unit::knobs::Value;

/// Other values of a knob to try: whole numbers up to 16 away, every other literal.
pub fn others(value: &Value, legal: &str) -> Vec<Value> {
    match value {
        Value::Integer(n) => (1..=16)
            .flat_map(|d| [n - d, n + d])
            .filter(|m| *m >= 0)
            .map(Value::Integer)
            .chain([Value::Text("off".into())])
            .collect(),
        Value::Text(t) => {
            legal.split(" | ").filter(|l| *l != t).map(|l| Value::Text(l.into())).collect()
        }
        Value::Float(_) | Value::Numbers(_) => Vec::new(),
    }
}

//! Reading a TOML table key by key, every error with its line and column.

use toml::de::{DeTable, DeValue};

use crate::error::InputError;
use crate::unit::file::{convert, described, place};
use crate::unit::knobs::Value;

/// A file that is being read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reader<'a> {
    subject: &'a str,
    text: &'a str,
}

impl<'a> Reader<'a> {
    pub(super) fn new(subject: &'a str, text: &'a str) -> Self {
        Self { subject, text }
    }

    /// An error at a byte offset.
    pub(super) fn at(
        &self,
        offset: usize,
        key: &str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> InputError {
        let remedy = "docs/studies.md lists the keys";
        InputError::new(self.subject, expected, found, remedy)
            .at(format!("{}, {key}", place(self.text, offset)))
    }

    /// An error at a key of a table, or at the file's beginning where the key is missing.
    pub(super) fn error(
        &self,
        table: &DeTable<'_>,
        key: &str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> InputError {
        self.at(self.offset(table, key), key, expected, found)
    }

    /// Somebody else's error, put at a place of this file.
    pub(super) fn located(&self, offset: usize, key: &str, mut error: InputError) -> InputError {
        error.subject = self.subject.into();
        error.place = Some(format!("{}, {key}", place(self.text, offset)));
        error
    }

    /// Where a key's value stands.
    pub(super) fn offset(&self, table: &DeTable<'_>, key: &str) -> usize {
        table.get(key).map_or(0, |v| v.span().start)
    }

    /// Refuses keys that are not among `keys`.
    pub(super) fn only(&self, table: &DeTable<'_>, keys: &[&str]) -> Result<(), InputError> {
        for (key, _) in table {
            let name = key.get_ref();
            if !keys.contains(&name.as_ref()) {
                let expected = format!("one of the keys {}", keys.join(", "));
                return Err(self.at(key.span().start, name, expected, "an unknown key"));
            }
        }
        Ok(())
    }

    fn found(&self, table: &DeTable<'_>, key: &str, expected: &str) -> InputError {
        let found = table.get(key).map_or("nothing".into(), |v| described(v.get_ref()));
        self.error(table, key, expected, found)
    }

    pub(super) fn text(
        &self,
        table: &DeTable<'_>,
        key: &str,
    ) -> Result<Option<String>, InputError> {
        match table.get(key).map(|v| v.get_ref()) {
            None => Ok(None),
            Some(DeValue::String(text)) => Ok(Some(text.to_string())),
            Some(_) => Err(self.found(table, key, "a string")),
        }
    }

    /// One of several strings.
    pub(super) fn literal(
        &self,
        table: &DeTable<'_>,
        key: &str,
        legal: &[&'static str],
    ) -> Result<Option<&'static str>, InputError> {
        let Some(text) = self.text(table, key)? else {
            return Ok(None);
        };
        match legal.iter().find(|l| **l == text) {
            Some(literal) => Ok(Some(literal)),
            None => Err(self.error(table, key, legal.join(" | "), format!("`{text}`"))),
        }
    }

    /// The items of an array, or a single value; none where the key is missing.
    fn items<'t>(&self, table: &'t DeTable<'_>, key: &str) -> Vec<(&'t DeValue<'t>, usize)> {
        let Some(value) = table.get(key) else {
            return Vec::new();
        };
        if let DeValue::Array(items) = value.get_ref() {
            let item = |i: &'t toml::Spanned<DeValue<'t>>| (i.get_ref(), i.span().start);
            return items.iter().map(item).collect();
        }
        vec![(value.get_ref(), value.span().start)]
    }

    /// An array of strings, or one string.
    pub(super) fn texts(
        &self,
        table: &DeTable<'_>,
        key: &str,
    ) -> Result<Vec<(String, usize)>, InputError> {
        let text = |(item, offset): (&DeValue<'_>, usize)| {
            if let DeValue::String(text) = item {
                return Ok((text.to_string(), offset));
            }
            Err(self.at(offset, key, "strings", described(item)))
        };
        self.items(table, key).into_iter().map(text).collect()
    }

    /// An array of whole numbers, or one.
    pub(super) fn wholes(
        &self,
        table: &DeTable<'_>,
        key: &str,
        low: usize,
        high: usize,
    ) -> Result<Vec<usize>, InputError> {
        let whole = |(item, offset): (&DeValue<'_>, usize)| {
            let number = match convert(item) {
                Some(Value::Integer(n)) => usize::try_from(n).ok(),
                Some(Value::Float(_) | Value::Text(_) | Value::Numbers(_)) | None => None,
            };
            number.filter(|n| (low..=high).contains(n)).ok_or_else(|| {
                let expected = format!("whole numbers from {low} to {high}");
                self.at(offset, key, expected, shown(item))
            })
        };
        self.items(table, key).into_iter().map(whole).collect()
    }

    pub(super) fn whole(
        &self,
        table: &DeTable<'_>,
        key: &str,
        low: usize,
        high: usize,
    ) -> Result<Option<usize>, InputError> {
        if matches!(table.get(key).map(|v| v.get_ref()), Some(DeValue::Array(_))) {
            return Err(self.found(table, key, "one whole number"));
        }
        Ok(self.wholes(table, key, low, high)?.first().copied())
    }

    /// A finite number.
    pub(super) fn real(
        &self,
        table: &DeTable<'_>,
        key: &str,
        low: f64,
        high: f64,
    ) -> Result<Option<f64>, InputError> {
        let Some(value) = table.get(key) else {
            return Ok(None);
        };
        let number = match convert(value.get_ref()) {
            Some(Value::Integer(n)) => i32::try_from(n).ok().map(f64::from),
            Some(Value::Float(x)) => Some(x),
            Some(Value::Text(_) | Value::Numbers(_)) | None => None,
        };
        match number.filter(|x| (low..=high).contains(x)) {
            Some(number) => Ok(Some(number)),
            None => Err(self.error(
                table,
                key,
                format!("a number from {low} to {high}"),
                shown(value.get_ref()),
            )),
        }
    }

    /// A knob's value.
    pub(super) fn value(
        &self,
        value: &DeValue<'_>,
        offset: usize,
        key: &str,
    ) -> Result<Value, InputError> {
        let expected = "a number, a literal or an array of numbers";
        convert(value).ok_or_else(|| self.at(offset, key, expected, described(value)))
    }

    /// The values of an array.
    pub(super) fn values(
        &self,
        table: &DeTable<'_>,
        key: &str,
    ) -> Result<Vec<(Value, usize)>, InputError> {
        let value = |(item, offset)| Ok((self.value(item, offset, key)?, offset));
        self.items(table, key).into_iter().map(value).collect()
    }

    pub(super) fn table<'t>(
        &self,
        table: &'t DeTable<'_>,
        key: &str,
    ) -> Result<Option<(&'t DeTable<'t>, usize)>, InputError> {
        match table.get(key) {
            None => Ok(None),
            Some(value) => {
                if let DeValue::Table(inner) = value.get_ref() {
                    return Ok(Some((inner, value.span().start)));
                }
                Err(self.found(table, key, "a table"))
            }
        }
    }

    /// An array of tables.
    pub(super) fn tables<'t>(
        &self,
        table: &'t DeTable<'_>,
        key: &str,
    ) -> Result<Vec<(&'t DeTable<'t>, usize)>, InputError> {
        let inner = |(item, offset): (&'t DeValue<'t>, usize)| {
            if let DeValue::Table(inner) = item {
                return Ok((inner, offset));
            }
            Err(self.at(offset, key, "tables", described(item)))
        };
        self.items(table, key).into_iter().map(inner).collect()
    }
}

/// A value as a message shows it.
fn shown(value: &DeValue<'_>) -> String {
    convert(value).map_or_else(|| described(value), |v| v.to_string())
}

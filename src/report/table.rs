//! Results as titled, typed cells: a table for a terminal and JSON for programs come from the same columns.
//!
//! Units stand in the column headers, numbers are right-aligned, columns are two spaces apart.
//! No colour and no line drawing: the output pastes into a bug report as it is.

use std::fmt;

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::base::num;

/// On which side a column's cells end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Text.
    Left,
    /// Numbers.
    Right,
}

/// What stands in one column of one row: the text that people read, and the value that programs read.
#[derive(Clone, Debug)]
pub struct Cell {
    shown: String,
    /// None: the row's object lacks the key.
    value: Option<Value>,
    align: Align,
}

impl Cell {
    fn new(shown: String, value: impl Serialize, align: Align) -> Self {
        Self { shown: clean(&shown), value: Some(json!(value)), align }
    }

    /// The same text over another value: a share that people read in per cent.
    #[must_use]
    pub fn with(self, value: impl Serialize) -> Self {
        Self { value: Some(json!(value)), ..self }
    }
}

/// A text.
#[must_use]
pub fn text(text: impl ToString) -> Cell {
    let text = text.to_string();
    Cell::new(text.clone(), text, Align::Left)
}

/// A whole number, or whatever else stands on the right as it is printed.
#[must_use]
pub fn whole(number: impl ToString + Serialize) -> Cell {
    Cell::new(number.to_string(), number, Align::Right)
}

/// A count with thin groups of three digits, as [`count`] prints it.
#[must_use]
pub fn grouped(number: u64) -> Cell {
    Cell::new(count(number), number, Align::Right)
}

/// A number with so many [`significant`] digits.
#[must_use]
pub fn digits(value: f64, digits: usize) -> Cell {
    Cell::new(significant(value, digits), value, Align::Right)
}

/// A number with a [`fixed`] count of decimals.
#[must_use]
pub fn places(value: f64, decimals: usize) -> Cell {
    Cell::new(fixed(value, decimals), value, Align::Right)
}

/// What stands where a number is missing: null for programs.
#[must_use]
pub fn missing(shown: &str) -> Cell {
    Cell::new(shown.into(), Value::Null, Align::Right)
}

/// A value for programs alone.
#[must_use]
pub fn value(value: impl Serialize) -> Cell {
    Cell::new(String::new(), value, Align::Right)
}

/// A value for programs alone; where there is none, the object lacks the key.
#[must_use]
pub fn given(value: Option<impl Serialize>) -> Cell {
    Cell { shown: String::new(), value: value.map(|v| json!(v)), align: Align::Right }
}

/// A column: its title in tables, its key in JSON, and its cell of a row.
///
/// A column without a title is in no table, one without a key in no JSON.
pub type Column<'a, T> = (&'a str, &'a str, &'a dyn Fn(&T) -> Cell);

/// A table: a header and rows of the same number of cells.
#[derive(Clone, Debug)]
pub struct Table {
    align: Vec<Align>,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    objects: Vec<Value>,
}

impl Table {
    /// One row for each item, with these columns; a column with a text in it is left-aligned.
    #[must_use]
    pub fn of<T>(items: impl IntoIterator<Item = T>, columns: &[Column<'_, T>]) -> Self {
        let shown = || columns.iter().filter(|(title, ..)| !title.is_empty());
        let header = shown().map(|(title, ..)| clean(title.trim())).collect();
        let align = vec![Align::Right; shown().count()];
        let mut table = Self { align, header, rows: Vec::new(), objects: Vec::new() };
        for item in items {
            let (mut row, mut object) = (Vec::new(), Map::new());
            for (title, key, cell) in columns {
                let Cell { shown, value, align } = cell(&item);
                if !title.is_empty() {
                    if align == Align::Left {
                        table.align[row.len()] = Align::Left;
                    }
                    row.push(shown);
                }
                if let (false, Some(value)) = (key.is_empty(), value) {
                    object.insert((*key).into(), value);
                }
            }
            table.rows.push(row);
            table.objects.push(Value::Object(object));
        }
        table
    }

    /// One JSON object a row.
    #[must_use]
    pub fn json(self) -> Vec<Value> {
        self.objects
    }

    /// A table with these columns; a title carries its unit: `PSNR (dB)`.
    #[must_use]
    pub fn new(columns: &[(&str, Align)]) -> Self {
        Self {
            align: columns.iter().map(|&(_, align)| align).collect(),
            header: columns.iter().map(|&(title, _)| clean(title)).collect(),
            rows: Vec::new(),
            objects: Vec::new(),
        }
    }

    /// Adds a row. Cells that are missing stay empty; cells beyond the last column are dropped.
    pub fn row<I>(&mut self, cells: I)
    where
        I: IntoIterator,
        I::Item: AsRef<str>,
    {
        let mut row: Vec<String> = cells.into_iter().map(|cell| clean(cell.as_ref())).collect();
        row.resize(self.header.len(), String::new());
        self.rows.push(row);
    }

    /// Rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether no row was added.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

impl fmt::Display for Table {
    /// One line per row and one for the header, each ended; no trailing blanks.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines = || std::iter::once(&self.header).chain(&self.rows);
        let width = |column: usize| lines().map(|row| row[column].chars().count()).max();
        let widths: Vec<usize> =
            (0..self.header.len()).map(|column| width(column).unwrap_or(0)).collect();
        for row in lines() {
            let mut line = String::new();
            for ((cell, &width), align) in row.iter().zip(&widths).zip(&self.align) {
                if !line.is_empty() {
                    line.push_str("  ");
                }
                match align {
                    Align::Left => line.push_str(&format!("{cell:<width$}")),
                    Align::Right => line.push_str(&format!("{cell:>width$}")),
                }
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Control characters would break the lines or reach the terminal: each becomes a space.
fn clean(cell: &str) -> String {
    cell.replace(char::is_control, " ")
}

/// A number with a fixed count of decimals: `54.20`.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

/// A number with at most `digits` significant digits, without an exponent where it stays short:
/// `0.000123`, `42.7`, `1.3e-7`.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    let digits = digits.max(1);
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e9).contains(&magnitude) {
        return format!("{value:.*e}", digits - 1);
    }
    // Rounding first: 9.996 with three digits is 10.0, not 10.00.
    let text = format!("{value:.*e}", digits - 1);
    let exponent = text.rsplit('e').next().and_then(|e| e.parse::<i32>().ok());
    let digits = num::i32(digits);
    let decimals = digits.saturating_sub(1).saturating_sub(exponent.unwrap_or(0));
    format!("{value:.*}", num::usize(decimals))
}

/// A number that may be missing: `-` for `None`.
#[must_use]
pub fn optional(value: Option<String>) -> String {
    value.unwrap_or_else(|| "-".to_owned())
}

/// A count with thin groups of three digits: `1 048 576`.
#[must_use]
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut out = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_align_by_characters_and_lines_have_no_trailing_blanks() {
        let mut table = Table::new(&[
            ("pair", Align::Left),
            ("PSNR (dB)", Align::Right),
            ("note", Align::Left),
        ]);
        table.row(["rtl-f64", "54.20", ""]);
        table.row(["λ1-λ2", "8.1", "µ"]);
        assert_eq!(
            table.to_string(),
            "pair     PSNR (dB)  note\nrtl-f64      54.20\nλ1-λ2          8.1  µ\n"
        );
    }

    #[test]
    fn a_table_and_its_objects_come_from_the_same_columns() {
        let table = Table::of(
            [("eigen", 0.25, None), ("hit", 1234.5, Some(3u64))],
            &[
                ("stage", "stage", &|(name, ..)| text(name)),
                ("share (%)", "share", &|(_, x, _)| places(100.0 * x, 1).with(x)),
                ("n", "", &|(.., n)| n.map_or(missing("-"), grouped)),
                ("", "count", &|(.., n)| given(*n)),
            ],
        );
        assert_eq!(table.len(), 2);
        assert_eq!(
            table.to_string(),
            "stage  share (%)  n\neigen       25.0  -\nhit     123450.0  3\n"
        );
        assert_eq!(
            json!(table.json()),
            json!([{"stage": "eigen", "share": 0.25}, {"stage": "hit", "share": 1234.5, "count": 3}])
        );
    }

    #[test]
    fn rows_of_the_wrong_length_and_control_characters_do_no_harm() {
        let mut table = Table::new(&[("a", Align::Left), ("b", Align::Right)]);
        assert!(table.is_empty());
        table.row(["x\ny\u{1b}[31m"]);
        table.row(["1", "2", "3"]);
        assert_eq!(table.to_string(), "a         b\nx y [31m\n1         2\n");
    }

    #[test]
    fn significant_digits_hold_across_magnitudes() {
        for (value, text) in [
            (42.67, "42.7"),
            (9.996, "10.0"),
            (0.000_123_4, "0.000123"),
            (0.000_000_13, "1.30e-7"),
            (1_234_567.0, "1234567"),
            (-0.5, "-0.500"),
            (0.0, "0"),
            (2e9, "2.00e9"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(significant(value, 3), text);
        }
    }

    #[test]
    fn counts_are_grouped_by_three() {
        for (value, text) in [(0, "0"), (999, "999"), (1000, "1 000"), (1_048_576, "1 048 576")] {
            assert_eq!(count(value), text);
        }
    }
}

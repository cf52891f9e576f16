//! Results as titled, typed cells: a table for a terminal and JSON for programs come from the same columns.
//!
//! Units stand in the column headers, numbers are right-aligned, columns are two spaces apart.
//! No colour and no line drawing: the output pastes into a bug report as it is.

use std::fmt;

use serde::Serialize;
use serde_json::{Value, json};

use crate::base::num;

/// On which side a column's cells end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Text.
    Left,
    /// Numbers.
    Right,
}

/// The content of one cell: the text that people read, and the value that programs read.
#[derive(Clone, Debug)]
pub struct Cell {
    pub(super) shown: String,
    /// None: the row's object lacks the key.
    pub(super) value: Option<Value>,
    pub(super) align: Align,
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

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.shown)
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

/// A number with a [`fixed()`] count of decimals.
#[must_use]
pub fn places(value: f64, decimals: usize) -> Cell {
    Cell::new(fixed(value, decimals), value, Align::Right)
}

/// The placeholder of a missing number: null for programs.
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

/// A table: columns, and rows of a cell for each.
#[derive(Clone, Debug)]
pub struct Table {
    /// Titles and keys.
    columns: Vec<(String, String)>,
    align: Vec<Align>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// One row for each item, with these columns; a column with a text in it is left-aligned.
    #[must_use]
    pub fn of<T>(items: impl IntoIterator<Item = T>, columns: &[Column<'_, T>]) -> Self {
        let cells = |item: T| columns.iter().map(|(.., cell)| cell(&item)).collect();
        let mut table = Self::new(
            columns.iter().map(|(title, ..)| (*title).to_string()),
            items.into_iter().map(cells),
        );
        for ((_, key), (_, of, _)) in table.columns.iter_mut().zip(columns) {
            *key = (*of).to_string();
        }
        table
    }

    /// A table without keys whose columns are not known before the run.
    #[must_use]
    pub fn new(
        titles: impl IntoIterator<Item = String>,
        rows: impl IntoIterator<Item = Vec<Cell>>,
    ) -> Self {
        let titles = titles.into_iter().map(|title| (clean(&title), String::new()));
        let (columns, rows): (Vec<_>, Vec<Vec<Cell>>) =
            (titles.collect(), rows.into_iter().collect());
        let is_text = |at: usize| rows.iter().any(|row| row[at].align == Align::Left);
        let align = |at| if is_text(at) { Align::Left } else { Align::Right };
        Self { align: (0..columns.len()).map(align).collect(), columns, rows }
    }

    /// One JSON object a row.
    #[must_use]
    pub fn json(self) -> Vec<Value> {
        let object = |row: Vec<Cell>| {
            let keys = self.columns.iter().map(|(_, key)| key).zip(row);
            let given = keys.filter(|(key, _)| !key.is_empty());
            given.filter_map(|(key, cell)| Some((key.clone(), cell.value?))).collect()
        };
        self.rows.into_iter().map(|row| Value::Object(object(row))).collect()
    }

    /// The columns that a table shows: title, alignment, and where the cell lies in a row.
    pub(super) fn shown(&self) -> impl Iterator<Item = (&str, Align, usize)> {
        let all = self.columns.iter().zip(&self.align).enumerate();
        let titled = all.filter(|(_, ((title, _), _))| !title.is_empty());
        titled.map(|(at, ((title, _), align))| (title.trim(), *align, at))
    }

    /// The rows, with the cells that no table shows.
    pub(super) fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// The table as Markdown has it.
    #[must_use]
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
        let rule = |align| if align == Align::Left { "---" } else { "---:" };
        let mut out = line(self.shown().map(|(title, ..)| title).collect());
        out += &line(self.shown().map(|(_, align, _)| rule(align)).collect());
        out.extend(
            self.rows
                .iter()
                .map(|row| line(self.shown().map(|(.., at)| &*row[at].shown).collect())),
        );
        out
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
        let cells = |at: usize| self.rows.iter().map(move |row| row[at].shown.as_str());
        let columns = self.shown().map(|(title, align, at)| {
            let column: Vec<&str> = std::iter::once(title).chain(cells(at)).collect();
            let width = column.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
            (column, align, width)
        });
        let columns: Vec<_> = columns.collect();
        for row in 0..=self.rows.len() {
            let mut line = String::new();
            for (at, (column, align, width)) in columns.iter().enumerate() {
                let gap = if at > 0 { "  " } else { "" };
                line += &match align {
                    Align::Left => format!("{gap}{:<width$}", column[row]),
                    Align::Right => format!("{gap}{:>width$}", column[row]),
                };
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
        let rows = [("rtl-f64", "54.20", ""), ("λ1-λ2", "8.1", "x\ny\u{1b}[31m")];
        let table = Table::of(
            rows,
            &[
                ("pair", "", &|(pair, ..)| text(pair)),
                ("PSNR (dB)", "", &|(_, db, _)| whole(db)),
                ("note", "", &|(.., note)| text(note)),
            ],
        );
        assert_eq!(
            table.to_string(),
            "pair     PSNR (dB)  note\nrtl-f64      54.20\nλ1-λ2          8.1  x y [31m\n"
        );
        assert!(
            table.markdown().starts_with("| pair | PSNR (dB) | note |\n| --- | ---: | --- |\n")
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

//! Result files: a journal that grows row by row while a study runs, and the files made from it at the end.
//!
//! The journal has the header and the rows in the order in which they were run; each row is written with one call and
//! flushed. At the end the rows are put in order into `results.jsonl` and `results.csv`, which appear whole, and the
//! journal goes. The same rows give the same bytes, however often a study was interrupted and on however many
//! machines its parts ran.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::rows::csv;
use crate::base::num;
use crate::error::InputError;
use crate::image::whole::{WholeFile, commit_all};

/// A part of a study: number K of N, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which part.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl Shard {
    /// The whole study.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// The rows of this part among `rows` in the order in which they run: a stretch of neighbours.
    #[must_use]
    pub fn range(self, rows: usize) -> std::ops::Range<usize> {
        let cut = |k: usize| (rows as u128 * k as u128 / self.of as u128) as usize;
        cut(self.number - 1)..cut(self.number)
    }

    /// The name of a result file's stem.
    fn stem(self) -> String {
        if self.of == 1 {
            "results".into()
        } else {
            format!("results-{}-of-{}", self.number, self.of)
        }
    }
}

/// Where a study's results go.
#[derive(Clone, Debug)]
pub struct Paths {
    /// Rows in order, once all are there.
    pub jsonl: PathBuf,
    /// The same as CSV.
    pub csv: PathBuf,
    /// Rows as they come.
    pub journal: PathBuf,
}

impl Paths {
    /// The files of a part in a folder.
    #[must_use]
    pub fn new(folder: &Path, shard: Shard) -> Self {
        let file = |ending: &str| folder.join(format!("{}.{ending}", shard.stem()));
        Self { jsonl: file("jsonl"), csv: file("csv"), journal: file("part") }
    }
}

/// A result file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// Its first line.
    pub header: Value,
    /// Its rows.
    pub rows: Vec<Value>,
}

fn broken(path: &Path, expected: &str, found: impl ToString) -> InputError {
    InputError::new(
        path.display().to_string(),
        expected,
        found.to_string(),
        "check the path; results are written by `tapline study`",
    )
}

/// Largest result file that is read.
const MAX_BYTES: u64 = 4 << 30;

impl Results {
    /// The first path of every axis.
    #[must_use]
    pub fn axes(&self) -> Vec<String> {
        let all = self.header["axes"].as_array().into_iter().flatten();
        all.filter_map(|axis| axis.get(0).and_then(Value::as_str).map(String::from)).collect()
    }

    /// Reads a result file or a journal. A last line that was cut off, as a machine that stops leaves it, is dropped
    /// if `torn` allows it.
    ///
    /// # Errors
    /// A file that cannot be read or is no result file, with the line.
    pub fn read(path: &Path, torn: bool) -> Result<Self, InputError> {
        let file = File::open(path).map_err(|e| broken(path, "a readable result file", e))?;
        let size = file.metadata().map(|m| m.len()).unwrap_or(0);
        if size > MAX_BYTES {
            return Err(broken(path, "a result file of at most 4 GiB", format!("{size} bytes")));
        }
        let mut header = None;
        let mut rows = Vec::new();
        let mut reader = BufReader::new(file);
        let mut line = String::new();
        for number in 1usize.. {
            line.clear();
            let read = reader.read_line(&mut line).map_err(|e| broken(path, "text in UTF-8", e))?;
            if read == 0 {
                break;
            }
            if torn && !line.ends_with('\n') {
                break;
            }
            let value: Value = serde_json::from_str(&line).map_err(|e| {
                broken(path, "one JSON object a line", e).at(format!("line {number}"))
            })?;
            let key = if number == 1 { "plan" } else { "row" };
            if value.get(key).is_none() {
                let found = format!("an object without `{key}`");
                return Err(broken(path, "a study's header, then its rows", found)
                    .at(format!("line {number}")));
            }
            if number == 1 {
                header = Some(value);
            } else {
                rows.push(value);
            }
        }
        let header = header.ok_or_else(|| broken(path, "a study's header", "an empty file"))?;
        Ok(Self { header, rows })
    }

    /// The rows by their numbers.
    ///
    /// # Errors
    /// Two rows of the same number that differ.
    pub fn by_number(&self, path: &Path) -> Result<BTreeMap<usize, Value>, InputError> {
        let mut out = BTreeMap::new();
        for row in &self.rows {
            let number =
                row.get("row").and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
            let Some(number) = number else {
                return Err(broken(path, "rows with their numbers", row));
            };
            if out.insert(number, row.clone()).is_some_and(|before| before != *row) {
                return Err(broken(
                    path,
                    "each row once",
                    format!("row {number} twice, with different figures"),
                ));
            }
        }
        Ok(out)
    }
}

/// The header without what tells parts apart.
#[must_use]
pub fn common(header: &Value) -> Value {
    let mut header = header.clone();
    if let Some(map) = header.as_object_mut() {
        map.remove("shard");
    }
    header
}

/// Rows as they come.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
}

impl Journal {
    /// A new journal with a header; its folder is made if it is not there.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn create(path: &Path, header: &Value) -> Result<Self, InputError> {
        let unwritable = |e: std::io::Error| broken(path, "a file that can be written", e);
        make_folder(path).map_err(unwritable)?;
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(path);
        let file = file.map_err(unwritable)?;
        lock(&file, path)?;
        file.set_len(0).map_err(unwritable)?;
        let mut journal = Self { file, path: path.into() };
        journal.append(header)?;
        Ok(journal)
    }

    /// The journal of a study that was interrupted, and its rows. What a torn last line left is cut off.
    ///
    /// # Errors
    /// A journal of another study or version.
    pub fn resume(path: &Path, header: &Value) -> Result<(Self, Results), InputError> {
        let before = Results::read(path, true)?;
        same_study(path, &before.header, header)?;
        let unwritable = |e: std::io::Error| broken(path, "a file that can be written", e);
        let file = OpenOptions::new().append(true).open(path).map_err(unwritable)?;
        lock(&file, path)?;
        let whole = std::fs::read(path).map_err(unwritable)?;
        let end = whole.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        file.set_len(end as u64).map_err(unwritable)?;
        Ok((Self { file, path: path.into() }, before))
    }

    /// Appends a line with one write.
    ///
    /// # Errors
    /// A full disk and the like.
    pub fn append(&mut self, value: &Value) -> Result<(), InputError> {
        let line = format!("{value}\n");
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.flush());
        written.map_err(|e| broken(&self.path, "a file that can be written", e))
    }
}

/// Keeps other runs away until the file is closed, where the file system knows locks.
fn lock(file: &File, path: &Path) -> Result<(), InputError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(InputError::new(
            path.display().to_string(),
            "a folder in which no other run of this part writes",
            "one that goes on",
            "wait for it, or take another --out",
        )),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// Refuses to replace the finished results of another study.
///
/// # Errors
/// Results of another study, or a file that holds none.
pub fn replaceable(path: &Path, header: &Value) -> Result<(), InputError> {
    if !path.exists() {
        return Ok(());
    }
    let before = Results::read(path, false)?.header;
    if common(&before) == common(header) {
        return Ok(());
    }
    let name = |header: &Value| {
        let text = |key: &str| header.get(key).and_then(Value::as_str).unwrap_or("?").to_string();
        format!("`{}` (plan {}, tapline {})", text("study"), text("plan"), text("version"))
    };
    Err(InputError::new(
        path.display().to_string(),
        format!("no results, or those of {}", name(header)),
        name(&before),
        "take another --out, or remove the file",
    ))
}

/// Refuses results of another study.
///
/// # Errors
/// Headers that differ.
pub fn same_study(path: &Path, found: &Value, expected: &Value) -> Result<(), InputError> {
    if common(found) == common(expected) && found.get("shard") == expected.get("shard") {
        return Ok(());
    }
    let differs = |key: &&str| found.get(*key) != expected.get(*key);
    let keys = ["plan", "version", "unit_hash", "cost", "seed", "shard", "rows"];
    let which = keys.iter().find(|k| differs(k)).copied().unwrap_or("columns");
    let shown = |v: &Value| v.get(which).cloned().unwrap_or_default();
    Err(InputError::new(
        path.display().to_string(),
        format!("results of this study: {which} {}", shown(expected)),
        shown(found).to_string(),
        "take another --out, or the study file and version that began it",
    ))
}

/// Writes the rows of a finished study or part.
///
/// # Errors
/// Files that cannot be written.
pub fn finish(
    paths: &Paths,
    header: &Value,
    rows: &BTreeMap<usize, Value>,
) -> Result<(), InputError> {
    let rows: Vec<Value> = rows.values().cloned().collect();
    let mut jsonl = WholeFile::create(&paths.jsonl)?;
    jsonl.write_with(|out| {
        writeln!(out, "{header}")?;
        rows.iter().try_for_each(|row| writeln!(out, "{row}"))
    })?;
    let mut table = WholeFile::create(&paths.csv)?;
    table.write_with(|out| out.write_all(csv(header, &rows).as_bytes()))?;
    commit_all([jsonl, table])
}

/// Puts the parts of a study together.
///
/// # Errors
/// Parts of different studies, rows that are missing or differ.
pub fn merge(parts: &[PathBuf], paths: &Paths) -> Result<usize, InputError> {
    let mut all: BTreeMap<usize, Value> = BTreeMap::new();
    let mut header: Option<Value> = None;
    for path in parts {
        let results = Results::read(path, false)?;
        let own = common(&results.header);
        same_study(path, &own, header.get_or_insert_with(|| own.clone()))?;
        for (number, row) in results.by_number(path)? {
            if all.insert(number, row.clone()).is_some_and(|before| before != row) {
                let found = format!("row {number} with other figures than in a part before");
                return Err(broken(path, "parts that agree", found));
            }
        }
    }
    let header =
        header.ok_or_else(|| broken(Path::new("study merge"), "one part or more", "none"))?;
    let rows = header.get("rows").and_then(Value::as_u64).unwrap_or(0);
    let missing: Vec<String> = (0..num::usize(rows))
        .filter(|n| !all.contains_key(n))
        .take(5)
        .map(|n| n.to_string())
        .collect();
    if !missing.is_empty() {
        let found = format!("{} of them; rows {} … are missing", all.len(), missing.join(", "));
        return Err(broken(&paths.jsonl, &format!("all {rows} rows of the study"), found));
    }
    replaceable(&paths.jsonl, &header)?;
    make_folder(&paths.jsonl).map_err(|e| broken(&paths.jsonl, "a file that can be written", e))?;
    finish(paths, &header, &all)?;
    Ok(all.len())
}

/// Makes the folder of a file.
fn make_folder(path: &Path) -> std::io::Result<()> {
    path.parent().map_or(Ok(()), std::fs::create_dir_all)
}

//! The cost model's knobs as a file: `tapline cost show` prints it, `--cost FILE` reads it.

use std::fmt::Write as _;
use std::path::Path;

use toml::de::DeTable;

use super::CostModel;
use crate::error::InputError;
use crate::study::read::Reader;
use crate::unit::file;

/// A knob: its table, its key, and what it says.
type Knob = (&'static str, &'static str, &'static str, fn(&mut CostModel) -> &mut f64);

/// Knobs that are any number above 0.
const KNOBS: &[Knob] = &[
    ("cells", "and2", "two-input AND", |m| &mut m.cells.and2),
    ("cells", "half_adder", "half adder: a bit of a rounding's carry", |m| &mut m.cells.half_adder),
    ("cells", "full_adder", "full adder", |m| &mut m.cells.full_adder),
    ("cells", "mux2", "two-way multiplexer", |m| &mut m.cells.mux2),
    ("cells", "flip_flop", "D flip-flop", |m| &mut m.cells.flip_flop),
    ("cells", "rom_bit", "bit of a table", |m| &mut m.cells.rom_bit),
    ("cells", "zero_count_bit", "bit of a leading-zero counter", |m| &mut m.cells.zero_count_bit),
    ("intervals", "front", "cycles from fragment to fragment in front of the probes", |m| {
        &mut m.front_interval
    }),
    ("intervals", "probe", "cycles a trilinear probe", |m| &mut m.probe_interval),
    ("intervals", "look_up", "cycles a look-up of the search", |m| &mut m.look_up_interval),
];

impl CostModel {
    /// Reads a file; what it leaves out keeps its default.
    ///
    /// # Errors
    /// Whatever in it is not as it should be, with line and column.
    pub fn load(path: Option<&Path>) -> Result<Self, InputError> {
        let Some(path) = path else {
            return Ok(Self::default());
        };
        let text = file::read_text(path, "cost file")?;
        Self::parse(&file::name(path), &text)
    }

    /// Reads a file's text.
    ///
    /// # Errors
    /// Whatever in it is not as it should be, with line and column.
    pub fn parse(subject: &str, text: &str) -> Result<Self, InputError> {
        let table = DeTable::parse(text).map_err(|e| {
            InputError::new(subject, "TOML", e.message(), "`tapline cost show` prints a cost file")
                .at(file::place(text, e.span().map_or(0, |s| s.start)))
        })?;
        let r = Reader::new(subject, text);
        let root = table.get_ref();
        r.only(root, &["cells", "intervals", "cache"])?;
        let mut model = Self::default();
        for name in ["cells", "intervals"] {
            let Some((inner, _)) = r.table(root, name)? else {
                continue;
            };
            let keys: Vec<&str> = KNOBS.iter().filter(|k| k.0 == name).map(|k| k.1).collect();
            r.only(inner, &keys)?;
            for (_, key, _, knob) in KNOBS.iter().filter(|k| k.0 == name) {
                if let Some(value) = r.real(inner, key, 1e-6, 1e6)? {
                    *knob(&mut model) = value;
                }
            }
        }
        if let Some((inner, offset)) = r.table(root, "cache")? {
            r.only(inner, &["bytes", "ways", "line_bytes"])?;
            let cache = &mut model.cache;
            let take = |key: &str, slot: &mut usize| -> Result<(), InputError> {
                if let Some(n) = r.whole(inner, key, 1, 1 << 30)? {
                    *slot = n;
                }
                Ok(())
            };
            take("bytes", &mut cache.bytes)?;
            take("ways", &mut cache.ways)?;
            take("line_bytes", &mut cache.line_bytes)?;
            if !cache.is_possible() {
                let expected = "a line of a power of two from 16 to 1024 bytes, and bytes / line_bytes / ways a power of two";
                return Err(r.at(offset, "cache", expected, format!("{cache:?}")));
            }
        }
        Ok(model)
    }

    /// The file of this model.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut model = self.clone();
        let mut out = String::from("# Areas in gate equivalents: one two-input NAND is 1.\n");
        let mut section = "";
        for (table, key, meaning, knob) in KNOBS {
            if *table != section {
                // Writing to a String cannot fail.
                let _ = writeln!(out, "[{table}]");
                section = table;
            }
            let _ = writeln!(out, "{key} = {:?} # {meaning}", knob(&mut model));
        }
        let cache = &self.cache;
        let _ = writeln!(
            out,
            "[cache]\nbytes = {}\nways = {}\nline_bytes = {}",
            cache.bytes, cache.ways, cache.line_bytes
        );
        out
    }
}

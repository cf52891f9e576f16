//! A first look at an OpenEXR header, on raw bytes and before the decoder sees any of them.
//!
//! Everything that sizes memory is read here and refused where it exceeds the file or the limit:
//! attribute sizes, windows, tiles, chunk tables; deep data and sub-sampled channels by name.

use super::limits::LoadOptions;
use super::planar::EnvLayout;
use super::window::Windows;
use crate::base::num;
use crate::error::InputError;

/// One attribute as stored.
pub(super) struct Attribute<'a> {
    pub(super) name: &'a [u8],
    kind: &'a [u8],
    value: &'a [u8],
    /// The whole entry: name, type, size and value.
    pub(super) entry: std::ops::Range<usize>,
}

/// The parts' attributes and where the chunk tables start.
pub(super) struct Raw<'a> {
    flags: u32,
    pub(super) parts: Vec<Vec<Attribute<'a>>>,
    pub(super) end: usize,
}

/// How a part is cut into chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blocks {
    /// Rows, with the number of rows a chunk.
    Lines(usize),
    /// Tiles.
    Tiles {
        /// Tile width and height.
        size: [usize; 2],
        /// 0: one level, 1: mip map, 2: rip map.
        mode: u8,
        /// Whether level sizes round up.
        round_up: bool,
    },
}

/// The data of a part that its pixels are found and placed by.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Data window's first row, which scan-line chunks count from.
    pub(super) top: i64,
    /// Bytes of each channel's sample, in order.
    pub(super) sample_bytes: Vec<usize>,
    pub(super) compression: u8,
    pub(super) blocks: Blocks,
    pub(super) envmap: Option<EnvLayout>,
    pub(super) windows: Windows,
    pub(super) chromaticities: bool,
}

/// A part's name and its channels, by which it is chosen.
#[derive(Clone, Debug, Default)]
pub(super) struct Contents {
    pub(super) name: Option<String>,
    pub(super) channels: Vec<String>,
    deep: bool,
}

const SINGLE_TILE: u32 = 1 << 9;
const LONG_NAMES: u32 = 1 << 10;
const DEEP: u32 = 1 << 11;
const MULTIPART: u32 = 1 << 12;

impl Raw<'_> {
    pub(super) fn multipart(&self) -> bool {
        self.flags & MULTIPART != 0
    }
}

/// An error about the header.
pub(super) fn bad(
    subject: &str,
    place: &str,
    expected: impl Into<String>,
    found: impl Into<String>,
) -> InputError {
    InputError::new(
        subject,
        expected,
        found,
        "the file is damaged or of a kind that is not read; export it again",
    )
    .at(place)
}

fn refused(subject: &str, place: &str, expected: &str, found: &str, remedy: &str) -> InputError {
    InputError::new(subject, expected, found, remedy).at(place)
}

/// Splits the header into attributes; every size is checked against the file.
pub(super) fn scan<'a>(bytes: &'a [u8], subject: &str) -> Result<Raw<'a>, InputError> {
    let truncated = || bad(subject, "header", "a whole header", "the end of the file");
    let word = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
    };
    let version = word(4).ok_or_else(truncated)?;
    let known = SINGLE_TILE | LONG_NAMES | DEEP | MULTIPART;
    if version & 0xff != 2 || version & !0xff & !known != 0 {
        let found = format!("version word {version:#010x}");
        return Err(bad(subject, "header", "OpenEXR version 2", found));
    }
    let limit = if version & LONG_NAMES != 0 { 256 } else { 32 };
    let name = |at: usize| -> Result<(&'a [u8], usize), InputError> {
        let rest = bytes.get(at..).unwrap_or_default();
        let length = rest.iter().take(limit + 1).position(|b| *b == 0);
        let length = length.ok_or_else(|| {
            let expected = format!("names of at most {limit} bytes");
            bad(subject, "header", expected, format!("none that ends at byte {at}"))
        })?;
        Ok((&rest[..length], at + length + 1))
    };
    let mut raw = Raw { flags: version, parts: Vec::new(), end: 8 };
    loop {
        let mut part = Vec::new();
        while *bytes.get(raw.end).ok_or_else(truncated)? != 0 {
            let start = raw.end;
            let (attribute, at) = name(start)?;
            let (kind, at) = name(at)?;
            let size = word(at).ok_or_else(truncated)?;
            let from = at + 4;
            let value = usize::try_from(size)
                .ok()
                .and_then(|size| bytes.get(from..from.checked_add(size)?))
                .ok_or_else(|| {
                    bad(
                        subject,
                        &format!("attribute \"{}\"", show(attribute)),
                        format!("a size of at most the file's {} bytes", bytes.len()),
                        format!("{size} bytes"),
                    )
                })?;
            raw.end = from + value.len();
            part.push(Attribute { name: attribute, kind, value, entry: start..raw.end });
        }
        raw.end += 1;
        if part.is_empty() && (raw.multipart() && !raw.parts.is_empty()) {
            return Ok(raw);
        }
        raw.parts.push(part);
        if !raw.multipart() {
            return Ok(raw);
        }
    }
}

fn show(name: &[u8]) -> String {
    let name: Vec<u8> =
        name.iter().map(|b| if b.is_ascii_graphic() { *b } else { b'?' }).take(64).collect();
    String::from_utf8_lossy(&name).into_owned()
}

impl Raw<'_> {
    /// The parts' names and channels; a deep one has none that can be read.
    pub(super) fn contents(&self) -> Vec<Contents> {
        self.parts
            .iter()
            .map(|attributes| {
                let text = |name: &[u8]| {
                    let value = value_of(attributes, name, b"string")?;
                    Some(String::from_utf8_lossy(value).trim_end_matches('\0').to_owned())
                };
                let kind = value_of(attributes, b"type", b"string").unwrap_or_default();
                let deep = self.flags & DEEP != 0 && !self.multipart() || kind.starts_with(b"deep");
                let list = value_of(attributes, b"channels", b"chlist").filter(|_| !deep);
                let channels = list.map(names).unwrap_or_default();
                Contents { name: text(b"name").filter(|n| !n.is_empty()), channels, deep }
            })
            .collect()
    }

    /// The header of one part as that of a file of its own, so that the decoder sees nothing else.
    pub(super) fn alone(&self, bytes: &[u8], index: usize) -> Option<Vec<u8>> {
        let attributes = self.parts.get(index)?;
        let tiled = is_tiled(self, attributes);
        let version = 2 | self.flags & LONG_NAMES | if tiled { SINGLE_TILE } else { 0 };
        let mut out = vec![0x76, 0x2f, 0x31, 0x01];
        out.extend(version.to_le_bytes());
        let window = value_of(attributes, b"dataWindow", b"box2i")?;
        let usual: [(&[u8], &[u8], &[u8]); 8] = [
            (b"channels", b"chlist", &[]),
            (b"compression", b"compression", &[]),
            (b"dataWindow", b"box2i", &[]),
            (b"displayWindow", b"box2i", window),
            (b"lineOrder", b"lineOrder", &[0]),
            (b"pixelAspectRatio", b"float", &[0, 0, 0x80, 0x3f]),
            (b"screenWindowCenter", b"v2f", &[0; 8]),
            (b"screenWindowWidth", b"float", &[0, 0, 0x80, 0x3f]),
        ];
        let tiles: (&[u8], &[u8], &[u8]) = (b"tiles", b"tiledesc", &[]);
        for (name, kind, value) in usual.into_iter().chain(tiled.then_some(tiles)) {
            if let Some(a) = attributes.iter().rev().find(|a| a.name == name && a.kind == kind) {
                out.extend(&bytes[a.entry.clone()]);
            } else {
                let size = num::u32(value.len()).to_le_bytes();
                for piece in [name, &[0], kind, &[0], &size, value] {
                    out.extend(piece);
                }
            }
        }
        out.push(0);
        Some(out)
    }
}

fn is_tiled(raw: &Raw, attributes: &[Attribute]) -> bool {
    match value_of(attributes, b"type", b"string") {
        Some(kind) => kind == b"tiledimage",
        None => raw.flags & SINGLE_TILE != 0,
    }
}

/// Checks one part, and returns it with the place of its chunk table.
///
/// `options` limits its top level; the chunk tables of it and of the parts before it must fit the file.
pub(super) fn check(
    raw: &Raw,
    index: usize,
    file_bytes: usize,
    subject: &str,
    options: &LoadOptions,
) -> Result<(Part, usize), InputError> {
    if raw.contents().get(index).is_none_or(|c| c.deep) {
        return Err(refused(subject, "type", "flat pixels", "deep data", "flatten the image"));
    }
    let mut table = 0u128;
    for attributes in &raw.parts[..index] {
        // A file of several parts has to say the number of chunks of each.
        let stated = value_of(attributes, b"chunkCount", b"int").and_then(|v| v.try_into().ok());
        let count = stated.and_then(|v| u128::try_from(i32::from_le_bytes(v)).ok());
        table += match count {
            Some(count) => count,
            None => part(attributes, is_tiled(raw, attributes), subject)?.chunk_count(),
        };
    }
    let attributes = &raw.parts[index];
    let part = part(attributes, is_tiled(raw, attributes), subject)?;
    let pixel = part.sample_bytes.iter().sum::<usize>() as u128;
    let what = format!("{}x{} pixels of {pixel} bytes", part.width, part.height);
    options.admit(subject, part.width as u128 * part.height as u128 * pixel, &what)?;
    if let Blocks::Tiles { size: [tw, th], .. } = part.blocks {
        let what = format!("tiles of {tw}x{th} pixels of {pixel} bytes");
        options.admit(subject, tw as u128 * th as u128 * pixel, &what)?;
    }
    // Each chunk has 8 bytes in the table and at least 8 of its own.
    let rest = file_bytes.saturating_sub(raw.end) as u128;
    let needed = table * 16 + part.chunk_count() * 16;
    if needed > rest {
        return Err(bad(
            subject,
            "chunk table",
            format!("room for {} chunks, at least {needed} bytes", needed / 16),
            format!("{rest} bytes after the header"),
        ));
    }
    Ok((part, raw.end + num::usize(table * 8)))
}

fn value_of<'a>(attributes: &[Attribute<'a>], name: &[u8], kind: &[u8]) -> Option<&'a [u8]> {
    // The decoder keeps the last of several, so do we.
    attributes.iter().rev().find(|a| a.name == name && a.kind == kind).map(|a| a.value)
}

fn part(attributes: &[Attribute], tiled: bool, subject: &str) -> Result<Part, InputError> {
    let get = |name: &str, kind: &str, least: usize| {
        value_of(attributes, name.as_bytes(), kind.as_bytes())
            .filter(|v| v.len() >= least)
            .ok_or_else(|| {
                let expected = format!("an attribute \"{name}\" of type {kind}");
                bad(subject, "header", expected, "none")
            })
    };
    let word = |v: &[u8], i: usize| i32::from_le_bytes([v[i], v[i + 1], v[i + 2], v[i + 3]]);
    let window = get("dataWindow", "box2i", 16)?;
    let [x0, y0, x1, y1] = [0, 4, 8, 12].map(|i| i64::from(word(window, i)));
    let far = i64::from(i32::MAX / 2);
    let inside = [x0, y0, x1, y1].iter().all(|c| c.abs() < far);
    let size = |a: i64, b: i64| usize::try_from(b - a + 1).ok().filter(|n| *n > 0);
    let (Some(width), Some(height), true) = (size(x0, x1), size(y0, y1), inside) else {
        let found = format!("({x0}, {y0}) to ({x1}, {y1})");
        return Err(bad(subject, "dataWindow", "a window that is not empty", found));
    };
    let sample_bytes = channels(get("channels", "chlist", 1)?, subject)?;
    let compression = get("compression", "compression", 1)?[0];
    let lines = match compression {
        0..=2 => 1,
        3 | 5 => 16,
        4 | 6 | 7 | 8 => 32,
        9 => 256,
        _ => {
            return Err(refused(
                subject,
                "compression",
                "none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA or DWAB",
                &format!("method {compression}"),
                "store the image with one of these",
            ));
        }
    };
    let blocks = if tiled {
        let tiles = get("tiles", "tiledesc", 9)?;
        let side = |i| num::usize(word(tiles, i));
        let (tw, th, mode) = (side(0), side(4), tiles[8]);
        if tw == 0 || th == 0 || mode & 15 > 2 || mode >> 4 > 1 {
            let found = format!("{}x{}, mode {mode}", word(tiles, 0), word(tiles, 4));
            return Err(bad(subject, "tiles", "a tile size of at least 1x1", found));
        }
        Blocks::Tiles { size: [tw, th], mode: mode & 15, round_up: mode >> 4 == 1 }
    } else {
        Blocks::Lines(lines)
    };
    let envmap = match value_of(attributes, b"envmap", b"envmap") {
        Some([0]) => Some(EnvLayout::LatLong),
        Some([1]) => Some(EnvLayout::Cube),
        Some(other) => {
            let found = format!("{other:?}").chars().take(20).collect::<String>();
            return Err(bad(subject, "envmap", "0 (lat-long) or 1 (cube)", found));
        }
        None => None,
    };
    let data = [x0, y0, x1, y1];
    let display = value_of(attributes, b"displayWindow", b"box2i").filter(|v| v.len() >= 16);
    let display = display.map_or(data, |v| [0, 4, 8, 12].map(|i| i64::from(word(v, i))));
    let windows = Windows { data, display };
    let chromaticities = value_of(attributes, b"chromaticities", b"chromaticities");
    let chromaticities = chromaticities.is_some_and(|v| !usual_chromaticities(v));
    let part = Part {
        width,
        height,
        top: y0,
        sample_bytes,
        compression,
        blocks,
        envmap,
        windows,
        chromaticities,
    };
    Ok(part)
}

/// Whether primaries and white are those of BT.709, to three decimals.
fn usual_chromaticities(value: &[u8]) -> bool {
    let usual = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.329];
    let words = value.chunks_exact(4).map(|w| w.try_into().unwrap_or_default());
    let near = |(w, u): ([u8; 4], f32)| (f32::from_le_bytes(w) - u).abs() < 1e-3;
    words.zip(usual).all(near)
}

/// The names of a list of channels, as far as it can be read.
fn names(list: &[u8]) -> Vec<String> {
    let (mut at, mut out) = (0, Vec::new());
    while let Some(length) = list.get(at..).and_then(|l| l.iter().position(|b| *b == 0)) {
        if length == 0 {
            break;
        }
        out.push(String::from_utf8_lossy(&list[at..at + length]).into_owned());
        at += length + 17;
    }
    out
}

/// Bytes per sample of each channel; sub-sampling is refused by name.
fn channels(list: &[u8], subject: &str) -> Result<Vec<usize>, InputError> {
    let damaged = |found: &str| bad(subject, "channels", "a list of channels", found);
    let mut at = 0;
    let mut bytes = Vec::new();
    while *list.get(at).ok_or_else(|| damaged("one without an end"))? != 0 {
        let length = list[at..].iter().position(|b| *b == 0);
        let length = length.ok_or_else(|| damaged("a name without an end"))?;
        let name = show(&list[at..at + length]);
        at += length + 1;
        let fields = list.get(at..at + 16).ok_or_else(|| damaged("half a channel"))?;
        at += 16;
        let word =
            |i: usize| i32::from_le_bytes([fields[i], fields[i + 1], fields[i + 2], fields[i + 3]]);
        if (word(8), word(12)) != (1, 1) {
            return Err(refused(
                subject,
                &format!("channel \"{name}\""),
                "one sample for every pixel",
                &format!("sub-sampling {}x{}", word(8), word(12)),
                "convert luminance/chroma to RGB",
            ));
        }
        bytes.push(match word(0) {
            0 | 2 => 4,
            1 => 2,
            other => {
                let found = format!("{other}");
                let place = format!("channel \"{name}\"");
                return Err(bad(subject, &place, "sample type 0, 1 or 2", found));
            }
        });
    }
    if bytes.is_empty() {
        return Err(damaged("none"));
    }
    Ok(bytes)
}

/// ⌊log2 n⌋ or ⌈log2 n⌉, n ≥ 1.
fn log2(n: usize, round_up: bool) -> u32 {
    n.ilog2() + u32::from(round_up && !n.is_power_of_two())
}

impl Part {
    /// Pixels of a level along an axis: full/2^level, rounded as the file says, at least 1.
    fn level_side(&self, full: usize, level: u32) -> usize {
        match self.blocks {
            Blocks::Tiles { round_up: true, .. } => full.div_ceil(1 << level),
            Blocks::Tiles { .. } | Blocks::Lines(_) => (full >> level).max(1),
        }
    }

    /// Width and height of mip level `level`.
    pub(super) fn level_size(&self, level: u32) -> [usize; 2] {
        [self.width, self.height].map(|full| self.level_side(full, level))
    }

    /// Number of mip levels (1 for single-level files and rip maps, of which only the top is read).
    pub(super) fn mip_levels(&self) -> u32 {
        match self.blocks {
            Blocks::Tiles { mode: 1, round_up, .. } => {
                log2(self.width.max(self.height), round_up) + 1
            }
            Blocks::Tiles { .. } | Blocks::Lines(_) => 1,
        }
    }

    /// Chunks along x and y of a level of the given size.
    pub(super) fn grid(&self, [width, height]: [usize; 2]) -> [usize; 2] {
        match self.blocks {
            Blocks::Lines(rows) => [1, height.div_ceil(rows)],
            Blocks::Tiles { size, .. } => [width.div_ceil(size[0]), height.div_ceil(size[1])],
        }
    }

    /// Chunks of all levels.
    pub(super) fn chunk_count(&self) -> u128 {
        let area = |size| {
            let [x, y] = self.grid(size);
            x as u128 * y as u128
        };
        if let Blocks::Tiles { mode: 2, round_up, .. } = self.blocks {
            let levels = |full| (0..=log2(full, round_up)).map(move |l| self.level_side(full, l));
            return levels(self.width)
                .map(|w| levels(self.height).map(|h| area([w, h])).sum::<u128>())
                .sum();
        }
        (0..self.mip_levels()).map(|l| area(self.level_size(l))).sum()
    }
}

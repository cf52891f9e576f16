//! OpenEXR to planes: chunks are found here, decompressed by `exr`, and placed here.

use super::exr_header::{Blocks, Contents, Part, bad, check, scan};
use super::limits::{LoadOptions, room};
use super::planar::{Planar, list, shown};
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;
use exr::block::UncompressedBlock;
use exr::block::chunk::{
    Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates,
};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use half::f16;
use rayon::prelude::*;

/// Which levels are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Want {
    /// Level 0.
    Top,
    /// Every level of a mip map.
    AllMips,
}

/// How well a part suits, by its channels and the layer that is asked for; 0: not at all.
pub(super) type Suits<'a> = &'a dyn Fn(&[&str], Option<&str>) -> u8;

/// Reads one part: that which is named or holds what is named, else the first of those that suit best.
pub(super) fn read(
    bytes: &[u8],
    subject: &str,
    options: &LoadOptions,
    want: Want,
    (chosen, suits): (Option<&str>, Suits<'_>),
) -> Result<Vec<Planar>, InputError> {
    let raw = scan(bytes, subject)?;
    let contents = raw.contents();
    let (index, layer) = choose(&contents, chosen, suits).ok_or_else(|| {
        InputError::new(
            subject,
            format!("a part, layer or channel `{}`", shown(chosen.unwrap_or_default())),
            inventory(&contents),
            "name one of these as in FILE.exr:NAME",
        )
        .at("channels")
    })?;
    let (part, table) = check(&raw, index, bytes.len(), subject, options)?;
    let part = &part;
    let decoder_error = |e: String| bad(subject, "header", "a header that the decoder takes", e);
    let alone = raw.alone(bytes, index).unwrap_or_default();
    let meta = guarded(|| -> exr::error::Result<MetaData> {
        let meta = MetaData::read_from_buffered(alone.as_slice(), false)?;
        MetaData::validate(&meta.headers, false)?;
        Ok(meta)
    })
    .and_then(|result| result.map_err(|e| e.to_string()))
    .map_err(decoder_error)?;
    let header = match &meta.headers[..] {
        [header]
            if (header.layer_size.0, header.layer_size.1) == (part.width, part.height)
                && header.channels.list.len() == part.sample_bytes.len()
                && header.chunk_count as u128 == part.chunk_count() =>
        {
            header
        }
        _ => return Err(decoder_error("two readings that differ".to_owned())),
    };
    let levels = match want {
        Want::Top => 1,
        Want::AllMips => part.mip_levels(),
    };
    let multipart = raw.multipart().then_some(index);
    let chunks = collect(bytes, table, part, multipart, levels, subject)?;
    let names = header.channels.list.iter().map(|c| c.name.to_string());
    let names: Vec<String> = names.collect();
    let mut planes = Vec::new();
    for level in 0..levels {
        let [width, height] = part.level_size(level);
        let mut channels = Vec::new();
        for name in &names {
            let mut plane = room(width * height, subject)?;
            plane.resize(width * height, 0.0);
            channels.push((name.clone(), plane));
        }
        let mut planar = Planar::plain(width, height, channels);
        planar.envmap = part.envmap;
        planar.windows = (level == 0).then_some(part.windows);
        planar.layer = layer.map(str::to_owned);
        if contents.len() > 1 {
            planar.part = Some(contents[index].name.clone().unwrap_or(format!("{index}")));
        }
        if part.chromaticities {
            planar.remarks.push("its chromaticities kept as they are".into());
        }
        planes.push(planar);
    }
    let kinds: Vec<SampleType> = header.channels.list.iter().map(|c| c.sample_type).collect();
    // A few chunks at a time: what is decompressed and not yet placed stays small.
    let mut chunks = chunks.into_iter().peekable();
    while chunks.peek().is_some() {
        let batch: Vec<Chunk> = chunks.by_ref().take(4 * rayon::current_num_threads()).collect();
        let blocks: Vec<Result<UncompressedBlock, String>> = batch
            .into_par_iter()
            .map(|chunk| {
                guarded(|| UncompressedBlock::decompress_chunk(chunk, &meta, false))
                    .and_then(|result| result.map_err(|e| e.to_string()))
            })
            .collect();
        for block in blocks {
            let block = block.map_err(|e| bad(subject, "pixels", "intact pixel data", e))?;
            place(&block, &kinds, &mut planes)
                .ok_or_else(|| bad(subject, "pixels", "chunks inside the image", "one outside"))?;
        }
    }
    Ok(planes)
}

/// The part to read, and the layer or channel in it where one is named.
fn choose<'a>(
    contents: &[Contents],
    chosen: Option<&'a str>,
    suits: Suits<'_>,
) -> Option<(usize, Option<&'a str>)> {
    let names = |c: &Contents| -> Vec<String> { c.channels.clone() };
    let fits = |c: &Contents, layer| {
        let names = names(c);
        suits(&names.iter().map(String::as_str).collect::<Vec<_>>(), layer)
    };
    let Some(chosen) = chosen else {
        // Of equals the first.
        let best = (0..contents.len()).rev().max_by_key(|i| fits(&contents[*i], None));
        return best.map(|index| (index, None));
    };
    if let Some(index) = contents.iter().position(|c| c.name.as_deref() == Some(chosen)) {
        // What is named counts, even where it would not have been chosen.
        let layer = (fits(&contents[index], None) == 0).then_some("");
        return Some((index, layer));
    }
    let holds = |c: &Contents| {
        let inside =
            |n: &String| n == chosen || n.strip_prefix(chosen).is_some_and(|r| r.starts_with('.'));
        c.channels.iter().any(inside)
    };
    contents.iter().position(holds).map(|index| (index, Some(chosen)))
}

/// Every part with its channels, for a message.
fn inventory(contents: &[Contents]) -> String {
    let one = |c: &Contents| {
        let names: Vec<&str> = c.channels.iter().map(String::as_str).collect();
        match &c.name {
            Some(name) if contents.len() > 1 => {
                format!("part \"{}\": {}", shown(name), list(&names))
            }
            _ => list(&names),
        }
    };
    contents.iter().take(12).map(one).collect::<Vec<_>>().join("; ")
}

/// Finds the chunks of the wanted levels by the part's table and copies their bytes.
fn collect(
    bytes: &[u8],
    table: usize,
    part: &Part,
    multipart: Option<usize>,
    levels: u32,
    subject: &str,
) -> Result<Vec<Chunk>, InputError> {
    let damaged = |found: String| bad(subject, "chunk table", "every chunk once", found);
    let count = num::usize(part.chunk_count());
    let offsets = bytes.get(table..).unwrap_or_default().chunks_exact(8).take(count);
    let mut missing: std::collections::BTreeSet<[usize; 3]> = (0..levels)
        .flat_map(|level| {
            let [nx, ny] = part.grid(part.level_size(level));
            (0..ny).flat_map(move |y| (0..nx).map(move |x| [level as usize, y, x]))
        })
        .collect();
    let mut chunks = Vec::with_capacity(missing.len());
    for (index, offset) in offsets.enumerate() {
        let offset = u64::from_le_bytes(offset.try_into().unwrap_or_default());
        let chunk = usize::try_from(offset)
            .ok()
            .and_then(|offset| Words(bytes.get(offset..)?).chunk(part, multipart))
            .ok_or_else(|| damaged(format!("chunk {index} outside the file or cut off")))?;
        let (at, chunk) = chunk;
        let wanted = at[0] < levels as usize;
        if !wanted {
            continue;
        }
        if !missing.remove(&at) {
            return Err(damaged(format!("a chunk twice or outside the image: {at:?}")));
        }
        if let CompressedBlock::ScanLine(CompressedScanLineBlock {
            compressed_pixels_le: data, ..
        })
        | CompressedBlock::Tile(CompressedTileBlock { compressed_pixels_le: data, .. }) =
            &chunk.compressed_block
            && matches!(part.compression, 8 | 9)
        {
            let size = part.block_size(at);
            dwa_counters(data, part, size)
                .ok_or_else(|| bad(subject, "pixels", "intact DWA data", "impossible sizes"))?;
        }
        chunks.push(chunk);
    }
    match missing.first() {
        None => Ok(chunks),
        Some(at) => Err(damaged(format!("none at level, row, column {at:?}"))),
    }
}

/// A little-endian reader over the remaining bytes.
struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    fn word(&mut self) -> Option<i32> {
        let (word, rest) = self.0.split_first_chunk::<4>()?;
        self.0 = rest;
        Some(i32::from_le_bytes(*word))
    }

    fn index(&mut self) -> Option<usize> {
        usize::try_from(self.word()?).ok()
    }

    fn data(&mut self) -> Option<&'a [u8]> {
        let size = self.index()?;
        self.0.get(..size)
    }

    /// A chunk of the part and its [level, row, column].
    ///
    /// Rip-map levels other than the diagonal are given level 63, which is never wanted.
    fn chunk(mut self, part: &Part, multipart: Option<usize>) -> Option<([usize; 3], Chunk)> {
        if let Some(number) = multipart
            && self.index()? != number
        {
            return None;
        }
        let (at, compressed_block) = match part.blocks {
            Blocks::Lines(rows) => {
                let y = self.word()?;
                let row = usize::try_from(i64::from(y) - part.top).ok()?;
                if row % rows != 0 {
                    return None;
                }
                let block = CompressedScanLineBlock {
                    y_coordinate: y,
                    compressed_pixels_le: self.data()?.to_vec(),
                };
                ([0, row / rows, 0], CompressedBlock::ScanLine(block))
            }
            Blocks::Tiles { .. } => {
                let [x, y, lx, ly] = [self.index()?, self.index()?, self.index()?, self.index()?];
                if lx > 31 || ly > 31 {
                    return None;
                }
                let level = if lx == ly { lx } else { 63 };
                let block = CompressedTileBlock {
                    coordinates: TileCoordinates {
                        tile_index: Vec2(x, y),
                        level_index: Vec2(lx, ly),
                    },
                    compressed_pixels_le: self.data()?.to_vec(),
                };
                ([level, y, x], CompressedBlock::Tile(block))
            }
        };
        let chunk = Chunk { layer_index: 0, compressed_block };
        Some((at, chunk))
    }
}

impl Part {
    /// Pixels of the block at [level, row, column], which lies inside the image.
    fn block_size(&self, [level, row, column]: [usize; 3]) -> [usize; 2] {
        let [width, height] = self.level_size(num::u32(level));
        let [bw, bh] = match self.blocks {
            Blocks::Lines(rows) => [width, rows],
            Blocks::Tiles { size, .. } => size,
        };
        [bw.min(width.saturating_sub(column * bw)), bh.min(height.saturating_sub(row * bh))]
    }
}

/// Whether the sizes that a DWA chunk claims are possible for its block.
///
/// The decoder allocates what they claim, so a forged chunk could ask for exabytes.
fn dwa_counters(data: &[u8], part: &Part, [width, height]: [usize; 2]) -> Option<()> {
    let raw = width * height * part.sample_bytes.iter().sum::<usize>();
    if data.is_empty() || data.len() == raw {
        return Some(());
    }
    let counter = |i: usize| {
        let bytes = data.get(8 * i..8 * i + 8)?;
        usize::try_from(u64::from_le_bytes(bytes.try_into().ok()?)).ok()
    };
    let blocks = width.div_ceil(8) * height.div_ceil(8) * part.sample_bytes.len();
    // version, unknown raw, unknown, AC, DC, RLE, RLE unpacked, RLE raw, AC count, DC count, kind.
    // RLE tokens take at most 2 bytes a byte; a DCT block has 63 AC values and one DC.
    let most = [(1, raw), (6, 2 * raw + 16), (7, raw), (8, 64 * blocks), (9, blocks)];
    let packed = (2..=5).try_fold(0usize, |sum, i| sum.checked_add(counter(i)?))?;
    (packed <= data.len() && most.iter().all(|(i, most)| counter(*i).is_some_and(|n| n <= *most)))
        .then_some(())
}

/// Copies a block's samples into the planes of its level.
fn place(block: &UncompressedBlock, kinds: &[SampleType], levels: &mut [Planar]) -> Option<()> {
    let index = block.index;
    let level = levels.get_mut(index.level.0)?;
    let (x, y) = (index.pixel_position.0, index.pixel_position.1);
    let (width, height) = (index.pixel_size.0, index.pixel_size.1);
    if x + width > level.width || y + height > level.height {
        return None;
    }
    let mut data = block.data.as_slice();
    for row in y..y + height {
        for (kind, (_, plane)) in kinds.iter().zip(&mut level.channels) {
            let (line, rest) = data.split_at_checked(width * kind.bytes_per_sample())?;
            data = rest;
            let start = row * level.width + x;
            let out = plane.get_mut(start..start + width)?;
            let samples = line.chunks_exact(kind.bytes_per_sample());
            for (o, s) in out.iter_mut().zip(samples) {
                *o = match (kind, s) {
                    (SampleType::F16, [a, b]) => f16::from_ne_bytes([*a, *b]).to_f32(),
                    (SampleType::F32, [a, b, c, d]) => f32::from_ne_bytes([*a, *b, *c, *d]),
                    (SampleType::U32, [a, b, c, d]) => {
                        num::f32(f64::from(u32::from_ne_bytes([*a, *b, *c, *d])))
                    }
                    _ => return None,
                };
            }
        }
    }
    Some(())
}

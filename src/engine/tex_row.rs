//! One row of a picture of the TEX operation while its requests are answered.

use std::collections::BTreeMap;

use rtl_model::unit::{Operation as _, Results, TexBlock, TexWords};

use super::dispatch::LANES;
use super::hit::HitResult;
use super::tex::TexRtl;
use super::tex_requests::Request;
use super::tiles::{Tiles, level_colour};
use crate::fragment::HitFragment;

/// The results of a row's requests.
pub(super) struct Row {
    pub(super) rgb: Vec<[f64; 3]>,
    pub(super) levels: Vec<[f64; 4]>,
    pub(super) probes: u64,
    pub(super) texels: u64,
    pub(super) flags: BTreeMap<String, u64>,
    pub(super) tiles: Vec<Tiles>,
    /// Seconds for paths, and for everything else.
    pub(super) seconds: [f64; 2],
}

impl Row {
    pub(super) fn new(width: usize) -> Self {
        Self {
            rgb: vec![[0.0; 3]; width],
            levels: vec![[0.0; 4]; width],
            probes: 0,
            texels: 0,
            flags: BTreeMap::new(),
            tiles: Vec::new(),
            seconds: [0.0; 2],
        }
    }

    pub(super) fn add(&mut self, column: usize, weight: f64, colour: [f64; 3]) {
        for (sum, c) in self.rgb[column].iter_mut().zip(colour) {
            *sum += weight * c;
        }
    }

    pub(super) fn level(&mut self, column: usize, weight: f64, lod: f64) {
        let [r, g, b] = level_colour(lod);
        for (sum, c) in self.levels[column].iter_mut().zip([r, g, b, 1.0]) {
            *sum += weight * c;
        }
    }

    /// Adds the result of one lane for a request to a texture.
    pub(super) fn look(
        &mut self,
        unit: &TexRtl,
        index: usize,
        request: &Request<TexWords>,
        (block, out, lane): (&TexBlock<LANES>, &Results<LANES>, usize),
    ) {
        let result = unit.result(block, out, lane);
        self.add(request.column, request.weight, result.color);
        self.level(request.column, request.weight, result.lod);
        self.probes += u64::from(result.probes);
        self.texels += result.texels;
        if !out.flags[lane].is_empty() {
            for name in unit.flag_names(out.flags[lane]) {
                *self.flags.entry(name).or_default() += 1;
            }
        }
        if let Some(texture) = &unit.memory.texture {
            let tiles = &mut self.tiles[index];
            unit.unit.touched_corners(block, lane, texture, &mut |at| {
                tiles.touch(at.level, at.texel);
            });
        }
    }

    pub(super) fn sky(&mut self, asked: &[Request<HitFragment>], found: Vec<HitResult>) {
        for (request, found) in asked.iter().zip(found) {
            self.add(request.column, request.weight, found.color);
            self.probes += u64::from(found.probes);
            self.texels += found.texels;
            for name in found.flags {
                *self.flags.entry(name).or_default() += 1;
            }
        }
    }
}

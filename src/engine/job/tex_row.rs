//! One row of a picture of the TEX operation while its requests are answered.

use std::collections::BTreeMap;

use rtl_model::unit::{Operation as _, Results, TexBlock, TexWords};

use super::tex_requests::Request;
use crate::engine::dispatch::LANES;
use crate::engine::hit::HitResult;
use crate::engine::tex::TexRtl;
use crate::engine::tiles::{Tiles, level_colour};
use crate::fragment::HitFragment;

/// The results of a row's requests.
pub(in crate::engine) struct Row {
    pub(in crate::engine) rgb: Vec<[f64; 3]>,
    pub(in crate::engine) levels: Vec<[f64; 4]>,
    pub(in crate::engine) probes: u64,
    pub(in crate::engine) texels: u64,
    pub(in crate::engine) flags: BTreeMap<String, u64>,
    pub(in crate::engine) tiles: Vec<Tiles>,
    /// Seconds for paths, and for everything else.
    pub(in crate::engine) seconds: [f64; 2],
}

impl Row {
    pub(in crate::engine) fn new(width: usize) -> Self {
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

    pub(in crate::engine) fn add(&mut self, column: usize, weight: f64, colour: [f64; 3]) {
        for (sum, c) in self.rgb[column].iter_mut().zip(colour) {
            *sum += weight * c;
        }
    }

    pub(in crate::engine) fn level(&mut self, column: usize, weight: f64, lod: f64) {
        let [r, g, b] = level_colour(lod);
        for (sum, c) in self.levels[column].iter_mut().zip([r, g, b, 1.0]) {
            *sum += weight * c;
        }
    }

    /// Adds what one lane found for a request to a texture.
    pub(in crate::engine) fn look(
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

    pub(in crate::engine) fn sky(&mut self, asked: &[Request<HitFragment>], found: Vec<HitResult>) {
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

//! From this crate's types to the integer model's: fragments as words, cube maps as texel memory.

use rtl_model::texture::Source;
use rtl_model::unit::{Needs, Words};
use rtl_model::{Config, ConfigError, Texture};

use crate::cube::{CubeMap, across_edge};
use crate::fragment::Fragment;

/// The ports' words of a fragment; a missing input is zero.
#[must_use]
pub fn words(fragment: &Fragment) -> Words {
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    Words {
        v: bits(fragment.v),
        n: bits(fragment.n),
        dv: [bits(fragment.dv_dx), bits(fragment.dv_dy)],
        dn: [bits(fragment.dn_dx), bits(fragment.dn_dy)],
        h: bits(fragment.h.unwrap_or([0.0; 3])),
        b: fragment.bump.unwrap_or([0.0; 2]).map(f64::to_bits),
        d: bits(fragment.rough.unwrap_or([0.0; 3])),
    }
}

/// The needs of a fragment: which parts of the unit.
#[must_use]
pub fn needs(fragment: &Fragment) -> Needs {
    Needs { bump: fragment.bump.is_some(), rough: fragment.rough.is_some() }
}

/// A cube map in the unit's texel format.
pub fn texture(config: &Config, map: &CubeMap) -> Result<Texture, ConfigError> {
    let words: Vec<Vec<[u32; 3]>> = map
        .levels
        .iter()
        .map(|level| level.texels.iter().map(|t| t.map(f32::to_bits)).collect())
        .collect();
    let sources: Vec<Source<'_>> = map
        .levels
        .iter()
        .zip(&words)
        .map(|(level, words)| Source { size: level.size, words })
        .collect();
    Texture::new(config, &sources, &across_edge)
}

//! The TEX operation over many requests: the integer model and the float reference, with one result shape.

use rtl_model::cone::{Cone, Dyadic};
use rtl_model::regs::Reg;
use rtl_model::texture::PlanarSource;
use rtl_model::unit::{Memory, Results, Tangents as WordTangents, TexBlock, TexUnit, TexWords};
use rtl_model::{Config, ConfigError, Texture};

use super::probe::to_f64;
use super::rtl::Rtl;
use crate::base::num;
use crate::error::InputError;
use crate::fragment::{Tangents, TexFragment};
use crate::planar::PlanarMap;
use crate::unit::{UnitSpec, refused};

/// A 2-D texture in the unit's texel format.
pub fn texture(config: &Config, map: &PlanarMap) -> Result<Texture, ConfigError> {
    let words: Vec<Vec<[u32; 3]>> = map
        .levels
        .iter()
        .map(|level| level.texels.iter().map(|t| t.map(f32::to_bits)).collect())
        .collect();
    let sources: Vec<PlanarSource<'_>> = map
        .levels
        .iter()
        .zip(&words)
        .map(|(level, words)| PlanarSource { size: level.size, words })
        .collect();
    Texture::planar(config, &sources, config.policy.address.wrap())
}

/// A request as the unit's ports take it.
#[must_use]
pub fn words(fragment: &TexFragment, cone: Cone) -> TexWords {
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    TexWords {
        cone,
        d: bits(fragment.d),
        n: bits(fragment.n),
        tangents: match fragment.tangents {
            Tangents::Surface { dp_ds, dp_dt } => WordTangents::Surface([bits(dp_ds), bits(dp_dt)]),
            Tangents::Triangle { edges, st } => {
                let [[s_b, t_b], [s_c, t_c]] = st.map(|st| st.map(f64::to_bits));
                WordTangents::Triangle { edges: edges.map(bits), st: [s_b, s_c, t_b, t_c] }
            }
        },
        st: fragment.st.map(f64::to_bits),
    }
}

/// The value of a cone's operand.
#[must_use]
pub fn value(x: Dyadic) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a cone's significand has at most 24 bits")]
    let magnitude = libm::ldexp(x.m as f64, num::i32(x.e));
    if x.negative { -magnitude } else { magnitude }
}

/// An engine's result for one request.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexResult {
    /// Filtered colour.
    pub color: [f64; 3],
    /// Level of detail.
    pub lod: f64,
    /// Probes.
    pub probes: u32,
    /// Texels read.
    pub texels: u64,
}

/// The integer model of TEX, for one texture; none where a trace only asks for addresses.
pub type TexRtl = Rtl<TexUnit>;

impl TexRtl {
    /// Compiles a unit and encodes a texture.
    pub fn new(spec: &UnitSpec, map: &PlanarMap) -> Result<Self, InputError> {
        Self::again(None, spec, map)
    }

    /// [`TexRtl::new`] with the texels of the engine before for the same texture.
    pub(super) fn again(
        before: Option<Self>,
        spec: &UnitSpec,
        map: &PlanarMap,
    ) -> Result<Self, InputError> {
        let texture = match Self::memory_for(before, &spec.config).0 {
            Some(texture) => texture,
            None => texture(&spec.config, map).map_err(refused)?,
        };
        let mut engine = Self::sized(spec, map.size_u32())?;
        engine.memory.texture = Some(texture);
        Ok(engine)
    }

    /// Compiles a unit for a texture of `size` that is not read.
    pub fn sized(spec: &UnitSpec, size: [u32; 2]) -> Result<Self, InputError> {
        let unit = TexUnit::new(&spec.config, size).map_err(refused)?;
        Ok(Self::around(spec, unit, Memory::default()))
    }

    /// One lane's result.
    #[must_use]
    pub fn result<const N: usize>(
        &self,
        block: &TexBlock<N>,
        out: &Results<N>,
        lane: usize,
    ) -> TexResult {
        let lod_frac = num::i32(self.config.format(Reg::FootLod).frac);
        TexResult {
            color: self.color(out.color[lane]),
            lod: to_f64(block.env.line.lod[lane], lod_frac),
            probes: num::u32(out.probes[lane]),
            texels: out.texels[lane],
        }
    }
}

//! The TEX operation over many requests: the integer model and the float reference, with one result shape.

use rtl_model::cone::{Cone, Dyadic};
use rtl_model::regs::{Event, Reg};
use rtl_model::texture::PlanarSource;
use rtl_model::unit::{Results, Tangents as WordTangents, TexState, TexUnit, TexWords};
use rtl_model::{Config, ConfigError, NoTap, NoTapStandard, Tap, Texture};

use super::dispatch::LANES;
use super::probe::to_f64;
use super::rtl::overflow_name;
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

/// What an engine made of one request.
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

/// A block of requests with everything that becomes of them, which stays from unit to unit.
#[derive(Clone, Debug)]
pub struct Block {
    requests: Vec<TexWords>,
    state: Box<TexState<LANES>>,
}

impl Block {
    /// A block of up to [`LANES`] requests; nothing has run yet.
    #[must_use]
    pub fn kept(requests: &[TexWords]) -> Self {
        Self { requests: requests.to_vec(), state: Box::new(TexState::kept()) }
    }

    /// What the steps have left.
    #[must_use]
    pub fn state(&self) -> &TexState<LANES> {
        &self.state
    }

    /// Its requests, one a lane.
    #[must_use]
    pub fn requests(&self) -> &[TexWords] {
        &self.requests
    }
}

/// The integer model with its texture.
#[derive(Clone, Debug)]
pub struct TexRtl {
    /// The compiled unit.
    pub unit: TexUnit,
    /// Texels; none where a trace only asks for addresses.
    pub texture: Option<Texture>,
    /// The configuration that both were made from.
    pub config: Config,
}

impl TexRtl {
    /// Compiles a unit and encodes a texture.
    pub fn new(spec: &UnitSpec, map: &PlanarMap) -> Result<Self, InputError> {
        let texture = texture(&spec.config, map).map_err(refused)?;
        Ok(Self { texture: Some(texture), ..Self::sized(spec, map.size_u32())? })
    }

    /// Compiles a unit for a texture of `size` that is not read.
    pub fn sized(spec: &UnitSpec, size: [u32; 2]) -> Result<Self, InputError> {
        Ok(Self {
            unit: TexUnit::new(&spec.config, size).map_err(refused)?,
            texture: None,
            config: spec.config.clone(),
        })
    }

    /// Runs blocks of requests; `each` gets the state of a block, its results and how many of its lanes are in use.
    ///
    /// Cones and `surface_footprint` work lane by lane, so that wider vectors would gain little here.
    pub fn blocks(
        &self,
        requests: &[TexWords],
        mut each: impl FnMut(&TexState<LANES>, &Results<LANES>, usize),
    ) {
        let (mut state, mut out) = (TexState::default(), Results::default());
        let texture = self.texture.as_ref();
        for requests in requests.chunks(LANES) {
            let (state, out) = (&mut state, &mut out);
            self.run(0, requests, texture, state, out);
            each(state, out, requests.len());
        }
    }

    /// [`TexRtl::blocks`] from step `first` on, over blocks in which the steps before it have run.
    pub fn reblocks(
        &self,
        blocks: &mut [Block],
        first: usize,
        mut each: impl FnMut(&TexState<LANES>, &Results<LANES>, usize),
    ) {
        let mut out = Results::default();
        for block in blocks {
            let (state, texture) = (&mut block.state, self.texture.as_ref());
            self.run(first, &block.requests, texture, state, &mut out);
            each(state, &out, block.requests.len());
        }
    }

    /// The stages up to the addresses, for one request.
    #[must_use]
    pub fn address(&self, request: &[TexWords; 1]) -> (TexState<LANES>, Results<LANES>) {
        let (mut state, mut out) = (TexState::default(), Results::default());
        self.run(0, request, None, &mut state, &mut out);
        (state, out)
    }

    fn run(
        &self,
        first: usize,
        requests: &[TexWords],
        texture: Option<&Texture>,
        state: &mut TexState<LANES>,
        out: &mut Results<LANES>,
    ) {
        if self.unit.is_standard() {
            let tap = &mut NoTapStandard;
            self.unit.run_from(first, requests, texture, state, out, tap);
        } else {
            self.unit.run_from(first, requests, texture, state, out, &mut NoTap);
        }
    }

    /// Runs up to `N` requests as one block.
    pub fn lanes<const N: usize, T: Tap>(
        &self,
        requests: &[TexWords],
        tap: &mut T,
    ) -> (TexState<N>, Results<N>) {
        let (mut state, mut out) = (TexState::default(), Results::default());
        let texture = self.texture.as_ref();
        self.unit.run(requests, texture, &mut state, &mut out, tap);
        (state, out)
    }

    /// One lane's result.
    #[must_use]
    pub fn result<const N: usize>(
        &self,
        state: &TexState<N>,
        out: &Results<N>,
        lane: usize,
    ) -> TexResult {
        let frac = |reg: Reg| num::i32(self.config.format(reg).frac);
        TexResult {
            color: out.color[lane].map(|c| to_f64(c, frac(Reg::FilterColor))),
            lod: to_f64(state.env.line.lod[lane], frac(Reg::FootLod)),
            probes: num::u32(out.probes[lane]),
            texels: out.texels[lane],
        }
    }

    /// Names of a lane's flags.
    #[must_use]
    pub fn flags<const N: usize>(&self, out: &Results<N>, lane: usize) -> Vec<String> {
        let flags = out.flags[lane];
        let registers = Reg::ALL.iter().filter(|reg| flags.has(**reg));
        let events = Event::ALL.iter().filter(|event| flags.has_event(**event));
        registers
            .map(|reg| overflow_name(&self.config, *reg))
            .chain(events.map(|event| event.name().to_string()))
            .collect()
    }
}

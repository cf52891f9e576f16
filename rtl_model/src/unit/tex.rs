//! The TEX operation: a cone's footprint on a 2-D texture, then the back end that ENV has.

use super::Unit;
use super::block::{NO_FLAGS, Needs, Ports, Results, State};
use crate::cone::Cone;
use crate::config::{Config, ConfigError};
use crate::fx::{Block, Quantizer};
use crate::port;
use crate::regs::{Event, Reg};
use crate::stages::filter::Corner;
use crate::stages::footprint::planar_unit;
use crate::stages::{Sink, ray_cone, store, surface_footprint};
use crate::tap::Tap;
use crate::texture::Texture;

/// How texture coordinates change along a surface, as binary64 words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tangents {
    /// ∂P/∂s and ∂P/∂t.
    Surface([[u64; 3]; 2]),
    /// A triangle ABC.
    Triangle {
        /// B − A and C − A.
        edges: [[u64; 3]; 2],
        /// s_B − s_A, s_C − s_A, t_B − t_A, t_C − t_A.
        st: [u64; 4],
    },
}

/// One request: a ray with its cone at a textured surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexWords {
    /// The cone's registers there.
    pub cone: Cone,
    /// Direction of the ray.
    pub d: [u64; 3],
    /// Normal of the surface.
    pub n: [u64; 3],
    /// The surface's texture coordinates.
    pub tangents: Tangents,
    /// s and t.
    pub st: [u64; 2],
}

/// What the stages have written for a block of lanes; kept from block to block.
#[derive(Clone, Debug)]
pub struct TexState<const N: usize> {
    /// `surface_footprint`.
    pub surface: [surface_footprint::Out; N],
    /// Codes of s and t.
    pub st: [[i64; 2]; N],
    /// The stages behind it.
    pub env: State<N>,
}

impl<const N: usize> Default for TexState<N> {
    fn default() -> Self {
        Self {
            surface: [surface_footprint::Out::default(); N],
            st: [[0; 2]; N],
            env: State::default(),
        }
    }
}

/// A tap that reports D, K and λ in texels: inside they count in half of a power of two of them.
struct InTexels<'a, T> {
    tap: &'a mut T,
    /// log2 of the texels in that unit.
    unit: i64,
}

impl<T: Tap> Tap for InTexels<'_, T> {
    const STANDARD: bool = T::STANDARD;
    const ACTIVE: bool = T::ACTIVE;

    #[inline(always)]
    fn put(&mut self, lane: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        let powers = match reg {
            Reg::CovK | Reg::EigenRoot | Reg::EigenSq => 2,
            Reg::SurfJac | Reg::EigenLambda | Reg::FootLine => 1,
            // Every other register means the same on a cube.
            _ => 0,
        };
        self.tap.put(lane, reg, component, raw, frac - powers * self.unit);
    }
}

/// A unit compiled for a 2-D texture.
#[derive(Clone, Debug)]
pub struct TexUnit {
    pub(super) unit: Unit,
    pub(super) surface: surface_footprint::Cfg,
    /// log2 of half the texels in which D, K and λ count.
    pub(super) texels: i64,
    /// The cones' formats and rules.
    pub cone: ray_cone::Cfg,
}

impl TexUnit {
    /// Compiles a configuration for a texture of `size` columns and rows; refuses by name what could not be exact
    /// inside.
    pub fn new(config: &Config, size: [u32; 2]) -> Result<Self, ConfigError> {
        Ok(Self {
            unit: Unit::planar(config, size)?,
            surface: surface_footprint::Cfg::new(config, size)?,
            texels: i64::from(planar_unit(size).ilog2()) - 1,
            cone: ray_cone::Cfg::new(config),
        })
    }

    /// Whether every register rounds half-even and saturates.
    #[must_use]
    pub fn is_standard(&self) -> bool {
        self.unit.is_standard()
    }

    /// Up to `N` requests, from the ports to the colour; without a texture everything but the colour.
    #[inline(always)]
    pub fn run<const N: usize, T: Tap>(
        &self,
        requests: &[TexWords],
        texture: Option<&Texture>,
        state: &mut TexState<N>,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        self.run_from(0, requests, texture, state, out, tap);
    }

    /// [`TexUnit::run`] from step `first` on, over a state in which the steps before it have run.
    #[inline(always)]
    pub fn run_from<const N: usize, T: Tap>(
        &self,
        first: usize,
        requests: &[TexWords],
        texture: Option<&Texture>,
        state: &mut TexState<N>,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        let tap = &mut InTexels { tap, unit: self.texels };
        let len = requests.len().min(N);
        let TexState { surface, st, env } = state;
        env.step(0, first, |env| {
            self.surfaces(&requests[..len], surface, st, env, tap);
        });
        let lanes = Ports::<N> { len, ..Ports::default() };
        let unit = &self.unit;
        env.step(1, first, |env| unit.covariance(&lanes, env, tap));
        env.step(2, first, |env| unit.eigen(&lanes, env, tap));
        env.step(3, first, |env| unit.footprint(&lanes, env, tap));
        unit.finish(env, len, texture, out, tap);
    }

    /// `surface_footprint` of each request, lane by lane.
    #[inline(always)]
    fn surfaces<const N: usize, T: Tap>(
        &self,
        requests: &[TexWords],
        surface: &mut [surface_footprint::Out; N],
        st: &mut [[i64; 2]; N],
        env: &mut State<N>,
        tap: &mut T,
    ) {
        for (lane, words) in requests.iter().enumerate() {
            let mut flags = NO_FLAGS;
            let mut finite = true;
            let mut sink = Sink { lane, flags: &mut flags, tap: &mut *tap };
            let input = self.load(words, &mut st[lane], &mut finite, &mut sink);
            sink.flags.event(Event::SurfNotFinite, !finite);
            let found = surface_footprint::surface_footprint(
                &self.surface,
                &self.unit.roms,
                &input,
                &mut sink,
            );
            store(&mut env.d.d, lane, found.d);
            env.d_exp[lane] = found.d_exp;
            surface[lane] = found;
            let [u, v] = self.unit.address.center(st[lane]);
            env.face.face[lane] = 0;
            env.face.u[lane] = u;
            env.face.v[lane] = v;
            env.flags[lane] = flags;
        }
    }

    /// The first texel of each bilinear footprint of a lane: what a cache of tiles sees.
    #[inline(always)]
    pub fn footprints<const N: usize>(
        &self,
        state: &TexState<N>,
        lane: usize,
        texture: &Texture,
        each: &mut dyn FnMut(Corner),
    ) {
        self.unit.footprints(&state.env, lane, texture, each);
    }

    #[inline(always)]
    fn load<T: Tap>(
        &self,
        words: &TexWords,
        st: &mut [i64; 2],
        finite: &mut bool,
        sink: &mut Sink<'_, T>,
    ) -> surface_footprint::In {
        let cfg = &self.surface;
        let direction = vector(&cfg.direction, Reg::SurfDirection, words.d, finite, sink);
        let normal = vector(&cfg.normal, Reg::SurfNormal, words.n, finite, sink);
        let regs = [Reg::SurfDpDs, Reg::SurfDpDt];
        let mut pair = |v: [[u64; 3]; 2], finite: &mut bool| {
            [0, 1].map(|i| vector(&cfg.tangents[i], regs[i], v[i], finite, sink))
        };
        let (tangents, edge) = match words.tangents {
            Tangents::Surface(v) => (pair(v, finite), None),
            Tangents::Triangle { edges, st } => {
                let tangents = pair(edges, finite);
                (tangents, Some(vector(&cfg.edge, Reg::SurfEdge, st, finite, sink)))
            }
        };
        for (i, reg) in [Reg::SurfS, Reg::SurfT].into_iter().enumerate() {
            st[i] = scalar(&cfg.st[i], (reg, 0), words.st[i], finite, sink);
        }
        surface_footprint::In {
            direction,
            normal,
            tangents,
            edge,
            width: self.cone.width(words.cone.width),
        }
    }
}

/// A port of a vector.
#[inline(always)]
fn vector<const C: usize, T: Tap>(
    q: &Quantizer,
    reg: Reg,
    words: [u64; C],
    finite: &mut bool,
    sink: &mut Sink<'_, T>,
) -> Block<C> {
    let (block, all_finite) = port::vector(T::STANDARD, q, words);
    *finite &= all_finite;
    for (c, m) in block.m.iter().enumerate() {
        sink.tap.put(sink.lane, reg, c, *m, block.frac);
    }
    block
}

/// A port of a number.
#[inline(always)]
fn scalar<T: Tap>(
    q: &Quantizer,
    (reg, c): (Reg, usize),
    word: u64,
    finite: &mut bool,
    sink: &mut Sink<'_, T>,
) -> i64 {
    let (code, over, is_finite) = port::scalar(T::STANDARD, q, word, 0);
    *finite &= is_finite;
    sink.flags.register(reg, over);
    sink.tap.put(sink.lane, reg, c, code, i64::from(q.format.frac));
    code
}

/// What a unit for textures needs of ENV's front: nothing.
pub(super) const NEEDS: Needs = Needs { bump: false, rough: false };

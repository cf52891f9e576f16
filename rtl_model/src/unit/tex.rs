//! The TEX operation: a cone's footprint on a 2-D texture, then the back end that ENV has.

use core::hash::{Hash as _, Hasher};

use lanes::Simd;

use super::block::{Block, NO_FLAGS, Needs, Results, State};
use super::operation::{BlockOf, Memory, Operation};
use super::steps::steps;
use super::{TexBlock, Unit};
use crate::cone::{Cone, Width};
use crate::config::{Config, ConfigError};
use crate::regs::{Event, Reg};
use crate::stages::footprint::planar_unit;
use crate::stages::{Sink, ray_cone, store, surface_footprint};
use crate::tap::Tap;

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

impl Default for TexWords {
    fn default() -> Self {
        Self {
            cone: Cone::default(),
            d: [0; 3],
            n: [0; 3],
            tangents: Tangents::Surface([[0; 3]; 2]),
            st: [0; 2],
        }
    }
}

/// Requests and what `surface_footprint` makes of them, one a lane.
#[derive(Clone, Debug)]
pub struct TexFront<const N: usize> {
    words: [TexWords; N],
    /// `surface_footprint`.
    pub surface: [surface_footprint::Out; N],
    /// Codes of s and t.
    pub st: [[i64; 2]; N],
}

impl<const N: usize> Default for TexFront<N> {
    fn default() -> Self {
        Self {
            words: [TexWords::default(); N],
            surface: [surface_footprint::Out::default(); N],
            st: [[0; 2]; N],
        }
    }
}

impl<const N: usize> TexFront<N> {
    /// Width of the cone in a lane.
    #[must_use]
    pub fn width(&self, lane: usize) -> Width {
        self.words[lane].cone.width
    }
}

/// A tap that reports D, K and λ in texels. The unit computes them in multiples of 2^k/2 texels, where 2^k is the power
/// of two that holds the texture's longer side.
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

    /// A tap behind the one that reports D, K and λ in texels.
    #[inline(always)]
    fn in_texels<'a, T: Tap>(&self, tap: &'a mut T) -> InTexels<'a, T> {
        InTexels { tap, unit: self.texels }
    }

    /// `surface_footprint` of each request, lane by lane.
    #[inline(always)]
    fn surfaces<const N: usize, T: Tap>(
        &self,
        front: &mut TexFront<N>,
        env: &mut State<N>,
        tap: &mut T,
    ) {
        let TexFront { words, surface, st } = front;
        for lane in 0..env.len.min(N) {
            let mut flags = NO_FLAGS;
            let mut finite = true;
            let mut sink = Sink { lane, flags: &mut flags, tap: &mut *tap };
            let input = self.ports(&words[lane], &mut st[lane], &mut finite, &mut sink);
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

    /// The ports of a request.
    #[inline(always)]
    fn ports<T: Tap>(
        &self,
        words: &TexWords,
        st: &mut [i64; 2],
        finite: &mut bool,
        sink: &mut Sink<'_, T>,
    ) -> surface_footprint::In {
        let cfg = &self.surface;
        let direction = sink.vector_port(&cfg.direction, words.d, finite);
        let normal = sink.vector_port(&cfg.normal, words.n, finite);
        let mut pair = |v: [[u64; 3]; 2], finite: &mut bool| {
            [0, 1].map(|i| sink.vector_port(&cfg.tangents[i], v[i], finite))
        };
        let (tangents, edge) = match words.tangents {
            Tangents::Surface(v) => (pair(v, finite), None),
            Tangents::Triangle { edges, st } => {
                let tangents = pair(edges, finite);
                (tangents, Some(sink.vector_port(&cfg.edge, st, finite)))
            }
        };
        for (i, q) in cfg.st.iter().enumerate() {
            st[i] = sink.scalar_port(q, 0, words.st[i], 0, finite);
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

impl Operation for TexUnit {
    type Words = TexWords;
    type Front<const N: usize> = TexFront<N>;

    fn unit(&self) -> &Unit {
        &self.unit
    }

    #[inline(always)]
    fn put<const N: usize>(&self, words: &TexWords, block: &mut BlockOf<Self, N>, lane: usize) {
        block.front.words[lane] = *words;
    }

    steps! { |tex, simd, front, env, memory, tap| if |_number| true;
        0: tex.surfaces(front, env, &mut tex.in_texels(tap)) => (
            (&tex.surface, &tex.cone, tex.texels, &tex.unit.address),
            (tex.unit.roms.recip.spec, tex.unit.roms.rsqrt.spec),
        );
        1: tex.unit.covariance(simd, env, &mut tex.in_texels(tap)) => tex.unit.covariance_reads();
        2: tex.unit.eigen(simd, env, &mut tex.in_texels(tap)) => tex.unit.eigen_reads();
        3: tex.unit.footprint(simd, env, &mut tex.in_texels(tap)) => tex.unit.footprint_reads();
    }

    #[inline(always)]
    fn finish<S: Simd, const N: usize, T: Tap>(
        &self,
        simd: S,
        block: &TexBlock<N>,
        memory: &Memory,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        let tap = &mut self.in_texels(tap);
        self.unit.back(simd, &block.env, memory.texture.as_ref(), out, tap);
    }
}

/// What a unit for textures needs of ENV's front: nothing.
pub(super) const NEEDS: Needs = Needs { bump: false, rough: false };

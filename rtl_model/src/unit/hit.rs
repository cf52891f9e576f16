//! The HIT operation: the search, then ENV's own stages from the face on.

use core::hash::{Hash as _, Hasher};

use lanes::Simd;

use super::block::{Block, NO_FLAGS, Needs, Results, State};
use super::operation::{BlockOf, Memory, Operation};
use super::steps::steps;
use super::{HitBlock, Unit};
use crate::cone::{Cone, Dither, Dyadic};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::distance::DistanceMemory;
use crate::fx::Flags;
use crate::policy::HitStatus;
use crate::regs::{Event, Reg};
use crate::stages::hit::{self, footprint};
use crate::stages::{Lanes, Sink, bits, fits, ray_cone, store, take};
use crate::tap::Tap;

/// One ray as binary64 words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HitWords {
    /// Where it starts.
    pub x: [u64; 3],
    /// Its direction.
    pub r: [u64; 3],
    /// Full angle and full width of its cone at x.
    pub cone: Option<[u64; 2]>,
}

/// Rays and their searches, one a lane.
#[derive(Clone, Debug)]
pub struct HitFront<const N: usize> {
    words: [HitWords; N],
    cone: [Option<(Cone, Dither)>; N],
    /// The search's results.
    pub hit: hit::Out<N>,
    /// Flags behind the search.
    searched: [Flags; N],
}

impl<const N: usize> Default for HitFront<N> {
    fn default() -> Self {
        Self {
            words: [HitWords::default(); N],
            cone: [None; N],
            hit: hit::Out::default(),
            searched: [NO_FLAGS; N],
        }
    }
}

impl<const N: usize> HitFront<N> {
    /// Whether the ray in a lane has a cone; a ray without one ends after the search.
    #[must_use]
    pub fn has_cone(&self, lane: usize) -> bool {
        self.words.get(lane).is_some_and(|words| words.cone.is_some())
    }

    #[inline(always)]
    fn any_cone(&self, len: usize) -> bool {
        let mut any = false;
        for lane in 0..len.min(N) {
            any |= self.words[lane].cone.is_some();
        }
        any
    }

    /// Powers of two of the directions that ENV looks up.
    #[inline(always)]
    fn exponents(&self, scale: i64) -> [i64; N] {
        let mut exp = [scale; N];
        for (exp, status) in exp.iter_mut().zip(&self.hit.status) {
            if *status == HitStatus::Escaped {
                *exp = 0;
            }
        }
        exp
    }
}

/// A unit compiled for rays.
#[derive(Clone, Debug)]
pub struct HitUnit {
    pub(super) unit: Unit,
    pub(super) hit: hit::Cfg,
    pub(super) footprint: footprint::Cfg,
    pub(super) cone: ray_cone::Cfg,
}

impl HitUnit {
    /// Compiles a configuration; refuses by name what could not be exact inside.
    pub fn new(config: &Config, face_size: u32) -> Result<Self, ConfigError> {
        let needs = Needs { bump: false, rough: false };
        let unit = Unit::new(config, needs, face_size)?;
        let looked_up = if config.rotation.is_some() {
            fits(Reg::FaceRotated, bits(config, Reg::HitTo) + ROTATION_FRAC + 3)?;
            bits(config, Reg::FaceRotated)
        } else {
            bits(config, Reg::HitTo)
        };
        fits(Reg::FaceU, looked_up + bits(config, Reg::FaceInvMa))?;
        Ok(Self {
            unit,
            hit: hit::Cfg::new(config)?,
            footprint: footprint::Cfg::new(config)?,
            cone: ray_cone::Cfg::new(config),
        })
    }

    /// The ports of a ray: x and its direction; the cone goes to its registers.
    #[inline(always)]
    fn ports<const N: usize, T: Tap>(
        &self,
        front: &mut HitFront<N>,
        (x, direction): (&mut Lanes<N, 3>, &mut Lanes<N, 3>),
        scale: i64,
        mut sink: Sink<'_, T>,
    ) {
        let lane = sink.lane;
        let words = front.words[lane];
        let mut all_finite = true;
        for (c, word) in words.x.into_iter().enumerate() {
            x[c][lane] = sink.scalar_port(&self.hit.x, c, word, scale, &mut all_finite);
        }
        let r = sink.vector_port(&self.hit.direction, words.r, &mut all_finite);
        store(direction, lane, r.m);
        front.cone[lane] = None;
        if let Some(cone) = words.cone {
            // A stochastic store looks at the ray alone: the same bits in every lane and on every thread.
            let mut sum = 0u64;
            for word in words.x.into_iter().chain(words.r).chain(cone) {
                sum = (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            }
            for word in cone {
                all_finite &= Dyadic::binary64(word).1;
            }
            let mut dither = self.cone.dither(sum);
            front.cone[lane] = Some((self.cone.load(cone, &mut dither, sink.flags), dither));
        }
        sink.flags.event(Event::HitNotFinite, !all_finite);
    }

    /// The ports and the search.
    #[inline(always)]
    fn search<const N: usize, T: Tap>(
        &self,
        front: &mut HitFront<N>,
        memory: &DistanceMemory,
        env: &mut State<N>,
        tap: &mut T,
    ) {
        let len = env.len.min(N);
        let (mut x, mut direction) = ([[0; N]; 3], [[0; N]; 3]);
        env.flags = [NO_FLAGS; N];
        for lane in 0..len {
            let sink = Sink { lane, flags: &mut env.flags[lane], tap: &mut *tap };
            self.ports(front, (&mut x, &mut direction), memory.scale, sink);
        }
        // Only the direction counts: mantissas with their largest in [1, 2).
        let frac = self.hit.direction.block_frac();
        let input = hit::In { x: &x, direction: &direction, direction_frac: &[frac; N] };
        let (roms, flags) = (&self.unit.roms, &mut env.flags[..len]);
        hit::hit(&self.hit, roms, memory, input, &mut front.hit, flags, tap);
        front.searched = env.flags;
    }

    /// Where the directions to the hits meet the cube.
    #[inline(always)]
    fn face<S: Simd, const N: usize, T: Tap>(
        &self,
        simd: S,
        front: &HitFront<N>,
        memory: &DistanceMemory,
        env: &mut State<N>,
        tap: &mut T,
    ) {
        (env.reflected.v_r, env.reflected.v_r_frac) = (front.hit.to, front.hit.to_frac);
        (env.input.v_exp, env.input.n_exp) = (front.exponents(memory.scale), [0; N]);
        env.reflected.n_lift = [0; N];
        self.unit.cube_face(simd, env, tap);
    }

    /// D of each lane's cone at its hit.
    #[inline(always)]
    fn footprints_at_hits<const N: usize, T: Tap>(
        &self,
        front: &HitFront<N>,
        memory: &DistanceMemory,
        env: &mut State<N>,
        tap: &mut T,
    ) {
        let (roms, hit, exp) = (&self.unit.roms, &front.hit, front.exponents(memory.scale));
        for lane in 0..env.len.min(N) {
            let escaped = hit.status[lane] == HitStatus::Escaped;
            let face = env.face_of(lane);
            let flags = &mut env.flags[lane];
            let width = front.cone[lane].map_or(Dyadic::ZERO, |(cone, mut dither)| {
                if escaped {
                    return self.cone.angle(cone.angle);
                }
                let d = Dyadic::fixed(hit.d[lane], self.hit.d_frac() - memory.scale);
                let there = ray_cone::propagate(&self.cone, cone, d, &mut dither, flags);
                self.cone.width(there.width)
            });
            // At most 24 bits.
            let width = (i64::try_from(width.m).unwrap_or(0), width.e);
            let mut sink = Sink { lane, flags, tap };
            let zero = env.face.zero[lane] != 0;
            let input = footprint::In {
                r: take(&hit.r, lane),
                to: take(&hit.to, lane),
                width,
                scale: exp[lane],
                escaped,
                face: (face, env.face.u[lane], env.face.v[lane]),
                inv_ma: if zero {
                    (0, 0)
                } else {
                    (env.face.inv_ma[lane], env.face.inv_ma_frac[lane])
                },
            };
            let d =
                footprint::footprint(&self.footprint, &self.hit, roms, memory, &input, &mut sink);
            store(&mut env.d.d, lane, d);
        }
    }
}

impl Operation for HitUnit {
    type Words = HitWords;
    type Front<const N: usize> = HitFront<N>;

    fn unit(&self) -> &Unit {
        &self.unit
    }

    #[inline(always)]
    fn put<const N: usize>(&self, words: &HitWords, block: &mut BlockOf<Self, N>, lane: usize) {
        block.front.words[lane] = *words;
    }

    steps! { |hit, simd, front, env, memory, tap| if |number| number == 0 || front.any_cone(env.len);
        0: hit.search(front, &memory.distances, env, tap) => {
            let roms = &hit.unit.roms;
            (&hit.hit, &hit.cone, roms.recip.spec, roms.rsqrt.spec, roms.sqrt.spec)
        };
        1: hit.face(simd, front, &memory.distances, env, tap) => hit.unit.face_reads();
        2: hit.footprints_at_hits(front, &memory.distances, env, tap) => {
            let roms = &hit.unit.roms;
            (&hit.footprint, &hit.hit, &hit.cone, roms.recip.spec, roms.rsqrt.spec)
        };
        3: hit.unit.covariance(simd, env, tap) => hit.unit.covariance_reads();
        4: hit.unit.eigen(simd, env, tap) => hit.unit.eigen_reads();
        5: hit.unit.footprint(simd, env, tap) => hit.unit.footprint_reads();
    }

    #[inline(always)]
    fn finish<S: Simd, const N: usize, T: Tap>(
        &self,
        simd: S,
        block: &HitBlock<N>,
        memory: &Memory,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        let Block { front, env } = block;
        if front.any_cone(env.len) {
            self.unit.back(simd, env, memory.texture.as_ref(), out, tap);
        }
        // Lanes without a cone ran along for nothing.
        for lane in (0..env.len.min(N)).filter(|lane| !front.has_cone(*lane)) {
            out.flags[lane] = front.searched[lane];
            out.color[lane] = [0; 3];
            out.probes[lane] = 0;
            out.texels[lane] = 0;
        }
    }
}

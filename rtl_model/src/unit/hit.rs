//! The HIT operation: the search, then ENV's own stages from the face on.

use super::Unit;
use super::block::{NO_FLAGS, Needs, Ports, Results, State};
use crate::cone::{Cone, Dither, Dyadic};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::distance::DistanceMemory;
use crate::fx::Flags;
use crate::policy::HitStatus;
use crate::port;
use crate::regs::{Event, Reg};
use crate::stages::filter::Corner;
use crate::stages::hit::{self, footprint};
use crate::stages::{Lanes, Sink, bits, cube_face, fits, ray_cone, store, take};
use crate::tap::Tap;
use crate::texture::Texture;

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

/// Up to `N` rays behind their ports.
#[derive(Clone, Debug)]
pub struct HitPorts<const N: usize> {
    /// Lanes in use.
    pub len: usize,
    x: Lanes<N, 3>,
    direction: Lanes<N, 3>,
    direction_frac: [i64; N],
    cone: [Option<(Cone, Dither)>; N],
    flags: [Flags; N],
}

impl<const N: usize> Default for HitPorts<N> {
    fn default() -> Self {
        Self {
            len: 0,
            x: [[0; N]; 3],
            direction: [[0; N]; 3],
            direction_frac: [0; N],
            cone: [None; N],
            flags: [NO_FLAGS; N],
        }
    }
}

/// What the stages have written; kept from block to block.
#[derive(Clone, Debug, Default)]
pub struct HitState<const N: usize> {
    /// The search's results.
    pub hit: hit::Out<N>,
    /// The stages behind it.
    pub env: State<N>,
}

/// Results of up to `N` rays.
#[derive(Clone, Debug)]
pub struct HitResults<const N: usize> {
    /// What ENV made of the footprint; flags of the whole operation.
    pub env: Results<N>,
}

impl<const N: usize> Default for HitResults<N> {
    fn default() -> Self {
        Self { env: Results::default() }
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

    /// Whether every register rounds half-even and saturates.
    #[must_use]
    pub fn is_standard(&self) -> bool {
        self.unit.is_standard()
    }

    /// Passes one ray through the ports into lane `ports.len`, which must be below `N`.
    #[inline(always)]
    pub fn load<const N: usize, T: Tap>(
        &self,
        ports: &mut HitPorts<N>,
        memory: &DistanceMemory,
        words: &HitWords,
        tap: &mut T,
    ) {
        let lane = ports.len;
        if lane >= N {
            return;
        }
        ports.len += 1;
        let mut flags = NO_FLAGS;
        let mut all_finite = true;
        let scale = memory.scale;
        for (c, word) in words.x.into_iter().enumerate() {
            let (code, over, finite) = port::scalar(T::STANDARD, &self.hit.x, word, scale);
            flags.register(Reg::HitX, over);
            all_finite &= finite;
            ports.x[c][lane] = code;
            let frac = i64::from(self.hit.x.format.frac) - scale;
            tap.put(lane, Reg::HitX, c, code, frac);
        }
        let (r, finite) = port::vector(T::STANDARD, &self.hit.direction, words.r);
        all_finite &= finite;
        for (c, m) in r.m.into_iter().enumerate() {
            tap.put(lane, Reg::HitDirection, c, m, r.frac);
        }
        store(&mut ports.direction, lane, r.m);
        // Only the direction counts: mantissas with their largest in [1, 2).
        ports.direction_frac[lane] = i64::from(self.hit.direction.format.magnitude_bits()) - 1;
        ports.cone[lane] = words.cone.map(|cone| {
            // A stochastic store looks at the ray alone: the same bits in every lane and on every thread.
            let ray = words.x.into_iter().chain(words.r).chain(cone);
            let mut dither = self
                .cone
                .dither(ray.fold(0, |sum, word| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
            all_finite &= cone.iter().all(|word| Dyadic::binary64(*word).1);
            let cone = self.cone.load(cone, &mut dither, &mut flags);
            (cone, dither)
        });
        flags.event(Event::HitNotFinite, !all_finite);
        ports.flags[lane] = flags;
    }

    /// The whole operation. A lane without a cone ends after the search.
    #[inline(always)]
    pub fn run<const N: usize, T: Tap>(
        &self,
        ports: &HitPorts<N>,
        memory: &DistanceMemory,
        texture: Option<&Texture>,
        state: &mut HitState<N>,
        out: &mut HitResults<N>,
        tap: &mut T,
    ) {
        self.run_from(0, ports, memory, texture, state, out, tap);
    }

    /// [`HitUnit::run`] from step `first` on, over a state in which the steps before it have run.
    #[expect(clippy::too_many_arguments, reason = "what `run` takes, and where to begin")]
    #[inline(always)]
    pub fn run_from<const N: usize, T: Tap>(
        &self,
        first: usize,
        ports: &HitPorts<N>,
        memory: &DistanceMemory,
        texture: Option<&Texture>,
        state: &mut HitState<N>,
        out: &mut HitResults<N>,
        tap: &mut T,
    ) {
        let len = ports.len.min(N);
        let (env, hit) = (&mut state.env, &mut state.hit);
        let roms = &self.unit.roms;
        env.step(0, first, |env| {
            env.flags.copy_from_slice(&ports.flags);
            let input = hit::In {
                x: &ports.x,
                direction: &ports.direction,
                direction_frac: &ports.direction_frac,
            };
            hit::hit(&self.hit, roms, memory, input, hit, &mut env.flags[..len], tap);
        });
        let searched = *env.flags_behind(0).unwrap_or(&env.flags);
        out.env.flags = searched;
        if ports.cone.iter().take(len).all(Option::is_none) {
            return;
        }
        let mut exp = [0; N];
        for (lane, exp) in exp.iter_mut().enumerate().take(len) {
            let escaped = hit.status[lane] == HitStatus::Escaped;
            *exp = if escaped { 0 } else { memory.scale };
        }
        env.step(1, first, |env| {
            let input = cube_face::In { v_r: &hit.to, v_r_frac: &hit.to_frac, exp: &exp };
            let flags = &mut env.flags[..len];
            cube_face::cube_face(&self.unit.face, roms, input, &mut env.face, flags, tap);
        });
        env.step(2, first, |env| {
            self.footprints_at_hits(ports, memory, hit, &exp, env, tap);
        });
        let lanes = Ports::<N> { len, ..Ports::default() };
        let unit = &self.unit;
        env.step(3, first, |env| unit.covariance(&lanes, env, tap));
        env.step(4, first, |env| unit.eigen(&lanes, env, tap));
        env.step(5, first, |env| unit.footprint(&lanes, env, tap));
        unit.finish(env, len, texture, &mut out.env, tap);
        // Lanes without a cone ran along for nothing.
        for lane in 0..len {
            if ports.cone[lane].is_none() {
                out.env.flags[lane] = searched[lane];
                out.env.color[lane] = [0; 3];
                out.env.probes[lane] = 0;
                out.env.texels[lane] = 0;
            }
        }
    }

    /// The first texel of each bilinear footprint of a lane.
    #[inline(always)]
    pub fn footprints<const N: usize>(
        &self,
        state: &HitState<N>,
        lane: usize,
        texture: &Texture,
        each: &mut dyn FnMut(Corner),
    ) {
        self.unit.footprints(&state.env, lane, texture, each);
    }

    /// D of each lane's cone at its hit.
    #[inline(always)]
    fn footprints_at_hits<const N: usize, T: Tap>(
        &self,
        ports: &HitPorts<N>,
        memory: &DistanceMemory,
        hit: &hit::Out<N>,
        exp: &[i64; N],
        env: &mut State<N>,
        tap: &mut T,
    ) {
        let roms = &self.unit.roms;
        for lane in 0..ports.len.min(N) {
            let escaped = hit.status[lane] == HitStatus::Escaped;
            let flags = &mut env.flags[lane];
            let width = ports.cone[lane].map_or(Dyadic::ZERO, |(cone, mut dither)| {
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
            let zero = env.face.zero[lane];
            let input = footprint::In {
                r: take(&hit.r, lane),
                to: take(&hit.to, lane),
                width,
                scale: exp[lane],
                escaped,
                face: (env.face.face[lane], env.face.u[lane], env.face.v[lane]),
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

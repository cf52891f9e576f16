//! `ray_cone`: the changes of a ray cone along a path (Cline 2023).
//!
//! Each operation is exact up to one rounding at the store: within half an ulp of the register's format
//! under `rne`, below one ulp otherwise. −0 counts as +0, no result is NaN or infinite, and what
//! is beyond the format becomes its largest number and sets a flag.

pub mod camera;

use crate::cone::exact::{self, Term};
use crate::cone::{
    Angle, Cone, Dither, Dyadic, LaneOrder, SmallFloat, StoreRounding, Sum, Width, fast,
};
use crate::config::Config;
use crate::fx::Flags;
use crate::policy::{ConeRules, SetDiffuse};
use crate::regs::Event;

/// Compiled configuration.
#[derive(Clone, Copy, Debug, Hash)]
pub struct Cfg {
    /// Format of both registers.
    pub format: SmallFloat,
    /// Order of the two in a packed word.
    pub order: LaneOrder,
    rounding: StoreRounding,
    seed: u64,
    rules: ConeRules,
    set_diffuse: SetDiffuse,
}

/// Greatest angular spread of one scatter, ¼ rad, and OptiX Toolkit's limit of an angle.
const S_MAX: Dyadic = Dyadic::new(false, 1, -2);

impl Cfg {
    /// Compiles the stage; every combination of its knobs is legal.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let cone = &config.policy.cone;
        Self {
            format: cone.format.float(),
            order: cone.lane_order,
            rounding: cone.rounding,
            seed: cone.seed.into(),
            rules: cone.rules,
            set_diffuse: cone.set_diffuse,
        }
    }

    /// The random bits of a ray's stores; only `stochastic` looks at them.
    #[must_use]
    pub fn dither(&self, ray: u64) -> Dither {
        Dither::new(self.seed, ray)
    }

    /// The value of the angle.
    #[must_use]
    pub fn angle(&self, angle: Angle) -> Dyadic {
        self.format.unpack(angle.0).0
    }

    /// The value of the width; its sign says on which side of the waist the cone is.
    #[must_use]
    pub fn width(&self, width: Width) -> Dyadic {
        self.format.unpack(width.0).0
    }

    /// Two binary64 words through the ports: one rounding each, that of the register.
    pub fn load(&self, words: [u64; 2], dither: &mut Dither, flags: &mut Flags) -> Cone {
        let mut store = Store::new(self, dither, flags);
        let [angle, width] = words.map(|word| store.port(word));
        Cone { angle: store.angle(&single(angle)), width: store.width(&single(width)) }
    }
}

/// Where results go: rounding, random bits, flags.
struct Store<'a> {
    cfg: &'a Cfg,
    dither: &'a mut Dither,
    flags: &'a mut Flags,
}

impl<'a> Store<'a> {
    fn new(cfg: &'a Cfg, dither: &'a mut Dither, flags: &'a mut Flags) -> Self {
        Self { cfg, dither, flags }
    }

    fn port(&mut self, word: u64) -> Dyadic {
        let (value, finite) = Dyadic::binary64(word);
        self.flags.event(Event::ConeNotFinite, !finite);
        value
    }

    fn code(&mut self, event: Event, value: &Sum) -> u32 {
        let random = match self.cfg.rounding {
            StoreRounding::Stochastic => self.dither.next_bits(),
            StoreRounding::Rne | StoreRounding::Truncate => 0,
        };
        let stored = self.cfg.format.store(self.cfg.rounding, random, value);
        self.flags.event(event, stored.saturated);
        stored.code
    }

    fn angle(&mut self, value: &Sum) -> Angle {
        Angle(self.code(Event::ConeAngleSaturated, value))
    }

    fn width(&mut self, value: &Sum) -> Width {
        Width(self.code(Event::ConeWidthSaturated, value))
    }

    /// Values of a cone's registers; a code that is not finite sets the flag.
    fn read(&mut self, cone: Cone) -> (Dyadic, Dyadic) {
        let (angle, first) = self.cfg.format.unpack(cone.angle.0);
        let (width, second) = self.cfg.format.unpack(cone.width.0);
        self.flags.event(Event::ConeNotFinite, !(first && second));
        (angle, width)
    }
}

/// One number as a sum.
fn single(x: Dyadic) -> Sum {
    exact::sum2(x, Dyadic::ONE, Dyadic::ZERO)
}

/// Whether a − b is at least 0.
fn at_least(a: Dyadic, b: Dyadic) -> bool {
    !exact::sum2(a, Dyadic::ONE, b.neg()).negative
}

/// w' = w + α·d over the distance d. Where α and the exact w' are both negative, both change sign: the
/// cone has passed its waist and diverges.
pub fn propagate(
    cfg: &Cfg,
    cone: Cone,
    distance: Dyadic,
    dither: &mut Dither,
    flags: &mut Flags,
) -> Cone {
    let mut store = Store::new(cfg, dither, flags);
    let (angle, width) = store.read(cone);
    let mut sum = exact::sum2(angle, distance, width);
    let passed = angle.negative && sum.negative;
    sum.negative &= !passed;
    Cone { angle: Angle(unchanged(cfg, cone.angle.0, angle, passed)), width: store.width(&sum) }
}

/// The code that holds `value`: `code`, made finite, with one zero and the sign turned where asked.
fn unchanged(cfg: &Cfg, code: u32, value: Dyadic, turned: bool) -> u32 {
    let magnitude =
        if value.is_zero() { 0 } else { cfg.format.abs(code).min(cfg.format.largest()) };
    if value.negative != turned && magnitude != 0 {
        magnitude | cfg.format.sign()
    } else {
        magnitude
    }
}

/// [`propagate`] for many cones whose distances are binary32 codes; the same bits, without flags.
///
/// `rays` numbers the first cone's ray; each cone's next store is its first one. Cones of 16-bit formats take the
/// word-parallel path, those of `f32` the general one.
///
/// Always inlined, so that a caller can compile it for the vectors that it has.
#[inline(always)]
pub fn propagate_batch(cfg: &Cfg, cones: &mut [Cone], distances: &[u32], first_ray: u64) {
    let len = cones.len().min(distances.len());
    let (cones, distances) = (&mut cones[..len], &distances[..len]);
    if cfg.format.width() > 16 {
        for ((cone, &d), ray) in cones.iter_mut().zip(distances).zip(first_ray..) {
            let d = SmallFloat::F32.unpack(d).0;
            *cone = propagate(cfg, *cone, d, &mut cfg.dither(ray), &mut Flags::default());
        }
        return;
    }
    // Constants for the loops of the formats that there are.
    let bf16 = cfg.format == SmallFloat::BF16;
    match (cfg.rounding, bf16) {
        (StoreRounding::Rne, true) => {
            blocks(cfg, SmallFloat::BF16, StoreRounding::Rne, cones, distances, first_ray);
        }
        (rounding, _) => blocks(cfg, cfg.format, rounding, cones, distances, first_ray),
    }
}

#[inline(always)]
fn blocks(
    cfg: &Cfg,
    format: SmallFloat,
    rounding: StoreRounding,
    cones: &mut [Cone],
    distances: &[u32],
    first_ray: u64,
) {
    let bits = |ray: u64| match rounding {
        StoreRounding::Stochastic => cfg.dither(ray).next_bits(),
        StoreRounding::Rne | StoreRounding::Truncate => 0,
    };
    let mut ray = first_ray;
    let chunks = cones.chunks_mut(fast::BLOCK).zip(distances.chunks(fast::BLOCK));
    for (cones, distances) in chunks {
        let done = match (cones.first_chunk_mut(), distances.first_chunk()) {
            (Some(block), Some(distances)) => {
                let mut random = [0; fast::BLOCK];
                if rounding == StoreRounding::Stochastic {
                    for (random, ray) in random.iter_mut().zip(ray..) {
                        *random = bits(ray);
                    }
                }
                fast::propagate_block(format, rounding, &random, block, distances)
            }
            _ => false,
        };
        if !done {
            for ((cone, &d), ray) in cones.iter_mut().zip(distances).zip(ray..) {
                *cone = fast::propagate(format, rounding, bits(ray), *cone, d).0;
            }
        }
        ray = ray.wrapping_add(u64::try_from(cones.len()).unwrap_or(0));
    }
}

/// α' = α + 2k|w| at a mirror of curvature k.
pub fn reflect(
    cfg: &Cfg,
    cone: Cone,
    curvature: Dyadic,
    dither: &mut Dither,
    flags: &mut Flags,
) -> Cone {
    let mut store = Store::new(cfg, dither, flags);
    let (angle, width) = store.read(cone);
    let width_code = Width(unchanged(cfg, cone.width.0, width, false));
    if cfg.rules == ConeRules::Otk && at_least(angle, S_MAX) {
        return Cone {
            angle: Angle(unchanged(cfg, cone.angle.0, angle, false)),
            width: width_code,
        };
    }
    let twice = Dyadic::new(curvature.negative, curvature.m, curvature.e + 1);
    Cone { angle: store.angle(&exact::sum2(width.abs(), twice, angle)), width: width_code }
}

/// α' = (n_o/n_i)(α + k|w|) − k|w| = (n_o·α + n_o·k|w| − n_i·k|w|)/n_i, rounded once.
///
/// n_o is the incident side's index. n_i = 0 has no quotient: the largest number of the numerator's
/// sign, with the flag; where the numerator is 0 as well, −k|w|.
pub fn refract(
    cfg: &Cfg,
    cone: Cone,
    curvature: Dyadic,
    [outside, inside]: [Dyadic; 2],
    dither: &mut Dither,
    flags: &mut Flags,
) -> Cone {
    let mut store = Store::new(cfg, dither, flags);
    let (angle, width) = store.read(cone);
    let width_code = Width(unchanged(cfg, cone.width.0, width, false));
    if cfg.rules == ConeRules::Otk && at_least(angle, S_MAX) {
        return Cone {
            angle: Angle(unchanged(cfg, cone.angle.0, angle, false)),
            width: width_code,
        };
    }
    let bend = width.abs();
    let numerator = exact::sum(&[
        Term::product(&[outside, angle]),
        Term::product(&[outside, curvature, bend]),
        Term::product(&[inside, curvature, bend]).neg(),
    ]);
    let quotient = if !inside.is_zero() {
        numerator.divided_by(inside)
    } else if numerator.is_zero() {
        exact::sum2(curvature.neg(), bend, Dyadic::ZERO)
    } else {
        Sum { e: 1 << 16, ..numerator }
    };
    Cone { angle: store.angle(&quotient), width: width_code }
}

/// α' = α + s_max·min(1, 1/(πF)) after a scatter with the BSDF (or phase function) value F, s_max = ¼.
///
/// A negative F counts as 0. With OptiX Toolkit's rules the angle grows away from zero, stays as it is
/// from ¼ on, and becomes diffuse where it would reach ±¼.
pub fn scatter(
    cfg: &Cfg,
    cone: Cone,
    bsdf: Dyadic,
    dither: &mut Dither,
    flags: &mut Flags,
) -> Cone {
    let mut store = Store::new(cfg, dither, flags);
    let (angle, width) = store.read(cone);
    let otk = cfg.rules == ConeRules::Otk;
    let same = Cone {
        angle: Angle(unchanged(cfg, cone.angle.0, angle, false)),
        width: Width(unchanged(cfg, cone.width.0, width, false)),
    };
    if otk && at_least(angle, S_MAX) {
        return same;
    }
    // F ≤ 1/π, also for the constant's first 256 bits: F has fewer.
    let below =
        bsdf.negative || exact::sum(&[Term::product(&[bsdf]), Term::inverse_pi(true, 0)]).negative;
    let away = otk && angle.negative;
    let sum = if below {
        exact::sum2(S_MAX, Dyadic::new(away, 1, 0), angle)
    } else {
        // (α·F + ¼/π)/F; 1/π never ends, so there are always bits below.
        let mut numerator =
            exact::sum(&[Term::product(&[angle, bsdf]), Term::inverse_pi(away, -2)]);
        numerator.sticky = true;
        numerator.divided_by(bsdf)
    };
    if otk && reaches_limit(&sum) {
        return match cfg.set_diffuse {
            SetDiffuse::Angle => Cone {
                angle: store.angle(&single(S_MAX)),
                width: store.width(&single(width.abs())),
            },
            SetDiffuse::Exchanged => Cone {
                angle: store.angle(&single(width.abs())),
                width: store.width(&single(S_MAX)),
            },
        };
    }
    Cone { angle: store.angle(&sum), width: same.width }
}

/// Whether a magnitude is at least ¼.
fn reaches_limit(sum: &Sum) -> bool {
    sum.m != 0 && 127 - i64::from(sum.m.leading_zeros()) + sum.e >= -2
}

/// Which of two cones a look-up takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Larger {
    /// The larger |w|: HIT and TEX. The first one on ties.
    Width,
    /// The larger |α|: ENV. The first one on ties.
    Angle,
}

/// The cone of two that a look-up takes; `alone` is the first-hit exception of pinhole and
/// orthographic cameras, for which the first cone is the answer.
#[must_use]
pub fn choose(cfg: &Cfg, cones: [Cone; 2], larger: Larger, alone: bool) -> Cone {
    let [first, second] = cones;
    let magnitude = |cone: Cone| {
        let code = match larger {
            Larger::Width => cone.width.0,
            Larger::Angle => cone.angle.0,
        };
        // Codes of magnitudes grow with their values; NaN reads as 0.
        let (value, _) = cfg.format.unpack(code);
        if value.is_zero() { 0 } else { cfg.format.abs(code).min(cfg.format.largest()) }
    };
    if alone || magnitude(first) >= magnitude(second) { first } else { second }
}

/// One operation with its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Along the ray by a distance.
    Propagate(Dyadic),
    /// At a mirror of a curvature.
    Reflect(Dyadic),
    /// Through a surface of a curvature, from the index `outside` to `inside`.
    Refract {
        /// Curvature.
        curvature: Dyadic,
        /// Index of the incident side.
        outside: Dyadic,
        /// Index of the other side.
        inside: Dyadic,
    },
    /// At a BSDF or phase function of a value.
    Scatter(Dyadic),
}

/// The cone after one operation.
pub fn ray_cone(cfg: &Cfg, cone: Cone, step: Step, dither: &mut Dither, flags: &mut Flags) -> Cone {
    match step {
        Step::Propagate(distance) => propagate(cfg, cone, distance, dither, flags),
        Step::Reflect(curvature) => reflect(cfg, cone, curvature, dither, flags),
        Step::Refract { curvature, outside, inside } => {
            refract(cfg, cone, curvature, [outside, inside], dither, flags)
        }
        Step::Scatter(bsdf) => scatter(cfg, cone, bsdf, dither, flags),
    }
}

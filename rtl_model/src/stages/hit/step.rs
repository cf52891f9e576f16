//! The next step of the search, by the method of the unit.

use super::{Cfg, P, Ray};
use crate::policy::Method;
use crate::regs::{Event, Reg};
use crate::stages::{Roms, Sink};
use crate::tables::rom::mantissa;
use crate::tap::Tap;

/// The step after ratio `f` on `side` (−1 undershoot, 1 overshoot); `None` where there is none: a bracket of at most
/// one unit of d, or a denominator of 0.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a register file and what listens to it")]
pub(super) fn step<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    ray: &mut Ray,
    f: i64,
    side: i64,
    k: usize,
    scale: i64,
    sink: &mut Sink<'_, T>,
) -> Option<i64> {
    let again = ray.side == side;
    ray.side = side;
    let before = ray.under;
    let halves = cfg.policy.method == Method::Illinois && again;
    let other = if side > 0 {
        sink.flags.event(Event::HitOvershoot, true);
        ray.over = (ray.d, f);
        ray.overshot = true;
        if halves {
            ray.under.1 = halved(cfg, ray.under.1, k, sink);
        }
        ray.under
    } else {
        ray.under = (ray.d, f);
        if halves && ray.overshot {
            ray.over.1 = halved(cfg, ray.over.1, k, sink);
        }
        ray.over
    };
    if ray.overshot {
        if (ray.over.0 - ray.under.0).abs() <= 1 {
            return None;
        }
        return between(cfg, roms, ray.d, f, other, None, k, scale, sink);
    }
    if cfg.policy.method == Method::Secant && f > before.1 {
        let lift = cfg.step.frac() - cfg.look_up.radius_frac();
        let far = 4 * ray.far;
        let most = if lift >= 0 { far << lift } else { far >> -lift };
        return between(cfg, roms, ray.d, f, before, Some(most), k, scale, sink);
    }
    // Eq. 2: towards the far point.
    let sum = ray.far * ((1 << cfg.ratio_frac) - f);
    Some(sink.write(&cfg.step_from_radius, k, sum, scale))
}

/// (1 + ratio)/2.
#[inline(always)]
fn halved<T: Tap>(cfg: &Cfg, ratio: i64, k: usize, sink: &mut Sink<'_, T>) -> i64 {
    let sum = (1 << cfg.ratio_frac) + ratio;
    let code = sink.write(&cfg.halved, k, sum, 0);
    code << (cfg.ratio_frac - cfg.halved.frac())
}

/// Eq. 3: (d − d0)(1 − f)/(f − p), at most `most`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a register file and what listens to it")]
fn between<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    d: i64,
    f: i64,
    (d0, p): (i64, i64),
    most: Option<i64>,
    k: usize,
    scale: i64,
    sink: &mut Sink<'_, T>,
) -> Option<i64> {
    let span = f - p;
    if span == 0 {
        return None;
    }
    let (m, e) = mantissa(span.abs());
    let y = roms.recip.recip(m) * span.signum();
    let inv = sink.block(&cfg.inv_span, &[y], P + e - cfg.ratio_frac, 0);
    let rest = (1 << cfg.ratio_frac) - f;
    let quotient = sink.block(&cfg.quotient, &[rest * inv.m[0]], cfg.ratio_frac + inv.frac, 0);
    let step_frac = cfg.step.frac();
    let shift = cfg.d.frac() + quotient.frac - step_frac;
    let product = (d - d0) * quotient.m[0];
    let (code, over) = cfg.step.write_as(T::STANDARD, product, shift);
    let clipped = most.is_some_and(|most| (over && product > 0) || code > most);
    let code = if clipped { most.unwrap_or(code).min(cfg.step.format.max_raw()) } else { code };
    sink.flags.register(Reg::HitStep, over && !clipped);
    sink.tap.put(sink.lane, Reg::HitStep, k, code, step_frac - scale);
    Some(code)
}

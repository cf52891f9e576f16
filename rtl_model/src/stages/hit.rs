//! `hit`: the ray parameter at which a ray meets the surface of a distance map (Szirmay-Kalos et al. 2005, eq. 1–3).
//!
//! f(d) = |l|/dist(l), l = x + R d, is 1 at a hit, less in front of the surface and more behind it. Lengths count in
//! units of the map's power of two. Lanes that are done keep their registers; the block ends when all are.

pub mod footprint;
pub mod look_up;
mod measure;
mod step;

use super::{Lanes, Roms, Sink, bits, dot, fits, frac, store, take};
use crate::config::{Config, ConfigError};
use crate::distance::DistanceMemory;
use crate::fx::Flags;
use crate::policy::{HitPolicy, HitStatus, Outside};
use crate::regs::{Event, Reg, Register};
use crate::tables::rom::mantissa4;
use crate::tap::Tap;

const P: i64 = 30;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Policies.
    pub policy: HitPolicy,
    /// Port of x.
    pub x: Register,
    /// Port of R.
    pub direction: Register,
    inv_norm: Register,
    r: Register,
    look_up: look_up::Cfg,
    inv_radius: Register,
    length: Register,
    ratio: Register,
    halved: Register,
    inv_span: Register,
    quotient: Register,
    step: Register,
    step_from_radius: Register,
    d: Register,
    d_first: Register,
    l: Register,
    to: Register,
    /// Fraction bits that all ratios share inside.
    ratio_frac: i64,
    /// 1 − τ and 1 + τ at `tolerance_frac` bits.
    limits: [i64; 2],
    tolerance_frac: i64,
}

/// Rays behind their ports.
#[derive(Clone, Debug)]
pub struct In<'a, const N: usize> {
    /// Codes of x.
    pub x: &'a Lanes<N, 3>,
    /// Mantissas of R as it came.
    pub direction: &'a Lanes<N, 3>,
    /// Their fraction bits.
    pub direction_frac: &'a [i64; N],
}

/// Where the rays end.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// Codes of the ray parameter.
    pub d: [i64; N],
    /// Codes of l; of R where the ray escaped.
    pub l: Lanes<N, 3>,
    /// Codes of R.
    pub r: Lanes<N, 3>,
    /// Look-ups in the loop.
    pub iterations: [u32; N],
    /// How the search ended.
    pub status: [HitStatus; N],
    /// The last f of the loop, with the fraction bits of `hit.ratio`.
    pub ratio: [Option<i64>; N],
    /// Mantissas of the direction that ENV looks up.
    pub to: Lanes<N, 3>,
    /// Their fraction bits, in units of the map (of 1 where the ray escaped).
    pub to_frac: [i64; N],
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self {
            d: [0; N],
            l: [[0; N]; 3],
            r: [[0; N]; 3],
            iterations: [0; N],
            status: [HitStatus::MaxIterations; N],
            ratio: [None; N],
            to: [[0; N]; 3],
            to_frac: [0; N],
        }
    }
}

/// One lane's registers inside the loop.
#[derive(Clone, Copy, Debug)]
struct Ray {
    x: [i64; 3],
    r: [i64; 3],
    far: i64,
    d: i64,
    l: [i64; 3],
    /// (d, ratio) of the last undershoot and of the last overshoot.
    under: (i64, i64),
    over: (i64, i64),
    /// The valid bit of `over`.
    overshot: bool,
    /// Which side the last result of the loop was on: −1, 0 (none), 1.
    side: i64,
    done: bool,
    iterations: u32,
    status: HitStatus,
    ratio: Option<i64>,
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let b = |reg| bits(config, reg);
        let whole = |n: i64| u32::try_from(n.max(0)).unwrap_or(u32::MAX);
        fits(Reg::HitInvNorm, 2 * b(Reg::HitDirection) + 2)?;
        fits(Reg::HitR, b(Reg::HitDirection) + b(Reg::HitInvNorm))?;
        fits(Reg::HitLength, 2 * b(Reg::HitL).max(b(Reg::HitX)) + 2)?;
        fits(Reg::HitRatio, b(Reg::HitLength) + b(Reg::HitInvRadius))?;
        let ratio_frac = f(Reg::HitRatio).max(f(Reg::HitHalved));
        let ratio = whole(ratio_frac)
            + 1
            + config.format(Reg::HitRatio).int.max(config.format(Reg::HitHalved).int);
        fits(Reg::HitQuotient, ratio + b(Reg::HitInvSpan))?;
        fits(Reg::HitStep, b(Reg::HitD) + 1 + b(Reg::HitQuotient))?;
        fits(Reg::HitStep, b(Reg::HitRadius) + ratio)?;
        fits(Reg::HitD, b(Reg::HitRadius) + ratio)?;
        let sum = f(Reg::HitX).max(f(Reg::HitR) + f(Reg::HitD));
        let top = config
            .format(Reg::HitX)
            .int
            .max(config.format(Reg::HitR).int + config.format(Reg::HitD).int);
        fits(Reg::HitL, whole(sum) + top + 1)?;
        let common = f(Reg::HitD).max(f(Reg::HitStep));
        let top = config.format(Reg::HitD).int.max(config.format(Reg::HitStep).int);
        fits(Reg::HitD, whole(common) + top + 1)?;
        let tolerance = config.policy.hit.tolerance_bits.map_or(0, i64::from);
        let tolerance_frac = ratio_frac.max(tolerance);
        fits(Reg::HitRatio, ratio + whole(tolerance_frac - ratio_frac))?;
        let one = 1i64 << tolerance_frac;
        let tau = config.policy.hit.tolerance_bits.map_or(0, |bits| one >> bits);
        Ok(Self {
            policy: config.policy.hit,
            x: q(Reg::HitX, 0),
            direction: q(Reg::HitDirection, 0),
            inv_norm: q(Reg::HitInvNorm, 0),
            r: q(Reg::HitR, 0),
            look_up: look_up::Cfg::new(config)?,
            inv_radius: q(Reg::HitInvRadius, 0),
            length: q(Reg::HitLength, 0),
            ratio: q(Reg::HitRatio, 0),
            halved: q(Reg::HitHalved, ratio_frac + 1),
            inv_span: q(Reg::HitInvSpan, 0),
            quotient: q(Reg::HitQuotient, 0),
            step: q(Reg::HitStep, 0),
            step_from_radius: q(Reg::HitStep, f(Reg::HitRadius) + ratio_frac),
            d: q(Reg::HitD, common),
            d_first: q(Reg::HitD, f(Reg::HitRadius) + ratio_frac),
            l: q(Reg::HitL, sum),
            to: q(Reg::HitTo, 0),
            ratio_frac,
            limits: [one - tau, one + tau],
            tolerance_frac,
        })
    }

    /// Fraction bits of d.
    #[must_use]
    pub fn d_frac(&self) -> i64 {
        self.d.frac()
    }
}

/// The stage.
#[inline(always)]
pub fn hit<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    memory: &DistanceMemory,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let len = flags.len().min(N);
    let start = Ray {
        x: [0; 3],
        r: [0; 3],
        far: 0,
        d: 0,
        l: [0; 3],
        under: (0, 0),
        over: (0, 0),
        overshot: false,
        side: 0,
        done: false,
        iterations: 0,
        status: HitStatus::MaxIterations,
        ratio: None,
    };
    let mut rays = [start; N];
    for lane in 0..len {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        rays[lane].x = take(input.x, lane);
        let direction = take(input.direction, lane);
        begin(cfg, roms, memory, direction, input.direction_frac[lane], &mut rays[lane], &mut sink);
    }
    for k in 0..cfg.policy.iterations {
        if rays.iter().take(len).all(|ray| ray.done) {
            break;
        }
        for lane in 0..len {
            // The lane mask.
            if rays[lane].done {
                continue;
            }
            let flags = &mut flags[lane];
            let mut sink = Sink { lane, flags, tap };
            let index = usize::try_from(k).unwrap_or(0);
            iterate(cfg, roms, memory, &mut rays[lane], index, &mut sink);
        }
    }
    for lane in 0..len {
        let ray = &rays[lane];
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let escaped = ray.status == HitStatus::Escaped;
        let (v, v_frac, scale) =
            if escaped { (ray.r, cfg.r.frac(), 0) } else { (ray.l, cfg.l.frac(), memory.scale) };
        let to = sink.block(&cfg.to, &v, v_frac, scale);
        store(&mut out.to, lane, to.m);
        out.to_frac[lane] = to.frac;
        store(&mut out.l, lane, v);
        store(&mut out.r, lane, ray.r);
        out.d[lane] = ray.d;
        out.iterations[lane] = ray.iterations;
        out.status[lane] = ray.status;
        let lift = cfg.ratio_frac - cfg.ratio.frac();
        out.ratio[lane] = ray.ratio.map(|f| f >> lift);
    }
}

/// Everything before the loop: R, dist(R), p_un, the first d and l.
#[inline(always)]
fn begin<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    memory: &DistanceMemory,
    direction: [i64; 3],
    direction_frac: i64,
    ray: &mut Ray,
    sink: &mut Sink<'_, T>,
) {
    let scale = memory.scale;
    let none = direction == [0; 3];
    sink.flags.event(Event::HitNoDirection, none);
    let (v, v_frac) = if none { ([0, 0, 1 << 20], 20) } else { (direction, direction_frac) };
    let (m, e) = mantissa4(dot(v, v));
    let inv = sink.block(&cfg.inv_norm, &[roms.rsqrt.rsqrt(m)], P + e - v_frac, 0);
    for (i, c) in v.into_iter().enumerate() {
        let shift = v_frac + inv.frac - cfg.r.frac();
        ray.r[i] = sink.shift(&cfg.r, i, c * inv.m[0], shift, 0);
    }
    let far = cfg.look_up.read(roms, memory, ray.r, 0, 0, sink);
    ray.far = far.radius;
    let near = cfg.look_up.read(roms, memory, ray.x, 1, scale, sink);
    let length = cfg.length(roms, ray.x, cfg.x.frac(), 0, scale, sink);
    let p = if length == 0 {
        let frac = cfg.ratio.frac();
        sink.tap.put(sink.lane, Reg::HitRatio, 0, 0, frac);
        0
    } else {
        cfg.ratio(roms, length, near, 0, scale, sink)
    };
    ray.under = (0, p);
    let side = cfg.side(p);
    let stops = side == 0 || (side > 0 && cfg.policy.outside == Outside::Stop);
    let first = (ray.far * ((1 << cfg.ratio_frac) - p)).max(i64::MIN >> 2);
    if stops || far.infinite {
        ray.done = true;
        ray.status = match (stops, side) {
            (true, 0) => HitStatus::AtSurface,
            (true, _) => HitStatus::Outside,
            (false, _) => HitStatus::Escaped,
        };
        if !stops {
            return;
        }
        ray.d = sink.write(&cfg.d_first, 0, 0, scale);
    } else {
        ray.d = sink.write(&cfg.d_first, 0, first, scale);
    }
    ray.l = cfg.point(ray, 0, scale, sink);
}

/// One look-up of the loop and the step that follows from it.
#[inline(always)]
fn iterate<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    memory: &DistanceMemory,
    ray: &mut Ray,
    k: usize,
    sink: &mut Sink<'_, T>,
) {
    let scale = memory.scale;
    let reading = cfg.look_up.read(roms, memory, ray.l, k + 2, scale, sink);
    let l_frac = cfg.l.frac();
    let length = cfg.length(roms, ray.l, l_frac, k + 1, scale, sink);
    let f = cfg.ratio(roms, length, reading, k + 1, scale, sink);
    ray.iterations += 1;
    ray.ratio = Some(f);
    let side = cfg.side(f);
    if side == 0 {
        ray.done = true;
        ray.status = HitStatus::Converged;
        return;
    }
    let moved = step::step(cfg, roms, ray, f, side, k, scale, sink);
    let lift_d = cfg.d.frac_in - cfg.d.frac();
    let lift_step = cfg.d.frac_in - cfg.step.frac();
    let sum = (ray.d << lift_d) + (moved.unwrap_or(0) << lift_step);
    let next = if moved.is_some_and(|step| step != 0) {
        sink.write(&cfg.d, k + 1, sum, scale)
    } else {
        ray.d
    };
    if next == ray.d {
        ray.done = true;
        ray.status = HitStatus::Stalled;
        return;
    }
    ray.d = next;
    ray.l = cfg.point(ray, k + 1, scale, sink);
}

//! `local_frame`: tangent vectors e1, e2 of the surface (Schilling, appendix A).
//!
//! e1 = (h × n)/|h × n| · |n|, e2 = (n × e1)/|n| = (n × ĉ) with c = h × n. h ∥ n: the cross product
//! with the axis of n's smallest component (ties z, y, x), event `local_frame.parallel`.

use core::array;

use super::{Lanes, Roms, bits, block_frac, fits, store, take};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::lanes::{LaneSink, Shift, dot, each, fill, mantissa4, mul};
use crate::regs::{Event, Reg, Register};
use crate::tables::rom::PORT_FRAC;
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Port of n.
    pub n: Register,
    /// Port of h.
    pub h: Register,
    cross: Register,
    inv_length: Register,
    length: Register,
    scale: Register,
    e1: Register,
    n_cross: Register,
    e2: Register,
    n_frac: i64,
    h_frac: i64,
    c_frac: i64,
}

/// Normalised n and h; `n_exp`, `h_exp` are the powers of two that were taken out.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Mantissas of n.
    pub n: &'a Lanes<N, 3>,
    /// n = nominal · 2^n_exp.
    pub n_exp: &'a [i64; N],
    /// Mantissas of h.
    pub h: &'a Lanes<N, 3>,
    /// h = nominal · 2^h_exp.
    pub h_exp: &'a [i64; N],
}

/// The tangent vectors in n's nominal scale.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// e1.
    pub e1: Lanes<N, 3>,
    /// e2.
    pub e2: Lanes<N, 3>,
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { e1: [[0; N]; 3], e2: [[0; N]; 3] }
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let q = |reg| config.register(reg, 0);
        let (n, h, c) =
            (bits(config, Reg::FrameN), bits(config, Reg::FrameH), bits(config, Reg::FrameCross));
        fits(Reg::FrameCross, n + h + 2)?;
        fits(Reg::FrameInvLength, 2 * c + 2)?;
        fits(Reg::FrameLength, 2 * n + 2)?;
        let length = bits(config, Reg::FrameLength);
        fits(Reg::FrameScale, length + bits(config, Reg::FrameInvLength))?;
        fits(Reg::FrameE1, c + bits(config, Reg::FrameScale))?;
        fits(Reg::FrameNCross, n + c + 2)?;
        fits(Reg::FrameE2, bits(config, Reg::FrameNCross) + bits(config, Reg::FrameInvLength))?;
        let n_frac = block_frac(config, Reg::FrameN);
        let c_frac = block_frac(config, Reg::FrameCross);
        Ok(Self {
            n: q(Reg::FrameN),
            h: q(Reg::FrameH),
            cross: q(Reg::FrameCross),
            inv_length: q(Reg::FrameInvLength),
            length: q(Reg::FrameLength),
            scale: q(Reg::FrameScale),
            e1: q(Reg::FrameE1),
            n_cross: config.register(Reg::FrameNCross, n_frac + c_frac),
            e2: q(Reg::FrameE2),
            n_frac,
            h_frac: block_frac(config, Reg::FrameH),
            c_frac,
        })
    }
}

/// The axis of the smallest component crossed with n.
#[inline(always)]
fn any_tangent([x, y, z]: [i64; 3]) -> [i64; 3] {
    let [ax, ay, az] = [x.abs(), y.abs(), z.abs()];
    if az <= ax && az <= ay {
        [-y, x, 0]
    } else if ay <= ax {
        [z, 0, -x]
    } else {
        [0, -z, y]
    }
}

/// The stage.
#[inline(always)]
pub fn local_frame<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let port = i64::from(PORT_FRAC);
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let n = input.n;
    let n_exp = |i: usize| input.n_exp[i];

    let mut c = [[0; N]; 3];
    cross_lanes::<N, T>(lanes, input.h, n, &mut c);
    let mut parallel = [false; N];
    for i in 0..lanes.min(N) {
        parallel[i] = (c[0][i] | c[1][i] | c[2][i]) == 0;
    }
    if parallel.contains(&true) {
        for (i, parallel) in parallel.iter().enumerate().take(lanes) {
            if *parallel {
                store(&mut c, i, any_tangent(take(n, i)));
            }
        }
    }
    sink.event(Event::FrameParallel, &parallel);
    // Without h in it the product has n's scale.
    let of_h = |i: usize| i64::from(!parallel[i]);
    let exact_frac = |i: usize| cfg.n_frac + of_h(i) * cfg.h_frac;
    let exact_exp: [i64; N] = each(lanes, |i| n_exp(i) + of_h(i) * input.h_exp[i]);
    let (exact, mut c, mut c_frac) = (c, [[0; N]; 3], [0; N]);
    let block = (&mut c, &mut c_frac);
    sink.block(&cfg.cross, &exact, exact_frac, |i| exact_exp[i], block);
    // From here on c's mantissas count as a vector with its largest component in [1, 2).
    let c_exp: [i64; N] = each(lanes, |i| exact_exp[i] + cfg.c_frac - c_frac[i]);

    let [mut square, mut m, mut q, mut root] = [[0; N]; 4];
    fill(lanes, &mut square, |i| dot::<T>(take(&c, i), take(&c, i)).max(1));
    mantissa4(lanes, |i| square[i], &mut m, &mut q);
    roms.rsqrt.rsqrt_lanes::<N, T>(lanes, &m, &mut root);
    let (mut inv, mut inv_frac) = ([0; N], [0; N]);
    sink.block(
        &cfg.inv_length,
        array::from_ref(&root),
        |i| port + q[i] - cfg.c_frac,
        |i| -c_exp[i],
        (array::from_mut(&mut inv), &mut inv_frac),
    );
    fill(lanes, &mut square, |i| dot::<T>(take(n, i), take(n, i)).max(1));
    mantissa4(lanes, |i| square[i], &mut m, &mut q);
    roms.sqrt.sqrt_lanes::<N, T>(lanes, &m, &roms.rsqrt, &mut root);
    let length_frac = cfg.length.frac();
    let shift = Shift::new(lanes, &cfg.length, |i| port + cfg.n_frac - q[i] - length_frac);
    let mut length = [0; N];
    sink.shift(&cfg.length, 0, &shift, |i| root[i], n_exp, &mut length);
    let (mut scale, mut scale_frac) = ([0; N], [0; N]);
    sink.block(
        &cfg.scale,
        &[each(lanes, |i| mul::<T>(length[i], inv[i]))],
        |i| length_frac + inv_frac[i],
        |i| n_exp(i) - c_exp[i],
        (array::from_mut(&mut scale), &mut scale_frac),
    );
    let fixed = cfg.c_frac - cfg.e1.frac();
    let shift = Shift::new(lanes, &cfg.e1, |i| fixed + scale_frac[i]);
    for (k, c) in c.iter().enumerate() {
        let product = |i: usize| mul::<T>(c[i], scale[i]);
        sink.shift(&cfg.e1, k, &shift, product, n_exp, &mut out.e1[k]);
    }
    let mut n_cross = exact;
    cross_lanes::<N, T>(lanes, n, &c, &mut n_cross);
    let fixed = cfg.n_cross.frac() - cfg.e2.frac();
    let shift = Shift::new(lanes, &cfg.e2, |i| fixed + inv_frac[i]);
    for (k, n_cross) in n_cross.iter().enumerate() {
        let exp = |i: usize| n_exp(i) + c_exp[i];
        let mut x = [0; N];
        sink.write(&cfg.n_cross, k, |i| n_cross[i], exp, &mut x);
        let product = |i: usize| mul::<T>(x[i], inv[i]);
        sink.shift(&cfg.e2, k, &shift, product, n_exp, &mut out.e2[k]);
    }
}

/// a × b of every lane.
#[inline(always)]
fn cross_lanes<const N: usize, T: Tap>(
    lanes: usize,
    a: &Lanes<N, 3>,
    b: &Lanes<N, 3>,
    out: &mut Lanes<N, 3>,
) {
    for (k, out) in out.iter_mut().enumerate() {
        let (p, q) = ((k + 1) % 3, (k + 2) % 3);
        fill(lanes, out, |i| mul::<T>(a[p][i], b[q][i]) - mul::<T>(a[q][i], b[p][i]));
    }
}

//! `local_frame`: tangent vectors e1, e2 of the surface (Schilling, appendix A).
//!
//! e1 = (h × n)/|h × n| · |n|, e2 = (n × e1)/|n| = (n × ĉ) with c = h × n. h ∥ n: the cross product
//! with the axis of n's smallest component (ties z, y, x), event `local_frame.parallel`.

use super::{Lanes, Roms, Sink, bits, block_frac, cross, dot, fits, store, take};
use crate::config::{Config, ConfigError};
use crate::fx::{Flags, Quantizer};
use crate::regs::{Event, Reg};
use crate::tables::rom::{PORT_FRAC, mantissa4};
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug)]
pub struct Cfg {
    /// Port of n.
    pub n: Quantizer,
    /// Port of h.
    pub h: Quantizer,
    cross: Quantizer,
    inv_length: Quantizer,
    length: Quantizer,
    scale: Quantizer,
    e1: Quantizer,
    n_cross: Quantizer,
    e2: Quantizer,
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
        Self {
            e1: [[0; N]; 3],
            e2: [[0; N]; 3],
        }
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let q = |reg| Quantizer::new(config.format(reg), 0);
        let (n, h, c) = (
            bits(config, Reg::FrameN),
            bits(config, Reg::FrameH),
            bits(config, Reg::FrameCross),
        );
        fits(Reg::FrameCross, n + h + 2)?;
        fits(Reg::FrameInvLength, 2 * c + 2)?;
        fits(Reg::FrameLength, 2 * n + 2)?;
        let length = bits(config, Reg::FrameLength);
        fits(Reg::FrameScale, length + bits(config, Reg::FrameInvLength))?;
        fits(Reg::FrameE1, c + bits(config, Reg::FrameScale))?;
        fits(Reg::FrameNCross, n + c + 2)?;
        fits(
            Reg::FrameE2,
            bits(config, Reg::FrameNCross) + bits(config, Reg::FrameInvLength),
        )?;
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
            n_cross: Quantizer::new(config.format(Reg::FrameNCross), n_frac + c_frac),
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
    for lane in 0..flags.len().min(N) {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let n = take(input.n, lane);
        let h = take(input.h, lane);
        let (n_exp, h_exp) = (input.n_exp[lane], input.h_exp[lane]);

        let mut c = cross(h, n);
        let mut c_exp = n_exp + h_exp;
        let mut exact_frac = cfg.n_frac + cfg.h_frac;
        let parallel = c == [0; 3];
        if parallel {
            c = any_tangent(n);
            exact_frac = cfg.n_frac;
            c_exp = n_exp;
        }
        sink.flags.event(Event::FrameParallel, parallel);
        let c = sink.block(&cfg.cross, Reg::FrameCross, &c, exact_frac, c_exp);
        // From here on c's mantissas count as a vector with its largest component in [1, 2).
        c_exp += cfg.c_frac - c.frac;

        let (m, q) = mantissa4(dot(c.m, c.m).max(1));
        let inv_frac = port + q - cfg.c_frac;
        let inv = sink.block(
            &cfg.inv_length,
            Reg::FrameInvLength,
            &[roms.rsqrt.rsqrt(m)],
            inv_frac,
            -c_exp,
        );
        let (m, q) = mantissa4(dot(n, n).max(1));
        let length = sink.shift(
            &cfg.length,
            Reg::FrameLength,
            0,
            roms.sqrt.sqrt(m, &roms.rsqrt),
            port + cfg.n_frac - q - i64::from(cfg.length.format.frac),
            n_exp,
        );
        let length_frac = i64::from(cfg.length.format.frac);
        let scale = sink.block(
            &cfg.scale,
            Reg::FrameScale,
            &[length * inv.m[0]],
            length_frac + inv.frac,
            n_exp - c_exp,
        );
        let e_shift = cfg.c_frac + scale.frac - i64::from(cfg.e1.format.frac);
        let mut e1 = [0; 3];
        for (i, e) in e1.iter_mut().enumerate() {
            *e = sink.shift(
                &cfg.e1,
                Reg::FrameE1,
                i,
                c.m[i] * scale.m[0],
                e_shift,
                n_exp,
            );
        }
        let n_cross = cross(n, c.m);
        let e_shift = i64::from(cfg.n_cross.format.frac) + inv.frac - i64::from(cfg.e2.format.frac);
        let mut e2 = [0; 3];
        for (i, e) in e2.iter_mut().enumerate() {
            let x = sink.write(&cfg.n_cross, Reg::FrameNCross, i, n_cross[i], n_exp + c_exp);
            *e = sink.shift(&cfg.e2, Reg::FrameE2, i, x * inv.m[0], e_shift, n_exp);
        }
        store(&mut out.e1, lane, e1);
        store(&mut out.e2, lane, e2);
    }
}

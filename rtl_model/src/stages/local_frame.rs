//! `local_frame`: tangent vectors e1, e2 of the surface (Schilling, appendix A).
//!
//! e1 = (h × n)/|h × n| · |n|, e2 = (n × e1)/|n| = (n × ĉ) with c = h × n. h ∥ n: the cross product
//! with the axis of n's smallest component (ties z, y, x), event `local_frame.parallel`.

use lanes::{Mask as _, Vector};

use super::{Roms, bits, block_frac, cross, dot, fits};
use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::regs::{Event, Reg, Register};
use crate::tables::rom::{PORT_FRAC, mantissa4};
use crate::unit::Inputs;

/// The stage.
#[inline(always)]
pub fn local_frame<V: Vector>(
    cfg: &Cfg,
    roms: &Roms,
    port: &Inputs<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let (n, n_exp) = (port.n, port.n_exp);
    let one = n_exp.like(1);
    let mut exact = cross(port.h, n);
    let parallel = (exact[0] | exact[1] | exact[2]).zero();
    let (mut exact_frac, mut exact_exp) = (one.like(cfg.n_frac + cfg.h_frac), n_exp + port.h_exp);
    if sink.event(Event::FrameParallel, parallel) {
        // Without h in it the product has n's scale.
        exact_frac = parallel.select(one.like(cfg.n_frac), exact_frac);
        exact_exp = parallel.select(n_exp, exact_exp);
        let any = any_tangent(n);
        for c in 0..3 {
            exact[c] = parallel.select(any[c], exact[c]);
        }
    }
    let (c, c_frac) = sink.normal(&cfg.cross, &exact, exact_frac, exact_exp);
    // From here on c's mantissas count as a vector with its largest component in [1, 2).
    let c_exp = exact_exp.plus(cfg.c_frac) - c_frac;

    let (m, q) = mantissa4(dot(c, c).larger(one));
    let inv_frac = q.plus(PORT_FRAC.into()).plus(-cfg.c_frac);
    let ([inv], inv_frac) = sink.normal(&cfg.inv_length, &[roms.rsqrt.rsqrt(m)], inv_frac, -c_exp);
    let (m, q) = mantissa4(dot(n, n).larger(one));
    let root = roms.sqrt.sqrt(m, &roms.rsqrt);
    let length_frac = cfg.length.frac();
    let shift = one.like(i64::from(PORT_FRAC) + cfg.n_frac - length_frac) - q;
    let length = sink.shifted(&cfg.length, 0, root, shift, n_exp);
    let ([scale], scale_frac) =
        sink.normal(&cfg.scale, &[length.mul(inv)], inv_frac.plus(length_frac), n_exp - c_exp);
    let mut e1 = c;
    let shift = scale_frac.plus(cfg.c_frac - cfg.e1.frac());
    for (k, e1) in e1.iter_mut().enumerate() {
        *e1 = sink.shifted(&cfg.e1, k, e1.mul(scale), shift, n_exp);
    }
    let mut e2 = cross(n, c);
    let shift = inv_frac.plus(cfg.n_cross.frac() - cfg.e2.frac());
    for (k, e2) in e2.iter_mut().enumerate() {
        let x = sink.put(&cfg.n_cross, k, *e2, n_exp + c_exp);
        *e2 = sink.shifted(&cfg.e2, k, x.mul(inv), shift, n_exp);
    }
    Out { e1, e2 }
}

/// The axis of the smallest component crossed with n.
#[inline(always)]
fn any_tangent<V: Vector>([x, y, z]: [V; 3]) -> [V; 3] {
    let ([ax, ay, az], zero) = ([x.abs(), y.abs(), z.abs()], x.like(0));
    let (of_z, of_y) = (!az.gt(ax) & !az.gt(ay), !ay.gt(ax));
    [
        of_z.select(-y, of_y.select(z, zero)),
        of_z.select(x, of_y.select(zero, -z)),
        of_z.select(zero, of_y.select(-x, y)),
    ]
}

in_lanes! {
    /// The tangent vectors in n's nominal scale.
    pub struct Out<V> {
        /// e1.
        pub e1: [V; 3],
        /// e2.
        pub e2: [V; 3],
    }
}

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

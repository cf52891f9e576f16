//! The derivative of the modified normal, by the policy `jacobian.dnmod`.
//!
//! `paper`: ∂n. `normal`: ∂n⊥ = ∂n − n⟨n,∂n⟩/⟨n,n⟩ of the interpolated normal. `frame`: the frame
//! (n, e1, e2) turns as a rigid body with p = ⟨∂n⊥,e1⟩/⟨n,n⟩, q = ⟨∂n⊥,e2⟩/⟨n,n⟩ and, because
//! e1 stays perpendicular to h, ω = p·⟨n,h⟩/⟨e2,h⟩: ∂e1 = −p n + ω e2, ∂e2 = −q n − ω e1.

use crate::config::{Config, ConfigError};
use crate::fx::{Flags, Quantizer};
use crate::policy::Dnmod;
use crate::regs::Reg;
use crate::stages::{Lanes, Roms, Sink, bits, block_frac, dot, fits, frac, int, store, take};
use crate::tables::rom::{PORT_FRAC, mantissa};
use crate::tap::Tap;

const P: i64 = 30;

/// Compiled configuration.
#[derive(Clone, Debug)]
pub struct Cfg {
    /// Ports of ∂n/∂x and ∂n/∂y.
    pub dn: [Quantizer; 2],
    dnmod: Dnmod,
    n_frac: i64,
    dn_dot: [Quantizer; 2],
    inv_nn: Quantizer,
    along: Quantizer,
    lift_dn: [i64; 2],
    lift_along: [i64; 2],
    dn_perp: [Quantizer; 2],
    perp_dot_e: [Quantizer; 2],
    tilt: Quantizer,
    turn: [Quantizer; 2],
    cot_frac: i64,
    de: [Quantizer; 2],
    de_lift: [[i64; 2]; 2],
    b_lift: [i64; 2],
    dn_mod: [Quantizer; 3],
}

/// What the stage reads.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// ∂n/∂x then ∂n/∂y, shifted with n.
    pub dn: &'a Lanes<N, 6>,
    /// Power of two of n.
    pub n_exp: &'a [i64; N],
    /// n_mod = nominal · 2^(n_exp + n_lift).
    pub n_lift: &'a [i64; N],
    /// The frame and the bump; `None` without a bump.
    pub bumped: Option<Bumped<'a, N>>,
}

/// The local frame and the offsets.
#[derive(Clone, Copy, Debug)]
pub struct Bumped<'a, const N: usize> {
    /// Mantissas of the interpolated normal.
    pub n: &'a Lanes<N, 3>,
    /// Mantissas of h.
    pub h: &'a Lanes<N, 3>,
    /// e1.
    pub e1: &'a Lanes<N, 3>,
    /// e2.
    pub e2: &'a Lanes<N, 3>,
    /// b1, b2.
    pub b: &'a Lanes<N, 2>,
}

impl Cfg {
    /// Compiles and checks the step. `bumped` says whether the scene has a bump.
    pub fn new(config: &Config, bumped: bool) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let w = |reg| bits(config, reg);
        let q = |reg, frac_in| Quantizer::new(config.format(reg), frac_in);
        let n_frac = block_frac(config, Reg::FrameN);
        let dn_regs = [Reg::JacDnDx, Reg::JacDnDy];
        let e_regs = [Reg::FrameE1, Reg::FrameE2];
        let wide = |bits: i64| u32::try_from(bits).unwrap_or(u32::MAX);
        let common = dn_regs.map(|reg| f(reg).max(n_frac + f(Reg::JacAlong)));
        let tilt = n_frac + f(Reg::JacTilt);
        // ∂e1 uses e2 and ∂e2 uses e1.
        let de_common = [1, 0].map(|k: usize| tilt.max(f(Reg::JacTurn) + frac(config, e_regs[k])));
        let b_common = f(Reg::JacDnPerp).max(f(Reg::BumpB) + f(Reg::JacDe));
        if bumped && config.dnmod != Dnmod::Paper {
            for (reg, common) in dn_regs.into_iter().zip(common) {
                fits(Reg::JacNIdotDn, w(Reg::FrameN) + w(reg) + 2)?;
                let whole = int(config, reg).max(1 + int(config, Reg::JacAlong)) + 1;
                fits(Reg::JacDnPerp, wide(common) + whole)?;
            }
            fits(Reg::JacInvNn, 2 * w(Reg::FrameN) + 2)?;
            fits(Reg::JacAlong, w(Reg::JacNIdotDn) + w(Reg::JacInvNn))?;
        }
        if bumped && config.dnmod == Dnmod::Frame {
            fits(
                Reg::JacPerpDotE,
                w(Reg::JacDnPerp) + w(Reg::FrameE1).max(w(Reg::FrameE2)) + 2,
            )?;
            fits(Reg::JacTilt, w(Reg::JacPerpDotE) + w(Reg::JacInvNn))?;
            fits(Reg::JacTurn, w(Reg::JacTilt) + w(Reg::JacTurn))?;
            fits(Reg::JacTurn, w(Reg::FrameE2) + w(Reg::FrameH) + 2)?;
            let e_int = int(config, Reg::FrameE1).max(int(config, Reg::FrameE2));
            let whole = (1 + int(config, Reg::JacTilt)).max(int(config, Reg::JacTurn) + e_int) + 1;
            fits(Reg::JacDe, wide(de_common[0].max(de_common[1])) + whole)?;
            let whole = int(config, Reg::JacDnPerp)
                .max(int(config, Reg::BumpB) + int(config, Reg::JacDe))
                + 2;
            fits(Reg::JacDnMod, wide(b_common) + whole)?;
        }
        Ok(Self {
            dn: dn_regs.map(|reg| q(reg, 0)),
            dnmod: config.dnmod,
            n_frac,
            dn_dot: dn_regs.map(|reg| q(Reg::JacNIdotDn, n_frac + f(reg))),
            inv_nn: q(Reg::JacInvNn, 0),
            along: q(Reg::JacAlong, f(Reg::JacNIdotDn) + f(Reg::JacInvNn)),
            lift_dn: [0, 1].map(|i: usize| common[i] - frac(config, dn_regs[i])),
            lift_along: common.map(|c| c - n_frac - f(Reg::JacAlong)),
            dn_perp: common.map(|c| q(Reg::JacDnPerp, c)),
            perp_dot_e: e_regs.map(|reg| q(Reg::JacPerpDotE, f(Reg::JacDnPerp) + f(reg))),
            tilt: q(Reg::JacTilt, f(Reg::JacPerpDotE) + f(Reg::JacInvNn)),
            turn: [
                q(Reg::JacTurn, 0),
                q(Reg::JacTurn, f(Reg::JacTilt) + f(Reg::JacTurn)),
            ],
            cot_frac: block_frac(config, Reg::FrameN) - f(Reg::FrameE2),
            de: de_common.map(|c| q(Reg::JacDe, c)),
            de_lift: [0, 1].map(|k: usize| {
                [
                    de_common[k] - tilt,
                    de_common[k] - f(Reg::JacTurn) - frac(config, e_regs[1 - k]),
                ]
            }),
            b_lift: [
                b_common - f(Reg::JacDnPerp),
                b_common - f(Reg::BumpB) - f(Reg::JacDe),
            ],
            dn_mod: [
                q(Reg::JacDnMod, f(Reg::JacDnDx)),
                q(Reg::JacDnMod, f(Reg::JacDnDy)),
                q(Reg::JacDnMod, b_common),
            ],
        })
    }

    #[inline(always)]
    fn perpendicular<T: Tap>(
        &self,
        sink: &mut Sink<'_, T>,
        col: usize,
        n: [i64; 3],
        dn: [i64; 3],
        inv_nn: i64,
        exp: i64,
    ) -> [i64; 3] {
        let along = sink.write(&self.dn_dot[col], Reg::JacNIdotDn, col, dot(n, dn), 2 * exp);
        let along = sink.write(&self.along, Reg::JacAlong, col, along * inv_nn, 0);
        let mut out = [0; 3];
        for i in 0..3 {
            let sum = (dn[i] << self.lift_dn[col]) - ((n[i] * along) << self.lift_along[col]);
            out[i] = sink.write(&self.dn_perp[col], Reg::JacDnPerp, 3 * col + i, sum, exp);
        }
        out
    }

    /// ⟨n,h⟩/⟨e2,h⟩; 0 where e2 ⟂ h, which only a parallel frame has.
    #[inline(always)]
    fn cotangent<T: Tap>(&self, sink: &mut Sink<'_, T>, roms: &Roms, n_h: i64, e2_h: i64) -> i64 {
        let (m, e) = mantissa(e2_h.abs().max(1));
        let y = if e2_h == 0 { 0 } else { roms.recip.recip(m) };
        let (k, e_k) = mantissa(n_h.abs().max(1));
        let k = if n_h == 0 { 0 } else { k };
        let product = if (n_h < 0) == (e2_h < 0) {
            k * y
        } else {
            -(k * y)
        };
        // k·2^(e_k − 30 − n_frac) · y·2^(−30 − e + e2_frac), h's fraction bits cancel.
        let shift = 2 * P - e_k + e + self.cot_frac - i64::from(self.turn[0].format.frac);
        sink.shift(&self.turn[0], Reg::JacTurn, 0, product, shift, 0)
    }
}

/// The step: ∂n_mod in n_mod's nominal scale.
#[inline(always)]
pub fn normal<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: In<'_, N>,
    dn_mod: &mut Lanes<N, 6>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let mod_frac = i64::from(cfg.dn_mod[0].format.frac);
    for lane in 0..flags.len().min(N) {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let dn = take(input.dn, lane);
        let dn = [[dn[0], dn[1], dn[2]], [dn[3], dn[4], dn[5]]];
        let n_exp = input.n_exp[lane];
        let lift = input.n_lift[lane];
        let exp = n_exp + lift;
        let mut out = [0; 6];
        match (&input.bumped, cfg.dnmod) {
            (None, _) | (_, Dnmod::Paper) => {
                for (col, dn) in dn.iter().enumerate() {
                    for i in 0..3 {
                        let shift = cfg.dn_mod[col].frac_in - mod_frac + lift;
                        out[3 * col + i] = sink.shift(
                            &cfg.dn_mod[col],
                            Reg::JacDnMod,
                            3 * col + i,
                            dn[i],
                            shift,
                            exp,
                        );
                    }
                }
            }
            (Some(frame), policy) => {
                let n = take(frame.n, lane);
                let (m, e) = mantissa(dot(n, n).max(1));
                let inv_shift =
                    i64::from(PORT_FRAC) + e - 2 * cfg.n_frac - i64::from(cfg.inv_nn.format.frac);
                let inv_nn = sink.shift(
                    &cfg.inv_nn,
                    Reg::JacInvNn,
                    0,
                    roms.recip.recip(m),
                    inv_shift,
                    -2 * n_exp,
                );
                let perp =
                    [0, 1].map(|col| cfg.perpendicular(&mut sink, col, n, dn[col], inv_nn, n_exp));
                if policy == Dnmod::Normal {
                    let perp_frac = i64::from(cfg.dn_perp[0].format.frac);
                    for (c, x) in perp.into_iter().flatten().enumerate() {
                        let shift = perp_frac - mod_frac + lift;
                        out[c] = sink.shift(&cfg.dn_mod[2], Reg::JacDnMod, c, x, shift, exp);
                    }
                } else {
                    let h = take(frame.h, lane);
                    let e = [take(frame.e1, lane), take(frame.e2, lane)];
                    let b = take(frame.b, lane);
                    let cot = cfg.cotangent(&mut sink, roms, dot(n, h), dot(e[1], h));
                    for (col, perp) in perp.into_iter().enumerate() {
                        let mut tilt = [0; 2];
                        for k in 0..2 {
                            let c = 2 * col + k;
                            let along = sink.write(
                                &cfg.perp_dot_e[k],
                                Reg::JacPerpDotE,
                                c,
                                dot(perp, e[k]),
                                2 * n_exp,
                            );
                            tilt[k] = sink.write(&cfg.tilt, Reg::JacTilt, c, along * inv_nn, 0);
                        }
                        let turn =
                            sink.write(&cfg.turn[1], Reg::JacTurn, 1 + col, tilt[0] * cot, 0);
                        for i in 0..3 {
                            let mut sum = perp[i] << cfg.b_lift[0];
                            for k in 0..2 {
                                let spin = if k == 0 {
                                    turn * e[1][i]
                                } else {
                                    -(turn * e[0][i])
                                };
                                let de = (spin << cfg.de_lift[k][1])
                                    - ((tilt[k] * n[i]) << cfg.de_lift[k][0]);
                                let c = 6 * col + 3 * k + i;
                                let de = sink.write(&cfg.de[k], Reg::JacDe, c, de, n_exp);
                                sum += (b[k] * de) << cfg.b_lift[1];
                            }
                            let shift = cfg.dn_mod[2].frac_in - mod_frac + lift;
                            let c = 3 * col + i;
                            out[c] = sink.shift(&cfg.dn_mod[2], Reg::JacDnMod, c, sum, shift, exp);
                        }
                    }
                }
            }
        }
        store(dn_mod, lane, out);
    }
}

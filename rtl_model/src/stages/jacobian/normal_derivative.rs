//! The derivative of the modified normal, by the policy `jacobian.dnmod`.
//!
//! `paper`: ∂n. `normal`: ∂n⊥ = ∂n − n⟨n,∂n⟩/⟨n,n⟩ of the interpolated normal. `frame`: the frame
//! (n, e1, e2) turns as a rigid body with p = ⟨∂n⊥,e1⟩/⟨n,n⟩, q = ⟨∂n⊥,e2⟩/⟨n,n⟩ and, because
//! e1 stays perpendicular to h, ω = p·⟨n,h⟩/⟨e2,h⟩: ∂e1 = −p n + ω e2, ∂e2 = −q n − ω e1.

use lanes::{Mask as _, Vector};

use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::policy::Dnmod;
use crate::regs::{Reg, Register};
use crate::stages::{Roms, bits, block_frac, column, dot, fits, frac, int, local_frame};
use crate::tables::rom::{PORT_FRAC, mantissa};
use crate::unit::Inputs;

/// The step: ∂n_mod in n_mod's nominal scale. `frame` is there with a bump.
#[inline(always)]
pub fn normal_derivative<V: Vector>(
    cfg: &Cfg,
    roms: &Roms,
    port: &Inputs<V>,
    lift: V,
    frame: Option<&local_frame::Out<V>>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let mod_frac = cfg.dn_mod[0].frac();
    let mut dn_mod = port.dn;
    let exp = port.n_exp + lift;
    let Some(frame) = frame.filter(|_| cfg.dnmod != Dnmod::Paper) else {
        for (c, dn) in dn_mod.iter_mut().enumerate() {
            let q = &cfg.dn_mod[c / 3];
            *dn = sink.shift_either(q, c, *dn, lift.plus(q.frac_in - mod_frac), exp);
        }
        return Out { dn_mod };
    };
    let (n, none) = (port.n, exp.like(0));
    let (m, e) = mantissa(dot(n, n).larger(none.like(1)));
    let fixed = i64::from(PORT_FRAC) - 2 * cfg.n_frac - cfg.inv_nn.frac();
    let inv_exp = -port.n_exp.up(1);
    let inv_nn = sink.shifted(&cfg.inv_nn, 0, roms.recip.recip(m), e.plus(fixed), inv_exp);
    let turns = cfg.dnmod == Dnmod::Frame;
    let mut perp = [n; 2];
    for col in 0..2 {
        perp[col] = cfg.perpendicular(sink, col, port, inv_nn);
    }
    if turns {
        let cot = cfg.cotangent(sink, roms, dot(n, port.h), dot(frame.e2, port.h));
        for col in 0..2 {
            perp[col] = cfg.turned(sink, col, (port, frame), perp[col], [inv_nn, cot]);
        }
    }
    let q = &cfg.dn_mod[2];
    let exact_frac = if turns { q.frac_in } else { cfg.dn_perp[0].frac() };
    for c in 0..6 {
        let right = lift.plus(exact_frac - mod_frac);
        dn_mod[c] = sink.shift_either(q, c, perp[c / 3][c % 3], right, exp);
    }
    Out { dn_mod }
}

in_lanes! {
    /// The derivative of the modified normal.
    pub struct Out<V> {
        /// ∂n_mod/∂x then ∂n_mod/∂y, shifted with n_mod.
        pub dn_mod: [V; 6],
    }
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Ports of ∂n/∂x and ∂n/∂y.
    pub dn: [Register; 2],
    dnmod: Dnmod,
    n_frac: i64,
    dn_dot: [Register; 2],
    inv_nn: Register,
    along: Register,
    lift_dn: [i64; 2],
    lift_along: [i64; 2],
    dn_perp: [Register; 2],
    perp_dot_e: [Register; 2],
    tilt: Register,
    turn: [Register; 2],
    cot_frac: i64,
    de: [Register; 2],
    de_lift: [[i64; 2]; 2],
    b_lift: [i64; 2],
    dn_mod: [Register; 3],
}

impl Cfg {
    /// Compiles and checks the step. `bumped` says whether the scene has a bump.
    pub fn new(config: &Config, bumped: bool) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let w = |reg| bits(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let n_frac = block_frac(config, Reg::FrameN);
        let dn_regs = [Reg::JacDnDx, Reg::JacDnDy];
        let e_regs = [Reg::FrameE1, Reg::FrameE2];
        let wide = |bits: i64| u32::try_from(bits).unwrap_or(u32::MAX);
        let common = dn_regs.map(|reg| f(reg).max(n_frac + f(Reg::JacAlong)));
        let tilt = n_frac + f(Reg::JacTilt);
        // ∂e1 uses e2 and ∂e2 uses e1.
        let de_common = [1, 0].map(|k: usize| tilt.max(f(Reg::JacTurn) + frac(config, e_regs[k])));
        let b_common = f(Reg::JacDnPerp).max(f(Reg::BumpB) + f(Reg::JacDe));
        if bumped && config.policy.jacobian.dnmod != Dnmod::Paper {
            for (reg, common) in dn_regs.into_iter().zip(common) {
                fits(Reg::JacNIdotDn, w(Reg::FrameN) + w(reg) + 2)?;
                let whole = int(config, reg).max(1 + int(config, Reg::JacAlong)) + 1;
                fits(Reg::JacDnPerp, wide(common) + whole)?;
            }
            fits(Reg::JacInvNn, 2 * w(Reg::FrameN) + 2)?;
            fits(Reg::JacAlong, w(Reg::JacNIdotDn) + w(Reg::JacInvNn))?;
        }
        if bumped && config.policy.jacobian.dnmod == Dnmod::Frame {
            fits(Reg::JacPerpDotE, w(Reg::JacDnPerp) + w(Reg::FrameE1).max(w(Reg::FrameE2)) + 2)?;
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
            dnmod: config.policy.jacobian.dnmod,
            n_frac,
            dn_dot: dn_regs.map(|reg| q(Reg::JacNIdotDn, n_frac + f(reg))),
            inv_nn: q(Reg::JacInvNn, 0),
            along: q(Reg::JacAlong, f(Reg::JacNIdotDn) + f(Reg::JacInvNn)),
            lift_dn: [0, 1].map(|i: usize| common[i] - frac(config, dn_regs[i])),
            lift_along: common.map(|c| c - n_frac - f(Reg::JacAlong)),
            dn_perp: common.map(|c| q(Reg::JacDnPerp, c)),
            perp_dot_e: e_regs.map(|reg| q(Reg::JacPerpDotE, f(Reg::JacDnPerp) + f(reg))),
            tilt: q(Reg::JacTilt, f(Reg::JacPerpDotE) + f(Reg::JacInvNn)),
            turn: [q(Reg::JacTurn, 0), q(Reg::JacTurn, f(Reg::JacTilt) + f(Reg::JacTurn))],
            cot_frac: block_frac(config, Reg::FrameN) - f(Reg::FrameE2),
            de: de_common.map(|c| q(Reg::JacDe, c)),
            de_lift: [0, 1].map(|k: usize| {
                [de_common[k] - tilt, de_common[k] - f(Reg::JacTurn) - frac(config, e_regs[1 - k])]
            }),
            b_lift: [b_common - f(Reg::JacDnPerp), b_common - f(Reg::BumpB) - f(Reg::JacDe)],
            dn_mod: [
                q(Reg::JacDnMod, f(Reg::JacDnDx)),
                q(Reg::JacDnMod, f(Reg::JacDnDy)),
                q(Reg::JacDnMod, b_common),
            ],
        })
    }

    /// ∂n⊥ of one column.
    #[inline(always)]
    fn perpendicular<V: Vector>(
        &self,
        sink: &mut impl Writes<V>,
        col: usize,
        port: &Inputs<V>,
        inv_nn: V,
    ) -> [V; 3] {
        let (n, dn, n_exp) = (port.n, column(&port.dn, col), port.n_exp);
        let along = sink.put(&self.dn_dot[col], col, dot(n, dn), n_exp.up(1));
        let along = sink.put(&self.along, col, along.mul_wide(inv_nn), n_exp.like(0));
        let mut out = n;
        for c in 0..3 {
            let sum = dn[c].up(self.lift_dn[col]) - n[c].mul(along).up(self.lift_along[col]);
            out[c] = sink.put(&self.dn_perp[col], 3 * col + c, sum, n_exp);
        }
        out
    }

    /// ⟨n,h⟩/⟨e2,h⟩; 0 where e2 ⟂ h, which only a parallel frame has.
    #[inline(always)]
    fn cotangent<V: Vector>(&self, sink: &mut impl Writes<V>, roms: &Roms, n_h: V, e2_h: V) -> V {
        let one = n_h.like(1);
        let (m, e) = mantissa(e2_h.abs().larger(one));
        let (k, e_k) = mantissa(n_h.abs().larger(one));
        let product = k.mul_unsigned(roms.recip.recip(m));
        let product = (n_h.zero() | e2_h.zero()).select(one.like(0), product);
        let product = (n_h ^ e2_h).negative().select(-product, product);
        // k·2^(e_k − 30 − n_frac) · y·2^(−30 − e + e2_frac), h's fraction bits cancel.
        let fixed = 2 * i64::from(PORT_FRAC) + self.cot_frac - self.turn[0].frac();
        sink.shifted(&self.turn[0], 0, product, (e - e_k).plus(fixed), one.like(0))
    }

    /// ∂n⊥ + b1 ∂e1 + b2 ∂e2 of one column, exact.
    #[inline(always)]
    fn turned<V: Vector>(
        &self,
        sink: &mut impl Writes<V>,
        col: usize,
        (port, frame): (&Inputs<V>, &local_frame::Out<V>),
        perp: [V; 3],
        [inv_nn, cot]: [V; 2],
    ) -> [V; 3] {
        let (e, n_exp) = ([frame.e1, frame.e2], port.n_exp);
        let none = n_exp.like(0);
        let mut tilt = [none; 2];
        for k in 0..2 {
            let c = 2 * col + k;
            let along = sink.put(&self.perp_dot_e[k], c, dot(perp, e[k]), n_exp.up(1));
            tilt[k] = sink.put(&self.tilt, c, along.mul_wide(inv_nn), none);
        }
        let turn = sink.put(&self.turn[1], 1 + col, tilt[0].mul(cot), none);
        let mut out = perp;
        for c in 0..3 {
            out[c] = perp[c].up(self.b_lift[0]);
            for k in 0..2 {
                let turned = turn.mul(e[1 - k][c]).up(self.de_lift[k][1]);
                let turned = if k == 0 { turned } else { -turned };
                let exact = turned - tilt[k].mul(port.n[c]).up(self.de_lift[k][0]);
                let de = sink.put(&self.de[k], 6 * col + 3 * k + c, exact, n_exp);
                out[c] = out[c] + port.b[k].mul(de).up(self.b_lift[1]);
            }
        }
        out
    }
}

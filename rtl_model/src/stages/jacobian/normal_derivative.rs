//! The derivative of the modified normal, by the policy `jacobian.dnmod`.
//!
//! `paper`: ∂n. `normal`: ∂n⊥ = ∂n − n⟨n,∂n⟩/⟨n,n⟩ of the interpolated normal. `frame`: the frame
//! (n, e1, e2) turns as a rigid body with p = ⟨∂n⊥,e1⟩/⟨n,n⟩, q = ⟨∂n⊥,e2⟩/⟨n,n⟩ and, because
//! e1 stays perpendicular to h, ω = p·⟨n,h⟩/⟨e2,h⟩: ∂e1 = −p n + ω e2, ∂e2 = −q n − ω e1.

use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::lanes::{LaneSink, Shift, dot, each, mantissa, mul, mul_unsigned, mul_wide};
use crate::policy::Dnmod;
use crate::regs::{Reg, Register};
use crate::stages::{Lanes, Roms, bits, block_frac, column, fits, frac, int, take};
use crate::tables::rom::PORT_FRAC;
use crate::tap::Tap;

const P: i64 = 30;

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

/// The inputs of the stage.
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
    fn perpendicular<const N: usize, T: Tap>(
        &self,
        sink: &mut LaneSink<'_, N, T>,
        col: usize,
        n: &Lanes<N, 3>,
        dn: &Lanes<N, 3>,
        inv_nn: &[i64; N],
        n_exp: &[i64; N],
    ) -> Lanes<N, 3> {
        let mut along = [0; N];
        sink.write(
            &self.dn_dot[col],
            col,
            |i| dot::<T>(take(n, i), take(dn, i)),
            |i| 2 * n_exp[i],
            &mut along,
        );
        let product = |i: usize| mul_wide::<T>(along[i], inv_nn[i]);
        let mut along = [0; N];
        sink.write(&self.along, col, product, |_| 0, &mut along);
        let (lift_dn, lift_along) = (self.lift_dn[col], self.lift_along[col]);
        let mut out = [[0; N]; 3];
        for (c, (out, (n, dn))) in out.iter_mut().zip(n.iter().zip(dn)).enumerate() {
            let sum = |i: usize| (dn[i] << lift_dn) - (mul::<T>(n[i], along[i]) << lift_along);
            let exp = |i: usize| n_exp[i];
            sink.write(&self.dn_perp[col], 3 * col + c, sum, exp, out);
        }
        out
    }

    /// ⟨n,h⟩/⟨e2,h⟩; 0 where e2 ⟂ h, which only a parallel frame has.
    #[inline(always)]
    fn cotangent<const N: usize, T: Tap>(
        &self,
        sink: &mut LaneSink<'_, N, T>,
        roms: &Roms,
        n_h: &[i64; N],
        e2_h: &[i64; N],
    ) -> [i64; N] {
        let lanes = sink.n;
        let [mut m, mut e, mut y] = [[0; N]; 3];
        mantissa(lanes, |i| e2_h[i].abs().max(1), &mut m, &mut e);
        roms.recip.recip_lanes::<N, T>(lanes, &m, &mut y);
        let (mut k, mut e_k) = (m, [0; N]);
        mantissa(lanes, |i| n_h[i].abs().max(1), &mut k, &mut e_k);
        let product = |i: usize| {
            let product = mul_unsigned::<T>(k[i], y[i]);
            let product = if n_h[i] == 0 || e2_h[i] == 0 { 0 } else { product };
            if (n_h[i] < 0) == (e2_h[i] < 0) { product } else { -product }
        };
        // k·2^(e_k − 30 − n_frac) · y·2^(−30 − e + e2_frac), h's fraction bits cancel.
        let fixed = 2 * P + self.cot_frac - self.turn[0].frac();
        let shift = Shift::new(lanes, &self.turn[0], |i| fixed - e_k[i] + e[i]);
        let mut out = [0; N];
        sink.shift(&self.turn[0], 0, &shift, product, |_| 0, &mut out);
        out
    }

    /// ∂n⊥ + b1 ∂e1 + b2 ∂e2 of one column, exact.
    #[inline(always)]
    fn turned<const N: usize, T: Tap>(
        &self,
        sink: &mut LaneSink<'_, N, T>,
        col: usize,
        frame: &Bumped<'_, N>,
        perp: &Lanes<N, 3>,
        [inv_nn, cot, n_exp]: [&[i64; N]; 3],
    ) -> Lanes<N, 3> {
        let lanes = sink.n;
        let e = [frame.e1, frame.e2];
        let mut tilt = [[0; N]; 2];
        for (k, tilt) in tilt.iter_mut().enumerate() {
            let c = 2 * col + k;
            let mut along = [0; N];
            sink.write(
                &self.perp_dot_e[k],
                c,
                |i| dot::<T>(take(perp, i), take(e[k], i)),
                |i| 2 * n_exp[i],
                &mut along,
            );
            let product = |i: usize| mul_wide::<T>(along[i], inv_nn[i]);
            sink.write(&self.tilt, c, product, |_| 0, tilt);
        }
        let product = |i: usize| mul::<T>(tilt[0][i], cot[i]);
        let mut turn = [0; N];
        sink.write(&self.turn[1], 1 + col, product, |_| 0, &mut turn);
        let mut out = [[0; N]; 3];
        for (c, out) in out.iter_mut().enumerate() {
            *out = each(lanes, |i| perp[c][i] << self.b_lift[0]);
            for k in 0..2 {
                let (other, sign) = if k == 0 { (e[1], 1) } else { (e[0], -1) };
                let lift = self.de_lift[k];
                let exact = |i: usize| {
                    ((sign * mul::<T>(turn[i], other[c][i])) << lift[1])
                        - (mul::<T>(tilt[k][i], frame.n[c][i]) << lift[0])
                };
                let at = 6 * col + 3 * k + c;
                let mut de = [0; N];
                sink.write(&self.de[k], at, exact, |i| n_exp[i], &mut de);
                *out = each(lanes, |i| out[i] + (mul::<T>(frame.b[k][i], de[i]) << self.b_lift[1]));
            }
        }
        out
    }
}

/// The step: ∂n_mod in n_mod's nominal scale.
#[inline(always)]
pub fn normal_derivative<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: In<'_, N>,
    dn_mod: &mut Lanes<N, 6>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let mod_frac = cfg.dn_mod[0].frac();
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let (n_exp, lift) = (input.n_exp, input.n_lift);
    let exp = |i: usize| n_exp[i] + lift[i];
    let frame = match (&input.bumped, cfg.dnmod) {
        (None, _) | (_, Dnmod::Paper) => {
            for (col, q) in [(0, &cfg.dn_mod[0]), (1, &cfg.dn_mod[1])] {
                let shift = Shift::new(lanes, q, |i| q.frac_in - mod_frac + lift[i]);
                for c in 3 * col..3 * col + 3 {
                    let dn = |i: usize| input.dn[c][i];
                    sink.shift(q, c, &shift, dn, exp, &mut dn_mod[c]);
                }
            }
            return;
        }
        (Some(frame), _) => frame,
    };
    let n = frame.n;
    let square: [i64; N] = each(lanes, |i| dot::<T>(take(n, i), take(n, i)).max(1));
    let [mut m, mut e, mut inv] = [[0; N]; 3];
    mantissa(lanes, |i| square[i], &mut m, &mut e);
    roms.recip.recip_lanes::<N, T>(lanes, &m, &mut inv);
    let fixed = i64::from(PORT_FRAC) - 2 * cfg.n_frac - cfg.inv_nn.frac();
    let shift = Shift::new(lanes, &cfg.inv_nn, |i| fixed + e[i]);
    let inv_exp = |i: usize| -2 * n_exp[i];
    let mut inv_nn = [0; N];
    sink.shift(&cfg.inv_nn, 0, &shift, |i| inv[i], inv_exp, &mut inv_nn);
    let mut perp = [[[0; N]; 3]; 2];
    for (col, perp) in perp.iter_mut().enumerate() {
        *perp = cfg.perpendicular(&mut sink, col, n, column(input.dn, col), &inv_nn, n_exp);
    }
    let q = &cfg.dn_mod[2];
    let mut exact_frac = cfg.dn_perp[0].frac();
    if cfg.dnmod == Dnmod::Frame {
        let n_h = each(lanes, |i| dot::<T>(take(n, i), take(frame.h, i)));
        let e2_h = each(lanes, |i| dot::<T>(take(frame.e2, i), take(frame.h, i)));
        let cot = cfg.cotangent(&mut sink, roms, &n_h, &e2_h);
        for (col, perp) in perp.iter_mut().enumerate() {
            *perp = cfg.turned(&mut sink, col, frame, perp, [&inv_nn, &cot, n_exp]);
        }
        exact_frac = q.frac_in;
    }
    let shift = Shift::new(lanes, q, |i| exact_frac - mod_frac + lift[i]);
    for (col, perp) in perp.iter().enumerate() {
        for (c, perp) in perp.iter().enumerate() {
            let c = 3 * col + c;
            sink.shift(q, c, &shift, |i| perp[i], exp, &mut dn_mod[c]);
        }
    }
}

//! `cube_face`: face, 1/|ma|, u = sc/|ma|, v = tc/|ma|.
//!
//! (sc, tc, ma) as in Vulkan; on equal magnitudes z wins over y wins over x. The zero vector gives
//! +z, u = v = 0 and the event `cube_face.zero`.

use super::{Lanes, Roms, Sink, bits, dot, fits, frac, take};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::fx::{Flags, Quantizer};
use crate::regs::{Event, Reg};
use crate::tables::rom::{PORT_FRAC, mantissa};
use crate::tap::Tap;

/// Per face: (axis, negated) of sc, tc and ma, order +X −X +Y −Y +Z −Z.
pub const FACES: [[(usize, bool); 3]; 6] = [
    [(2, true), (1, true), (0, false)],
    [(2, false), (1, true), (0, true)],
    [(0, false), (2, false), (1, false)],
    [(0, false), (2, true), (1, true)],
    [(0, false), (1, true), (2, false)],
    [(0, true), (1, true), (2, true)],
];

/// The face of a direction.
#[inline(always)]
#[must_use]
pub fn select([x, y, z]: [i64; 3]) -> usize {
    let [ax, ay, az] = [x.abs(), y.abs(), z.abs()];
    if az >= ax && az >= ay {
        4 + usize::from(z < 0)
    } else if ay >= ax {
        2 + usize::from(y < 0)
    } else {
        usize::from(x < 0)
    }
}

/// (sc, tc, |ma|) of a direction on a face.
#[inline(always)]
#[must_use]
pub fn components(face: usize, d: [i64; 3]) -> [i64; 3] {
    FACES[face].map(|(axis, negative)| if negative { -d[axis] } else { d[axis] })
}

/// The direction of (sc, tc, |ma|) on a face.
#[inline(always)]
#[must_use]
pub fn direction(face: usize, components: [i64; 3]) -> [i64; 3] {
    let mut d = [0; 3];
    for ((axis, negative), value) in FACES[face].into_iter().zip(components) {
        d[axis] = if negative { -value } else { value };
    }
    d
}

/// Compiled configuration.
#[derive(Clone, Debug)]
pub struct Cfg {
    rotation: Option<[[i64; 3]; 3]>,
    rotated: Quantizer,
    inv_ma: Quantizer,
    u: Quantizer,
    v: Quantizer,
}

/// The reflected direction.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Mantissas of v_r.
    pub v_r: &'a Lanes<N, 3>,
    /// Their fraction bits in nominal scale.
    pub v_r_frac: &'a [i64; N],
    /// Power of two of the nominal scale.
    pub exp: &'a [i64; N],
}

/// Where the direction meets the cube.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// Face 0…5.
    pub face: [usize; N],
    /// Whether v_r was zero.
    pub zero: [bool; N],
    /// Mantissa of 1/|ma|.
    pub inv_ma: [i64; N],
    /// Its fraction bits in nominal scale.
    pub inv_ma_frac: [i64; N],
    /// u with the register's fraction bits.
    pub u: [i64; N],
    /// v with the register's fraction bits.
    pub v: [i64; N],
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self {
            face: [4; N],
            zero: [false; N],
            inv_ma: [0; N],
            inv_ma_frac: [0; N],
            u: [0; N],
            v: [0; N],
        }
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let v_r = bits(config, Reg::ReflectVr);
        let looked_up = if config.rotation.is_some() {
            fits(Reg::FaceRotated, v_r + ROTATION_FRAC + 3)?;
            bits(config, Reg::FaceRotated)
        } else {
            v_r
        };
        fits(Reg::FaceU, looked_up + bits(config, Reg::FaceInvMa))?;
        Ok(Self {
            rotation: config.rotation,
            rotated: Quantizer::new(config.format(Reg::FaceRotated), 0),
            inv_ma: Quantizer::new(config.format(Reg::FaceInvMa), 0),
            u: Quantizer::new(config.format(Reg::FaceU), 0),
            v: Quantizer::new(config.format(Reg::FaceV), 0),
        })
    }

    /// Fraction bits of (u, v).
    #[must_use]
    pub fn uv_frac(config: &Config) -> [i64; 2] {
        [frac(config, Reg::FaceU), frac(config, Reg::FaceV)]
    }
}

/// The stage.
#[inline(always)]
pub fn cube_face<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    for lane in 0..flags.len().min(N) {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let mut d = take(input.v_r, lane);
        let mut d_frac = input.v_r_frac[lane];
        let exp = input.exp[lane];
        if let Some(a) = &cfg.rotation {
            let sum = a.map(|row| dot(row, d));
            let rotated = sink.block(
                &cfg.rotated,
                Reg::FaceRotated,
                &sum,
                d_frac + i64::from(ROTATION_FRAC),
                exp,
            );
            d = rotated.m;
            d_frac = rotated.frac;
        }
        let face = select(d);
        let [sc, tc, ma] = components(face, d);
        let zero = ma == 0;
        sink.flags.event(Event::FaceZero, zero);
        // ma = m · 2^e as an integer, so 1/|ma| = 2^(d_frac − e) / m.
        let (m, e) = mantissa(ma.max(1));
        let inv_frac = i64::from(PORT_FRAC) + e - d_frac;
        let y = if zero { 0 } else { roms.recip.recip(m) };
        let inv = sink.block(&cfg.inv_ma, Reg::FaceInvMa, &[y], inv_frac, -exp);
        let mut uv = [0; 2];
        for (i, (q, reg, s)) in [(&cfg.u, Reg::FaceU, sc), (&cfg.v, Reg::FaceV, tc)]
            .into_iter()
            .enumerate()
        {
            let f = i64::from(q.format.frac);
            let one = 1i64 << f;
            // |sc| ≤ |ma|: a table error must not leave the face.
            let (code, over) = q.write_as(T::STANDARD, s * inv.m[0], d_frac + inv.frac - f);
            uv[i] = code.clamp(-one, one);
            sink.flags.register(reg, over && code.abs() < one);
            sink.tap.put(lane, reg, 0, uv[i], f);
        }
        out.face[lane] = face;
        out.zero[lane] = zero;
        out.inv_ma[lane] = inv.m[0];
        out.inv_ma_frac[lane] = inv.frac;
        [out.u[lane], out.v[lane]] = uv;
    }
}

//! `cube_face`: face, 1/|ma|, u = sc/|ma|, v = tc/|ma|.
//!
//! (sc, tc, ma) as in Vulkan; on equal magnitudes z wins over y wins over x. The zero vector gives
//! +z, u = v = 0 and the event `cube_face.zero`.

use core::array;

use super::{Lanes, Roms, bits, fits, frac, take};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::fx::Flags;
use crate::lanes::{LaneSink, Shift, dot, fill, mantissa, mul};
use crate::regs::{Event, Reg, Register};
use crate::tables::rom::PORT_FRAC;
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

/// [`components`] of every lane, without a look-up that depends on the face.
#[inline(always)]
pub(crate) fn components_lanes<const N: usize>(
    lanes: usize,
    face: &[usize; N],
    d: &Lanes<N, 3>,
) -> Lanes<N, 3> {
    let [mut sc, mut tc, mut ma] = [[0; N]; 3];
    for i in 0..lanes.min(N) {
        let [x, y, z] = take(d, i);
        // All ones on the faces of an axis, and where |ma| is the negative component.
        let negative = -i64::from(face[i] & 1 == 1);
        let (on_x, on_y) = (-i64::from(face[i] < 2), -i64::from(face[i] & !1 == 2));
        let on_z = !(on_x | on_y);
        let flip = |value: i64, sign: i64| (value ^ sign) - sign;
        ma[i] = flip((x & on_x) | (y & on_y) | (z & on_z), negative);
        // sc: −z, z, x, x, x, −x; tc: −y, −y, z, −z, −y, −y.
        sc[i] = flip((z & on_x) | (x & !on_x), (!negative & on_x) | (negative & on_z));
        tc[i] = flip((z & on_y) | (y & !on_y), (negative & on_y) | !on_y);
    }
    [sc, tc, ma]
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
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    rotation: Option<[[i64; 3]; 3]>,
    rotated: Register,
    inv_ma: Register,
    u: Register,
    v: Register,
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
            rotated: config.register(Reg::FaceRotated, 0),
            inv_ma: config.register(Reg::FaceInvMa, 0),
            u: config.register(Reg::FaceU, 0),
            v: config.register(Reg::FaceV, 0),
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
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let exp = |i: usize| input.exp[i];
    let (mut d, mut d_frac) = (*input.v_r, *input.v_r_frac);
    if let Some(a) = &cfg.rotation {
        let mut sum = [[0; N]; 3];
        for (sum, row) in sum.iter_mut().zip(a) {
            fill(lanes, sum, |i| dot::<T>(*row, take(input.v_r, i)));
        }
        let sum_frac = |i: usize| input.v_r_frac[i] + i64::from(ROTATION_FRAC);
        let rotated = (&mut d, &mut d_frac);
        sink.block(&cfg.rotated, &sum, sum_frac, exp, rotated);
    }
    for i in 0..lanes.min(N) {
        out.face[i] = select(take(&d, i));
    }
    let [sc, tc, ma] = components_lanes(lanes, &out.face, &d);
    for i in 0..lanes.min(N) {
        out.zero[i] = ma[i] == 0;
    }
    sink.event(Event::FaceZero, &out.zero);
    // ma = m · 2^e as an integer, so 1/|ma| = 2^(d_frac − e) / m.
    let [mut m, mut e, mut y] = [[0; N]; 3];
    mantissa(lanes, |i| ma[i].max(1), &mut m, &mut e);
    roms.recip.recip_lanes::<N, T>(lanes, &m, &mut y);
    for i in 0..lanes.min(N) {
        y[i] = if ma[i] == 0 { 0 } else { y[i] };
    }
    let inv_frac = |i: usize| i64::from(PORT_FRAC) + e[i] - d_frac[i];
    let inv = (array::from_mut(&mut out.inv_ma), &mut out.inv_ma_frac);
    sink.block(&cfg.inv_ma, &[y], inv_frac, |i| -exp(i), inv);
    for (q, side, uv) in [(&cfg.u, &sc, &mut out.u), (&cfg.v, &tc, &mut out.v)] {
        let f = q.frac();
        let one = 1i64 << f;
        // |sc| ≤ |ma|: a table error must not leave the face.
        let shift = Shift::new(lanes, q, |i| d_frac[i] + out.inv_ma_frac[i] - f);
        let mut code = [0; N];
        sink.shift_code(q, &shift, one, |i| mul::<T>(side[i], out.inv_ma[i]), &mut code);
        fill(lanes, uv, |i| code[i].clamp(-one, one));
        sink.put(q, 0, uv, |_| f);
    }
}

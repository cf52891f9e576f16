//! `cube_face`: face, 1/|ma|, u = sc/|ma|, v = tc/|ma|.
//!
//! (sc, tc, ma) as in Vulkan; on equal magnitudes z wins over y wins over x. The zero vector gives
//! +z, u = v = 0 and the event `cube_face.zero`.

use lanes::{Mask as _, Vector};

use super::{Roms, bits, fits, frac};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::lanes::{Writes, in_lanes};
use crate::regs::{Event, Reg, Register};
use crate::tables::rom::{PORT_FRAC, mantissa};

/// The stage, from a direction's mantissas with `frac` fraction bits in a nominal scale of 2^`exp`.
#[inline(always)]
pub fn cube_face<V: Vector>(
    cfg: &Cfg,
    roms: &Roms,
    (v_r, frac, exp): ([V; 3], V, V),
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let (mut d, mut d_frac) = (v_r, frac);
    if let Some(a) = &cfg.rotation {
        let mut sum = d;
        for (sum, row) in sum.iter_mut().zip(a) {
            *sum = v_r[0].times(row[0]) + v_r[1].times(row[1]) + v_r[2].times(row[2]);
        }
        (d, d_frac) = sink.normal(&cfg.rotated, &sum, frac.plus(ROTATION_FRAC.into()), exp);
    }
    let face = face_of(d);
    let [sc, tc, ma] = components_of(face, d);
    let none = sink.event(Event::FaceZero, ma.zero());
    // ma = m · 2^e as an integer, so 1/|ma| = 2^(d_frac − e) / m.
    let (m, e) = mantissa(ma.larger(ma.like(1)));
    let y = if none { ma } else { roms.recip.recip(m) };
    let inv_frac = e.plus(PORT_FRAC.into()) - d_frac;
    let ([inv_ma], inv_ma_frac) = sink.normal(&cfg.inv_ma, &[y], inv_frac, -exp);
    let mut uv = [sc, tc];
    for (uv, q) in uv.iter_mut().zip([&cfg.u, &cfg.v]) {
        let f = q.frac();
        let one = 1i64 << f;
        // |sc| ≤ |ma|: a table error must not leave the face.
        let code = sink.shift_code(q, uv.mul(inv_ma), (d_frac + inv_ma_frac).plus(-f), one);
        *uv = code.limit(-one, one);
        sink.tell(q, 0, *uv, exp.like(f));
    }
    let zero = ma.zero().select(ma.like(1), ma.like(0));
    Out { face, zero, inv_ma, inv_ma_frac, u: uv[0], v: uv[1] }
}

in_lanes! {
    /// Where the direction meets the cube.
    pub struct Out<V> {
        /// Face 0…5.
        pub face: V,
        /// 1 where v_r was zero.
        pub zero: V,
        /// Mantissa of 1/|ma|.
        pub inv_ma: V,
        /// Its fraction bits in nominal scale.
        pub inv_ma_frac: V,
        /// u with the register's fraction bits.
        pub u: V,
        /// v with the register's fraction bits.
        pub v: V,
    }
}

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

/// [`select`] of lanes.
#[inline(always)]
pub(crate) fn face_of<V: Vector>([x, y, z]: [V; 3]) -> V {
    let [ax, ay, az] = [x.abs(), y.abs(), z.abs()];
    let (on_z, on_y) = (!ax.gt(az) & !ay.gt(az), !ax.gt(ay));
    let axis = on_z.select(x.like(4), on_y.select(x.like(2), x.like(0)));
    let ma = on_z.select(z, on_y.select(y, x));
    axis + ma.shr(x.like(63))
}

/// [`components`] of lanes, without a look-up that depends on the face.
#[inline(always)]
pub(crate) fn components_of<V: Vector>(face: V, [x, y, z]: [V; 3]) -> [V; 3] {
    // All ones where |ma| is the negative component.
    let (negative, none) = (-face.and(1), face.like(0));
    let (on_x, on_z) = (face.like(2).gt(face), face.gt(face.like(3)));
    let ma = flip(on_x.select(x, on_z.select(z, y)), negative);
    // sc: −z, z, x, x, x, −x; tc: −y, −y, z, −z, −y, −y.
    let sc = flip(on_x.select(z, x), on_x.select(!negative, on_z.select(negative, none)));
    let on_y = !on_x & !on_z;
    let tc = flip(on_y.select(z, y), on_y.select(negative, !none));
    [sc, tc, ma]
}

/// [`direction`] of lanes.
#[inline(always)]
pub(crate) fn direction_of<V: Vector>(face: V, [sc, tc, ma]: [V; 3]) -> [V; 3] {
    let (negative, none) = (-face.and(1), face.like(0));
    let (on_x, on_z) = (face.like(2).gt(face), face.gt(face.like(3)));
    let ma = flip(ma, negative);
    [
        on_x.select(ma, flip(sc, on_z.select(negative, none))),
        (on_x | on_z).select(-tc, ma),
        on_x.select(flip(sc, !negative), on_z.select(ma, flip(tc, negative))),
    ]
}

/// The negative where `sign` is all ones.
#[inline(always)]
fn flip<V: Vector>(value: V, sign: V) -> V {
    (value ^ sign) - sign
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

//! Inputs of an operation: ordinary numbers, numbers of every size, extremes.

use rtl_model::unit::Words;

use super::extremes::{self, FACING, Request};
use super::subject::Subject;
use crate::base::num;
use crate::base::random::Random;
use crate::engine::encode;
use crate::fragment::{Fragment, HitFragment};
use crate::stage::Stage;

/// The inputs of an operation, before its ports.
#[derive(Clone, Copy, Debug)]
pub enum Stimulus {
    /// A fragment, for ENV and its stages.
    Fragment(Words),
    /// A ray, for HIT.
    Ray(HitFragment),
    /// A request, for TEX.
    Request(Request),
    /// Operation, angle, width and operands of a cone.
    Operation(u64, [f64; 2], [f64; 3]),
}

/// Rows of a subject's extremes.
#[must_use]
pub fn rows(subject: Subject) -> u64 {
    let n = match kind(subject) {
        Kind::Fragment => extremes::env().len(),
        Kind::Ray => extremes::hit().len(),
        Kind::Request => extremes::tex().len(),
        Kind::Operation => extremes::CONES.len(),
    };
    num::u64(n)
}

enum Kind {
    Fragment,
    Ray,
    Request,
    Operation,
}

fn kind(subject: Subject) -> Kind {
    match subject {
        Subject::Hit | Subject::Stage(Stage::Hit) => Kind::Ray,
        Subject::Tex | Subject::Stage(Stage::SurfaceFootprint) => Kind::Request,
        Subject::Stage(Stage::RayCone) => Kind::Operation,
        Subject::Env | Subject::Stage(_) => Kind::Fragment,
    }
}

/// A vector times a power of two.
fn scaled<const N: usize>(v: [f64; N], power: i64) -> [f64; N] {
    let power = num::i32(power);
    v.map(|x| libm::ldexp(x, power))
}

/// A fragment whose footprint spans from a small part of a texel to several faces.
fn fragment(random: &mut Random) -> Fragment {
    let pixel = -random.between(0, 12);
    let v = random.vector();
    let mut n = random.vector();
    if random.below(4) > 0 {
        // Seen from the front, as most are.
        let dot: f64 = v.iter().zip(n).map(|(a, b)| a * b).sum();
        n = n.map(|x| if dot < 0.0 { -x } else { x });
    }
    let mut f = Fragment {
        v,
        n,
        dv_dx: scaled(random.vector(), pixel),
        dv_dy: scaled(random.vector(), pixel),
        dn_dx: scaled(random.vector(), pixel),
        dn_dy: scaled(random.vector(), pixel),
        h: Some(random.vector()),
        bump: Some(scaled([random.signed(), random.signed()], random.between(-6, 2))),
        rough: Some(scaled(random.vector(), random.between(-10, 0))),
    };
    if random.below(5) == 0 {
        // Of rank 1: λ2 is put to the test.
        f.dv_dy = scaled(f.dv_dx, -1);
        f.dn_dy = scaled(f.dn_dx, -1);
    }
    f
}

fn ray(random: &mut Random) -> HitFragment {
    let reach = if random.below(8) == 0 { 1.3 } else { 0.95 };
    let [x, y, z] = random.vector();
    HitFragment {
        x: [3.0 * reach * x, 2.0 * reach * y, 4.0 * reach * z],
        r: random.vector(),
        cone: (random.below(16) > 0).then(|| {
            let [angle] = scaled([random.signed()], -random.between(2, 12));
            let [width] = scaled([random.signed()], -random.between(0, 12));
            [angle, width]
        }),
    }
}

fn request(random: &mut Random) -> Request {
    let [width] = scaled([random.unit()], -random.between(0, 14));
    let tangents = [random.vector(), random.vector()].map(|t| scaled(t, random.between(-4, 4)));
    Request {
        width,
        d: random.vector(),
        n: random.vector(),
        tangents,
        edge: (random.below(4) == 0).then(|| {
            let ([a, b], [c, _, d]) = ([random.signed(), random.signed()], random.vector());
            [a, b, c, d]
        }),
        st: scaled([random.signed(), random.signed()], random.between(-2, 3)),
    }
}

fn operation(random: &mut Random) -> (u64, [f64; 2], [f64; 3]) {
    let operation = random.below(4);
    let cone = [random.signed(), random.signed()].map(|x| {
        let [x] = scaled([x], -random.between(0, 10));
        x
    });
    let ior = 1.0 + random.unit();
    let operand = match operation {
        0 => [8.0 * random.unit(), 0.0, 0.0],
        1 => [random.signed(), 0.0, 0.0],
        2 => [random.signed(), 1.0, ior],
        _ => [2.0 * random.unit(), 0.0, 0.0],
    };
    (operation, cone, operand)
}

pub(super) fn ordinary(subject: Subject, random: &mut Random) -> Stimulus {
    match kind(subject) {
        Kind::Fragment => Stimulus::Fragment(encode::words(&fragment(random))),
        Kind::Ray => Stimulus::Ray(ray(random)),
        Kind::Request => Stimulus::Request(request(random)),
        Kind::Operation => {
            let (operation, cone, operand) = operation(random);
            Stimulus::Operation(operation, cone, operand)
        }
    }
}

/// Powers of two that scale an operand, the usual ones more often.
const POWERS: [i64; 16] = [-1060, -300, -100, -40, -24, -12, -4, -1, 0, 1, 3, 7, 12, 40, 300, 1020];

pub(super) fn exponents(subject: Subject, random: &mut Random) -> Stimulus {
    let power = |random: &mut Random| {
        if random.below(3) == 0 { random.one_of(&POWERS) } else { random.between(-12, 12) }
    };
    match kind(subject) {
        Kind::Fragment => {
            let f = fragment(random);
            // Derivatives go with their vector, or not.
            let (v, n) = (power(random), power(random));
            let with = |random: &mut Random, base: i64| {
                if random.below(8) == 0 { power(random) } else { base + random.between(-6, 3) }
            };
            let rows = [v, v, n, n].map(|base| with(random, base));
            let f = Fragment {
                v: scaled(f.v, v),
                n: scaled(f.n, n),
                dv_dx: scaled(f.dv_dx, rows[0]),
                dv_dy: scaled(f.dv_dy, rows[1]),
                dn_dx: scaled(f.dn_dx, rows[2]),
                dn_dy: scaled(f.dn_dy, rows[3]),
                h: f.h.map(|h| scaled(h, with(random, 0))),
                bump: f.bump.map(|b| scaled(b, with(random, 0))),
                rough: f.rough.map(|d| scaled(d, with(random, 0))),
            };
            Stimulus::Fragment(encode::words(&f))
        }
        Kind::Ray => {
            let f = ray(random);
            Stimulus::Ray(HitFragment {
                x: scaled(f.x, random.one_of(&[-300, -20, -3, 0, 0, 0, 1, 6])),
                r: scaled(f.r, power(random)),
                cone: f.cone.map(|[a, w]| {
                    let ([a], [w]) = (scaled([a], power(random)), scaled([w], power(random)));
                    [a, w]
                }),
            })
        }
        Kind::Request => {
            let f = request(random);
            let [width] = scaled([f.width], power(random));
            Stimulus::Request(Request {
                width,
                d: scaled(f.d, power(random)),
                n: scaled(f.n, power(random)),
                tangents: f.tangents.map(|t| scaled(t, power(random))),
                edge: f.edge.map(|e| scaled(e, power(random))),
                st: scaled(f.st, random.between(-20, 12)),
            })
        }
        Kind::Operation => {
            let (operation, cone, operand) = operation(random);
            let cone = cone.map(|x| {
                let [x] = scaled([x], power(random));
                x
            });
            Stimulus::Operation(operation, cone, scaled(operand, power(random)))
        }
    }
}

/// Row `index` of the extremes, turned by one of the cube's symmetries for every further round.
pub(super) fn extreme(subject: Subject, index: u64, random: &mut Random) -> Stimulus {
    let rows = rows(subject);
    let (row, round) = (num::usize(index % rows), index / rows);
    let turn = |v: [f64; 3]| turned(v, round);
    match kind(subject) {
        Kind::Fragment => {
            let (_, f) = extremes::env()[row];
            let f = Fragment {
                v: turn(f.v),
                n: turn(f.n),
                dv_dx: turn(f.dv_dx),
                dv_dy: turn(f.dv_dy),
                dn_dx: turn(f.dn_dx),
                dn_dy: turn(f.dn_dy),
                h: Some(turn(f.h.unwrap_or([1.0, 0.5, 0.25]))),
                bump: Some(f.bump.unwrap_or([0.0; 2])),
                rough: Some(f.rough.unwrap_or([0.0; 3])),
            };
            Stimulus::Fragment(encode::words(&f))
        }
        Kind::Ray => {
            let (_, f) = extremes::hit()[row];
            // The room is no cube: signs alone are its symmetries.
            Stimulus::Ray(HitFragment {
                x: signed(f.x, round),
                r: signed(f.r, round),
                cone: f.cone,
            })
        }
        Kind::Request => {
            let (_, f) = extremes::tex().get(row).copied().unwrap_or(("", FACING));
            Stimulus::Request(Request {
                d: turn(f.d),
                n: turn(f.n),
                tangents: f.tangents.map(turn),
                ..f
            })
        }
        Kind::Operation => {
            let (operation, cone, operand) = extremes::CONES[row];
            // The same with a neighbouring code or operand in further rounds.
            let nudge = |x: f64, random: &mut Random| {
                if round == 0 { x } else { x * (1.0 + libm::ldexp(random.signed(), -7)) }
            };
            let cone = cone.map(|x| nudge(x, random));
            Stimulus::Operation(operation, cone, operand.map(|x| nudge(x, random)))
        }
    }
}

/// Signs of the components by three bits.
fn signed(v: [f64; 3], bits: u64) -> [f64; 3] {
    [0, 1, 2].map(|i| if bits >> i & 1 == 1 { -v[i] } else { v[i] })
}

/// One of the cube's 48 rotations and reflections.
#[must_use]
pub fn turned(v: [f64; 3], symmetry: u64) -> [f64; 3] {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let order = ORDERS[num::usize(symmetry / 8 % 6)];
    signed(order.map(|i| v[i]), symmetry)
}

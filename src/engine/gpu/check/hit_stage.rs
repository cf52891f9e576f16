//! The stage `hit` from the device's own registers: the expected value of each, given those before it.

use super::env::Rotation;
use super::{Bounded, Expected, exactly, expect, number, own};
use crate::base::num;
use crate::cube::{FACE_AXES, major_face};
use crate::engine::gpu::bit;
use crate::fragment::HitFragment;
use crate::gpu::policy::to_f32;
use crate::policy::{ConeEnv, HitFootprint, HitStatus, LookUp, Outside};
use crate::reference::Distances;
use crate::reference::cube_face::cube_face;
use crate::reference::hit::step::{Ray, step};
use crate::reference::real::{Narrow as _, Real as _};
use crate::reference::vector::{beside, cross, dot, transform};
use crate::reference::{Flag, Flags, NoTap};
use crate::settings::Settings;

/// Words of the search before its first look-up, and after every one.
const TURN: usize = 10;

/// A distance map as the kernels read it.
pub(super) struct Walls<'a> {
    pub(super) distances: &'a Distances,
    /// Half edges of a box; x is a sphere's radius.
    pub(super) half_edges: Option<[f64; 3]>,
    pub(super) radius: Option<f64>,
    pub(super) rotation: Rotation,
    pub(super) settings: &'a Settings,
}

/// The vector with its largest component in [1, 2) and the power of two that brings it there, which the kernel takes out
/// exactly; nothing for 0.
fn scaled(v: [Bounded; 3]) -> Option<([Bounded; 3], f64)> {
    let most = v.iter().fold(0.0f64, |most, c| most.max(c.value.abs()));
    if most == 0.0 {
        return None;
    }
    let scale = libm::ldexp(1.0, 1 - libm::frexp(most).1);
    Some((v.map(|c| c.scaled(scale)), scale))
}

/// v/√⟨v,v⟩.
fn unit(v: [Bounded; 3]) -> [Bounded; 3] {
    let Some((v, _)) = scaled(v) else {
        return [0.0, 0.0, 1.0].map(Bounded::exact);
    };
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

/// |v|.
fn length(v: [Bounded; 3]) -> Bounded {
    let Some((v, scale)) = scaled(v) else {
        return Bounded::exact(0.0);
    };
    dot(v, v).sqrt().scaled(1.0 / scale)
}

impl Walls<'_> {
    fn turn(&self, q: [Bounded; 3]) -> [Bounded; 3] {
        self.rotation.as_ref().map_or(q, |a| transform(a, q))
    }

    /// dist(q); infinite distances are −1, as the kernels have them.
    fn read(&self, q: [Bounded; 3]) -> Bounded {
        let q = unit(self.turn(q));
        if let Some(radius) = self.radius {
            return Bounded::exact(f64::from(to_f32(radius)));
        }
        if let Some(half_edges) = self.half_edges {
            let walls = q.iter().zip(half_edges).filter(|(q, _)| !q.is_zero());
            let walls = walls.map(|(q, h)| Bounded::exact(f64::from(to_f32(h))) / q.abs());
            return walls
                .fold(Bounded::exact(f64::from(f32::MAX)), |least, x| -(-x).larger(-least));
        }
        let Some((size, texels)) = self.distances.bordered() else {
            return Bounded::exact(-1.0);
        };
        bilinear_distance(q, size, texels, self.settings.policy.hit.lookup)
    }
}

/// The place of a unit direction on a bordered cube of distances, and the content of that place.
fn bilinear_distance(q: [Bounded; 3], size: usize, texels: &[f64], look_up: LookUp) -> Bounded {
    let face = major_face(q.map(|c| c.value));
    let sizes = q.map(Bounded::abs);
    let major = face / 2;
    for other in (0..3).filter(|axis| *axis != major) {
        // On another face a device finds the same edge, but with other weights.
        let _ = sizes[major] > sizes[other];
    }
    let [s, t, _] = FACE_AXES[face].map(|(axis, sign)| if sign < 0.0 { -q[axis] } else { q[axis] });
    let [one, two, half] = [1.0, 2.0, 0.5].map(Bounded::exact);
    let mut corner = [0usize; 2];
    let mut weight = [Bounded::exact(0.0); 2];
    for (i, c) in [s, t].into_iter().enumerate() {
        let u = c / sizes[major];
        let mut place = (u + one) / two * Bounded::exact(size as f64) - half;
        let mut low = -1.0;
        if look_up == LookUp::Nearest {
            place = place + half;
            low = 0.0;
        }
        let whole = place.floor().value.clamp(low, size as f64 - 1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to the face's size"
        )]
        let index = (whole + 1.0) as usize;
        corner[i] = index;
        weight[i] = place - Bounded::exact(whole);
    }
    let row = size + 2;
    let outside = |c: usize| c == 0 || c == size + 1;
    let at = |dx: usize, dy: usize| {
        let [x, y] = [corner[0] + dx, corner[1] + dy];
        let value = texels[(face * row + y.min(size + 1)) * row + x.min(size + 1)];
        if !value.is_finite() {
            return Bounded::exact(-1.0);
        }
        let error = if outside(x) && outside(y) { 4.5 * super::EPSILON * value } else { 0.0 };
        Bounded { value, error }
    };
    if look_up == LookUp::Nearest {
        return at(0, 0);
    }
    let [s, t] = weight;
    let zero = Bounded::exact(0.0);
    let mut sum = zero;
    for (value, weight) in [
        (at(0, 0), (one - s) * (one - t)),
        (at(1, 0), s * (one - t)),
        (at(0, 1), (one - s) * t),
        (at(1, 1), s * t),
    ] {
        if value.value < 0.0 {
            // A share that may be none decides between a distance and infinity.
            if weight > zero {
                return Bounded::exact(-1.0);
            }
        } else if weight.value > 0.0 || weight.error > 0.0 {
            sum = sum + value * weight;
        }
    }
    sum
}

/// |l|/dist(l) as the kernel forms it from its own two numbers.
fn ratio(length: Bounded, distance: Bounded) -> Bounded {
    if distance.value == 0.0 {
        Bounded::exact(f32::MAX.into())
    } else if distance.value < 0.0 {
        Bounded::exact(0.0)
    } else {
        length / distance
    }
}

/// Words of one turn of the kernel's results.
struct Turn<'a>(&'a [u32]);

impl Turn<'_> {
    fn ratio(&self) -> Bounded {
        own(self.0[2])
    }

    fn step(&self) -> Bounded {
        own(self.0[3])
    }

    fn d(&self) -> Bounded {
        own(self.0[4])
    }

    fn l(&self) -> [Bounded; 3] {
        [5, 6, 7].map(|i| own(self.0[i]))
    }
}

fn status_word(status: HitStatus) -> u32 {
    let at = crate::engine::gpu::hit::STATUS.iter().position(|s| *s == status);
    num::u32(at.unwrap_or(0))
}

/// The expected words of the kernel's results.
pub(super) fn expected(
    walls: &Walls<'_>,
    ray: &HitFragment,
    operands: &[u32],
    results: &[u32],
) -> Vec<Expected> {
    let settings = walls.settings;
    let policy = &settings.policy.hit;
    let operand = |at: usize| [at, at + 1, at + 2].map(|i| own(operands[i]));
    let (x, direction) = (operand(0), operand(3));
    let mut out: Vec<Expected> = unit(direction).map(expect).to_vec();
    let r = [0, 1, 2].map(|i| own(results[i]));
    out.push(expect(walls.read(r)));
    let far = own(results[3]);
    let one = Bounded::exact(1.0);
    let tau = policy.tolerance_bits.map_or(0.0, |bits| 1.0 / f64::from(1u32 << bits.min(31)));
    let tau = Bounded::exact(tau);
    let side = |f: Bounded| i8::from(f > one + tau) - i8::from(f < one - tau);
    let turns: Vec<Turn<'_>> =
        results[4..].chunks_exact(TURN).take(policy.iterations as usize + 1).map(Turn).collect();
    // Before the first look-up in the loop.
    let first = &turns[0];
    let start = length(x);
    out.push(expect(start));
    let at_origin = start.value == 0.0;
    out.push(expect(if at_origin { start } else { walls.read(x) }));
    let near = if at_origin { start } else { ratio(own(first.0[0]), own(first.0[1])) };
    out.push(expect(near));
    out.push(exactly(0));
    let begins = side(first.ratio());
    let mut status = HitStatus::MaxIterations;
    let mut done = true;
    if begins == 0 {
        status = HitStatus::AtSurface;
    } else if begins > 0 && policy.outside == Outside::Stop {
        status = HitStatus::Outside;
    } else if far.value < 0.0 {
        status = HitStatus::Escaped;
    } else {
        done = false;
    }
    let mut flags =
        if direction.iter().all(|c| c.value == 0.0) { bit(Flag::HitNoDirection) } else { 0 };
    let mut search =
        Ray { far, d: first.d(), under: (Bounded::exact(0.0), first.ratio()), over: None, side: 0 };
    let moved = |d: Bounded| [0, 1, 2].map(|i| x[i] + r[i] * d);
    let (d, l) = match (done, status) {
        (true, HitStatus::Escaped) => (Bounded::exact(0.0), r),
        (true, _) => (Bounded::exact(0.0), x),
        (false, _) => (far * (one - first.ratio()), moved(first.d())),
    };
    out.push(expect(d));
    out.extend(l.map(expect));
    out.extend([exactly(status_word(status)), exactly(u32::from(done))]);
    for pair in turns.windows(2) {
        let (before, turn) = (&pair[0], &pair[1]);
        if done {
            // A search that has ended keeps its registers.
            out.extend(before.0.iter().map(|word| Some((number(*word), 0.0))).take(8));
            out.extend([exactly(status_word(status)), exactly(1)]);
            continue;
        }
        let l = before.l();
        out.push(expect(length(l)));
        out.push(expect(walls.read(l)));
        out.push(expect(ratio(own(turn.0[0]), own(turn.0[1]))));
        let f = turn.ratio();
        let to = side(f);
        if to > 0 {
            flags |= bit(Flag::HitOvershoot);
        }
        let mut next = before.d();
        let mut stays = true;
        if to == 0 {
            status = HitStatus::Converged;
            done = true;
            out.push(exactly(0));
        } else {
            search.d = before.d();
            let step = step(policy.method, &mut search, f, to);
            if step.value.is_nan() {
                status = HitStatus::Stalled;
                done = true;
                out.push(exactly(0));
            } else {
                out.push(expect(step));
                next = before.d() + turn.step();
                // Whether the sum rounds to what it was.
                let sum = to_f32(next.value).to_bits();
                if sum == to_f32(before.d().value).to_bits() {
                    status = HitStatus::Stalled;
                    done = true;
                } else {
                    stays = false;
                }
                let _ = next == before.d();
            }
        }
        if stays {
            out.push(Some((before.d().value, 0.0)));
            out.extend(l.map(|c| Some((c.value, 0.0))));
        } else {
            out.push(expect(next));
            out.extend(moved(turn.d()).map(expect));
        }
        out.extend([exactly(status_word(status)), exactly(u32::from(done))]);
    }
    let (words, raised) = footprint(walls, ray, operands, results, &turns, status, r);
    out.extend(words);
    // Whether a wall has a plane is no register.
    let all = (policy.footprint == HitFootprint::Disc).then_some(flags | raised);
    out.push(all.and_then(exactly));
    out
}

/// Tangents, width and D, and the flags of the face.
fn footprint(
    walls: &Walls<'_>,
    ray: &HitFragment,
    operands: &[u32],
    results: &[u32],
    turns: &[Turn<'_>],
    status: HitStatus,
    r: [Bounded; 3],
) -> (Vec<Expected>, u32) {
    let settings = walls.settings;
    let escaped = status == HitStatus::Escaped;
    let rest = &results[4 + TURN * turns.len()..];
    let three = |at: usize| [at, at + 1, at + 2].map(|i| own(rest[i]));
    let last = &turns[turns.len() - 1];
    let mut out = Vec::new();
    if settings.policy.hit.footprint == HitFootprint::Plane && !escaped {
        // The wall's normal is no register: the picture shows it.
        out.extend([None; 6]);
    } else {
        let e = beside(r);
        out.extend(unit(e).map(expect));
        out.extend(cross(r, three(0)).map(expect));
    }
    let t = [three(0), three(3)];
    let (angle, width) = (own(operands[6]), own(operands[7]));
    let wide = if escaped { angle.abs() } else { (width + angle * last.d()).abs() };
    out.push(expect(wide));
    let width = own(rest[6]);
    let rotation = walls.rotation.as_ref();
    let mut flags = Flags::default();
    let facing = cube_face(last.l(), rotation, &mut flags, &mut NoTap);
    let raised = if flags.contains(Flag::Zero) { bit(Flag::Zero) } else { 0 };
    if ray.cone.is_none() {
        out.extend([None; 4]);
        return (out, raised);
    }
    if escaped && settings.policy.cone.env == ConeEnv::Otk {
        let constant = Bounded::from_f64(4.0 * std::f64::consts::FRAC_1_PI) * width;
        let zero = exactly(0);
        out.extend([expect(constant), zero, zero, expect(constant)]);
        return (out, raised);
    }
    let columns = t.map(|t| facing.numerator(walls.turn(t)).map(|x| x * facing.inv_ma * width));
    for row in 0..2 {
        out.extend(columns.map(|column| expect(column[row])));
    }
    (out, raised)
}

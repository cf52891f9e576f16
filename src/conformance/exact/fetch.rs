//! Rules of `address` and `filter`.

use rtl_model::TexelFormat;
use rtl_model::regs::Reg;
use rtl_model::stages::filter::weights::weights;

use super::Case;
use super::sheet::{Sheet, real, within, zero};
use crate::base::num;
use crate::cube::{CubeMap, FACE_AXES, direction, major_face};
use crate::policy::{Weights, Wrap};
use crate::reference::Texture;
use crate::reference::real::Real;
use crate::reference::wide::Wide;

/// The level of detail as the filter takes it: first level, and the weight of the next one in 2^lod_bits.
fn level(s: &Sheet<'_>, last: usize) -> Option<(usize, i64)> {
    let code = s.codes(Reg::FootLod).first()?;
    let frac = code.frac.clamp(0, 60);
    let whole = code.raw >> frac;
    let part = code.raw - (whole << frac);
    let down = frac - i64::from(s.config.policy.filter.lod_bits);
    let weight = if down > 0 { (part + (1 << (down - 1))) >> down } else { part << -down };
    let whole = usize::try_from(whole).ok()?;
    Some(if whole >= last { (last, 0) } else { (whole, weight) })
}

/// Face, coordinates and their slack of a probe.
struct Probe {
    face: usize,
    uv: [Wide; 2],
    slack: Wide,
}

/// A probe that left its face, looked up again from (1, u, v). `None` where another register is too short to tell.
fn on_cube(s: &Sheet<'_>, face: usize, uv: [Wide; 2]) -> Probe {
    let inside = uv.iter().all(|x| x.abs() <= real(1.0));
    if inside {
        return Probe { face, uv, slack: zero() };
    }
    // At most 44 bits: exact in doubles, also the comparison of magnitudes.
    let d = direction(face, uv[0].to_f64(), uv[1].to_f64());
    let found = major_face(d);
    let [(sc, sign_s), (tc, sign_t), (ma, _)] = FACE_AXES[found];
    let over = real(1.0) / real(d[ma].abs());
    let uv = [real(sign_s * d[sc]) * over, real(sign_t * d[tc]) * over];
    // The table, a product cut to 30 bits, and the rounding to u's and v's own fraction.
    let frac = s.config.format(Reg::AddrU).frac.min(s.config.format(Reg::AddrV).frac);
    let slack = s.tables.recip + libm::ldexp(1.0, -29) + libm::ldexp(1.0, -num::i32(frac));
    Probe { face: found, uv, slack: real(slack) }
}

/// A coordinate of a 2-D texture beyond −1 … 1, brought back. At most 44 bits: exact in doubles.
fn wrapped(x: f64, wrap: Wrap) -> f64 {
    if x.abs() <= 1.0 {
        return x;
    }
    match wrap {
        Wrap::Repeat => x - 2.0 * ((x + 1.0) / 2.0).floor(),
        Wrap::Clamp => x.clamp(-1.0, 1.0),
        Wrap::Mirror => {
            let turn = x + 1.0 - 4.0 * ((x + 1.0) / 4.0).floor();
            turn.min(4.0 - turn) - 1.0
        }
    }
}

/// The centre of the probe line.
fn centre(s: &Sheet<'_>, axis: usize, planar: bool) -> Wide {
    if !planar {
        return s.value([Reg::FaceU, Reg::FaceV][axis], 0);
    }
    let st = s.value([Reg::SurfS, Reg::SurfT][axis], 0).to_f64();
    let x = 2.0 * st - 1.0;
    let wrap = s.config.policy.address.wrap()[axis];
    real(if wrap == Wrap::Repeat { wrapped(x, wrap) } else { x })
}

/// Sizes of a level.
fn level_size(size: u32, planar: bool, level: usize) -> [f64; 2] {
    let at = |n: u32| f64::from((n >> level.min(31)).max(1));
    [at(size), at(if planar { (size / 2).max(1) } else { size })]
}

/// Probe i at (u, v) + (2i + 1 − count)·step, and its texel coordinates (u + 1)/2·N − ½ in one or two levels.
pub(super) fn address(s: &mut Sheet<'_>, case: &Case<'_>, size: u32, planar: bool) {
    let (Some(count), Some(face)) = (case.count(), case.face().or(planar.then_some(0))) else {
        return;
    };
    let last = num::usize(size.max(1).ilog2());
    let Some((first, weight)) = level(s, last) else {
        return;
    };
    for k in 0..count {
        let index = num::usize(k);
        let along = real((2 * k + 1 - count) as f64);
        let mut uv = [zero(); 2];
        for (i, reg) in [Reg::AddrU, Reg::AddrV].into_iter().enumerate() {
            let x = centre(s, i, planar) + along * s.value(Reg::FootStep, i);
            let x = if planar {
                real(wrapped(x.to_f64(), s.config.policy.address.wrap()[i]))
            } else {
                x
            };
            uv[i] = s.fixed(reg, index, x);
        }
        let probe =
            if planar { Probe { face: 0, uv, slack: zero() } } else { on_cube(s, face, uv) };
        for l in 0..=usize::from(weight != 0) {
            let sizes = level_size(size, planar, first + l);
            for (i, size) in sizes.into_iter().enumerate() {
                let half = real(size / 2.0);
                let exact = (probe.uv[i] + real(1.0)) * half - real(0.5);
                s.fixed(Reg::AddrS, 4 * index + 2 * l + i, within(exact, probe.slack * half));
            }
        }
    }
}

/// Weight of the second texel and the first texel's number plus one, from a texel coordinate's code.
fn cell(s: &Sheet<'_>, component: usize, size: f64) -> Option<(usize, i64)> {
    let code = s.codes(Reg::AddrS).get(component).filter(|c| c.is_written())?;
    let frac = code.frac.clamp(0, 60);
    let whole = code.raw >> frac;
    let part = code.raw - (whole << frac);
    let bits = i64::from(s.config.policy.filter.weight_bits);
    let down = frac - bits;
    let weight = if down > 0 { (part + (1 << (down - 1))) >> down } else { part << -down };
    #[expect(clippy::cast_possible_truncation, reason = "a face's size")]
    let most = size as i64 - 1;
    let clamped = whole.clamp(-1, most);
    let weight = match whole.cmp(&clamped) {
        std::cmp::Ordering::Less => 0,
        std::cmp::Ordering::Equal => weight,
        std::cmp::Ordering::Greater => 1 << bits,
    };
    Some((usize::try_from(clamped + 1).ok()?, weight))
}

/// Bilinear sums of four texels, where memory holds them exactly, and the mean of the probes' trilinear values.
pub(super) fn filter(s: &mut Sheet<'_>, case: &Case<'_>, map: Option<&CubeMap>) {
    let Some(count) = case.count() else { return };
    let levels = map.map_or(usize::MAX, |m| m.levels.len());
    let last = if levels == usize::MAX { 31 } else { levels - 1 };
    let Some((first, weight)) = level(s, last) else {
        return;
    };
    let exact_memory = s.config.policy.texel.format == TexelFormat::Half
        && s.config.policy.texel.frac >= 24
        && s.config.policy.texel.int >= 16;
    if let (Some(map), Some(face), true) = (map, case.face(), exact_memory) {
        bilinear(s, map, face, count, [first, usize::from(weight != 0)]);
    }
    color(s, count, weight);
}

fn bilinear(s: &mut Sheet<'_>, map: &CubeMap, face: usize, count: i64, [first, two]: [usize; 2]) {
    let texture = Texture::new(map);
    let config = s.config;
    let exact_frac = config.policy.texel.frac + 2 * config.policy.filter.weight_bits;
    let register = config.format(Reg::FilterBilinear);
    let narrowed = register.frac < exact_frac || register.int < config.policy.texel.int;
    let one = 1i64 << config.policy.filter.weight_bits;
    for k in 0..num::usize(count) {
        let uv = [Reg::AddrU, Reg::AddrV].map(|reg| s.value(reg, k));
        let probe = on_cube(s, face, uv);
        for l in 0..=two {
            let level = (first + l).min(map.levels.len() - 1);
            let size = map.levels[level].size;
            #[expect(clippy::cast_precision_loss, reason = "a face's size")]
            let cells = [0, 1].map(|i| cell(s, 4 * k + 2 * l + i, size as f64));
            let [Some((x, wx)), Some((y, wy))] = cells else {
                continue;
            };
            let taps = [
                (x, y, (one - wx) * (one - wy)),
                (x + 1, y, wx * (one - wy)),
                (x, y + 1, (one - wx) * wy),
                (x + 1, y + 1, wx * wy),
            ];
            let inside = |t: usize| t >= 1 && t <= size;
            for c in 0..3 {
                let mut sum = zero();
                for (x, y, weight) in taps {
                    let share = Wide::code(weight, 2 * i64::from(config.policy.filter.weight_bits));
                    if weight == 0 {
                        continue;
                    }
                    let mut texel = texture.tap(level, probe.face, x, y)[c];
                    if !inside(x) && !inside(y) {
                        // A corner holds the mean of three, rounded to binary16 as every texel is.
                        texel = half::f16::from_f64(texel).to_f64();
                    }
                    sum = sum + real(texel) * share;
                }
                let component = 6 * k + 3 * l + c;
                if narrowed {
                    s.fixed(Reg::FilterBilinear, component, sum);
                } else {
                    s.exact(Reg::FilterBilinear, component, sum);
                }
            }
        }
    }
}

/// Levels combined, probes weighted, one rounding.
fn color(s: &mut Sheet<'_>, count: i64, weight: i64) {
    let config = s.config;
    let policy = &config.policy.footprint;
    let probes = num::usize(count);
    let (shares, total) = match policy.weights {
        Weights::Box => (vec![1; probes], count.max(1)),
        Weights::Gaussian | Weights::Bell => {
            (weights(num::u32(count.max(1)), policy), 1 << policy.weight_bits)
        }
    };
    let next = Wide::code(weight, i64::from(config.policy.filter.lod_bits));
    let here = real(1.0) - next;
    for c in 0..3 {
        let mut sum = zero();
        for (k, share) in shares.iter().enumerate() {
            let value = s.value(Reg::FilterBilinear, 6 * k + c) * here
                + s.value(Reg::FilterBilinear, 6 * k + 3 + c) * next;
            sum = sum + Wide::code(*share, 0) * value;
        }
        s.fixed(Reg::FilterColor, c, sum / Wide::code(total, 0));
    }
}

//! The study of the extremes: what the paper's formulas do there, what the unit does, and where the colour jumps.

use rtl_model::regs::Reg;
use rtl_model::{Texture, Unit};

use super::extremes::{env, straight};
use super::study_rays::finite;
use crate::base::num;
use crate::base::random::Random;
use crate::cube::{FACE_AXES, FACE_NAMES, major_face};
use crate::engine::encode;
use crate::engine::probe::{RtlProbe, rtl};
use crate::error::InputError;
use crate::fragment::Fragment;
use crate::policy::{Axis, Minor};
use crate::reference::{self, NoTap, Prepared};
use crate::unit::{ReferenceAxis, UnitSpec, refused};

/// What an engine makes of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// Face and its coordinates.
    pub at: (usize, [f64; 2]),
    /// λ1, λ2.
    pub lambda: [f64; 2],
    /// Direction of the line.
    pub axis: [f64; 2],
    /// Probes and level of detail.
    pub fetch: (i64, f64),
    /// Flags.
    pub flags: Vec<String>,
}

/// A number in a table's cell: four decimals, or two digits and a power of ten.
pub(super) fn number(x: f64) -> String {
    if x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e5) {
        return format!("{x:.1e}");
    }
    let text = format!("{x:.4}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" | "" => "0".into(),
        short => short.into(),
    }
}

impl Seen {
    /// The numbers in a table's cell.
    #[must_use]
    pub fn text(&self) -> String {
        let (face, [u, v]) = self.at;
        let face = FACE_NAMES[face.min(5)];
        let [u, v] = [u, v].map(number);
        let [l, m] = self.lambda.map(number);
        let [x, y] = self.axis.map(number);
        let (probes, lod) = (self.fetch.0, number(self.fetch.1));
        format!("{face} ({u}, {v}) λ {l}, {m} axis ({x}, {y}) {probes} × LOD {lod}")
    }
}

/// A row of the specification's section 8.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// The paper's formulas as they are written, in doubles.
    pub paper: String,
    /// The integer model.
    pub rtl: String,
    /// The float reference.
    pub f64: String,
    /// Flags of the integer model.
    pub flags: Vec<String>,
}

/// Face size of the study.
const FACE: u32 = 256;

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Equations 4, 6, 16, 17 and 20 as the paper writes them, in doubles, with K from exact arithmetic.
fn paper(fragment: &Fragment, k: [f64; 3]) -> String {
    let (v, n) = (fragment.v, fragment.n);
    let (nv, nn) = (dot(n, v), dot(n, n));
    let v_r = [0, 1, 2].map(|i| 2.0 * n[i] * nv - v[i] * nn);
    let face = major_face(v_r);
    let [(s, sign_s), _, (m, _)] = FACE_AXES[face];
    let u = sign_s * v_r[s] / v_r[m].abs();
    let [a, b, c] = k;
    let root = ((c - a) * (c - a) + 4.0 * b * b).sqrt();
    let major = (f64::midpoint(a + c, root)).sqrt();
    let minor = ((a + c - root) / 2.0).sqrt();
    let tangent = 2.0 * b / (c - a);
    finite(&[("u", u), ("λ1", major), ("λ2", minor), ("tan 2α", tangent)])
}

fn seen_by_rtl(
    unit: &Unit,
    spec: &UnitSpec,
    f: &Fragment,
    texture: Option<&Texture>,
) -> (Seen, [f64; 3]) {
    let mut probe = RtlProbe::default();
    let out = rtl(unit, &spec.config, f, texture, &mut probe);
    let value = |reg: Reg, k: usize| probe.get(reg).get(k).map_or(0.0, |c| c.value());
    let pair = |reg: Reg| [value(reg, 0), value(reg, 1)];
    let seen = Seen {
        at: (out.face, [value(Reg::FaceU, 0), value(Reg::FaceV, 0)]),
        lambda: pair(Reg::EigenLambda),
        axis: pair(Reg::EigenAxis),
        fetch: (out.probes, value(Reg::FootLod, 0)),
        flags: out.flags,
    };
    (seen, [0, 1, 2].map(|c| value(Reg::FilterColor, c)))
}

/// Every row of ENV by the paper, the integer model and the float reference.
pub fn rows(spec: &UnitSpec) -> Result<Vec<Row>, InputError> {
    let settings = spec.settings(ReferenceAxis::Exact);
    let prepared = Prepared::new(&settings);
    env()
        .into_iter()
        .map(|(name, f)| {
            let unit = Unit::new(&spec.config, encode::needs(&f), FACE).map_err(refused)?;
            let (rtl, _) = seen_by_rtl(&unit, spec, &f, None);
            let size = num::usize(FACE);
            let env = reference::env(&prepared, &f, size, None, &mut NoTap);
            let theirs = Seen {
                at: (env.face, [env.u, env.v]),
                lambda: env.lambda,
                axis: env.axis,
                fetch: (env.probes.into(), env.lod),
                flags: Vec::new(),
            };
            Ok(Row {
                name: name.into(),
                paper: paper(&f, env.k),
                rtl: rtl.text(),
                f64: theirs.text(),
                flags: rtl.flags,
            })
        })
        .collect()
}

/// λ2's relative error and the line's sideways displacement at one anisotropy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thin {
    /// λ1/λ2.
    pub anisotropy: f64,
    /// Worst |λ2 − exact|/exact by eq. 17 in registers, by √det, by eq. 17 in binary32.
    pub minor: [f64; 3],
    /// Worst displacement of a line's end across the line, over the width that the probes have: 10 and 32 entries.
    pub displacement: [f64; 2],
}

/// λ2 by eq. 17 on a K that was rounded to binary32, as a shader has it.
fn single([a, b, c]: [f64; 3]) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "binary32 is what is asked for")]
    let [a, b, c] = [a, b, c].map(|x| x as f32);
    let root = ((c - a) * (c - a) + 4.0 * b * b).sqrt();
    f64::from(((a + c - root) / 2.0).max(0.0).sqrt())
}

/// Ellipses of growing anisotropy, turned by `turns` angles each.
pub fn thin(spec: &UnitSpec, turns: u32) -> Result<Vec<Thin>, InputError> {
    let unit = |change: &dyn Fn(&mut UnitSpec)| -> Result<(UnitSpec, Unit), InputError> {
        let mut spec = spec.clone();
        change(&mut spec);
        let unit = Unit::new(&spec.config, encode::needs(&super::extremes::PLAIN), FACE)
            .map_err(refused)?;
        Ok((spec, unit))
    };
    let by_paper = unit(&|s| s.config.policy.eigen.minor = Minor::Paper)?;
    let by_det = unit(&|s| s.config.policy.eigen.minor = Minor::Det)?;
    let table = |entries: u32| {
        move |s: &mut UnitSpec| {
            s.config.policy.footprint.axis = Axis::EigenTable;
            s.config.tables.eigen.entries = entries;
        }
    };
    let tables = [unit(&table(10))?, unit(&table(32))?];
    let mut out = Vec::new();
    for step in 0..=24 {
        let anisotropy = libm::exp10(f64::from(step) / 4.0);
        let mut worst = Thin { anisotropy, minor: [0.0; 3], displacement: [0.0; 2] };
        for turn in 0..turns {
            let angle = std::f64::consts::PI * (f64::from(turn) + 0.37) / f64::from(turns);
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let (l, m) = (0.75, 0.75 / anisotropy);
            let f = straight([[l * cos, -m * sin], [l * sin, m * cos]]);
            for (k, (spec, unit)) in [&by_paper, &by_det].into_iter().enumerate() {
                let (seen, _) = seen_by_rtl(unit, spec, &f, None);
                worst.minor[k] = worst.minor[k].max((seen.lambda[1] - m).abs() / m);
            }
            let k = [
                l * l * cos * cos + m * m * sin * sin,
                (l * l - m * m) * cos * sin,
                l * l * sin * sin + m * m * cos * cos,
            ];
            worst.minor[2] = worst.minor[2].max((single(k) - m).abs() / m);
            for (k, (spec, unit)) in tables.iter().enumerate() {
                let (seen, _) = seen_by_rtl(unit, spec, &f, None);
                let off = (seen.axis[0] * sin - seen.axis[1] * cos).abs();
                // In texels of level 0: half the line, and the width that the level of detail stands for.
                let half = f64::from(FACE) / 2.0;
                let width = libm::exp2(seen.fetch.1);
                worst.displacement[k] = worst.displacement[k].max(off * l * half / 2.0 / width);
            }
        }
        out.push(worst);
    }
    Ok(out)
}

/// Jumps of the colour between two fragments that a continuous filter could not tell apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// What lies between them.
    pub name: &'static str,
    /// Largest and mean jump, in steps of 8 bits after sRGB: integer model, float reference.
    pub rtl: [f64; 2],
    /// The same of the float reference.
    pub f64: [f64; 2],
    /// Pairs.
    pub pairs: u32,
}

/// Two fragments on either side of a break, next to each other.
fn sides(kind: usize, random: &mut Random) -> [Fragment; 2] {
    let tiny = libm::ldexp(1.0, -20);
    let place = [0.8 * random.signed(), 0.8 * random.signed()];
    // Looking at (x, y, 1), with D scaled by `by` and turned by `angle`.
    let look = |d: [[f64; 2]; 2]| {
        let f = straight(d);
        let n = [place[0], place[1], 1.0];
        Fragment { v: n, n, ..f }
    };
    let turned = |angle: f64, l: f64, m: f64| {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        look([[l * cos, -m * sin], [l * sin, m * cos]])
    };
    match kind {
        0 => [1.0 - tiny, 1.0 + tiny].map(|x| Fragment {
            v: [x, place[1], 1.0],
            n: [x, place[1], 1.0],
            ..straight([[0.06, 0.0], [0.0, 0.02]])
        }),
        1 => {
            let boundary = std::f64::consts::FRAC_PI_2 / 64.0;
            [-4.0, 4.0].map(|k| turned(boundary + k * tiny, 0.4, 0.01))
        }
        2 => [-4.0, 4.0].map(|k| look([[0.1 + k * tiny, 0.0], [0.0, 0.1]])),
        _ => {
            let count = 1.0 + libm::floor(7.0 * random.unit()) + 1.0 / 256.0;
            [-16.0, 16.0].map(|k| look([[count / 32.0 + k * tiny, 0.0], [0.0, 1.0 / 32.0]]))
        }
    }
}

/// Names of the breaks.
const BREAKS: [&str; 4] =
    ["a face's seam", "a break of the angle table", "λ1 = λ2", "count → count + 1"];

fn encoded(linear: f64) -> f64 {
    255.0 * crate::srgb::srgb_encode(linear.clamp(0.0, 1.0))
}

/// Jumps at every kind of break over the built-in environment.
pub fn jumps(spec: &UnitSpec, pairs: u32) -> Result<Vec<Jump>, InputError> {
    let map = crate::image::build_mips(crate::scene::environment::procedural(256));
    let texture = encode::texture(&spec.config, &map).map_err(refused)?;
    let needs = encode::needs(&super::extremes::PLAIN);
    let unit = Unit::new(&spec.config, needs, FACE).map_err(refused)?;
    let settings = spec.settings(ReferenceAxis::Exact);
    let (prepared, float) = (Prepared::new(&settings), reference::Texture::new(&map));
    let mut out = Vec::new();
    for (kind, name) in BREAKS.into_iter().enumerate() {
        let mut random = Random::of_case(3, 0x6a75_6d70, num::u64(kind));
        let (mut rtl, mut f64) = ([0.0f64; 2], [0.0f64; 2]);
        for _ in 0..pairs {
            let both = sides(kind, &mut random);
            let mine = both.map(|f| seen_by_rtl(&unit, spec, &f, Some(&texture)).1);
            let theirs = both
                .map(|f| reference::env(&prepared, &f, map.size(), Some(&float), &mut NoTap).color);
            for (to, [a, b]) in [(&mut rtl, mine), (&mut f64, theirs)] {
                let jump =
                    (0..3).map(|c| (encoded(a[c]) - encoded(b[c])).abs()).fold(0.0, f64::max);
                to[0] = to[0].max(jump);
                to[1] += jump / f64::from(pairs);
            }
        }
        out.push(Jump { name, rtl, f64, pairs });
    }
    Ok(out)
}

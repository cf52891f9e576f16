//! A unit's behaviour at the edges of its input: thin ellipses, and two fragments on either side of a break.

use rtl_model::regs::Reg;
use rtl_model::{Texture, Unit};

use super::measures::Measures;
use crate::base::num;
use crate::base::random::Random;
use crate::conformance::extremes::{PLAIN, straight};
use crate::cube::CubeMap;
use crate::engine::encode;
use crate::engine::probe::{RtlProbe, rtl};
use crate::error::InputError;
use crate::fragment::Fragment;
use crate::reference::{self, NoTap, Prepared};
use crate::settings::Settings;
use crate::srgb::srgb_encode;
use crate::unit::{UnitSpec, refused};

/// Angles of each ellipse.
const TURNS: u32 = 181;
/// Pairs of fragments at each break.
const PAIRS: u32 = 400;
/// Texels along a face under the ellipses.
const FACE: u32 = 256;

/// λ1/λ2 of the ellipses.
const THIN: [f64; 10] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 3e4];

/// A register of a fragment that went through a unit.
fn value(probe: &RtlProbe, reg: Reg, component: usize) -> f64 {
    probe.get(reg).get(component).map_or(0.0, |code| code.value())
}

/// A unit without a bump map.
fn plain(spec: &UnitSpec, face_size: u32) -> Result<Unit, InputError> {
    Unit::new(&spec.config, encode::needs(&PLAIN), face_size).map_err(refused)
}

/// The worst of λ2's relative error and of the line's move, over ellipses of one shape in all directions.
pub(super) fn thin(spec: &UnitSpec, measures: &mut Measures) -> Result<(), InputError> {
    let unit = plain(spec, FACE)?;
    let mut probe = RtlProbe::default();
    for anisotropy in THIN {
        let (l, m) = (0.75, 0.75 / anisotropy);
        let (mut minor, mut end) = (0.0f64, 0.0f64);
        for turn in 0..TURNS {
            let angle = std::f64::consts::PI * (f64::from(turn) + 0.37) / f64::from(TURNS);
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let f = straight([[l * cos, -m * sin], [l * sin, m * cos]]);
            rtl(&unit, &spec.config, &f, None, &mut probe);
            let of = |reg, component| value(&probe, reg, component);
            minor = minor.max((of(Reg::EigenLambda, 1) - m).abs() / m);
            let off = (of(Reg::EigenAxis, 0) * sin - of(Reg::EigenAxis, 1) * cos).abs();
            // In texels of level 0: half the line, and the width that the level of detail stands for.
            let half = f64::from(FACE) / 2.0;
            end = end.max(off * l * half / 2.0 / libm::exp2(of(Reg::FootLod, 0)));
        }
        measures.put_of("minor_error_", &anisotropy.to_string(), minor);
        measures.put_of("thin_line_end_", &anisotropy.to_string(), end);
    }
    Ok(())
}

/// A break between two fragments that a continuous filter could not tell apart.
#[derive(Clone, Copy, Debug)]
enum Break {
    /// A face's seam.
    Seam,
    /// A break of the angle table with 32 entries.
    Table,
    /// λ1 = λ2.
    Equal,
    /// One probe more.
    Count,
}

/// Every break with the middle of its figures' names.
const BREAKS: [(Break, &str); 4] = [
    (Break::Seam, "seam"),
    (Break::Table, "table"),
    (Break::Equal, "equal"),
    (Break::Count, "count"),
];

/// Two fragments on either side of a break, next to each other.
fn sides(kind: Break, random: &mut Random) -> [Fragment; 2] {
    let tiny = libm::ldexp(1.0, -20);
    let place = [0.8 * random.signed(), 0.8 * random.signed()];
    // Looking at (x, y, 1).
    let look = |d: [[f64; 2]; 2]| {
        let n = [place[0], place[1], 1.0];
        Fragment { v: n, n, ..straight(d) }
    };
    let turned = |angle: f64, l: f64, m: f64| {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        look([[l * cos, -m * sin], [l * sin, m * cos]])
    };
    match kind {
        Break::Seam => [1.0 - tiny, 1.0 + tiny].map(|x| Fragment {
            v: [x, place[1], 1.0],
            n: [x, place[1], 1.0],
            ..straight([[0.06, 0.0], [0.0, 0.02]])
        }),
        Break::Table => {
            let boundary = std::f64::consts::FRAC_PI_2 / 64.0;
            [-4.0, 4.0].map(|k| turned(boundary + k * tiny, 0.4, 0.01))
        }
        Break::Equal => [-4.0, 4.0].map(|k| look([[0.1 + k * tiny, 0.0], [0.0, 0.1]])),
        Break::Count => {
            let count = 1.0 + libm::floor(7.0 * random.unit()) + 1.0 / 256.0;
            [-16.0, 16.0].map(|k| look([[count / 32.0 + k * tiny, 0.0], [0.0, 1.0 / 32.0]]))
        }
    }
}

/// Jumps of the colour at every break over an environment, in steps of 8 bits after sRGB.
pub(super) fn jumps(
    spec: &UnitSpec,
    settings: &Settings,
    map: &CubeMap,
    measures: &mut Measures,
) -> Result<(), InputError> {
    let texture: Texture = encode::texture(&spec.config, map).map_err(refused)?;
    let unit = plain(spec, num::u32(map.size()))?;
    let (prepared, float) = (Prepared::new(settings), reference::Texture::new(map));
    let encoded = |linear: f64| 255.0 * srgb_encode(linear.clamp(0.0, 1.0));
    let mut probe = RtlProbe::default();
    for (number, (kind, name)) in BREAKS.into_iter().enumerate() {
        let mut random = Random::of_case(3, 0x6a75_6d70, num::u64(number));
        let (mut worst, mut mean) = ([0.0f64; 2], [0.0; 2]);
        for _ in 0..PAIRS {
            let both = sides(kind, &mut random);
            let mine = both.map(|f| {
                rtl(&unit, &spec.config, &f, Some(&texture), &mut probe);
                [0, 1, 2].map(|c| value(&probe, Reg::FilterColor, c))
            });
            let theirs = both
                .map(|f| reference::env(&prepared, &f, map.size(), Some(&float), &mut NoTap).color);
            for (at, [a, b]) in [mine, theirs].into_iter().enumerate() {
                let step = |c: usize| (encoded(a[c]) - encoded(b[c])).abs();
                let jump = (0..3).map(step).fold(0.0, f64::max);
                worst[at] = worst[at].max(jump);
                mean[at] += jump / f64::from(PAIRS);
            }
        }
        for (at, engine) in ["jump_", "jump_f64_"].into_iter().enumerate() {
            measures.put_of(engine, &format!("{name}_max_lsb8"), worst[at]);
            measures.put_of(engine, &format!("{name}_mean_lsb8"), mean[at]);
        }
    }
    Ok(())
}

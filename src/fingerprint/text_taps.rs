//! The sections of the text about the anisotropic filter.

use super::model::{Line, Rule};
use super::taps::Taps;
use super::{Fingerprint, MAP};
use crate::report::table::{Cell, Table, missing, places, text, whole};
use crate::sampler::{Shape, Source};

/// A number with one decimal and a power of ten.
pub(super) fn power(x: f64) -> Cell {
    whole(format!("{x:.1e}")).with(x)
}

pub(super) fn filters(found: &Fingerprint) -> String {
    let title = "4. anisotropic filter: level of detail and shape";
    if found.filters.is_empty() {
        return format!("{title}\n   the driver offers none\n\n");
    }
    let table = Table::of(
        &found.filters,
        &[
            ("texture", "", &|f| text(f.rule.shape.name())),
            ("by", "", &|f| text(f.rule.source.name())),
            ("clamp", "", &|f| whole(f.rule.clamp)),
            ("level of detail", "", &|f| text(f.rule.lod.name())),
            ("worst (levels)", "", &|f| power(f.lod.worst)),
            ("shape, mean error", "", &|f| power(f.lines[0].mean)),
            ("next shape", "", &|f| power(f.lines[1].mean)),
        ],
    );
    let mut shapes: Vec<String> = Vec::new();
    for Rule { shape, source, line, .. } in found.filters.iter().map(|f| f.rule) {
        let (shape, source) = (shape.name(), source.name());
        let named = format!("       {shape} {source}: {}\n", line.name());
        if !shapes.contains(&named) {
            shapes.push(named);
        }
    }
    let (all, table, shapes) = (Line::all(Shape::Cube).len(), indented(&table), shapes.concat());
    format!(
        "{title}
   measured: lambda of 251 footprints (ratios 1 to 32 at three widths, 128 skewed pairs; on cubes up to 512 random ones)
   against 54 rules; the shape by 384 random look-ups into noise 0..1 against {all} shapes
{table}   shapes:
{shapes}
"
    )
}

/// A table below a line of the report.
pub(super) fn indented(table: &Table) -> String {
    table.to_string().lines().map(|line| format!("   {line}\n")).collect()
}

/// Largest and smallest weight of taps.
fn extent(taps: &Taps) -> [f64; 2] {
    let weights = || taps.taps.iter().map(|t| t.weight);
    [weights().fold(f64::INFINITY, f64::min), weights().fold(0.0, f64::max)]
}

pub(super) fn taps(found: &Fingerprint) -> String {
    let mut out = String::from(
        "5. taps of textureSampleGrad, on 2-D textures and on face +z of cubes
   measured: kinks of the texture max(0, x) under a sweep of 1/16 texel; places finer than 1/256 texel; the shorter
   derivative is one texel. Teeth that point down: the filter is no sum of bilinear taps that move with the coordinate
",
    );
    let (bilinear, strange): (Vec<&Taps>, Vec<_>) = found.taps.iter().partition(|t| t.explains());
    let strange = strange.len();
    // The taps' ends, and the way from the first to the last where there are several.
    let apart = |t: &Taps| {
        let ends = t.taps.first().zip(t.taps.last());
        ends.map_or([0.0; 2], |(a, b)| [0, 1].map(|i| b.offset[i] - a.offset[i]))
    };
    let spaced = |t: &Taps, shown: &dyn Fn([f64; 2]) -> String| {
        t.spacing().map_or(missing("-"), |spacing| whole(shown(spacing)))
    };
    let table = Table::of(
        bilinear,
        &[
            ("texture", "", &|t| text(t.footprint.shape.name())),
            ("clamp", "", &|t| whole(t.footprint.clamp)),
            ("ratio", "", &|t| whole(t.footprint.ratio)),
            ("angle (deg)", "", &|t| whole(t.footprint.degrees)),
            ("lambda", "", &|t| places(t.lod, 3)),
            ("taps", "", &|t| whole(t.taps.len())),
            ("spacing (texels)", "", &|t| {
                spaced(t, &|[mean, off]| format!("{mean:.4} +-{off:.4}"))
            }),
            ("span/longer", "", &|t| {
                let [x, y] = apart(t);
                let texels = libm::hypot(x, y) * libm::exp2(t.lod.round());
                spaced(t, &|_| format!("{:.4}", texels / t.footprint.ratio))
            }),
            ("direction (deg)", "", &|t| {
                let [x, y] = apart(t);
                let angle = libm::atan2(y, x).to_degrees().rem_euclid(180.0);
                spaced(t, &|_| format!("{angle:.2}"))
            }),
            ("weights", "", &|t| {
                let [low, high] = extent(t);
                whole(format!("{low:.4}..{high:.4}"))
            }),
        ],
    );
    if !table.is_empty() {
        out += &indented(&table);
    }
    if strange > 0 {
        let all = found.taps.len();
        out += &format!(
            "   {strange} of {all} footprints are no sum of bilinear taps: see the shape in 4 and the texels below\n"
        );
    }
    out += &format!(
        "   texels (impulse at each texel of every level of a {MAP} x {MAP} texture in turn): lengths of boxes with the same variance\n"
    );
    let maps = [(Source::Gradient, &found.map), (Source::Quad, &found.quad_map)];
    let rows = maps.iter().flat_map(|(source, map)| {
        map.iter().map(|m| {
            let level = m.transfer.main_level();
            let [dx, _] = m.footprint.derivatives();
            let length = libm::hypot(dx[0], dx[1]);
            let scale = libm::exp2(-(level as f64));
            let at = [(MAP as f64 + 1.0) / 2.0 * scale; 2];
            let (off, sides) = m.transfer.moments(level, at, dx.map(|c| c / length));
            let texels = [sides[0], sides[1], libm::hypot(off[0], off[1])].map(|x| x / scale);
            (*source, m, level, texels)
        })
    });
    let table = Table::of(
        rows,
        &[
            ("by", "", &|(source, ..)| text(source.name())),
            ("ratio", "", &|(_, m, ..)| whole(m.footprint.ratio)),
            ("angle (deg)", "", &|(_, m, ..)| whole(m.footprint.degrees)),
            ("main level", "", &|(_, _, level, _)| whole(level)),
            ("texels", "", &|(_, m, ..)| whole(m.transfer.texels())),
            ("along (texels)", "", &|(.., texels)| places(texels[0], 3)),
            ("across (texels)", "", &|(.., texels)| places(texels[1], 3)),
            ("centroid off by", "", &|(.., texels)| places(texels[2], 4)),
        ],
    );
    out + &indented(&table) + "\n"
}

//! The report as a picture.

use super::cube::SMALL;
use super::levels::CURVE;
use super::picture_map::{CUBE_TEXEL, LARGE, SMALL_SCALE, net, tap_map};
use super::plot::{Axes, Canvas, IDEAL, INK, SERIES};
use super::texels::fractions;
use super::{Fingerprint, MAP_ANGLES, MAP_RATIOS, honours};
use crate::picture::Picture;
use crate::sampler::Source;

/// Columns of the picture.
const WIDTH: usize = 1640;
/// Draws the report.
#[must_use]
pub fn draw(adapter: &str, found: &Fingerprint) -> Picture {
    let cubes: usize = found.cube_map.len();
    let scale = if found.quad_map.is_empty() { LARGE } else { SMALL_SCALE };
    let height = 930 + MAP_RATIOS.len() * scale.cell() + cubes * (3 * SMALL * CUBE_TEXEL + 40);
    let mut canvas = Canvas::new(WIDTH, height);
    canvas.text((24, 20), &format!("sampler fingerprint: {adapter}"), 2, INK);
    let (right, all) = found.checks.iter().fold((0, 0), |(a, b), g| (a + g.within, b + g.look_ups));
    let proof = format!(
        "tapline {}   model of these rules predicts {right} of {all} random samples within one step",
        env!("CARGO_PKG_VERSION")
    );
    canvas.text((24, 42), &proof, 1, INK);
    staircases(&mut canvas, found);
    lods(&mut canvas, found);
    ratios(&mut canvas, found);
    let top = 810;
    tap_map(&mut canvas, (24, top), scale, Source::Gradient, &found.map, found);
    if !found.quad_map.is_empty() {
        tap_map(
            &mut canvas,
            (24 + MAP_ANGLES.len() * scale.cell() + 20, top),
            scale,
            Source::Quad,
            &found.quad_map,
            found,
        );
    }
    let mut y = top + 60 + MAP_RATIOS.len() * scale.cell();
    for (source, shown) in &found.cube_map {
        let title = format!(
            "cube, {SMALL} x {SMALL} texels a face: footprint of 6 x 1 texels by {}, largest clamp; +x -x +y -y around +z",
            source.name()
        );
        canvas.text((24, y), &title, 1, INK);
        for (i, s) in shown.iter().enumerate() {
            net(&mut canvas, (24 + i * (4 * SMALL * CUBE_TEXEL + 40), y + 24), s);
        }
        y += 3 * SMALL * CUBE_TEXEL + 40;
    }
    canvas.picture
}

/// Weights over the fraction, whole and enlarged.
fn staircases(canvas: &mut Canvas, found: &Fingerprint) {
    let x = fractions();
    for (i, zoom) in [1.0, 1.0 / 32.0].into_iter().enumerate() {
        let axes =
            Axes { at: (70 + 520 * i, 90), size: (430, 280), x: [0.0, zoom], y: [0.0, zoom] };
        let ticks = [0.0, zoom / 4.0, zoom / 2.0, zoom * 0.75, zoom];
        let title = if i == 0 {
            "weight of the right texel over the fraction of the coordinate"
        } else {
            "the same, the first 1/32"
        };
        axes.draw(canvas, title, ["fraction", "weight"], [&ticks, &ticks]);
        axes.curve(canvas, [[0.0, 0.0], [zoom, zoom]].into_iter(), IDEAL);
        for (w, color) in found.weights.iter().zip(SERIES) {
            let points = x.iter().zip(&w.axes[0].weights).map(|(x, y)| [*x, *y]);
            axes.curve(canvas, points.take_while(|p| p[0] <= zoom), color);
        }
    }
    let mut y = 100;
    canvas.text((1100, y), "grey: ideal", 1, IDEAL);
    for (w, color) in found.weights.iter().zip(SERIES) {
        y += 16;
        let steps = w.axes[0].steps;
        canvas.text((1100, y), &format!("{}: {steps}", w.format.name()), 1, color);
    }
    y += 32;
    for line in facts(found) {
        for part in wrap(&line, 84) {
            canvas.text((1100, y), &part, 1, INK);
            y += 12;
        }
        y += 4;
    }
}

/// Findings in words.
fn facts(found: &Fingerprint) -> Vec<String> {
    let c = &found.curve;
    let (seam, corner) = found.seams.rule;
    let ignored: Vec<String> = found
        .neighbours
        .iter()
        .filter(|(_, lods)| !honours(*lods))
        .map(|(clamp, _)| clamp.to_string())
        .collect();
    let gradients = if ignored.is_empty() {
        "given gradients: honoured at every clamp".to_string()
    } else {
        format!("given gradients: ignored at clamps {}", ignored.join(" "))
    };
    let mut facts = vec![
        format!("weights between levels: {}", found.mips.steps),
        format!("logarithm: {}", c.logs[0].rule.name()),
        format!("lambda - log2 rho: {:+.4} to {:+.4}", c.error[0], c.error[1]),
        format!("rho: {}", found.rho[0].rule.name()),
        gradients,
        format!("cube edge: {}", seam.name()),
        format!("cube corner: {}", corner.name()),
    ];
    for f in &found.filters {
        if f.rule.clamp == 16 {
            let (shape, by) = (f.rule.shape.name(), f.rule.source.name());
            facts.push(format!("{shape}, {by}: {}", f.rule.line.short()));
        }
    }
    facts
}

/// Lines of at most so many characters, broken at blanks.
fn wrap(text: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].len() + 1 + word.len() > most {
            lines.push(format!("  {word}"));
        } else {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last] += word;
        }
    }
    lines
}

/// λ over the length, and its distance from the ideal.
fn lods(canvas: &mut Canvas, found: &Fingerprint) {
    let lods = &found.curve.lods;
    let x = |i: usize| i as f64 / CURVE as f64 - 1.0;
    let whole = Axes { at: (70, 450), size: (430, 280), x: [-1.0, 5.0], y: [0.0, 5.0] };
    let ticks = [-1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    whole.draw(
        canvas,
        "lambda over log2 rho, clamp 1",
        ["log2 rho", "lambda"],
        [&ticks, &ticks[1..]],
    );
    whole.curve(canvas, [[-1.0, 0.0], [0.0, 0.0], [5.0, 5.0]].into_iter(), IDEAL);
    let points = lods.iter().enumerate().map(|(i, l)| [x(i), *l]);
    whole.curve(canvas, points, SERIES[0]);
    let off = Axes { at: (590, 450), size: (430, 280), x: [0.0, 3.0], y: [-0.1, 0.1] };
    off.draw(
        canvas,
        "lambda - log2 rho: the D3D and Vulkan ideal is 0",
        ["log2 rho", "levels"],
        [&[0.0, 1.0, 2.0, 3.0], &[-0.1, -0.05, 0.0, 0.05, 0.1]],
    );
    let points = lods.iter().enumerate().map(|(i, l)| [x(i), l - x(i)]);
    off.curve(canvas, points.filter(|p| (0.0..=3.0).contains(&p[0])), SERIES[0]);
}

/// λ over the ratio for every clamp.
fn ratios(canvas: &mut Canvas, found: &Fingerprint) {
    for (i, source) in [Source::Gradient, Source::Quad].into_iter().enumerate() {
        let axes =
            Axes { at: (1110 + 265 * i, 450), size: (235, 280), x: [0.0, 5.0], y: [-0.2, 7.2] };
        let title = format!("lambda, {}", source.name());
        let y_ticks = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let y_ticks: &[f64] = if i == 0 { &y_ticks } else { &[] };
        axes.draw(
            canvas,
            &title,
            ["log2 ratio", "lambda"],
            [&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], y_ticks],
        );
        for clamp in [1.0, 16.0] {
            let ideal = |ratio: f64| 2.0 + libm::log2((ratio / clamp).max(1.0));
            let points = (0..=100).map(|k| k as f64 / 20.0).map(|x| [x, ideal(libm::exp2(x))]);
            axes.curve(canvas, points, IDEAL);
        }
        let of = found.ratios.iter().filter(|r| r.source == source);
        for (r, color) in of.zip(SERIES) {
            let points = r.sweep.iter().map(|[ratio, lod]| [libm::log2(*ratio), *lod]);
            axes.curve(canvas, points, color);
        }
    }
    for (i, (clamp, color)) in [1, 2, 4, 8, 16].iter().zip(SERIES).enumerate() {
        canvas.text((1110 + 72 * i, 764), &format!("clamp {clamp}"), 1, color);
    }
    canvas.text(
        (1110, 778),
        "shorter derivative 4 texels; grey: ideal of clamps 1 and 16",
        1,
        IDEAL,
    );
}

//! The report as text: each finding, how it was measured, how fine the measurement is.

use std::io::{self, Write};

use super::levels::SIZE;
use super::steps::{SWEEP, Staircase, Steps};
use super::taps::Taps;
use super::unit::{Format, Shape, Source};
use super::{Filter, Fingerprint, honours, shape_name, source_name};
use crate::report::table::{Align, Table};

/// Writes the report.
///
/// # Errors
///
/// What the writer fails with.
pub fn print(out: &mut dyn Write, adapter: &str, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "fingerprint of {adapter}\n")?;
    weights(out, found)?;
    levels(out, found)?;
    gradients(out, found)?;
    filters(out, found)?;
    taps(out, found)?;
    cubes(out, found)?;
    checks(out, found)
}

fn stairs(s: &Staircase) -> String {
    let mut text = format!("{}, {} different weights", s.steps, s.distinct);
    if s.off > 0 {
        text += &format!(
            "; {} of {} off that rule by up to {:.4}",
            s.off,
            s.weights.len(),
            s.worst
        );
    }
    if !s.rising {
        text += "; not rising everywhere";
    }
    if s.steps != Steps::Smooth {
        text += &format!(
            "; leaves 0 at {:.5}, reaches 1 at {:.5}",
            s.turns[0], s.turns[1]
        );
    }
    text
}

fn weights(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "1. weights between texels")?;
    writeln!(
        out,
        "   measured: an impulse column and row, the coordinate in {SWEEP} steps from one texel centre to the next;"
    )?;
    writeln!(
        out,
        "   resolution 1/{SWEEP} texel, and of the output its format's own (8 bits of rgba8unorm)"
    )?;
    for w in &found.weights {
        let [x, y] = &w.axes;
        writeln!(out, "   {}: {}", w.format.name(), stairs(x))?;
        if x.weights != y.weights {
            writeln!(out, "       rows differ: {}", stairs(y))?;
        }
        if let Some(distinct) = w.fine {
            writeln!(
                out,
                "       {distinct} different weights at 256 coordinates 2^-20 texel apart (as fine as f32 resolves them there)"
            )?;
        }
        writeln!(
            out,
            "       weight of a texel = column's x row's within {:.1e}; the four sum to 1 within {:.1e}",
            w.separable, w.sum
        )?;
    }
    let c = &found.coordinates;
    writeln!(
        out,
        "   nearest filter: the texel changes {:+.6} texel from the border (bisection to 2^-20)",
        c.nearest_switch
    )?;
    writeln!(
        out,
        "   clamp to edge: weight of the outermost texel {:.4} at a quarter texel from the edge, {:.4} at 1000 texels beyond; nearest {}\n",
        c.edge[0],
        c.edge[1],
        if c.clamps { "stays on it" } else { "LEAVES it" }
    )
}

fn levels(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    let c = &found.curve;
    writeln!(out, "2. level of detail without anisotropy")?;
    writeln!(
        out,
        "   measured: texels that are their level's number, {SIZE} x {SIZE}, 9 levels; one look-up shows lambda with its weights"
    )?;
    writeln!(
        out,
        "   weights between levels (lambda given, {SWEEP} steps): {}",
        stairs(&found.mips)
    )?;
    let bits = c.bits.map_or("no grid of up to 10 bits".into(), |b| {
        format!("{b} fraction bits")
    });
    writeln!(
        out,
        "   lambda from derivatives: {bits}, {} different values at {SWEEP} lengths of an octave",
        c.distinct
    )?;
    writeln!(
        out,
        "   lambda - log2 rho: {:+.4} to {:+.4} levels over 5 octaves in steps of 1/256; octaves repeat within {:.1e}",
        c.error[0], c.error[1], c.repeats
    )?;
    let (best, next) = (c.logs[0], c.logs[1]);
    writeln!(
        out,
        "   logarithm: {}, worst {:.1e} levels (next: {}, {:.1e})",
        best.rule.name(),
        best.worst,
        next.rule.name(),
        next.worst
    )?;
    writeln!(
        out,
        "   nearest level: level 1 gives way to 2 at log2 rho = {:.4} (ideal 1.5)",
        c.nearest_switch
    )?;
    let (best, next) = (found.rho[0], found.rho[1]);
    writeln!(
        out,
        "   rho of 512 random pairs: {}, worst {:.1e}, mean {:.1e} levels",
        best.rule.name(),
        best.worst,
        best.mean
    )?;
    writeln!(
        out,
        "       next best: {}, worst {:.1e}, mean {:.1e}\n",
        next.rule.name(),
        next.worst,
        next.mean
    )
}

fn gradients(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "3. are the derivatives of textureSampleGrad honoured?")?;
    writeln!(
        out,
        "   measured: lambda for derivatives of 8 texels (ideal 3), once in four equal invocations, once beside neighbours"
    )?;
    writeln!(
        out,
        "   that look up 4 texels away (differences between invocations would give 2)"
    )?;
    for (clamp, [alone, together]) in &found.neighbours {
        let verdict = if honours([*alone, *together]) {
            "honoured"
        } else if (alone - together).abs() < 1e-3 {
            "IGNORED"
        } else {
            "IGNORED: differences between neighbouring invocations take their place"
        };
        writeln!(
            out,
            "   anisotropy_clamp {clamp:2}: {alone:.3} alone, {together:.3} beside neighbours: {verdict}"
        )?;
    }
    writeln!(out)
}

fn filter_row(table: &mut Table, f: &Filter) {
    let rule = f.rule;
    table.row([
        shape_name(rule.shape).to_string(),
        source_name(rule.source).to_string(),
        rule.clamp.to_string(),
        format!("{}; {}", rule.lod.width.name(), rule.lod.mix.name()),
        format!("{:.1e}", f.lod.worst),
        format!("{:.1e}", f.lines[0].mean),
        format!("{:.1e}", f.lines[1].mean),
    ]);
}

fn filters(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "4. anisotropic filter: level of detail and shape")?;
    if found.filters.is_empty() {
        return writeln!(out, "   the driver offers none\n");
    }
    writeln!(
        out,
        "   measured: lambda of 251 footprints (ratios 1 to 32 at three widths, 128 skewed pairs; on cubes 512 random ones)"
    )?;
    writeln!(
        out,
        "   against 54 rules; the shape by 384 random look-ups into noise 0..1 against {} shapes",
        super::model::Line::all(Shape::Cube).len()
    )?;
    let mut table = Table::new(&[
        ("texture", Align::Left),
        ("by", Align::Left),
        ("clamp", Align::Right),
        ("level of detail", Align::Left),
        ("worst (levels)", Align::Right),
        ("shape, mean error", Align::Right),
        ("next shape", Align::Right),
    ]);
    for f in &found.filters {
        filter_row(&mut table, f);
    }
    indent(out, &table)?;
    writeln!(out, "   shapes:")?;
    let mut shapes: Vec<String> = Vec::new();
    for f in &found.filters {
        let name = format!(
            "{} {}: {}",
            shape_name(f.rule.shape),
            source_name(f.rule.source),
            f.rule.line.name()
        );
        if !shapes.contains(&name) {
            writeln!(out, "       {name}")?;
            shapes.push(name);
        }
    }
    writeln!(out)
}

fn indent(out: &mut dyn Write, table: &Table) -> io::Result<()> {
    table
        .to_string()
        .lines()
        .try_for_each(|line| writeln!(out, "   {line}"))
}

/// Largest and smallest weight of taps.
fn extent(taps: &Taps) -> [f64; 2] {
    let weights = || taps.taps.iter().map(|t| t.weight);
    [
        weights().fold(f64::INFINITY, f64::min),
        weights().fold(0.0, f64::max),
    ]
}

fn taps(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "5. taps of textureSampleGrad on 2-D textures")?;
    writeln!(
        out,
        "   measured: kinks of the texture max(0, x) under a sweep of 1/16 texel; places finer than 1/256 texel; the shorter"
    )?;
    writeln!(
        out,
        "   derivative is one texel. Teeth that point down: the filter is no sum of bilinear taps that move with the coordinate"
    )?;
    let mut table = Table::new(&[
        ("clamp", Align::Right),
        ("ratio", Align::Right),
        ("angle (deg)", Align::Right),
        ("lambda", Align::Right),
        ("taps", Align::Right),
        ("spacing (texels)", Align::Right),
        ("span/longer", Align::Right),
        ("direction (deg)", Align::Right),
        ("weights", Align::Right),
    ]);
    let mut strange = 0;
    for t in &found.taps {
        let f = t.footprint;
        if !t.explains() {
            strange += 1;
            continue;
        }
        let [low, high] = extent(t);
        let spacing = t.spacing();
        let ends = t.taps.first().zip(t.taps.last());
        let apart = ends.map_or([0.0; 2], |(a, b)| [0, 1].map(|i| b.offset[i] - a.offset[i]));
        let angle = libm::atan2(apart[1], apart[0])
            .to_degrees()
            .rem_euclid(180.0);
        let dash = || "-".to_string();
        table.row([
            f.clamp.to_string(),
            f.ratio.to_string(),
            f.degrees.to_string(),
            format!("{:.3}", t.lod),
            t.taps.len().to_string(),
            spacing.map_or_else(dash, |[mean, off]| format!("{mean:.4} +-{off:.4}")),
            spacing.map_or_else(dash, |_| {
                let texels = libm::hypot(apart[0], apart[1]) * libm::exp2(t.lod.round());
                format!("{:.4}", texels / f.ratio)
            }),
            spacing.map_or_else(dash, |_| format!("{angle:.2}")),
            format!("{low:.4}..{high:.4}"),
        ]);
    }
    if !table.is_empty() {
        indent(out, &table)?;
    }
    if strange > 0 {
        writeln!(
            out,
            "   {strange} of {} footprints are no sum of bilinear taps: see the shape in 4 and the texels below",
            found.taps.len()
        )?;
    }
    writeln!(
        out,
        "   texels (impulse at each texel of every level of a {0} x {0} texture in turn): lengths of boxes with the same variance",
        super::MAP
    )?;
    let mut table = Table::new(&[
        ("by", Align::Left),
        ("ratio", Align::Right),
        ("angle (deg)", Align::Right),
        ("main level", Align::Right),
        ("texels", Align::Right),
        ("along (texels)", Align::Right),
        ("across (texels)", Align::Right),
        ("centroid off by", Align::Right),
    ]);
    let maps = [
        (Source::Gradient, &found.map),
        (Source::Quad, &found.quad_map),
    ];
    for (source, map) in maps {
        for m in map {
            let level = m.transfer.main_level();
            let [dx, _] = m.footprint.derivatives();
            let length = libm::hypot(dx[0], dx[1]);
            let scale = libm::exp2(-(level as f64));
            let at = [(super::MAP as f64 + 1.0) / 2.0 * scale; 2];
            let (off, [along, across]) = m.transfer.moments(level, at, dx.map(|c| c / length));
            table.row([
                source_name(source).to_string(),
                m.footprint.ratio.to_string(),
                m.footprint.degrees.to_string(),
                level.to_string(),
                m.transfer.texels().to_string(),
                format!("{:.3}", along / scale),
                format!("{:.3}", across / scale),
                format!("{:.4}", libm::hypot(off[0], off[1]) / scale),
            ]);
        }
    }
    indent(out, &table)?;
    writeln!(out)
}

fn cubes(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "6. cube maps")?;
    let ties = &found.ties;
    writeln!(
        out,
        "   equal components: {} of {} edges and corners give z before y before x",
        ties.expected,
        ties.seen.len()
    )?;
    if ties.expected < ties.seen.len() {
        for (d, face) in &ties.seen {
            writeln!(out, "       {d:?} -> {}", super::cube::Ties::name(*face))?;
        }
    }
    let s = &found.seams;
    writeln!(
        out,
        "   edges and corners: every texel's weight of {} look-ups within 0.45 texel of edges and corners of all faces, 8 x 8 texels a face",
        s.look_ups
    )?;
    let ((seam, corner), worst) = s.ranked[0];
    writeln!(
        out,
        "       beyond an edge: {}; in place of the texel that a corner lacks: {}; worst weight off by {worst:.1e}",
        seam.name(),
        corner.name()
    )?;
    let ((seam, corner), worst) = s.ranked[1];
    writeln!(
        out,
        "       next best: {}; {}; {worst:.1e}",
        seam.name(),
        corner.name()
    )?;
    let corner: Vec<String> = s.at_corner.iter().map(|w| format!("{w:.4}")).collect();
    writeln!(
        out,
        "       exactly at the corner (1, 1, 1): weights {}",
        corner.join(", ")
    )?;
    let (best, next) = (found.cube_rho[0], found.cube_rho[1]);
    let name = |(p, r): (super::Projection, super::Rho)| format!("{}; {}", r.name(), p.name());
    writeln!(
        out,
        "   rho of 512 random 3-D pairs: {}, worst {:.1e} levels",
        name(best.rule),
        best.worst
    )?;
    writeln!(
        out,
        "       next best: {}, worst {:.1e}",
        name(next.rule),
        next.worst
    )?;
    for (source, shown) in &found.cube_map {
        writeln!(
            out,
            "   footprint 6 x 1 texels by {}, largest clamp:",
            source_name(*source)
        )?;
        for s in shown {
            let faces: Vec<String> = (0..6)
                .map(|face| {
                    let level = s.transfer.main_level();
                    let count = s.transfer.levels[level].len() / 6;
                    let part = &s.transfer.levels[level][face * count..(face + 1) * count];
                    (face, part.iter().map(|w| f64::from(*w)).sum::<f64>())
                })
                .filter(|(_, w)| *w > 1e-6)
                .map(|(face, w)| format!("{} {w:.3}", super::cube::Ties::name(face)))
                .collect();
            writeln!(
                out,
                "       {}: level {}, {} texels, {}",
                s.title,
                s.transfer.main_level(),
                s.transfer.texels(),
                faces.join(" ")
            )?;
        }
    }
    writeln!(out)
}

fn checks(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(
        out,
        "7. proof: a model with these rules against random look-ups into noise 0..1 in {}",
        Format::Half.name()
    )?;
    writeln!(
        out,
        "   (footprints of 1 to 16 texels, ratios 1 to 16, cubes over edges and corners too)"
    )?;
    let mut table = Table::new(&[
        ("texture", Align::Left),
        ("by", Align::Left),
        ("clamp", Align::Right),
        ("look-ups", Align::Right),
        ("within 2^-16", Align::Right),
        ("within 1 step", Align::Right),
        ("step", Align::Right),
        ("worst", Align::Right),
        ("mean", Align::Right),
    ]);
    let (mut right, mut all, mut straddling) = (0, 0, [0; 2]);
    for g in &found.checks {
        right += g.within;
        all += g.look_ups;
        straddling = [0, 1].map(|i| straddling[i] + g.straddling[i]);
        table.row([
            shape_name(g.shape).to_string(),
            source_name(g.source).to_string(),
            g.clamp.to_string(),
            g.look_ups.to_string(),
            g.exact.to_string(),
            g.within.to_string(),
            format!("{:.5}", g.step),
            format!("{:.1e}", g.worst),
            format!("{:.1e}", g.mean),
        ]);
    }
    indent(out, &table)?;
    let [quads, predicted] = straddling;
    writeln!(
        out,
        "   model predicts {right} of {all} random samples within one step"
    )?;
    writeln!(
        out,
        "   apart: quads of textureSample that lie on several faces of a cube: {predicted} of {quads} predicted"
    )
}

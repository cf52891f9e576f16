//! The report as text: each finding, how it was measured, how fine the measurement is.

use std::io::{self, Write};

use super::check::Group;
use super::levels::SIZE;
use super::steps::{SWEEP, Staircase, Steps};
use super::text_taps::{self, indent, power};
use super::{Fingerprint, honours, shape_name, source_name};
use crate::report::table::{Table, places, text, value, whole};
use crate::sampler::Format;

/// Writes the report.
///
/// # Errors
///
/// The writer's error.
pub fn print(out: &mut dyn Write, adapter: &str, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "fingerprint of {adapter}\n")?;
    weights(out, found)?;
    levels(out, found)?;
    gradients(out, found)?;
    text_taps::filters(out, found)?;
    text_taps::taps(out, found)?;
    cubes(out, found)?;
    checks(out, found)
}

fn stairs(s: &Staircase) -> String {
    let mut text = format!("{}, {} different weights", s.steps, s.distinct);
    if s.off > 0 {
        text +=
            &format!("; {} of {} off that rule by up to {:.4}", s.off, s.weights.len(), s.worst);
    }
    if !s.rising {
        text += "; not rising everywhere";
    }
    if s.steps != Steps::Smooth {
        text += &format!("; leaves 0 at {:.5}, reaches 1 at {:.5}", s.turns[0], s.turns[1]);
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
    let bits = c.bits.map_or("no grid of up to 10 bits".into(), |b| format!("{b} fraction bits"));
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
    writeln!(out, "   that look up 4 texels away (differences between invocations would give 2)")?;
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
    writeln!(out, "       next best: {}; {}; {worst:.1e}", seam.name(), corner.name())?;
    let corner: Vec<String> = s.at_corner.iter().map(|w| format!("{w:.4}")).collect();
    writeln!(out, "       exactly at the corner (1, 1, 1): weights {}", corner.join(", "))?;
    let (best, next) = (found.cube_rho[0], found.cube_rho[1]);
    let name = |(p, r): (super::Projection, super::Rho)| format!("{}; {}", r.name(), p.name());
    writeln!(
        out,
        "   rho of 512 random 3-D pairs: {}, worst {:.1e} levels",
        name(best.rule),
        best.worst
    )?;
    writeln!(out, "       next best: {}, worst {:.1e}", name(next.rule), next.worst)?;
    for (source, shown) in &found.cube_map {
        writeln!(out, "   footprint 6 x 1 texels by {}, largest clamp:", source_name(*source))?;
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
    let sum = |count: fn(&Group) -> usize| found.checks.iter().map(count).sum::<usize>();
    indent(out, &checked(found))?;
    let (right, all) = (sum(|g| g.within), sum(|g| g.look_ups));
    let (quads, predicted) = (sum(|g| g.straddling[0]), sum(|g| g.straddling[1]));
    writeln!(out, "   model predicts {right} of {all} random samples within one step")?;
    writeln!(
        out,
        "   apart: quads of textureSample that lie on several faces of a cube: {predicted} of {quads} predicted"
    )
}

/// How many look-ups the model predicts, texture by texture.
pub(super) fn checked(found: &Fingerprint) -> Table {
    Table::of(
        &found.checks,
        &[
            ("texture", "texture", &|g| text(shape_name(g.shape))),
            ("by", "by", &|g| text(source_name(g.source))),
            ("clamp", "clamp", &|g| whole(g.clamp)),
            ("look-ups", "look_ups", &|g| whole(g.look_ups)),
            ("within 2^-16", "within_2^-16", &|g| whole(g.exact)),
            ("within 1 step", "within_one_step", &|g| whole(g.within)),
            ("step", "step", &|g| places(g.step, 5)),
            ("worst", "worst", &|g| power(g.fit.worst)),
            ("mean", "mean", &|g| power(g.fit.mean)),
            ("", "quads_on_several_faces", &|g| value(g.straddling[0])),
            ("", "of_those_within_one_step", &|g| value(g.straddling[1])),
        ],
    )
}

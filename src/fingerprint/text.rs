//! The report as text: each finding, how it was measured, how fine the measurement is.

use std::io::{self, Write};

use super::check::Group;
use super::cube::Ties;
use super::levels::{Curve, Fit, SIZE};
use super::rho::{Projection, Rho};
use super::steps::{SWEEP, Staircase, Steps};
use super::text_taps::{filters, indented, power, taps};
use super::{Fingerprint, honours};
use crate::report::table::{Table, places, text, value, whole};
use crate::sampler::Format;

/// Writes the report.
///
/// # Errors
///
/// The writer's error.
pub fn print(out: &mut dyn Write, adapter: &str, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "fingerprint of {adapter}\n")?;
    for section in [weights, levels, gradients, filters, taps, cubes, checks] {
        out.write_all(section(found).as_bytes())?;
    }
    Ok(())
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

fn weights(found: &Fingerprint) -> String {
    let mut out = format!(
        "1. weights between texels
   measured: an impulse column and row, the coordinate in {SWEEP} steps from one texel centre to the next;
   resolution 1/{SWEEP} texel, and of the output its format's own (8 bits of rgba8unorm)
"
    );
    for w in &found.weights {
        let [x, y] = &w.axes;
        out += &format!("   {}: {}\n", w.format.name(), stairs(x));
        if x.weights != y.weights {
            out += &format!("       rows differ: {}\n", stairs(y));
        }
        if let Some(distinct) = w.fine {
            out += &format!(
                "       {distinct} different weights at 256 coordinates 2^-20 texel apart (as fine as f32 resolves them there)\n"
            );
        }
        let (separable, sum) = (w.separable, w.sum);
        out += &format!(
            "       weight of a texel = column's x row's within {separable:.1e}; the four sum to 1 within {sum:.1e}\n"
        );
    }
    let c = &found.coordinates;
    let (switch, [quarter, beyond]) = (c.nearest_switch, c.edge);
    let nearest = if c.clamps { "stays on it" } else { "LEAVES it" };
    out + &format!(
        "   nearest filter: the texel changes {switch:+.6} texel from the border (bisection to 2^-20)
   clamp to edge: weight of the outermost texel {quarter:.4} at a quarter texel from the edge, {beyond:.4} at 1000 texels beyond; nearest {nearest}

"
    )
}

fn levels(found: &Fingerprint) -> String {
    let Curve { distinct, error: [low, high], repeats, nearest_switch, bits, logs, .. } =
        &found.curve;
    let mips = stairs(&found.mips);
    let bits = bits.map_or("no grid of up to 10 bits".into(), |b| format!("{b} fraction bits"));
    let ((log, log_off), (next_log, next_off)) =
        ((logs[0].rule.name(), logs[0].worst), (logs[1].rule.name(), logs[1].worst));
    let rho = |Fit { rule, worst, mean }: Fit<Rho>| {
        format!("{}, worst {worst:.1e}, mean {mean:.1e}", rule.name())
    };
    let (best, next) = (rho(found.rho[0]), rho(found.rho[1]));
    format!(
        "2. level of detail without anisotropy
   measured: texels that are their level's number, {SIZE} x {SIZE}, 9 levels; one look-up shows lambda with its weights
   weights between levels (lambda given, {SWEEP} steps): {mips}
   lambda from derivatives: {bits}, {distinct} different values at {SWEEP} lengths of an octave
   lambda - log2 rho: {low:+.4} to {high:+.4} levels over 5 octaves in steps of 1/256; octaves repeat within {repeats:.1e}
   logarithm: {log}, worst {log_off:.1e} levels (next: {next_log}, {next_off:.1e})
   nearest level: level 1 gives way to 2 at log2 rho = {nearest_switch:.4} (ideal 1.5)
   rho of 512 random pairs: {best} levels
       next best: {next}

"
    )
}

fn gradients(found: &Fingerprint) -> String {
    let mut out = String::from(
        "3. are the derivatives of textureSampleGrad honoured?
   measured: lambda for derivatives of 8 texels (ideal 3), once in four equal invocations, once beside neighbours
   that look up 4 texels away (differences between invocations would give 2)
",
    );
    for (clamp, [alone, together]) in &found.neighbours {
        let verdict = if honours([*alone, *together]) {
            "honoured"
        } else if (alone - together).abs() < 1e-3 {
            "IGNORED"
        } else {
            "IGNORED: differences between neighbouring invocations take their place"
        };
        out += &format!(
            "   anisotropy_clamp {clamp:2}: {alone:.3} alone, {together:.3} beside neighbours: {verdict}\n"
        );
    }
    out + "\n"
}

fn cubes(found: &Fingerprint) -> String {
    let (ties, all) = (found.ties.expected, found.ties.seen.len());
    let mut out = format!(
        "6. cube maps\n   equal components: {ties} of {all} edges and corners give z before y before x\n"
    );
    if ties < all {
        for (d, face) in &found.ties.seen {
            out += &format!("       {d:?} -> {}\n", Ties::name(*face));
        }
    }
    let s = &found.seams;
    let [((seam, corner), worst), ((next_seam, next_corner), next_worst)] =
        [0, 1].map(|i| s.ranked[i]).map(|((s, c), worst)| ((s.name(), c.name()), worst));
    let at_corner: Vec<String> = s.at_corner.iter().map(|w| format!("{w:.4}")).collect();
    let (look_ups, at_corner) = (s.look_ups, at_corner.join(", "));
    let rho = |Fit { rule: (p, r), worst, .. }: Fit<(Projection, Rho)>| {
        format!("{}; {}, worst {worst:.1e}", r.name(), p.name())
    };
    let (best, next) = (rho(found.cube_rho[0]), rho(found.cube_rho[1]));
    out += &format!(
        "   edges and corners: every texel's weight of {look_ups} look-ups within 0.45 texel of edges and corners of all faces, 8 x 8 texels a face
       beyond an edge: {seam}; in place of the texel that a corner lacks: {corner}; worst weight off by {worst:.1e}
       next best: {next_seam}; {next_corner}; {next_worst:.1e}
       exactly at the corner (1, 1, 1): weights {at_corner}
   rho of 512 random 3-D pairs: {best} levels
       next best: {next}
"
    );
    for (source, shown) in &found.cube_map {
        let by = source.name();
        out += &format!("   footprint 6 x 1 texels by {by}, largest clamp:\n");
        for s in shown {
            let (level, texels) = (s.transfer.main_level(), s.transfer.texels());
            let weights = &s.transfer.levels[level];
            let faces = weights.chunks(weights.len() / 6).enumerate();
            let faces: Vec<String> = faces
                .map(|(face, part)| (face, part.iter().map(|w| f64::from(*w)).sum::<f64>()))
                .filter(|(_, w)| *w > 1e-6)
                .map(|(face, w)| format!("{} {w:.3}", Ties::name(face)))
                .collect();
            let (title, faces) = (&s.title, faces.join(" "));
            out += &format!("       {title}: level {level}, {texels} texels, {faces}\n");
        }
    }
    out + "\n"
}

fn checks(found: &Fingerprint) -> String {
    let sum = |count: fn(&Group) -> usize| found.checks.iter().map(count).sum::<usize>();
    let (right, all) = (sum(|g| g.within), sum(|g| g.look_ups));
    let (quads, predicted) = (sum(|g| g.straddling[0]), sum(|g| g.straddling[1]));
    let (format, table) = (Format::Half.name(), indented(&checked(found)));
    format!(
        "7. proof: a model with these rules against random look-ups into noise 0..1 in {format}
   (footprints of 1 to 16 texels, ratios 1 to 16, cubes over edges and corners too)
{table}   model predicts {right} of {all} random samples within one step
   apart: quads of textureSample that lie on several faces of a cube: {predicted} of {quads} predicted
"
    )
}

/// How many look-ups the model predicts, texture by texture.
pub(super) fn checked(found: &Fingerprint) -> Table {
    Table::of(
        &found.checks,
        &[
            ("texture", "texture", &|g| text(g.shape.name())),
            ("by", "by", &|g| text(g.source.name())),
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

//! The sections of the text about the anisotropic filter.

use std::io::{self, Write};

use super::taps::Taps;
use super::{Filter, Fingerprint, shape_name, source_name};
use crate::report::table::{Align, Table};
use crate::sampler::{Shape, Source};

fn filter_row(table: &mut Table, f: &Filter) {
    let rule = f.rule;
    table.row([
        shape_name(rule.shape).to_string(),
        source_name(rule.source).to_string(),
        rule.clamp.to_string(),
        rule.lod.name(),
        format!("{:.1e}", f.lod.worst),
        format!("{:.1e}", f.lines[0].mean),
        format!("{:.1e}", f.lines[1].mean),
    ]);
}

pub(super) fn filters(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "4. anisotropic filter: level of detail and shape")?;
    if found.filters.is_empty() {
        return writeln!(out, "   the driver offers none\n");
    }
    writeln!(
        out,
        "   measured: lambda of 251 footprints (ratios 1 to 32 at three widths, 128 skewed pairs; on cubes up to 512 random ones)"
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

pub(super) fn indent(out: &mut dyn Write, table: &Table) -> io::Result<()> {
    table.to_string().lines().try_for_each(|line| writeln!(out, "   {line}"))
}

/// Largest and smallest weight of taps.
fn extent(taps: &Taps) -> [f64; 2] {
    let weights = || taps.taps.iter().map(|t| t.weight);
    [weights().fold(f64::INFINITY, f64::min), weights().fold(0.0, f64::max)]
}

pub(super) fn taps(out: &mut dyn Write, found: &Fingerprint) -> io::Result<()> {
    writeln!(out, "5. taps of textureSampleGrad, on 2-D textures and on face +z of cubes")?;
    writeln!(
        out,
        "   measured: kinks of the texture max(0, x) under a sweep of 1/16 texel; places finer than 1/256 texel; the shorter"
    )?;
    writeln!(
        out,
        "   derivative is one texel. Teeth that point down: the filter is no sum of bilinear taps that move with the coordinate"
    )?;
    let mut table = Table::new(&[
        ("texture", Align::Left),
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
        let angle = libm::atan2(apart[1], apart[0]).to_degrees().rem_euclid(180.0);
        let dash = || "-".to_string();
        table.row([
            shape_name(f.shape).to_string(),
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
    let maps = [(Source::Gradient, &found.map), (Source::Quad, &found.quad_map)];
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

//! The report as JSON.

use serde_json::{Value, json};

use super::cube::Ties;
use super::levels::Fit;
use super::model::Rule;
use super::steps::{Rounding, Staircase, Steps};
use super::taps::{Footprint, Taps};
use super::transfer::Transfer;
use super::{Filter, Fingerprint, Mapped, honours};
use crate::sampler::Source;

/// Every finding; the caller adds the adapter.
#[must_use]
pub fn to_json(found: &Fingerprint) -> Value {
    let c = &found.coordinates;
    let weights: Vec<Value> = found
        .weights
        .iter()
        .map(|w| {
            json!({
                "format": w.format.name(),
                "columns": staircase(&w.axes[0]),
                "rows": staircase(&w.axes[1]),
                "distinct_at_256_coordinates_2^-20_apart": w.fine,
                "separable_within": w.separable,
                "sum_within": w.sum,
            })
        })
        .collect();
    json!({
        "weights": weights,
        "coordinates": {
            "nearest_switch_texels": c.nearest_switch,
            "nearest_clamps": c.clamps,
            "edge_weights": c.edge,
        },
        "levels": levels(found),
        "gradients": found.neighbours.iter().map(|(clamp, [alone, together])| json!({
            "clamp": clamp,
            "lod_alone": alone,
            "lod_beside_neighbours": together,
            "honoured": honours([*alone, *together]),
        })).collect::<Vec<_>>(),
        "anisotropy": {
            "filters": found.filters.iter().map(filter).collect::<Vec<_>>(),
            "lod_over_ratio": found.ratios.iter().map(|r| json!({
                "clamp": r.clamp,
                "by": r.source.name(),
                "ratio_and_lod": r.sweep,
            })).collect::<Vec<_>>(),
            "taps": found.taps.iter().map(taps).collect::<Vec<_>>(),
            "map": map(Source::Gradient, &found.map),
            "quad_map": map(Source::Quad, &found.quad_map),
        },
        "cube": cube(found),
        "checks": super::text::checked(found).json(),
    })
}

fn steps(steps: Steps) -> Value {
    match steps {
        Steps::Smooth => json!({"bits": null, "rounding": null}),
        Steps::Bits { bits, rounding } => json!({
            "bits": bits,
            "rounding": match rounding {
                Rounding::Floor => "floor",
                Rounding::Nearest => "nearest",
                Rounding::NearestEven => "nearest-even",
            },
        }),
    }
}

fn staircase(s: &Staircase) -> Value {
    json!({
        "steps": steps(s.steps),
        "distinct": s.distinct,
        "worst": s.worst,
        "off_by_more_than_half_a_step": s.off,
        "rising": s.rising,
        "leaves_first_and_reaches_last_at": s.turns,
        "weights": s.weights.iter().step_by(16).collect::<Vec<_>>(),
    })
}

fn fit<R: Copy>(fit: &Fit<R>, name: impl Fn(R) -> String) -> Value {
    json!({"rule": name(fit.rule), "worst": fit.worst, "mean": fit.mean})
}

fn levels(found: &Fingerprint) -> Value {
    let c = &found.curve;
    json!({
        "weights_between_levels": staircase(&found.mips),
        "log2_rho_from": -1.0,
        "points_per_octave": super::levels::CURVE,
        "lod": c.lods.iter().step_by(4).collect::<Vec<_>>(),
        "lod_every": 4,
        "error_min_max": c.error,
        "octaves_repeat_within": c.repeats,
        "fraction_bits": c.bits,
        "distinct_in_an_octave": c.distinct,
        "logarithm": c.logs.iter().map(|f| fit(f, |r| r.name().into())).collect::<Vec<_>>(),
        "nearest_switch_log2": c.nearest_switch,
        "rho": found.rho.iter().map(|f| fit(f, |r| r.name().into())).collect::<Vec<_>>(),
    })
}

fn rule(r: &Rule) -> Value {
    json!({
        "texture": r.shape.name(),
        "by": r.source.name(),
        "clamp": r.clamp,
        "lod": {"width": r.lod.width.name(), "lengths": r.lod.lengths.name(), "levels": r.lod.mix.name()},
        "shape": r.line.name(),
    })
}

fn filter(f: &Filter) -> Value {
    json!({
        "rule": rule(&f.rule),
        "lod_worst": f.lod.worst,
        "lod_mean": f.lod.mean,
        "shapes": f.lines.iter().take(3).map(|f| fit(f, |line| line.name())).collect::<Vec<_>>(),
    })
}

fn footprint(f: &Footprint) -> Value {
    json!({"texture": f.shape.name(), "clamp": f.clamp, "ratio": f.ratio, "degrees": f.degrees})
}

fn taps(t: &Taps) -> Value {
    json!({
        "footprint": footprint(&t.footprint),
        "lod": t.lod,
        "are_bilinear_taps": t.explains(),
        "taps": if t.explains() {
            t.taps.iter().map(|t| json!({"offset": t.offset, "weight": t.weight})).collect()
        } else {
            Vec::new()
        },
        "negative": t.negative,
    })
}

/// Texels with weight: level, index, weight.
fn transfer(t: &Transfer) -> Vec<Value> {
    let levels = t.levels.iter().enumerate();
    levels
        .flat_map(|(level, weights)| {
            let texels = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
            texels.map(move |(index, w)| json!([level, index, w]))
        })
        .collect()
}

fn map(source: Source, map: &[Mapped]) -> Value {
    json!({
        "by": source.name(),
        "size": super::MAP,
        "level_index_weight": map.iter().map(|m| json!({
            "footprint": footprint(&m.footprint),
            "texels": transfer(&m.transfer),
        })).collect::<Vec<_>>(),
    })
}

fn cube(found: &Fingerprint) -> Value {
    let s = &found.seams;
    let mut maps = Vec::new();
    for (source, shown) in &found.cube_map {
        for s in shown {
            maps.push(json!({
                "by": source.name(),
                "title": s.title,
                "direction": s.query.at,
                "dx": s.query.dx,
                "dy": s.query.dy,
                "size": super::cube::SMALL,
                "level_index_weight": transfer(&s.transfer),
            }));
        }
    }
    json!({
        "ties": found.ties.seen.iter().map(|(d, f)| json!([d, Ties::name(*f)])).collect::<Vec<_>>(),
        "ties_as_z_before_y_before_x": found.ties.expected,
        "seams": s.ranked.iter().map(|((seam, corner), worst)| json!({
            "edge": seam.name(),
            "corner": corner.name(),
            "worst_weight": worst,
        })).collect::<Vec<_>>(),
        "weights_at_a_corner": s.at_corner,
        "rho": found.cube_rho.iter().take(4)
            .map(|f| fit(f, |(p, r)| format!("{}; {}", r.name(), p.name()))).collect::<Vec<_>>(),
        "footprints": maps,
    })
}

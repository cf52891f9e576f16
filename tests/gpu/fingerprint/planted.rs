//! The analysis finds the rules that a model was given. No GPU is needed.

use tapline::base::num;
use tapline::fingerprint::aniso::{CLAMPS, Count, Lengths, LodRule, Mix, Width};
use tapline::fingerprint::check::lines;
use tapline::fingerprint::cube::{self, ties};
use tapline::fingerprint::levels::{Log, curve, mip_weights, rho};
use tapline::fingerprint::model::{Corner, Line, Model, Rule, Seam, Spacing};
use tapline::fingerprint::rho::{Projection, Rho};
use tapline::fingerprint::steps::{Rounding, Staircase, Steps, grid_bits, staircase};
use tapline::fingerprint::taps::{Footprint, taps};
use tapline::fingerprint::texels::{coordinates, weights};
use tapline::fingerprint::{Fingerprint, fingerprint, honours};
use tapline::sampler::{Format, Shape, Source};

use super::models::{bits, odd, orthodox, rules};

fn sweep(weight: impl Fn(f64) -> f64) -> Staircase {
    let weights = (0..=4096).map(|k| weight(f64::from(k) / 4096.0));
    staircase(weights.collect(), None)
}

#[test]
fn every_staircase_of_up_to_ten_bits_is_recognised_and_smooth_weights_are_none() {
    for width in 1..=10 {
        for rounding in Rounding::ALL {
            let rule = bits(width, rounding);
            let found = sweep(|f| rule.weight(f));
            assert_eq!(found.steps, rule);
            assert_eq!((found.off, found.distinct), (0, (1 << width) + 1));
            // The output's own rounding to 11 bits, as in half floats, does not hide up to 8 bits.
            if width <= 8 {
                assert_eq!(sweep(|f| (rule.weight(f) * 2048.0).round() / 2048.0).steps, rule);
            }
        }
    }
    assert_eq!(sweep(|f| f).steps, Steps::Smooth);
    assert_eq!(grid_bits(&[0.25, 1.5, 3.0]), Some(2));
    assert_eq!(grid_bits(&[0.25, 1.0 / 3.0]), None);
}

#[test]
fn fails_when_a_staircase_has_a_wrong_step() {
    let rule = bits(6, Rounding::Nearest);
    let found = sweep(|f| if (0.50..0.53).contains(&f) { 0.25 } else { rule.weight(f) });
    assert_eq!(found.steps, rule);
    assert!(found.off > 100 && !found.rising, "{} off", found.off);
}

#[test]
fn every_rule_of_length_is_told_from_the_others() {
    for rule in Rho::ALL {
        let mut model = orthodox();
        model.rho = rule;
        model.octave = Log::Exact.octave();
        let curve = curve(&mut model).expect("a model does not fail");
        let ranked = rho(&mut model, &curve).expect("a model does not fail");
        assert_eq!(ranked[0].rule, rule);
        // Half floats hold the levels' numbers, the octave is exact: only f32 rounds, 2^-20 of a level at most.
        assert!(ranked[0].worst < 1e-5, "{rule:?}: {}", ranked[0].worst);
        assert!(ranked[1].mean > 100.0 * ranked[0].mean, "{rule:?}");
    }
}

#[test]
fn every_projection_to_a_face_is_told_from_the_others() {
    for projection in Projection::ALL {
        let mut model = orthodox();
        let pair = (projection, Rho::ALL[1]);
        model.cube_rho = pair;
        model.octave = Log::Exact.octave();
        let ranked = cube::rho(&mut model, &Log::Exact.octave()).expect("a model does not fail");
        assert_eq!(ranked[0].rule, pair);
        assert!(ranked[0].worst < 1e-5 && ranked[1].mean > 1e-3);
    }
}

#[test]
fn every_logarithm_is_told_from_the_others() {
    for log in [Log::Exact, Log::Mantissa, Log::MantissaOfSquare, Log::MiddleHalf] {
        let mut model = orthodox();
        model.octave = log.octave();
        let found = curve(&mut model).expect("a model does not fail");
        assert_eq!(found.logs[0].rule, log);
        assert!(found.repeats < 1e-5);
    }
    let found = curve(&mut orthodox()).expect("a model does not fail");
    assert_eq!(found.logs[0].rule, Log::Exact);
}

#[test]
fn every_corner_and_seam_is_told_from_the_others() {
    for (seam, corner) in
        Corner::ALL.map(|c| (Seam::Neighbour, c)).into_iter().chain([(Seam::Clamped, Corner::Mean)])
    {
        let mut model = Model { seam, corner, ..orthodox() };
        let known = orthodox();
        let found = cube::seams(&mut model, &known).expect("a model does not fail");
        assert_eq!(found.rule, (seam, corner));
        assert!(found.ranked[0].1 < 1e-6 && found.ranked[1].1 > 1e-3, "{:?}", found.ranked);
    }
}

#[test]
fn taps_are_found_at_every_angle_where_they_are() {
    let mut model = orthodox();
    model.texels = Steps::Smooth;
    let mut asked = Vec::new();
    for (shape, degrees) in [
        (Shape::Planar, 0.0),
        (Shape::Planar, 15.0),
        (Shape::Cube, 45.0),
        (Shape::Planar, 60.0),
        (Shape::Cube, 90.0),
        (Shape::Planar, 120.0),
        (Shape::Cube, 165.0),
    ] {
        for ratio in [1.0, 2.0, 3.5, 8.0, 16.0] {
            asked.push(Footprint { shape, clamp: 16, ratio, degrees });
        }
    }
    let found = taps(&mut model, Source::Gradient, &asked).expect("a model does not fail");
    assert_eq!(found.iter().map(|t| t.footprint).collect::<Vec<_>>(), asked);
    for t in found {
        let Footprint { ratio, degrees, .. } = t.footprint;
        let count = Count::Ceil.of(ratio, 16);
        let n = num::index(count);
        assert!(t.explains(), "{:?}", t.footprint);
        assert_eq!(t.taps.len(), n, "{:?}", t.footprint);
        let texel = libm_exp2(t.lod.round());
        let (sin, cos) = degrees.to_radians().sin_cos();
        for (i, tap) in t.taps.iter().enumerate() {
            let along = ((i as f64 + 0.5) / count - 0.5) * ratio / texel;
            // Taps run from one end to the other, from either.
            let want = [along * cos, along * sin];
            let off = (tap.offset[0] - want[0]).hypot(tap.offset[1] - want[1]);
            let turned = (tap.offset[0] + want[0]).hypot(tap.offset[1] + want[1]);
            // f32 coordinates on 256 texels: 2^-16 texel, which is less; colours to 2^-24 of 160, times 16 steps a texel and 16 taps.
            let tolerance = 160.0 * 16.0 * 16.0 * 2.0f64.powi(-24);
            assert!(off.min(turned) < tolerance, "{:?} tap {i}: {tap:?}, {want:?}", t.footprint);
            assert!((tap.weight * count - 1.0).abs() < tolerance * count, "{tap:?}");
        }
    }
}

fn libm_exp2(x: f64) -> f64 {
    2.0f64.powf(x)
}

/// Everything that a model was given.
fn assert_found(model: &Model, found: &Fingerprint) {
    let half = found.weights.iter().find(|w| w.format == Format::Half).expect("measured");
    assert_eq!(half.axes[0].steps, model.texels);
    assert_eq!(half.axes[1].steps, model.texels);
    assert_eq!(found.mips.steps, model.mips);
    assert_eq!(found.rho[0].rule, model.rho);
    assert_eq!(found.cube_rho[0].rule, model.cube_rho);
    assert_eq!(found.seams.rule, (model.seam, model.corner));
    for f in &found.filters {
        let fits = |r: &&tapline::fingerprint::model::Rule| {
            (r.shape, r.source, r.clamp) == (f.rule.shape, f.rule.source, f.rule.clamp)
        };
        let planted = model.rules.iter().find(fits).expect("a rule for every kind");
        assert_eq!(f.rule.line, planted.line, "{:?}", f.rule);
        assert_eq!(f.rule.lod, planted.lod, "{:?}", f.rule);
    }
    // A clamp of 2 cannot tell counts apart; the largest clamp decides for all.
    assert_eq!(found.filters.len(), 2 * 2 * (CLAMPS.len() - 1));
    assert!(found.neighbours.iter().all(|(_, lods)| honours(*lods)));
    for group in &found.checks {
        assert!(group.look_ups > 1000);
        assert_eq!(group.within, group.look_ups, "{group:?}");
    }
}

#[test]
fn an_orthodox_unit_is_found_with_every_rule_and_predicts_itself() {
    let found = fingerprint(&mut orthodox(), &|_| {}).expect("a model does not fail");
    assert_found(&orthodox(), &found);
    assert_eq!(found.curve.bits, Some(8));
    assert!(found.quad_map.is_empty(), "given derivatives are honoured");
    let text = text(&found);
    for part in
        ["256 steps (8 bits), rounded to nearest", "ceil(ratio)", "8 fraction bits", "honoured"]
    {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    assert!(!text.contains("IGNORED"));
}

#[test]
fn an_odd_unit_is_found_with_every_rule_and_predicts_itself() {
    let found = fingerprint(&mut odd(), &|_| {}).expect("a model does not fail");
    assert_found(&odd(), &found);
    let text = text(&found);
    for part in [
        "64 steps (6 bits), rounded down",
        "the face's own edge again",
        "straight lines between whole levels",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn an_ellipse_is_told_from_taps_and_its_seams_from_each_other() {
    let lod = LodRule { width: Width::Minor, lengths: Lengths::Derivatives, mix: Mix::Floor };
    for (shape, seam) in [
        (Shape::Planar, Seam::Clamped),
        (Shape::Cube, Seam::Clamped),
        (Shape::Cube, Seam::Neighbour),
    ] {
        let mut unit = orthodox();
        unit.rules = rules(shape, lod, Line::Ellipse(seam));
        let rule = Rule { line: Line::Single, ..unit.rules[0] };
        let claims = unit.clone();
        let lines = lines(&mut unit, &claims, rule).expect("a model does not fail");
        assert_eq!(lines[0].rule, Line::Ellipse(seam));
        assert!(lines[0].worst < 1e-6 && lines[1].mean > 1e-3, "{:?}", &lines[..2]);
    }
}

#[test]
fn fails_when_the_model_has_another_rule_than_the_unit() {
    let mut unit = orthodox();
    let mut claims = orthodox();
    for rule in &mut claims.rules {
        rule.line = Line::Taps(Count::Ceil, Spacing::Between);
    }
    let group =
        tapline::fingerprint::check::check(&mut unit, &claims, Shape::Planar, Source::Gradient, 16)
            .expect("a model does not fail");
    assert!(group.within < group.look_ups / 2, "{group:?}");
}

#[test]
fn coordinates_edges_ties_and_level_weights_of_a_model_are_its_own() {
    let mut model = orthodox();
    let found = coordinates(&mut model).expect("a model does not fail");
    assert!(found.nearest_switch.abs() < 1e-5 && found.clamps);
    assert!(found.edge.iter().all(|w| (w - 1.0).abs() < 1e-6));
    let found = ties(&mut model).expect("a model does not fail");
    assert_eq!((found.expected, found.seen.len()), (20, 20));
    assert_eq!(mip_weights(&mut model).expect("a model does not fail").steps, model.mips);
    let found = weights(&mut model, Format::Unorm8).expect("a model does not fail");
    assert!(found.separable < 1e-6 && found.sum < 1e-6);
}

fn text(found: &Fingerprint) -> String {
    let mut out = Vec::new();
    tapline::fingerprint::print(&mut out, "a model", found).expect("memory");
    String::from_utf8(out).expect("text")
}

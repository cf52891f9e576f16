//! The charts of a study: the frontier of each picture, and the effect of each axis on the error.

use std::collections::BTreeMap;

use maud::html;
use serde_json::Value;

use super::setting;
use super::svg::{Axes, CHART, dot, points, svg, tick};
use crate::report::page::{list, words};
use crate::study::front::{figure, figure_cell, larger_is_better};
use crate::study::store::Results;

/// A chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The picture that it belongs to.
    pub place: String,
    /// Its file's name.
    pub file: String,
    /// The drawing.
    pub svg: String,
    /// What it shows.
    pub caption: String,
}

/// Where a row was measured.
fn place(row: &Value) -> String {
    let size: Vec<String> = list(&row["size"]).iter().map(words).collect();
    let mut out = format!("{}, {}", words(&row["scene"]), size.join(" × "));
    for (name, key) in [("", "env"), ("face size ", "face_size"), ("bounces ", "bounces")] {
        if !row[key].is_null() {
            out += &format!(", {name}{}", words(&row[key]));
        }
    }
    out
}

/// Every chart, picture by picture.
pub(super) fn all(results: &Results, on_front: &[bool], error: &str) -> Vec<Chart> {
    let mut places: Vec<String> = Vec::new();
    for row in &results.rows {
        let here = place(row);
        if !places.contains(&here) {
            places.push(here);
        }
    }
    let axes = results.axes();
    let mut out = Vec::new();
    for (number, here) in places.iter().enumerate() {
        let rows: Vec<(&Value, bool)> = results
            .rows
            .iter()
            .zip(on_front)
            .filter(|(r, _)| place(r) == *here)
            .map(|(r, on)| (r, *on))
            .collect();
        if rows.iter().all(|(r, _)| figure(r, error).is_none()) {
            continue;
        }
        out.extend(frontier(here, number, &rows, error));
        for axis in &axes {
            out.extend(effect(here, number, &rows, axis, error));
        }
    }
    out
}

/// The name of a figure on an axis.
fn label(name: &str) -> &'static str {
    match name {
        "truth_psnr_db" => "PSNR against supersampled rays (dB)",
        "ewa_psnr_db" => "PSNR against the elliptical Gaussian (dB)",
        "psnr_db" => "PSNR against f64 (dB)",
        "gates" => "gate equivalents (thousands)",
        "cycles_per_fragment" => "cycles per fragment",
        "direction_p95_deg" => "95th percentile of the direction's error (degrees)",
        "direction_median_deg" => "median of the direction's error (degrees)",
        "max_lsb8" => "largest difference from f64 (8-bit steps)",
        "share_over_1_lsb8" => "share of fragments beyond one 8-bit step",
        _ => "error",
    }
}

/// Error against cost.
fn frontier(here: &str, number: usize, rows: &[(&Value, bool)], error: &str) -> Option<Chart> {
    let varies = |name: &str| {
        let mut seen: Vec<u64> =
            rows.iter().filter_map(|(r, _)| figure(r, name)).map(f64::to_bits).collect();
        seen.sort_unstable();
        seen.dedup();
        seen.len() > 1
    };
    let cost = ["gates", "cycles_per_fragment"].into_iter().find(|name| varies(name))?;
    let scale = if cost == "gates" { 1e-3 } else { 1.0 };
    let mut dots: Vec<([f64; 2], &Value, bool)> = rows
        .iter()
        .filter_map(|(row, on)| {
            Some(([figure(row, cost)? * scale, figure(row, error)?], *row, *on))
        })
        .collect();
    // Those that matter lie on top.
    dots.sort_by_key(|(_, _, on)| *on);
    let finite = dots.iter().map(|(p, ..)| p[1]).filter(|y| y.is_finite());
    let top = finite.fold(0.0, f64::max) + 3.0;
    let value = |y: f64| if y.is_finite() { y } else { top };
    let xs: Vec<f64> = dots.iter().map(|(p, ..)| p[0]).collect();
    let ys: Vec<f64> = dots.iter().map(|(p, ..)| value(p[1])).collect();
    let axes = Axes::new(&xs, false, &ys, None);
    let at = |[x, y]: [f64; 2]| axes.at([x, value(y)]);
    let mut steps: Vec<[f64; 2]> = dots.iter().filter(|(.., on)| *on).map(|(p, ..)| *p).collect();
    steps.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut best: Option<f64> = None;
    let mut line = Vec::new();
    for [x, worth] in steps {
        let better = |before: f64| (worth > before) == larger_is_better(error);
        if best.is_none_or(|before| before.to_bits() != worth.to_bits() && better(before)) {
            if let Some(before) = best {
                line.push(at([x, before]));
            }
            line.push(at([x, worth]));
            best = Some(worth);
        }
    }
    let names = [label(cost), label(error)];
    let title = |x: f64, row: &Value| {
        let worth = figure_cell(row, error);
        format!("{}\n{} {worth}, {} {}", setting(row), names[1], names[0], tick(x))
    };
    let body = html! {
        (axes.draw(names, here))
        polyline.l points=(points(&line)) {}
        @for (p, row, on) in &dots {
            @let (radius, class) = if *on { (5.0, "f") } else { (3.5, "o") };
            (dot(at(*p), radius, class, &words(&row["row"]), &title(p[0], row)))
        }
    };
    Some(Chart {
        place: here.into(),
        file: format!("frontier-{number}.svg"),
        svg: svg(CHART, &format!("frontier of {here}"), &body),
        caption: format!(
            "Each dot is a unit. Orange: on the frontier. The line joins what a given cost buys at best; {} and to the left is better.",
            if larger_is_better(error) { "up" } else { "down" }
        ),
    })
}

/// The effect of an axis: the median error at each of its values, and the range over everything else.
fn effect(
    here: &str,
    number: usize,
    rows: &[(&Value, bool)],
    axis: &str,
    error: &str,
) -> Option<Chart> {
    let mut by: BTreeMap<usize, (String, Vec<f64>)> = BTreeMap::new();
    let mut order: Vec<String> = Vec::new();
    for (row, _) in rows {
        let (value, Some(y)) = (&row["set"][axis], figure(row, error)) else {
            continue;
        };
        if value.is_null() || !y.is_finite() {
            continue;
        }
        let name = words(value);
        let at = order.iter().position(|o| *o == name).unwrap_or_else(|| {
            order.push(name.clone());
            order.len() - 1
        });
        by.entry(at).or_insert((name, Vec::new())).1.push(y);
    }
    if by.len() < 2 || by.len() > 64 {
        return None;
    }
    let mut groups: Vec<(String, Vec<f64>)> = by.into_values().collect();
    let numbers: Option<Vec<f64>> = groups.iter().map(|(name, _)| name.parse().ok()).collect();
    let (positions, log) = match numbers {
        Some(numbers) => {
            let mut joined: Vec<(f64, (String, Vec<f64>))> =
                numbers.into_iter().zip(groups).collect();
            joined.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (positions, sorted): (Vec<f64>, Vec<_>) = joined.into_iter().unzip();
            groups = sorted;
            let wide = positions[0] > 0.0 && positions[positions.len() - 1] / positions[0] >= 16.0;
            (positions, wide)
        }
        None => ((0..groups.len()).map(|i| i as f64).collect(), false),
    };
    let named = groups.iter().any(|(name, _)| name.parse::<f64>().is_err());
    let all: Vec<f64> = groups.iter().flat_map(|(_, ys)| ys.iter().copied()).collect();
    let ticks = groups.iter().zip(&positions).map(|((name, _), at)| (*at, name.clone()));
    let axes = Axes::new(&positions, log, &all, named.then(|| ticks.collect()));
    let (mut upper, mut lower, mut middle) = (Vec::new(), Vec::new(), Vec::new());
    for ((_, ys), x) in groups.iter_mut().zip(&positions) {
        ys.sort_by(f64::total_cmp);
        upper.push(axes.at([*x, ys[ys.len() - 1]]));
        lower.push(axes.at([*x, ys[0]]));
        middle.push(axes.at([*x, ys[ys.len() / 2]]));
    }
    let title = |name: &str, ys: &[f64]| {
        format!("{axis} = {name}: median {} of {} units", tick(ys[ys.len() / 2]), ys.len())
    };
    let body = html! {
        (axes.draw([axis, label(error)], here))
        polygon.band points=(points(upper.iter().chain(lower.iter().rev()))) {}
        polyline.b points=(points(&middle)) {}
        @for (p, (name, ys)) in middle.iter().zip(&groups) { (dot(*p, 4.0, "r", "", &title(name, ys))) }
    };
    let stem: String =
        axis.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    Some(Chart {
        place: here.into(),
        file: format!("{stem}-{number}.svg"),
        svg: svg(CHART, &format!("{axis} in {here}"), &body),
        caption: format!(
            "{axis}: the median over all units with that value; the band reaches from the worst to the best of them."
        ),
    })
}

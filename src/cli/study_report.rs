//! `study report`: one HTML file of a study, and its figures as SVG.

use std::io::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::Failure;
use super::output::output_folder;
use super::study::{job_at, measuring};
use crate::error::InputError;
use crate::image::whole::WholeFile;
use crate::study::cost::CostModel;
use crate::study::front::{error_figure, figure, front, larger_is_better};
use crate::study::plan::Plan;
use crate::study::report::{details, page};
use crate::study::rows;
use crate::study::runner::Study;
use crate::study::store::{Results, common};
use crate::study::sweep::Sweep;

/// Rows that are shown in detail if none are named.
const USUAL: usize = 3;

/// Writes `report.html` and `figures/*.svg` beside the results.
pub(super) fn report(
    folder: &Path,
    study: Option<&Path>,
    chosen: &[usize],
    pixels: &[[u32; 2]],
) -> Result<(), Failure> {
    let results = Results::read(&folder.join("results.jsonl"), false)?;
    let kept = folder.join("details.json");
    let details = match study {
        Some(file) => {
            let found = gather(&results, file, chosen, pixels)?;
            write(WholeFile::create(kept)?, &found.to_string())?;
            Some(found)
        }
        None => read(&kept, &results)?,
    };
    let shown = details.as_ref().map(|d| &d["details"]);
    let (html, figures) = page(&results, shown);
    let into = folder.join("figures");
    let made = output_folder(&into)?;
    for (name, svg) in &figures {
        write(made.file(name)?, svg)?;
    }
    let out = folder.join("report.html");
    write(WholeFile::create(&out)?, &html)?;
    writeln!(
        std::io::stdout(),
        "{}\n{}: {} figures",
        out.display(),
        into.display(),
        figures.len()
    )?;
    Ok(())
}

fn write(mut file: WholeFile, text: &str) -> Result<(), InputError> {
    file.write_with(|w| w.write_all(text.as_bytes()))?;
    file.commit()
}

/// Details that an earlier report left, if they are of these results.
fn read(path: &Path, results: &Results) -> Result<Option<Value>, InputError> {
    if !path.exists() {
        return Ok(None);
    }
    let wrong = |found: String| {
        InputError::new(
            path.display().to_string(),
            "details of these results",
            found,
            "give --study FILE to make them again",
        )
    };
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    if value["plan"] != results.header["plan"] {
        return Err(wrong("those of another study".into()));
    }
    Ok(Some(value))
}

/// Renders chosen rows once more: by default the best row of each picture's frontier, the cheapest, and the middle one.
fn gather(
    results: &Results,
    file: &Path,
    chosen: &[usize],
    pixels: &[[u32; 2]],
) -> Result<Value, InputError> {
    let study = Study::new(Plan::load(file)?);
    let cost = CostModel::default();
    let header = study.header("", crate::study::store::Shard::WHOLE);
    if common(&results.header)["plan"] != header["plan"] {
        return Err(InputError::new(
            file.display().to_string(),
            "the study file of these results",
            "another one",
            "name the file that they were made with",
        ));
    }
    let rows = if chosen.is_empty() { usual(results) } else { chosen.to_vec() };
    let how = measuring(&study.plan, cost, true);
    let points = study.points.len();
    let mut out = Vec::new();
    for number in rows {
        let found = results.rows.iter().find(|r| r["row"].as_u64() == u64::try_from(number).ok());
        let Some(row) = found.filter(|r| r["metrics"].is_object()) else {
            return Err(InputError::new(
                "--rows",
                "numbers of rows that have figures",
                number.to_string(),
                "results.csv lists them",
            ));
        };
        let (place, point) = (number / points, number % points);
        debug_assert_eq!(rows::number(&study.plan, points, place, point), number);
        let (spec, checked) = study.unit(&study.points[point]);
        checked?;
        let settings = spec.settings(study.plan.reference_axis);
        let mut bench =
            Sweep::new(job_at(&study.plan.places[place], study.plan.exposure, &settings)?);
        out.push(details::gather(&mut bench, row, &spec, &settings, &how, pixels)?);
    }
    Ok(json!({"plan": results.header["plan"], "details": out}))
}

fn usual(results: &Results) -> Vec<usize> {
    let error = error_figure(results);
    let on = front(&results.rows, &error);
    let mut scenes: Vec<&Value> = results.rows.iter().map(|r| &r["scene"]).collect();
    scenes.dedup();
    let mut out = Vec::new();
    for scene in scenes.into_iter().take(USUAL) {
        let mut rows: Vec<(&Value, f64)> = results
            .rows
            .iter()
            .zip(&on)
            .filter(|(r, on)| **on && r["scene"] == *scene)
            .filter_map(|(r, _)| Some((r, figure(r, &error)?)))
            .collect();
        rows.sort_by(|a, b| b.1.total_cmp(&a.1));
        if !larger_is_better(&error) {
            rows.reverse();
        }
        let picks = [0, rows.len() / 2];
        let number = |i: usize| {
            rows.get(i).and_then(|(r, _)| r["row"].as_u64()).and_then(|n| usize::try_from(n).ok())
        };
        out.extend(picks.into_iter().filter_map(number));
    }
    out.dedup();
    out
}

/// X,Y.
pub(super) fn pixel(text: &str) -> Result<[u32; 2], String> {
    let parts = text
        .split_once(',')
        .and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
    parts.ok_or_else(|| "expected X,Y, such as 120,80".into())
}

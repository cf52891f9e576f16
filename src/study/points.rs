//! The points of a study, and the order in which they are run.

use std::collections::HashMap;

use super::axis::Axis;
use super::plan::{Mode, Plan};
use crate::base::random::Random;
use crate::stage::Stage;
use crate::unit::knobs::{Path, Value};

/// One unit of a study: its changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its number in the study, from 0.
    pub number: usize,
    /// Paths and values, in the axes' order.
    pub sets: Vec<(String, Value)>,
}

/// Every point of a plan, in the order of the results.
#[must_use]
pub fn points(plan: &Plan) -> Vec<Point> {
    let mut random = Random::new(plan.seed);
    let axes = &plan.axes;
    let rows: Vec<Vec<(usize, Value)>> = match plan.mode {
        Mode::Random => (0..plan.count)
            .map(|_| axes.iter().enumerate().map(|(i, a)| (i, a.draw(&mut random))).collect())
            .collect(),
        Mode::Grid => {
            let values: Vec<Vec<Value>> = axes.iter().map(|a| a.all(&mut random)).collect();
            values.iter().enumerate().fold(vec![Vec::new()], |rows, (i, values)| {
                let with = |row: &Vec<(usize, Value)>, v: &Value| {
                    [row.as_slice(), &[(i, v.clone())]].concat()
                };
                rows.iter().flat_map(|row| values.iter().map(move |v| with(row, v))).collect()
            })
        }
        Mode::Zip => {
            let values: Vec<Vec<Value>> = axes.iter().map(|a| a.all(&mut random)).collect();
            let count = values.first().map_or(0, Vec::len);
            let row =
                |n: usize| values.iter().enumerate().map(|(i, v)| (i, v[n].clone())).collect();
            (0..count).map(row).collect()
        }
        Mode::OneAtATime => {
            let alone = axes.iter().enumerate();
            let alone =
                alone.flat_map(|(i, a)| a.all(&mut random).into_iter().map(move |v| vec![(i, v)]));
            std::iter::once(Vec::new()).chain(alone).collect()
        }
    };
    let point = |(number, row): (usize, Vec<(usize, Value)>)| Point {
        number,
        sets: row.into_iter().flat_map(|(i, value)| on_all(&axes[i], &value)).collect(),
    };
    rows.into_iter().enumerate().map(point).collect()
}

fn on_all(axis: &Axis, value: &Value) -> Vec<(String, Value)> {
    axis.paths.iter().map(|path| (path.clone(), value.clone())).collect()
}

/// The order in which points are run: those that differ in late stages only follow each other, so that most of each is
/// there from the one before. It depends on the plan alone.
#[must_use]
pub fn order(plan: &Plan, points: &[Point]) -> Vec<usize> {
    // Axes by the first stage that they reach; a point's key are its values there, missing ones first.
    let mut axes: Vec<&Axis> = plan.axes.iter().collect();
    axes.sort_by_key(|axis| axis.paths.iter().map(|p| reach(p)).min());
    let mut seen: Vec<HashMap<String, usize>> = vec![HashMap::new(); axes.len()];
    let mut keys: Vec<(Vec<usize>, usize)> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let place = |(axis, seen): (&&Axis, &mut HashMap<String, usize>)| {
            let set = point.sets.iter().find(|(path, _)| axis.paths.first() == Some(path));
            let Some((_, value)) = set else { return 0 };
            let next = seen.len() + 1;
            *seen.entry(value.to_string()).or_insert(next)
        };
        keys.push((axes.iter().zip(&mut seen).map(place).collect(), index));
    }
    keys.sort();
    keys.into_iter().map(|(_, index)| index).collect()
}

/// The place in the pipeline of the first stage that a path reaches: 0 for what changes the scene itself.
fn reach(path: &str) -> usize {
    let stage = Path::find(path).map_or("scene", Path::reach);
    Stage::ALL.iter().position(|s| s.name() == stage).map_or(0, |i| i + 1)
}

//! Runs a study: place by place, point by point in the order that leaves most to be reused.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::plan::{Place, Plan};
use super::points::{Point, order, points};
use super::rows::{self, row};
use super::store::Shard;
use super::sweep::{Measuring, Sweep};
use crate::engine::Job;
use crate::error::InputError;
use crate::settings::Settings;
use crate::unit::{UnitSpec, check};

/// What a runner needs from outside: scenes come from files, rows go to files, and somebody watches.
pub trait Host {
    /// Builds the scene of a place; it depends on the two roughness policies of the settings.
    ///
    /// # Errors
    /// A scene or map that cannot be had.
    fn job(&mut self, place: &Place, settings: &Settings) -> Result<Job, InputError>;

    /// Takes a row.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn row(&mut self, number: usize, row: Value) -> Result<(), InputError>;
}

/// Where a study's time went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Seconds in the integer model.
    pub rtl_seconds: f64,
    /// Steps in front of the filter that were not run again, and all.
    pub saved: [u64; 2],
}

impl Spent {
    fn add(&mut self, bench: &Sweep) {
        self.rtl_seconds += bench.rtl_seconds;
        for (sum, n) in self.saved.iter_mut().zip(bench.saved) {
            *sum += n;
        }
    }
}

/// A study with its points.
#[derive(Debug)]
pub struct Study {
    /// The plan.
    pub plan: Plan,
    /// Every point.
    pub points: Vec<Point>,
    /// (place, point) in the order in which they run.
    pub schedule: Vec<(usize, usize)>,
}

impl Study {
    /// All points of a plan.
    #[must_use]
    pub fn new(plan: Plan) -> Self {
        let points = points(&plan);
        let order = order(&plan, &points);
        let places = 0..plan.places.len();
        let schedule =
            places.flat_map(|place| order.iter().map(move |point| (place, *point))).collect();
        Self { plan, points, schedule }
    }

    /// Rows in all.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.schedule.len()
    }

    /// The header of a part's results.
    #[must_use]
    pub fn header(&self, cost: &str, shard: Shard) -> Value {
        let mut header = rows::header(&self.plan, self.points.len(), cost);
        if let (Some(map), true) = (header.as_object_mut(), shard.of > 1) {
            map.insert("shard".into(), json!([shard.number, shard.of]));
        }
        header
    }

    /// The unit of a point, checked as every command checks its unit.
    ///
    /// # Errors
    /// The model's refusal.
    pub fn unit(&self, point: &Point) -> (UnitSpec, Result<(), InputError>) {
        let mut spec = self.plan.unit.clone();
        let sets = point.sets.iter().map(|(path, value)| (path.as_str(), value));
        let set = spec.set_all(sets);
        let checked = set.and_then(|()| check(&spec));
        (spec, checked)
    }

    /// Runs what is not done of a part.
    ///
    /// # Errors
    /// Those of the host. A unit that is refused is a row that says so.
    pub fn run(
        &self,
        shard: Shard,
        done: &BTreeMap<usize, Value>,
        how: &Measuring,
        host: &mut dyn Host,
    ) -> Result<Spent, InputError> {
        let mut spent = Spent::default();
        let mut bench: Option<(usize, Settings, Sweep)> = None;
        let mut checked: BTreeMap<usize, (UnitSpec, Result<(), InputError>)> = BTreeMap::new();
        for (place_index, point_index) in &self.schedule[shard.range(self.rows())] {
            let number = rows::number(&self.plan, self.points.len(), *place_index, *point_index);
            if done.contains_key(&number) {
                continue;
            }
            let (place, point) = (&self.plan.places[*place_index], &self.points[*point_index]);
            let (spec, refused) = checked.entry(*point_index).or_insert_with(|| self.unit(point));
            let outcome = match refused {
                Err(error) => Err(error.clone()),
                Ok(()) => {
                    let settings = spec.settings(self.plan.reference_axis);
                    let stays = |(at, before, _): &(usize, Settings, Sweep)| {
                        at == place_index && before.policy.roughness == settings.policy.roughness
                    };
                    if !bench.as_ref().is_some_and(stays) {
                        if let Some((_, _, bench)) = bench.take() {
                            spent.add(&bench);
                        }
                        let job = host.job(place, &settings)?;
                        bench = Some((*place_index, settings.clone(), Sweep::new(job)));
                    }
                    let Some((_, _, bench)) = &mut bench else {
                        continue;
                    };
                    bench.measure(spec, &settings, how).map(|found| found.measures)
                }
            };
            host.row(number, row(&self.plan, number, place, point, spec, &outcome))?;
        }
        if let Some((_, _, bench)) = bench.take() {
            spent.add(&bench);
        }
        Ok(spent)
    }
}

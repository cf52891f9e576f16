//! `impostor study`: tables of what each iteration, bit and texel of an impostor buys.

use crate::base::num;
use std::io::Write as _;
use std::path::PathBuf;

use rtl_model::regs::Reg;
use serde_json::{Value, json};

use super::Failure;
use super::output::{JsonTarget, Origin};
use crate::distance::Distance;
use crate::engine::hit::{HitF64, HitResult, HitRtl};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::impostor::Impostor;
use crate::impostor::footprints::{Footprint, filtered, supersampled};
use crate::impostor::study::{
    Angles, Case, Found, Row, cases, exact, farthest, marches, run as measure,
};
use crate::policy::{HitPolicy, HitStatus, Method};
use crate::reference::Distances;
use crate::report::metrics;
use crate::report::table::{Align, Table, count, significant};
use crate::scene::SceneOptions;
use crate::scene::hit;
use crate::truth::TruthOptions;
use crate::truth::texels::PaddedCube;
use crate::unit::{ReferenceAxis, UnitSpec};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scene: room, columns, doorway.
    scene: String,
    /// Picture size: one ray a pixel.
    #[arg(long, value_name = "WxH", default_value = "128x128", value_parser = super::args::size)]
    size: (usize, usize),
    /// Texels along an edge of a face, where the table does not sweep them.
    #[arg(long, value_name = "N")]
    face_size: Option<usize>,
    /// Fraction bits of τ: |f − 1| ≤ 2^-N has converged.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=24))]
    tolerance_bits: u32,
    /// Results as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Iterations at which words and sizes are swept.
const AT: u32 = 6;
/// The march: steps and halvings.
const MARCH: [u32; 2] = [32, 6];
/// Fraction bits of `hit.distance`, in units of the map's power of two.
const WORDS: [u32; 8] = [4, 6, 8, 10, 12, 14, 16, 20];
/// Texels along an edge.
const SIZES: [usize; 6] = [16, 32, 64, 128, 256, 512];

impl From<&HitResult> for Found {
    fn from(result: &HitResult) -> Self {
        Self {
            l: result.l,
            d: result.d,
            look_ups: result.iterations,
            overshot: result.overshot,
            status: result.status,
        }
    }
}

struct Line {
    table: &'static str,
    method: &'static str,
    iterations: u32,
    engine: &'static str,
    distance_frac: Option<u32>,
    face_size: usize,
    row: Row,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let target = JsonTarget::open(args.json.as_deref())?;
    let options = SceneOptions {
        width: args.size.0,
        height: args.size.1,
        face_size: args.face_size,
        bump: None,
        mesh: None,
    };
    let scene = hit::build(&args.scene, &options)?;
    let rays = cases(&scene);
    let lines = sweep(args, &scene, &rays)?;
    let map = Impostor::build(&scene.view.world, glam::DVec3::ZERO, scene.face_size).colour;
    let truth = supersampled(&scene, &map, &TruthOptions::default());
    let mut footprints = Vec::new();
    for kind in Footprint::ALL {
        let pair = metrics::compare(&filtered(&scene, &map, kind), &truth.picture, 0.0)?;
        footprints.push((kind, pair));
    }
    let need = needed(&lines);
    let mut root = Origin::new(&UnitSpec::default()).json();
    root.insert("scene".into(), json!(args.scene));
    root.insert("size".into(), json!([args.size.0, args.size.1]));
    root.insert("face_size".into(), json!(scene.face_size));
    root.insert("tolerance_bits".into(), json!(args.tolerance_bits));
    root.insert("rays".into(), json!(rays.len()));
    root.insert("rows".into(), lines.iter().map(line_json).collect());
    root.insert(
        "footprints".into(),
        footprints
            .iter()
            .map(
                |(kind, p)| json!({"footprint": kind.name(), "psnr_db": p.psnr_db, "rmse": p.rmse}),
            )
            .collect(),
    );
    root.insert("truth_display_error".into(), json!(truth.rms_display_error));
    root.insert(
        "look_ups_for_the_march_s_p95".into(),
        need.iter().map(|(m, n)| json!({"method": m, "look_ups": n})).collect(),
    );
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "{} {}x{}: {} rays, impostor {}, tolerance 2^-{}; tapline {}",
            args.scene,
            args.size.0,
            args.size.1,
            count(num::u64(rays.len())),
            scene.face_size,
            args.tolerance_bits,
            env!("CARGO_PKG_VERSION")
        )?;
        for (name, title) in [
            ("iterations", "iterations by method"),
            ("words", "fraction bits of hit.distance, 6 iterations, by the integer model"),
            ("sizes", "texels along an edge, 6 iterations"),
            ("march", "linear march, 32 steps and 6 halvings"),
        ] {
            writeln!(out, "\n{title}\n{}", table(&lines, name, rays.len()))?;
        }
        for (method, n) in &need {
            match n {
                Some(n) => writeln!(
                    out,
                    "{method}: {n} look-ups in all (2 before the loop) for the march's p95 or less"
                )?,
                None => writeln!(out, "{method}: never as good as the march within 10 iterations")?,
            }
        }
        let mut feet = Table::new(&[
            ("footprint (ewa)", Align::Left),
            ("PSNR (dB)", Align::Right),
            ("RMS (8-bit steps)", Align::Right),
        ]);
        for (kind, p) in &footprints {
            feet.row([
                kind.name().to_string(),
                p.psnr_db.map_or("identical".into(), |db| significant(db, 4)),
                significant(255.0 * p.rmse, 3),
            ]);
        }
        writeln!(out, "\nfootprint at the real hit against supersampled rays\n{feet}")?;
        writeln!(
            out,
            "truth: RMS display error {} (8-bit steps)",
            significant(255.0 * truth.rms_display_error, 3)
        )?;
    }
    target.write(&Value::Object(root))
}

/// An impostor and what it is measured against.
struct Subject<'a> {
    cases: &'a [Case],
    rays: Vec<HitFragment>,
    distance: Distance,
    face_size: usize,
    distances: Distances,
    farthest: f64,
    colours: PaddedCube,
    exact: Vec<Option<[f64; 3]>>,
}

impl<'a> Subject<'a> {
    fn new(scene: &hit::HitScene, cases: &'a [Case], size: usize) -> Self {
        let impostor = Impostor::build(&scene.view.world, glam::DVec3::ZERO, size);
        let farthest = farthest(&impostor.distance);
        let distance = Distance::Cube(impostor.distance);
        let distances = Distances::new(&distance);
        Self {
            rays: cases
                .iter()
                .map(|case| HitFragment { x: case.x, r: case.r, cone: None })
                .collect(),
            exact: exact(cases, &distances, farthest),
            cases,
            distance,
            face_size: size,
            distances,
            farthest,
            colours: PaddedCube::new(&impostor.colour.levels[0]),
        }
    }

    fn row(&self, found: &[Found]) -> Row {
        measure(self.cases, &self.exact, &self.colours, found)
    }

    /// By the float reference.
    fn by_f64(&self, table: &'static str, policy: HitPolicy) -> Line {
        let mut settings = UnitSpec::default().settings(ReferenceAxis::Exact);
        settings.policy.hit = policy;
        let engine = HitF64::new(&settings, &self.distance, None, 1);
        let results = engine.filter(&self.rays, &|_| {});
        let found: Vec<Found> = results.iter().map(Found::from).collect();
        Line {
            table,
            method: policy.method.name(),
            iterations: policy.iterations,
            engine: "f64",
            distance_frac: None,
            face_size: self.face_size,
            row: self.row(&found),
        }
    }

    /// By the integer model with so many fraction bits a distance.
    fn by_rtl(
        &self,
        table: &'static str,
        policy: HitPolicy,
        frac: u32,
    ) -> Result<Line, InputError> {
        let mut spec = UnitSpec::default();
        spec.config.policy.hit = policy;
        if let Some(format) = spec.config.formats.get_mut(Reg::HitDistance.index()) {
            format.frac = frac;
        }
        let engine = HitRtl::new(&spec, &self.distance, None, 1)?;
        let results = engine.filter(&self.rays, &|_| {});
        let found: Vec<Found> = results.iter().map(Found::from).collect();
        Ok(Line {
            table,
            method: policy.method.name(),
            iterations: policy.iterations,
            engine: "rtl",
            distance_frac: Some(frac),
            face_size: self.face_size,
            row: self.row(&found),
        })
    }
}

fn sweep(args: &Args, scene: &hit::HitScene, cases: &[Case]) -> Result<Vec<Line>, InputError> {
    let policy = |method, iterations| HitPolicy {
        method,
        iterations,
        tolerance_bits: Some(args.tolerance_bits),
        ..HitPolicy::default()
    };
    let own = Subject::new(scene, cases, scene.face_size);
    let mut lines = Vec::new();
    for method in Method::ALL {
        for iterations in 0..=10 {
            lines.push(own.by_f64("iterations", policy(*method, iterations)));
        }
    }
    let found = marches(cases, &own.distances, own.farthest, MARCH);
    lines.push(Line {
        table: "march",
        method: "march",
        iterations: MARCH[0] + MARCH[1],
        engine: "f64",
        distance_frac: None,
        face_size: own.face_size,
        row: own.row(&found),
    });
    for frac in WORDS {
        lines.push(own.by_rtl("words", policy(Method::Secant, AT), frac)?);
    }
    for size in SIZES {
        let other = Subject::new(scene, cases, size);
        for method in [Method::FalsePosition, Method::Secant] {
            lines.push(other.by_f64("sizes", policy(method, AT)));
        }
    }
    Ok(lines)
}

/// The fewest look-ups of each method, the two before the loop included, that bring p95 against the
/// impostor's surface to the march's or below.
fn needed(lines: &[Line]) -> Vec<(&'static str, Option<u32>)> {
    let Some(march) = lines.iter().find(|l| l.table == "march") else {
        return Vec::new();
    };
    Method::ALL
        .iter()
        .map(|m| {
            let least = lines
                .iter()
                .filter(|l| l.table == "iterations" && l.method == m.name())
                .find(|l| l.row.surface.p95 <= march.row.surface.p95)
                .map(|l| l.iterations + 2);
            (m.name(), least)
        })
        .collect()
}

fn table(lines: &[Line], name: &str, rays: usize) -> Table {
    let mut table = Table::new(&[
        ("method", Align::Left),
        ("iterations", Align::Right),
        ("engine", Align::Left),
        ("frac", Align::Right),
        ("face", Align::Right),
        ("median (deg)", Align::Right),
        ("p95", Align::Right),
        ("p99", Align::Right),
        ("max", Align::Right),
        ("surface p95", Align::Right),
        ("p99", Align::Right),
        ("colour (steps)", Align::Right),
        ("converged (%)", Align::Right),
        ("max-iter. (%)", Align::Right),
        ("other (%)", Align::Right),
        ("look-ups", Align::Right),
        ("overshot", Align::Right),
        ("false far", Align::Right),
    ]);
    for l in lines.iter().filter(|l| l.table == name) {
        #[expect(clippy::cast_precision_loss, reason = "a share to three digits")]
        let share = |n: u64| significant(100.0 * n as f64 / rays.max(1) as f64, 3);
        let r = &l.row;
        table.row([
            l.method.to_string(),
            l.iterations.to_string(),
            l.engine.to_string(),
            l.distance_frac.map_or("f32".into(), |f| f.to_string()),
            l.face_size.to_string(),
            significant(r.real.median, 3),
            significant(r.real.p95, 3),
            significant(r.real.p99, 3),
            significant(r.real.max, 3),
            significant(r.surface.p95, 3),
            significant(r.surface.p99, 3),
            significant(r.colour_steps, 3),
            share(r.endings[0]),
            share(r.endings[1]),
            share(r.endings[2..].iter().sum()),
            significant(r.look_ups, 3),
            count(r.overshoots),
            count(r.false_far),
        ]);
    }
    table
}

fn line_json(l: &Line) -> Value {
    let angles = |a: &Angles| json!({"median": a.median, "p95": a.p95, "p99": a.p99, "max": a.max});
    let endings: serde_json::Map<String, Value> = HitStatus::ALL
        .iter()
        .zip(l.row.endings)
        .map(|(e, n)| (e.name().to_string(), json!(n)))
        .collect();
    json!({
        "table": l.table,
        "method": l.method,
        "iterations": l.iterations,
        "engine": l.engine,
        "distance_frac": l.distance_frac,
        "face_size": l.face_size,
        "degrees_from_real": angles(&l.row.real),
        "degrees_from_surface": angles(&l.row.surface),
        "colour_rms_lsb8": l.row.colour_steps,
        "status": endings,
        "rays_with_an_overshoot": l.row.overshoots,
        "look_ups_per_ray": l.row.look_ups,
        "converged_beyond_a_near_wall": l.row.false_far,
    })
}

//! `size`: the smallest unit that a scene needs.

use std::io::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use rtl_model::unit::Needs;
use serde_json::{Value, json};

use super::Failure;
use super::args::{UnitArgs, size as parse_size};
use super::job::tell_losses;
use super::output::{JsonTarget, Origin, unit_json};
use super::study::job_at;
use crate::engine::EngineKind;
use crate::error::InputError;
use crate::image::whole::WholeFile;
use crate::operation::Operation;
use crate::report::metrics::Pair;
use crate::report::table::{Table, fixed, places, text, value, whole};
use crate::study::cost::{CostModel, Sheet};
use crate::study::plan::Place;
use crate::study::size::{Found, Goal, Outcome, Shorter, SizeOptions, size};
use crate::study::sweep::Sweep;
use crate::truth::TruthOptions;
use crate::unit::{ReferenceAxis, UnitSpec, file};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    scene: String,
    /// Largest difference from f64 in 8-bit steps.
    #[arg(long, value_name = "STEPS")]
    max_lsb8: Option<f64>,
    /// Least PSNR against f64 in dB.
    #[arg(long, value_name = "DB")]
    psnr: Option<f64>,
    /// Largest share (0 to 1) of fragments more than one 8-bit step from f64.
    #[arg(long, value_name = "SHARE")]
    share: Option<f64>,
    /// Integer bits above what the scene's registers take.
    #[arg(long, value_name = "BITS", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=16))]
    margin: u32,
    /// Axis of the float reference: exact sizes the angle table too, table leaves it alone.
    #[arg(long, value_enum, default_value_t = ReferenceAxis::Exact)]
    reference_axis: ReferenceAxis,
    /// Picture size.
    #[arg(long, value_name = "WxH", default_value = "256x256", value_parser = parse_size, allow_hyphen_values = true)]
    size: (usize, usize),
    /// Environment map.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// Texels along an edge of the cube map or the texture.
    #[arg(long, value_name = "N")]
    face_size: Option<usize>,
    /// Exposure in stops.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f64,
    /// The unit file to write.
    #[arg(short = 'o', value_name = "FILE")]
    out: Option<PathBuf>,
    /// Cost model's knobs: they decide which word gives way first.
    #[arg(long, value_name = "FILE")]
    cost: Option<PathBuf>,
    /// Threads; 0 takes all cores.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// The result as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    unit: UnitArgs,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let goal = Goal { max_lsb8: args.max_lsb8, psnr_db: args.psnr, share: args.share };
    if goal == Goal::default() {
        return Err(InputError::new(
            "size",
            "a bound: --max-lsb8, --psnr or --share",
            "none",
            "write for instance --max-lsb8 1",
        )
        .into());
    }
    let numbers = [args.max_lsb8, args.psnr, args.share].into_iter().flatten();
    if numbers.into_iter().any(|x| !x.is_finite() || x < 0.0) {
        return Err(InputError::new(
            "size",
            "bounds that are numbers from 0 up",
            "another",
            "write for instance --psnr 60",
        )
        .into());
    }
    super::args::threads(args.threads)?;
    let base = args.unit.load()?;
    let cost = CostModel::load(args.cost.as_deref())?;
    let target = JsonTarget::open(args.json.as_deref())?;
    let file = args.out.as_ref().map(WholeFile::create).transpose()?;
    let place = Place {
        scene: args.scene.clone(),
        size: args.size,
        env: args.env.clone(),
        face_size: args.face_size,
        bounces: None,
    };
    let built = job_at(&place, args.exposure, &base.settings(args.reference_axis))?;
    if built.fragments() == 0 {
        return Err(InputError::new(
            "--size",
            "a picture that shows a fragment",
            "none",
            "ask for a larger picture",
        )
        .into());
    }
    tell_losses(&built, &base)?;
    let options = SizeOptions {
        goal,
        margin: args.margin,
        reference_axis: args.reference_axis,
        exposure: args.exposure,
        cost,
    };
    let start = Instant::now();
    let (outcome, mut bench) = size(built, &base, &options)?;
    let found = match outcome {
        Outcome::Found(found) => found,
        Outcome::Beyond(best) => {
            let what = format!("no unit keeps the bound; the best has {}", verdict(&best));
            return Err(Failure::Disagrees(what));
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    tell_white(&mut bench, &found.spec, &options)?;
    let sheets = sheets(&base, &found.spec, &bench, &options.cost);
    if !target.takes_stdout() {
        print(args, &found, &sheets, &options.cost, seconds)?;
    }
    if let Some(mut file) = file {
        let head = format!(
            "# tapline {} size {}{}: {}\n",
            env!("CARGO_PKG_VERSION"),
            args.scene,
            bounds(&goal),
            verdict(&found.pair)
        );
        file.write_with(|w| write!(w, "{head}{}", file::to_toml(&found.spec)))?;
        file.commit()?;
    }
    target.write(&to_json(args, &found, &sheets, &options.cost, seconds))
}

/// Says where a picture is mostly white, whose errors a bound on what is shown cannot see.
fn tell_white(bench: &mut Sweep, spec: &UnitSpec, how: &SizeOptions) -> Result<(), InputError> {
    let settings = spec.settings(how.reference_axis);
    let white = libm::exp2(-how.exposure);
    let picture = bench.reference_picture(EngineKind::F64, &settings, &TruthOptions::default())?;
    let shown = picture.rgb.iter().zip(&picture.covered).filter(|(_, covered)| **covered);
    let (mut count, mut clipped) = (0u64, 0u64);
    for (rgb, _) in shown {
        count += 1;
        clipped += u64::from(rgb.iter().any(|c| *c >= white));
    }
    if 2 * clipped > count {
        super::note(&format!(
            "size: {clipped} of {count} fragments are clipped to white, where the bound sees no error; lower --exposure"
        ));
    }
    Ok(())
}

/// The unit for every operation, the given one built for the scene, and the sized one.
fn sheets(base: &UnitSpec, sized: &UnitSpec, bench: &Sweep, cost: &CostModel) -> [Sheet; 3] {
    let operation = bench.job().operation();
    let all = Operation::Env(Needs { bump: true, rough: true });
    let mut whole = cost.sheet(&base.config, all);
    for other in [Operation::Hit, Operation::Tex] {
        for (stage, parts) in cost.sheet(&base.config, other).stages {
            if whole.stages.iter().all(|(s, _)| *s != stage) {
                whole.stages.push((stage, parts));
            }
        }
    }
    [whole, cost.sheet(&base.config, operation), cost.sheet(&sized.config, operation)]
}

fn bounds(goal: &Goal) -> String {
    let part =
        |name: &str, value: Option<f64>| value.map_or(String::new(), |x| format!(" --{name} {x}"));
    part("max-lsb8", goal.max_lsb8) + &part("psnr", goal.psnr_db) + &part("share", goal.share)
}

fn verdict(pair: &Pair) -> String {
    let db = pair.psnr_db.map_or("equal".into(), |db| format!("{} dB", fixed(db, 2)));
    let share = 100.0 * pair.share_over_1_lsb8;
    format!(
        "{} 8-bit steps at most, {db}, {} % of fragments beyond one step",
        fixed(pair.max_lsb8, 3),
        fixed(share, 3)
    )
}

/// The command that checks the result.
fn check_command(args: &Args) -> String {
    let mut out = format!(
        "tapline compare {} --size {}x{} --engines rtl,f64",
        args.scene, args.size.0, args.size.1
    );
    if args.reference_axis == ReferenceAxis::Table {
        out += " --reference-axis table";
    }
    let mut option = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            out += &format!(" {name} {value}");
        }
    };
    option("--env", args.env.as_ref().map(|p| p.display().to_string()));
    option("--face-size", args.face_size.map(|n| n.to_string()));
    let unit = args.out.as_ref().map_or("unit.toml".into(), |p| p.display().to_string());
    option("--unit", Some(unit));
    option("--max-lsb8", args.max_lsb8.map(|x| format!("rtl:f64={x}")));
    option("--min-psnr", args.psnr.map(|x| format!("rtl:f64={x}")));
    out
}

/// What the unit for all operations, for the scene and the sized one cost.
fn costs(sheets: &[Sheet; 3], cost: &CostModel) -> Table {
    let names = ["all operations", "built for the scene", "sized"];
    Table::of(
        names.into_iter().zip(sheets.iter().map(Sheet::total)),
        &[
            ("cost", "", &|(name, _)| text(name)),
            ("", "gates", &|(_, t)| value(t.gates(&cost.cells))),
            ("logic (kGE)", "logic_gates", &|(_, t)| {
                let gates = t.logic(&cost.cells);
                places(gates / 1000.0, 1).with(gates)
            }),
            ("tables (bits)", "rom_bits", &|(_, t)| whole(t.rom_bits)),
            ("registers (bits)", "register_bits", &|(_, t)| whole(t.register_bits)),
            ("all (kGE)", "", &|(_, t)| places(t.gates(&cost.cells) / 1000.0, 1)),
        ],
    )
}

fn integers(found: &Found) -> Table {
    Table::of(
        &found.integers,
        &[
            ("integer bits", "register", &|(name, _)| text(name)),
            ("before", "before", &|(_, v)| whole(v[0])),
            ("needed", "needed", &|(_, v)| whole(v[1])),
            ("sized", "sized", &|(_, v)| whole(v[2])),
        ],
    )
}

fn knobs(found: &Found) -> Table {
    Table::of(
        &found.knobs,
        &[
            ("word or table", "path", &|k| text(&k.path)),
            ("before", "before", &|k| whole(k.values[0])),
            ("sized", "sized", &|k| whole(k.values[1])),
            ("one step less", "one_step_less", &|k| text(shorter(&k.shorter))),
        ],
    )
}

fn print(
    args: &Args,
    found: &Found,
    sheets: &[Sheet; 3],
    cost: &CostModel,
    seconds: f64,
) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{}, {}x{}:{}",
        args.scene,
        args.size.0,
        args.size.1,
        bounds(&Goal { max_lsb8: args.max_lsb8, psnr_db: args.psnr, share: args.share })
    )?;
    writeln!(out, "before: {}", verdict(&found.before))?;
    writeln!(out, "sized:  {}", verdict(&found.pair))?;
    writeln!(out, "{} units in {} rounds, {} s\n", found.trials, found.rounds, fixed(seconds, 1))?;
    writeln!(out, "{}", costs(sheets, cost))?;
    if !found.trimmed.is_empty() {
        writeln!(out, "limits that the scene does not reach:")?;
        for (path, before, after) in &found.trimmed {
            writeln!(out, "  {path} {before} -> {after}")?;
        }
    }
    let integers = integers(found);
    if !integers.is_empty() {
        writeln!(out, "{integers}")?;
    }
    write!(out, "{}", knobs(found))?;
    writeln!(out, "check: {}", check_command(args))?;
    Ok(())
}

fn shorter(what: &Shorter) -> String {
    match what {
        Shorter::Breaks(pair) => {
            let db = pair.psnr_db.map_or("equal".into(), |db| format!("{} dB", fixed(db, 2)));
            format!(
                "breaks: {} steps, {db}, {} %",
                fixed(pair.max_lsb8, 3),
                fixed(100.0 * pair.share_over_1_lsb8, 3)
            )
        }
        Shorter::Refused(why) => format!("refused: {}", why.split(';').next().unwrap_or("")),
        Shorter::Least => "is the least".into(),
    }
}

fn to_json(
    args: &Args,
    found: &Found,
    sheets: &[Sheet; 3],
    cost: &CostModel,
    seconds: f64,
) -> Value {
    let pair = |pair: &Pair| pair.to_json("rtl", "f64");
    let [all, before, sized] = [0, 1, 2].map(|i| costs(sheets, cost).json().swap_remove(i));
    let trimmed: Vec<Value> = found
        .trimmed
        .iter()
        .map(|(path, a, b)| json!({"path": path, "before": a, "sized": b}))
        .collect();
    Origin::new(&found.spec).object(json!({
        "scene": args.scene,
        "size": args.size,
        "bound": {"max_lsb8": args.max_lsb8, "psnr_db": args.psnr, "share": args.share},
        "before": {"pair": pair(&found.before), "cost": before, "all_operations": all},
        "sized": {"pair": pair(&found.pair), "cost": sized},
        "trials": found.trials,
        "rounds": found.rounds,
        "seconds": seconds,
        "knobs": knobs(found).json(),
        "integers": integers(found).json(),
        "trimmed": trimmed,
        "check": check_command(args),
        "unit": unit_json(&found.spec),
    }))
}

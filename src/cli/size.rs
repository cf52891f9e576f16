//! `size`: the smallest unit that a scene needs.

use std::io::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use rtl_model::unit::Needs;
use serde_json::{Value, json};

use super::Failure;
use super::args::{UnitArgs, size as parse_size};
use super::output::{JsonTarget, Origin, unit_json};
use super::study::scene;
use crate::error::InputError;
use crate::image::whole::WholeFile;
use crate::report::metrics::Pair;
use crate::report::table::{Align, Table, fixed};
use crate::study::bench::Bench;
use crate::study::cost::{CostModel, Operation, Sheet};
use crate::study::plan::Place;
use crate::study::size::{Found, Goal, Outcome, Shorter, SizeOptions, size};
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
    };
    let built = scene(&place, args.exposure, &base.settings(args.reference_axis))?;
    if built.fragments() == 0 {
        return Err(InputError::new(
            "--size",
            "a picture that shows a fragment",
            "none",
            "ask for a larger picture",
        )
        .into());
    }
    let options = SizeOptions {
        goal,
        margin: args.margin,
        reference_axis: args.reference_axis,
        exposure: args.exposure,
        cost,
    };
    let start = Instant::now();
    let (outcome, bench) = size(built, &base, &options)?;
    let found = match outcome {
        Outcome::Found(found) => found,
        Outcome::Beyond(best) => {
            let what = format!("no unit keeps the bound; the best has {}", verdict(&best));
            return Err(Failure::Disagrees(what));
        }
    };
    let seconds = start.elapsed().as_secs_f64();
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

/// The unit for every operation, the given one built for the scene, and the sized one.
fn sheets(base: &UnitSpec, sized: &UnitSpec, bench: &Bench, cost: &CostModel) -> [Sheet; 3] {
    let operation = bench.scene().operation();
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
    let mut table = Table::new(&[
        ("cost", Align::Left),
        ("logic (kGE)", Align::Right),
        ("tables (bits)", Align::Right),
        ("registers (bits)", Align::Right),
        ("all (kGE)", Align::Right),
    ]);
    for (name, sheet) in ["all operations", "built for the scene", "sized"].iter().zip(sheets) {
        let total = sheet.total();
        table.row([
            (*name).to_string(),
            fixed(total.logic(&cost.cells) / 1000.0, 1),
            total.rom_bits.to_string(),
            total.register_bits.to_string(),
            fixed(total.gates(&cost.cells) / 1000.0, 1),
        ]);
    }
    writeln!(out, "{table}")?;
    if !found.trimmed.is_empty() {
        writeln!(out, "limits that the scene does not reach:")?;
        for (path, before, after) in &found.trimmed {
            writeln!(out, "  {path} {before} -> {after}")?;
        }
    }
    let mut table = Table::new(&[
        ("integer bits", Align::Left),
        ("before", Align::Right),
        ("needed", Align::Right),
        ("sized", Align::Right),
    ]);
    for (name, values) in &found.integers {
        table.row([
            name.clone(),
            values[0].to_string(),
            values[1].to_string(),
            values[2].to_string(),
        ]);
    }
    if !table.is_empty() {
        writeln!(out, "{table}")?;
    }
    let mut table = Table::new(&[
        ("word or table", Align::Left),
        ("before", Align::Right),
        ("sized", Align::Right),
        ("one step less", Align::Left),
    ]);
    for knob in &found.knobs {
        table.row([
            knob.path.clone(),
            knob.values[0].to_string(),
            knob.values[1].to_string(),
            shorter(&knob.shorter),
        ]);
    }
    write!(out, "{table}")?;
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
    let mut root = Origin::new(&found.spec).json();
    let cost_of = |sheet: &Sheet| {
        let total = sheet.total();
        json!({"gates": total.gates(&cost.cells), "logic_gates": total.logic(&cost.cells), "rom_bits": total.rom_bits, "register_bits": total.register_bits})
    };
    root.insert("scene".into(), json!(args.scene));
    root.insert("size".into(), json!([args.size.0, args.size.1]));
    root.insert(
        "bound".into(),
        json!({"max_lsb8": args.max_lsb8, "psnr_db": args.psnr, "share": args.share}),
    );
    root.insert("before".into(), json!({"pair": found.before.to_json("rtl", "f64"), "cost": cost_of(&sheets[1]), "all_operations": cost_of(&sheets[0])}));
    root.insert(
        "sized".into(),
        json!({"pair": found.pair.to_json("rtl", "f64"), "cost": cost_of(&sheets[2])}),
    );
    root.insert("trials".into(), json!(found.trials));
    root.insert("rounds".into(), json!(found.rounds));
    root.insert("seconds".into(), json!(seconds));
    let knobs: Vec<Value> = found
        .knobs
        .iter()
        .map(|k| json!({"path": k.path, "before": k.values[0], "sized": k.values[1], "one_step_less": shorter(&k.shorter)}))
        .collect();
    root.insert("knobs".into(), json!(knobs));
    let integers: Vec<Value> = found
        .integers
        .iter()
        .map(|(name, v)| json!({"register": name, "before": v[0], "needed": v[1], "sized": v[2]}))
        .collect();
    root.insert("integers".into(), json!(integers));
    let trimmed: Vec<Value> = found
        .trimmed
        .iter()
        .map(|(path, a, b)| json!({"path": path, "before": a, "sized": b}))
        .collect();
    root.insert("trimmed".into(), json!(trimmed));
    root.insert("check".into(), json!(check_command(args)));
    root.insert("unit".into(), unit_json(&found.spec));
    Value::Object(root)
}

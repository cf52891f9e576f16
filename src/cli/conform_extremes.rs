//! `conform extremes`: the study of the extremes, as Markdown tables and pictures.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::Failure;
use super::args::UnitArgs;
use super::output::{Kind, Origin, write_picture};
use crate::conformance::study::{self, Jump, Row, Thin};
use crate::conformance::study_rays;
use crate::image::whole::WholeFile;
use crate::image::write::Sample;
use crate::report::plot::{COLORS, Curve, log_log};
use crate::report::table::significant;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder for the pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Angles of each ellipse.
    #[arg(long, value_name = "N", default_value_t = 181)]
    turns: u32,
    /// Pairs of fragments at each break.
    #[arg(long, value_name = "N", default_value_t = 400)]
    pairs: u32,
    #[command(flatten)]
    unit: UnitArgs,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let spec = args.unit.load()?;
    let rows = [
        ("ENV", study::rows(&spec)?),
        ("HIT", study_rays::searches(&spec)?),
        ("Ray cones", study_rays::cones(&spec)),
        ("TEX", study_rays::textures(&spec)?),
    ];
    let thin = study::thin(&spec, args.turns.max(1))?;
    let jumps = study::jumps(&spec, args.pairs.max(1))?;
    let mut out = std::io::stdout().lock();
    let origin = Origin::new(&spec);
    writeln!(out, "tapline {}, unit {}\n", env!("CARGO_PKG_VERSION"), origin.unit_hash)?;
    for (title, rows) in &rows {
        print_rows(&mut out, title, rows)?;
    }
    print_thin(&mut out, &thin)?;
    print_jumps(&mut out, &jumps)?;
    drop(out);
    if let Some(folder) = &args.out {
        draw(folder, &thin, &origin)?;
    }
    Ok(())
}

fn print_rows(out: &mut impl std::io::Write, title: &str, rows: &[Row]) -> Result<(), Failure> {
    writeln!(out, "### {title}\n")?;
    writeln!(out, "| row | the paper's formulas in doubles | rtl | f64 | flags of rtl |")?;
    writeln!(out, "|---|---|---|---|---|")?;
    let cell = |text: &str| text.replace('|', "\\|");
    for row in rows {
        let same = row.rtl == row.f64;
        writeln!(
            out,
            "| {} | {} | {} | {} | {} |",
            cell(&row.name),
            cell(&row.paper),
            row.rtl,
            if same { "the same" } else { &row.f64 },
            row.flags.join(" ")
        )?;
    }
    writeln!(out)?;
    Ok(())
}

fn print_thin(out: &mut impl std::io::Write, thin: &[Thin]) -> Result<(), Failure> {
    writeln!(
        out,
        "| λ1/λ2 | λ2 off by, eq. 17 | √det | eq. 17 in binary32 | line's end off, widths, 10 entries | 32 entries |"
    )?;
    writeln!(out, "|--:|--:|--:|--:|--:|--:|")?;
    for t in thin.iter().step_by(2) {
        let n = |x: f64| significant(x, 2);
        writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} |",
            significant(t.anisotropy, 3),
            n(t.minor[0]),
            n(t.minor[1]),
            n(t.minor[2]),
            n(t.displacement[0]),
            n(t.displacement[1])
        )?;
    }
    writeln!(out)?;
    Ok(())
}

fn print_jumps(out: &mut impl std::io::Write, jumps: &[Jump]) -> Result<(), Failure> {
    writeln!(out, "| between the two | pairs | rtl: worst, mean | f64: worst, mean |")?;
    writeln!(out, "|---|--:|--:|--:|")?;
    for j in jumps {
        let pair = |[worst, mean]: [f64; 2]| format!("{worst:.2}, {mean:.3}");
        writeln!(out, "| {} | {} | {} | {} |", j.name, j.pairs, pair(j.rtl), pair(j.f64))?;
    }
    Ok(())
}

fn draw(folder: &Path, thin: &[Thin], origin: &Origin) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let curve = |name: &str, k: usize, y: &dyn Fn(&Thin) -> f64| Curve {
        name: name.into(),
        color: COLORS[k],
        points: thin.iter().map(|t| [t.anisotropy, y(t)]).collect(),
    };
    let minor = [
        curve("EQ. 17 IN REGISTERS", 0, &|t| t.minor[0]),
        curve("ROOT OF DET", 1, &|t| t.minor[1]),
        curve("EQ. 17 IN BINARY32", 2, &|t| t.minor[2]),
    ];
    let axis = [
        curve("10 ENTRIES", 0, &|t| t.displacement[0]),
        curve("32 ENTRIES", 1, &|t| t.displacement[1]),
    ];
    for (name, title, curves) in [
        ("lambda2", "LAMBDA 2: RELATIVE ERROR, WORST OF ALL ANGLES", &minor[..]),
        ("axis", "END OF THE LINE: DISPLACEMENT IN WIDTHS OF A PROBE", &axis[..]),
    ] {
        let picture = log_log(title, "LAMBDA 1 / LAMBDA 2", curves, 560, 340);
        let file = WholeFile::create(folder.join(format!("{name}.png")))?;
        write_picture(file, Kind::Png, &picture, 0.0, &origin.attributes(name), Sample::Float)?;
    }
    Ok(())
}

//! Budgets over whole domains: a function of at most 2^24 inputs is tested with all of them.

use rayon::prelude::*;
use rtl_model::cone::{Dyadic, SmallFloat, StoreRounding, exact};
use rtl_model::regs::Reg;
use rtl_model::stages::filter::weights::weights;
use rtl_model::stages::{Roms, filter};
use rtl_model::tables::rom::PORT_FRAC;

use crate::base::num;
use crate::engine::tex::value;
use crate::error::InputError;
use crate::unit::bounds::words::TableErrors;
use crate::unit::{UnitSpec, refused};

/// A domain that was tried whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Certified {
    /// What was tried.
    pub name: String,
    /// The inputs, in words.
    pub domain: String,
    /// How many.
    pub inputs: u64,
    /// The derived bound.
    pub bound: f64,
    /// The worst error.
    pub worst: f64,
    /// The unit of both.
    pub unit: &'static str,
}

impl Certified {
    /// Whether the bound holds everywhere.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.worst <= self.bound
    }
}

/// Arguments of a table that are tried: all with this many fraction bits.
const ARGUMENT_BITS: u32 = 23;

/// The worst |error(argument)| over all arguments of [`ARGUMENT_BITS`] in `binades` binades.
fn sweep(binades: u32, error: impl Fn(i64, f64) -> f64 + Sync) -> (u64, f64) {
    let count = 1u32 << ARGUMENT_BITS;
    let lift = PORT_FRAC - ARGUMENT_BITS;
    let worst = (0..count * binades)
        .into_par_iter()
        .map(|k| {
            let (binade, step) = (k / count, k % count);
            let code = i64::from((count + step) << binade) << lift;
            let x = libm::ldexp(f64::from(count + step), num::i32(binade) - 23);
            error(code, x)
        })
        .reduce(|| 0.0, f64::max);
    (u64::from(count * binades), worst)
}

fn real(code: i64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "at most 33 bits")]
    let code = code as f64;
    libm::ldexp(code, -30)
}

/// The tables: relative errors, of log2 absolute ones. Doubles are off by 2^−52, far below every bound.
fn tables(spec: &UnitSpec, roms: &Roms, out: &mut Vec<Certified>) {
    let bounds = TableErrors::new(&spec.config);
    let mut add = |name: &str,
                   binades: u32,
                   bound: f64,
                   error: &(dyn Fn(i64, f64) -> f64 + Sync)| {
        let (inputs, worst) = sweep(binades, error);
        out.push(Certified {
            name: format!("tables.{name}"),
            domain: format!("arguments of {ARGUMENT_BITS} fraction bits in {binades} binade(s)"),
            inputs,
            bound,
            worst,
            unit: if name == "log2" { "absolute" } else { "relative" },
        });
    };
    add("recip", 1, bounds.recip, &|code, x| (real(roms.recip.recip(code)) * x - 1.0).abs());
    add("rsqrt", 2, bounds.rsqrt, &|code, x| (real(roms.rsqrt.rsqrt(code)) * x.sqrt() - 1.0).abs());
    add("sqrt", 2, bounds.sqrt, &|code, x| {
        (real(roms.sqrt.sqrt(code, &roms.rsqrt)) / x.sqrt() - 1.0).abs()
    });
    add("log2", 1, bounds.log2, &|code, x| (real(roms.log2.log2(code)) - libm::log2(x)).abs());
}

/// The angle table's entries against sine and cosine.
fn angles(spec: &UnitSpec, roms: &Roms, out: &mut Vec<Certified>) {
    let frac = num::i32(spec.config.tables.eigen.frac);
    let mut worst = 0.0f64;
    for [cos, sin] in &roms.angle.angles {
        // Entries lie on the circle but for their roundings.
        #[expect(clippy::cast_precision_loss, reason = "at most 29 bits")]
        let [c, s] = [*cos, *sin].map(|x| libm::ldexp(x as f64, -frac));
        let angle = libm::atan2(s, c);
        let step = std::f64::consts::FRAC_PI_2 / f64::from(spec.config.tables.eigen.entries);
        let place = (2.0 * angle / step).round() * step / 2.0;
        let error = (c - libm::cos(place)).abs().max((s - libm::sin(place)).abs());
        worst = worst.max(libm::ldexp(error, frac));
    }
    let inputs = num::u64(roms.angle.angles.len());
    out.push(Certified {
        name: "tables.eigen".into(),
        domain: "entries".into(),
        inputs: 2 * inputs,
        bound: 0.5 + 1e-6,
        worst,
        unit: "LSB",
    });
}

/// Weights of the probes: their sums and their shapes.
fn probe_weights(spec: &UnitSpec, out: &mut Vec<Certified>) {
    let policy = &spec.config.policy.footprint;
    let (mut inputs, mut off) = (0, 0);
    for count in 1..=policy.max_probes {
        let table = weights(count, policy);
        inputs += u64::from(count);
        let sum: i64 = table.iter().sum();
        off = off.max((sum - (1 << policy.weight_bits)).abs());
        off += i64::from(table.iter().any(|w| *w < 0));
    }
    #[expect(clippy::cast_precision_loss, reason = "a small count")]
    out.push(Certified {
        name: "footprint.weights".into(),
        domain: "gaussian weights of every count of probes".into(),
        inputs,
        bound: 0.0,
        worst: off as f64,
        unit: "sum less 2^bits",
    });
}

/// LOD codes: level and weight against the code's own value.
fn levels(spec: &UnitSpec, out: &mut Vec<Certified>) -> Result<(), InputError> {
    let cfg = filter::Cfg::new(&spec.config).map_err(refused)?;
    let format = spec.config.format(Reg::FootLod);
    if format.magnitude_bits() > 24 {
        return Ok(());
    }
    let frac = num::i32(format.frac);
    let bits = num::i32(spec.config.policy.filter.lod_bits);
    let mut worst = 0.0f64;
    for code in 0..=format.max_raw() {
        let (level, weight) = cfg.level(code, usize::MAX);
        #[expect(clippy::cast_precision_loss, reason = "at most 24 bits")]
        let (lod, level, weight) = (code as f64, level as f64, weight as f64);
        let held = level + libm::ldexp(weight, -bits);
        worst = worst.max((libm::ldexp(lod, -frac) - held).abs());
    }
    let bound = if bits >= frac { 0.0 } else { libm::ldexp(0.5, -bits) };
    out.push(Certified {
        name: "filter.level".into(),
        domain: "LOD codes".into(),
        inputs: format.max_raw().unsigned_abs() + 1,
        bound,
        worst,
        unit: "levels",
    });
    Ok(())
}

/// Stores of cones: every binary16 number and the 256 places between it and the next.
fn stores(spec: &UnitSpec, out: &mut Vec<Certified>) {
    let format: SmallFloat = spec.config.policy.cone.format.float();
    let rounding = spec.config.policy.cone.rounding;
    let largest = format.unpack(format.largest()).0;
    let top = value(largest);
    let worst = (0..0x7c00u32 << 8)
        .into_par_iter()
        .map(|k| {
            let (code, between) = (k >> 8, k & 0xff);
            let here = SmallFloat::F16.unpack(code).0;
            let x = Dyadic::new(false, (here.m << 8) | u64::from(between), here.e - 8);
            let sum = exact::sum2(x, Dyadic::ONE, Dyadic::ZERO);
            let stored = format.store(rounding, 0x8000_0000, &sum);
            let (want, held) = (value(x).min(top), value(format.unpack(stored.code).0));
            let place = if want == 0.0 {
                format.lowest_exponent()
            } else {
                (i64::from(libm::ilogb(want)) - i64::from(format.mantissa_bits))
                    .max(format.lowest_exponent())
            };
            let ulp = libm::ldexp(1.0, num::i32(place));
            ((held - want) / ulp).abs()
        })
        .reduce(|| 0.0, f64::max);
    out.push(Certified {
        name: "ray_cone.store".into(),
        domain: "every binary16 number and 255 places to the next".into(),
        inputs: 0x7c00 << 8,
        bound: match rounding {
            StoreRounding::Rne => 0.5,
            StoreRounding::Truncate | StoreRounding::Stochastic => 1.0,
        },
        worst,
        unit: "ulp",
    });
}

/// Every domain of at most 2^24 inputs.
pub fn certify(spec: &UnitSpec) -> Result<Vec<Certified>, InputError> {
    let roms = Roms::new(&spec.config).map_err(refused)?;
    let mut out = Vec::new();
    tables(spec, &roms, &mut out);
    angles(spec, &roms, &mut out);
    probe_weights(spec, &mut out);
    levels(spec, &mut out)?;
    stores(spec, &mut out);
    Ok(out)
}

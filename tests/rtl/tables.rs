//! The integer model's tables against `libm`: every entry correctly rounded, every evaluation inside
//! the bound that its order, entry width and Newton steps imply.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "the oracle is in doubles: integers here stay below 2^53"
)]

use rtl_model::policy::Placement;
use rtl_model::tables::rom::{PORT_FRAC, mantissa, mantissa4};
use rtl_model::tables::{AngleRom, Function, Rom, TableSpec};
use tapline::base::random::Random;

const ULP: f64 = 1.0 / (1u64 << PORT_FRAC) as f64;

fn exact(function: Function, x: f64) -> f64 {
    match function {
        Function::Recip => 1.0 / x,
        Function::Rsqrt => 1.0 / x.sqrt(),
        Function::Sqrt => x.sqrt(),
        Function::Log2 => libm::log2(x),
    }
}

const FUNCTIONS: [Function; 4] = [Function::Recip, Function::Rsqrt, Function::Sqrt, Function::Log2];

/// Where the entries of a table lie, in the order in which it stores them.
fn points(function: Function, spec: TableSpec) -> Vec<f64> {
    let binades: u32 = match function {
        Function::Recip | Function::Log2 => 1,
        Function::Rsqrt | Function::Sqrt => 2,
    };
    let n = spec.entries / binades;
    let mut out = Vec::new();
    for binade in 0..binades {
        let base = f64::from(1 << binade);
        let at = |k: f64| base * (1.0 + k / f64::from(n));
        match spec.order {
            0 => out.extend((0..n).map(|k| at(f64::from(k) + 0.5))),
            1 => out.extend((0..=n).map(|k| at(f64::from(k)))),
            _ => out.extend((0..=2 * n).map(|k| at(f64::from(k) / 2.0))),
        }
    }
    out
}

#[test]
fn every_entry_is_the_correctly_rounded_value() {
    // libm is within 1 ulp of a double: 2^28 · 2 · 2^−52 < 2^−22 LSB, so |error| ≤ ½ + 2^−22; only an
    // entry that lies nearer to a tie than that would escape.
    let mut seen = 0;
    for function in FUNCTIONS {
        for entries in [2, 4, 64, 4096] {
            for order in 0..=2 {
                for frac in [2, 9, 16, 28] {
                    let spec = TableSpec { entries, order, frac, newton: 0 };
                    let rom = Rom::new(function, spec).expect("every entry is decided");
                    let points = points(function, spec);
                    assert_eq!(rom.values.len(), points.len());
                    for (&value, x) in rom.values.iter().zip(points) {
                        let scaled = exact(function, x) * f64::from(1u32 << frac);
                        let error = (value as f64 - scaled).abs();
                        assert!(
                            error <= 0.5 + 0.5f64.powi(22),
                            "{function:?} at {x}, {entries} entries, {frac} bits: {error} LSB"
                        );
                        seen += 1;
                    }
                }
            }
        }
    }
    assert!(seen > 100_000);
}

/// Largest magnitude of the first three derivatives on the binade that starts at `low`.
fn derivatives(function: Function, low: f64) -> [f64; 3] {
    // All of them fall with x, so their largest magnitudes are at `low`.
    match function {
        Function::Recip => [low.powi(-2), 2.0 * low.powi(-3), 6.0 * low.powi(-4)],
        Function::Rsqrt => [0.5 * low.powf(-1.5), 0.75 * low.powf(-2.5), 1.875 * low.powf(-3.5)],
        Function::Sqrt => [0.5 * low.powf(-0.5), 0.25 * low.powf(-1.5), 0.375 * low.powf(-2.5)],
        Function::Log2 => {
            let e = std::f64::consts::LOG2_E;
            [e / low, e * low.powi(-2), 2.0 * e * low.powi(-3)]
        }
    }
}

/// Bound of the interpolated value, before Newton.
///
/// Order 0: |f′|h/2; 1: |f″|h²/8; 2: |f‴|·max|t(t − h/2)(t − h)|/6 = |f‴|h³/(72√3)·… with
/// max = h³/(12√3). Entries are off by ½ LSB, amplified by 1, 1 and 5/4 (the Lebesgue constant of three
/// nodes). Ports round by ½ ulp; order 2 truncates the square, whose coefficient is at most |f″|h²·2.
fn table_bound(function: Function, spec: TableSpec, low: f64) -> f64 {
    let binades = match function {
        Function::Recip | Function::Log2 => 1,
        Function::Rsqrt | Function::Sqrt => 2,
    };
    let h = low / f64::from(spec.entries / binades);
    let [d1, d2, d3] = derivatives(function, low);
    let half_lsb = 0.5f64.powi(i32::try_from(spec.frac).expect("small") + 1);
    match spec.order {
        0 => d1 * h / 2.0 + half_lsb,
        1 => d2 * h * h / 8.0 + half_lsb + ULP,
        _ => {
            let square = 2.0 * (d2 * h * h + 8.0 * half_lsb) * ULP;
            d3 * h.powi(3) / (72.0 * 3.0f64.sqrt()) + 1.25 * half_lsb + square + ULP
        }
    }
}

/// Bound after the Newton steps of 1/x, 1/√x and √x (see the comments for the recurrences).
fn newton_bound(function: Function, spec: TableSpec, rsqrt: TableSpec, low: f64) -> f64 {
    let mut error = table_bound(function, spec, low);
    for _ in 0..spec.newton {
        error = match function {
            // y′ − 1/x = −x(y − 1/x)²; xy and ye round: ½ ulp·y + ½ ulp.
            Function::Recip => 2.0 * low * error * error + 1.25 * ULP,
            // With y = (1 + δ)/√x: y′ = (1 − 3δ²/2 − δ³/2)/√x; three roundings: ≤ 1.5 ulp.
            Function::Rsqrt => {
                let root = (2.0 * low).sqrt();
                let delta = error * root;
                (1.5 * delta * delta + 0.5 * delta.powi(3)) / low.sqrt() + 1.5 * ULP
            }
            // With r = (1 + ρ)/√x: y′ = √x(1 − δ²/2 − ρ(δ + δ²/2)); two roundings: ≤ 1 ulp.
            Function::Sqrt => {
                let delta = error / low.sqrt();
                let rho = newton_bound(Function::Rsqrt, rsqrt, rsqrt, low) * (2.0 * low).sqrt();
                let left = delta * delta / 2.0 + rho * (delta + delta * delta / 2.0);
                (2.0 * low).sqrt() * left + ULP
            }
            Function::Log2 => error,
        };
    }
    error
}

#[test]
fn every_evaluation_lies_inside_the_bound_of_its_knobs() {
    let mut tight = 0;
    for function in FUNCTIONS {
        for entries in [2, 8, 64, 1024] {
            for order in 0..=2 {
                for frac in [6, 16, 28] {
                    for newton in 0..=2 {
                        if function == Function::Log2 && newton > 0 {
                            continue;
                        }
                        let spec = TableSpec { entries, order, frac, newton };
                        // A step's recurrence holds for any start; a poor start gives a large bound.
                        let rom = Rom::new(function, spec).expect("decided");
                        let rsqrt = Rom::new(Function::Rsqrt, spec).expect("decided");
                        let (bits, binades) = match function {
                            Function::Recip | Function::Log2 => (14, 1),
                            Function::Rsqrt | Function::Sqrt => (13, 2),
                        };
                        for binade in 0..binades {
                            let low = f64::from(1 << binade);
                            let bound = newton_bound(function, spec, spec, low);
                            let mut worst = 0.0f64;
                            for i in 0..1i64 << bits {
                                let x = ((1i64 << bits) + i) << (30 - bits + binade);
                                let y = match function {
                                    Function::Recip => rom.recip(x),
                                    Function::Rsqrt => rom.rsqrt(x),
                                    Function::Sqrt => rom.sqrt(x, &rsqrt),
                                    Function::Log2 => rom.log2(x),
                                };
                                let want = exact(function, x as f64 * ULP);
                                worst = worst.max((y as f64 * ULP - want).abs());
                            }
                            assert!(
                                worst <= bound,
                                "{function:?} {spec:?}, binade {binade}: {worst} > {bound}"
                            );
                            tight += usize::from(worst > bound / 4.0);
                        }
                    }
                }
            }
        }
    }
    assert!(tight > 80, "{tight}: the bounds would be too loose to say anything");
}

#[test]
fn the_default_tables_hold_every_20_bit_mantissa_inside_their_bound() {
    let tables = rtl_model::Config::default().tables;
    let rsqrt = Rom::new(Function::Rsqrt, tables.rsqrt).expect("decided");
    for (function, spec) in [
        (Function::Recip, tables.recip),
        (Function::Rsqrt, tables.rsqrt),
        (Function::Sqrt, tables.sqrt),
        (Function::Log2, tables.log2),
    ] {
        let rom = Rom::new(function, spec).expect("decided");
        let mut before = None;
        for x in (1i64 << 20)..(1 << 21) {
            let x = x << 10;
            let y = match function {
                Function::Recip => rom.recip(x),
                Function::Rsqrt => rom.rsqrt(x),
                Function::Sqrt => rom.sqrt(x, &rsqrt),
                Function::Log2 => rom.log2(x),
            };
            let error = (y as f64 * ULP - exact(function, x as f64 * ULP)).abs();
            let bound = newton_bound(function, spec, tables.rsqrt, 1.0);
            assert!(error <= bound, "{function:?} at {x}: {error} > {bound}");
            // The log2 decides the level: it may never fall.
            if function == Function::Log2 {
                assert!(before <= Some(y), "log2 falls at {x}");
                before = Some(y);
            }
        }
    }
}

#[test]
fn order_one_and_two_are_exact_at_their_own_entries() {
    for function in FUNCTIONS {
        for order in [1, 2] {
            let spec = TableSpec { entries: 16, order, frac: 28, newton: 0 };
            let rom = Rom::new(function, spec).expect("decided");
            for (&value, x) in rom.values.iter().zip(points(function, spec)) {
                let code = (x / ULP) as i64;
                let (end, y) = match function {
                    Function::Recip => (2.0, code),
                    Function::Log2 => (2.0, code),
                    Function::Rsqrt | Function::Sqrt => (4.0, code),
                };
                if x >= end {
                    continue;
                }
                let y = match function {
                    Function::Recip => rom.recip(y),
                    Function::Rsqrt => rom.rsqrt(y),
                    Function::Sqrt => rom.sqrt(y, &rom),
                    Function::Log2 => rom.log2(y),
                };
                // At 2 the second binade answers; its first entry is the first one's last.
                assert_eq!(y, value << 2, "{function:?} order {order} at {x}");
            }
        }
    }
}

#[test]
fn mantissas_are_normalised_with_their_power_of_two() {
    for bit in 0..62 {
        for x in [1i64 << bit, (1 << bit) + (1 << bit) / 3, (2 << bit) - 1] {
            let (m, e) = mantissa(x);
            assert!((1 << 30..2 << 30).contains(&m), "{x}");
            assert_eq!(e, i64::from(x.ilog2()));
            let kept = if e > 30 {
                (m << (e - 30), x >> (e - 30) << (e - 30))
            } else {
                (m >> (30 - e), x)
            };
            assert_eq!(kept.0, kept.1);
            let (m4, q) = mantissa4(x);
            assert!((1i64 << 30..4i64 << 30).contains(&m4), "{x}: {m4}");
            let s = 2 * q - 30;
            let kept = if s > 0 { (m4 << s, x >> s << s) } else { (m4 >> -s, x) };
            assert_eq!(kept.0, kept.1, "{x}");
        }
    }
}

fn angle(entries: u32, order: u32, frac: u32, placement: Placement) -> AngleRom {
    let spec = TableSpec { entries, order, frac, newton: 0 };
    AngleRom::new(spec, placement).expect("every entry is decided")
}

/// α of entry k in degrees of a quarter turn, in units of 90°.
fn alpha(k: usize, entries: u32, placement: Placement) -> f64 {
    let k = f64::from(u32::try_from(k).expect("small"));
    let offset = match placement {
        Placement::Edges => 0.0,
        Placement::Centres => 0.5,
    };
    (k + offset) / f64::from(entries) * std::f64::consts::FRAC_PI_2
}

#[test]
fn the_angle_table_holds_rounded_sines_and_ascending_boundaries() {
    for &placement in Placement::ALL {
        for entries in [2, 4, 10, 32, 90, 1024] {
            for order in [0, 1] {
                for frac in [4, 20, 28] {
                    let rom = angle(entries, order, frac, placement);
                    let scale = f64::from(1u32 << frac);
                    for (k, &[cos, sin]) in rom.angles.iter().enumerate() {
                        // Interpolated centres begin with the first entry's mirror image.
                        let mirror = order == 1 && placement == Placement::Centres;
                        let a = alpha(k, entries, placement)
                            - if mirror { alpha(1, entries, Placement::Edges) } else { 0.0 };
                        let slack = 0.5 + 0.5f64.powi(20);
                        assert!((cos as f64 - libm::cos(a) * scale).abs() <= slack);
                        assert!((sin as f64 - libm::sin(a) * scale).abs() <= slack);
                    }
                    for pair in rom.boundaries.windows(2) {
                        let [[c0, s0], [c1, s1]] = [pair[0], pair[1]];
                        assert!(s1 * c0 > s0 * c1, "boundaries ascend");
                    }
                    let beyond = usize::from(order == 1);
                    assert_eq!(rom.boundaries.len() + 1 + beyond, rom.angles.len());
                    assert_eq!(rom.doubled.len(), beyond * (rom.boundaries.len() + 1));
                    if placement == Placement::Edges {
                        assert_eq!(rom.angles[0], [1 << frac, 0], "0° is an entry");
                        let last = rom.angles[rom.angles.len() - 1];
                        assert_eq!(last[0], last[1], "45° is the last one");
                    }
                }
            }
        }
    }
}

#[test]
fn the_angle_index_is_the_nearest_entry() {
    // Boundaries are rounded to 2^−28 and atan2 to 2^−52: outside of 2^−26 around a boundary the nearest
    // entry is certain.
    let mut random = Random::new(1);
    let mut next = |bits: u32| random.between(0, (1 << bits) - 1);
    let mut compared = 0;
    for &placement in Placement::ALL {
        for entries in [2, 10, 32, 64, 1024] {
            let rom = angle(entries, 0, 20, placement);
            for case in 0..4000 {
                let (a, b) = (next(1 + case % 31), next(1 + case / 31 % 31));
                if a == 0 && b == 0 {
                    continue;
                }
                let two_alpha = libm::atan2(a as f64, b as f64);
                let near = |k: usize| (2.0 * alpha(k, entries, placement) - two_alpha).abs();
                let best = (0..rom.angles.len())
                    .min_by(|&i, &j| near(i).total_cmp(&near(j)))
                    .expect("entries");
                let got = usize::try_from(rom.index(a, b)).expect("an entry");
                assert!(
                    near(got) <= near(best) + 0.5f64.powi(25),
                    "{entries} entries, {placement:?}: {a}/{b} gives {got}, nearest {best}"
                );
                compared += usize::from(got == best);
            }
        }
    }
    assert!(compared > 39_000, "{compared}");
}

#[test]
fn the_angle_index_turns_over_exactly_at_its_boundary_constants() {
    for &placement in Placement::ALL {
        for entries in [4, 32, 1024] {
            for order in [0, 1] {
                let rom = angle(entries, order, 20, placement);
                for (k, &[cos, sin]) in (0..).zip(&rom.boundaries) {
                    // On the boundary the lower entry, one code above it the higher one.
                    assert_eq!(rom.index(sin, cos), k);
                    // The boundary at 90° is the last entry of order 1: nothing lies beyond it.
                    if cos > 0 {
                        assert_eq!(rom.index(sin + 1, cos), k + 1);
                        assert_eq!(rom.index(sin, cos - 1), k + 1);
                    }
                    assert_eq!(rom.index(sin, cos + 1), k);
                }
                assert_eq!(rom.index(0, 1), 0);
                let reachable = rom.boundaries.iter().filter(|b| b[0] > 0).count();
                assert_eq!(usize::try_from(rom.index(1, 0)), Ok(reachable));
            }
        }
    }
}

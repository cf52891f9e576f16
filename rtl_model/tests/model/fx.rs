//! Register writes and block registers against their definitions.

use crate::common::{Rng, limit, round_ratio};
use rtl_model::fx::{Format, Overflow, Quantizer, Rounding, block};

fn format(signed: bool, int: u32, frac: u32, rounding: Rounding, overflow: Overflow) -> Format {
    Format { signed, int, frac, rounding, overflow }
}

#[test]
fn rounding_matches_its_definition_for_every_16_bit_input_and_shift() {
    for &rounding in Rounding::ALL {
        let q = Quantizer::new(format(true, 40, 0, rounding, Overflow::Saturate), 0);
        for shift in 0..=18 {
            for x in -32768i64..=32767 {
                let expected = round_ratio(x.into(), 1 << shift, rounding);
                assert_eq!(
                    i128::from(q.round(x, shift)),
                    expected,
                    "{} of {x} / 2^{shift}",
                    rounding.name()
                );
            }
        }
    }
}

#[test]
fn the_eight_roundings_are_eight_different_functions() {
    // (value·2, results in the order of `Rounding::ALL`), checked by hand.
    let ties = [
        (5, [2, 2, 3, 2, 3, 2, 2, 3]),
        (7, [3, 3, 4, 3, 4, 3, 4, 3]),
        (-5, [-3, -2, -2, -3, -3, -2, -2, -3]),
        (-7, [-4, -3, -3, -4, -4, -3, -4, -3]),
    ];
    for (x, expected) in ties {
        for (&rounding, want) in Rounding::ALL.iter().zip(expected) {
            let q = Quantizer::new(format(true, 8, 0, rounding, Overflow::Saturate), 0);
            assert_eq!(q.round(x, 1), want, "{} of {x}/2", rounding.name());
        }
    }
}

#[test]
fn overflow_matches_its_definition_for_every_16_bit_value() {
    for signed in [false, true] {
        for bits in [1, 2, 7, 8, 15, 16] {
            for &overflow in Overflow::ALL {
                let f = format(signed, bits, 0, Rounding::Floor, overflow);
                let q = Quantizer::new(f, 0);
                for y in -40000i64..=40000 {
                    let (code, over) = q.limit(y);
                    assert_eq!(
                        (i128::from(code), over),
                        limit(y.into(), f),
                        "{} of {y} in {bits} bits, signed {signed}",
                        overflow.name()
                    );
                }
            }
        }
    }
}

/// x·2^−shift in a format, by definition; exact for |x| < 2^63 and any shift.
fn defined(x: i64, shift: i64, f: Format) -> (i64, bool) {
    // Beyond ±64 nothing changes: less than 2^−1 is left, or every kept bit is zero.
    let y = if shift <= 0 {
        i128::from(x) << (-shift).min(64)
    } else {
        round_ratio(x.into(), 1 << shift.min(66), f.rounding)
    };
    let (code, over) = limit(y, f);
    (i64::try_from(code).expect("a code of at most 58 bits"), over)
}

#[test]
fn a_write_with_any_shift_matches_its_definition() {
    let mut rng = Rng(1);
    let mut values: Vec<i64> = vec![0, 1, -1, 3, -3];
    for bit in 1..62 {
        for near in [-1, 0, 1] {
            values.extend([(1 << bit) + near, -(1 << bit) + near]);
        }
        values.push((3 << bit) >> 1);
        values.push(-((3i64 << bit) >> 1));
        values.push(rng.signed(62));
    }
    values.retain(|x| x.unsigned_abs() < 1 << 62);
    let widths = [(0, 1), (1, 0), (8, 8), (17, 24), (0, 58), (58, 0)];
    for &rounding in Rounding::ALL {
        for &overflow in Overflow::ALL {
            for signed in [false, true] {
                for (int, frac) in widths {
                    let f = format(signed, int, frac, rounding, overflow);
                    let q = Quantizer::new(f, 0);
                    for &x in &values {
                        for shift in (-70..=70).chain([-200, -128, -127, 127, 128, 200]) {
                            if shift > 24 && shift < 54 && shift % 4 != 0 {
                                continue;
                            }
                            assert_eq!(
                                q.write_shifted(x, shift),
                                defined(x, shift, f),
                                "{x} / 2^{shift} in {f:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn three_quarters_of_the_largest_sum_shifted_out_rounds_to_zero() {
    // 1.5·2^61 / 2^63 = 0.375: to nearest it is 0.
    let f = format(true, 8, 8, Rounding::HalfEven, Overflow::Saturate);
    assert_eq!(Quantizer::new(f, 0).write_shifted(3 << 60, 63), (0, false));
    let f = format(true, 8, 8, Rounding::Floor, Overflow::Saturate);
    assert_eq!(Quantizer::new(f, 0).write_shifted(-(3 << 60), 63), (-1, false));
    assert_eq!(Quantizer::new(f, 0).write_shifted(3 << 60, 1000), (0, false));
}

#[test]
fn a_left_shift_takes_any_integer() {
    for &overflow in Overflow::ALL {
        for signed in [false, true] {
            let f = format(signed, 20, 12, Rounding::HalfEven, overflow);
            let q = Quantizer::new(f, 0);
            for x in [i64::MIN, i64::MIN + 1, i64::MAX, 1 << 62, -(1 << 62), 0x1234_5678_9abc] {
                for shift in -130..=0 {
                    assert_eq!(
                        q.write_shifted(x, shift),
                        defined(x, shift, f),
                        "{x} {shift} {f:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn write_uses_the_fraction_it_was_made_with() {
    for frac_in in 0..60 {
        let f = format(true, 10, 20, Rounding::HalfAway, Overflow::SaturateSymmetric);
        let q = Quantizer::new(f, frac_in);
        for x in [-1i64, 1, 12345, -54321, (1 << 40) + 3] {
            assert_eq!(q.write(x), defined(x, frac_in - 20, f));
        }
    }
}

#[test]
fn a_block_fills_its_register_and_each_mantissa_is_within_half_an_lsb() {
    let mut rng = Rng(2);
    let mut filled = 0;
    for case in 0..200_000 {
        let width = rng.bits(1, 31);
        let rounding = rng.pick(Rounding::ALL);
        let q = Quantizer::new(format(true, 1, width - 1, rounding, Overflow::Saturate), 0);
        let x = [rng.signed(61), rng.signed(61), rng.signed(61)];
        let frac = rng.range(-100, 100);
        let out = block::normalize(false, &q, &x, frac);
        let max = (1i64 << width) - 1;
        let largest = out.m.iter().map(|m| m.abs()).max().expect("three");
        if x == [0; 3] {
            assert_eq!(out.m, [0; 3]);
            continue;
        }
        filled += 1;
        assert!(largest <= max && largest >= 1 << (width - 1), "case {case}: {x:?} {out:?}");
        // One shift for all: m·2^shift stands for x.
        let shift = frac - out.frac;
        let nearest = !matches!(rounding, Rounding::Floor | Rounding::Zero);
        for (&m, &x) in out.m.iter().zip(&x) {
            let (m, x) = if shift >= 0 {
                (i128::from(m) << shift, i128::from(x))
            } else {
                (i128::from(m), i128::from(x) << -shift)
            };
            let error = (m - x).abs();
            let lsb = if shift >= 0 { 1i128 << shift } else { 1 };
            let clamped = m.abs() == i128::from(max) << shift.max(0);
            if shift <= 0 {
                assert_eq!(error, 0, "case {case}: a left shift is exact");
            } else if nearest && !clamped {
                assert!(2 * error <= lsb, "case {case}: {error} of {lsb}");
            } else {
                assert!(error < lsb || (clamped && error == lsb), "case {case}: {error} of {lsb}");
            }
        }
    }
    assert!(filled > 190_000);
}

#[test]
fn a_block_with_a_given_shift_rounds_each_component_alike() {
    let mut rng = Rng(3);
    for _ in 0..50_000 {
        let width = rng.bits(4, 31);
        let rounding = rng.pick(Rounding::ALL);
        let f = format(true, 2, width - 2, rounding, Overflow::SaturateSymmetric);
        let q = Quantizer::new(f, 0);
        let x = [rng.signed(60), rng.signed(60)];
        let shift = block::top_bit(&x) + 2 - i64::from(width);
        let out = block::shifted(false, &q, &x, 60, shift);
        assert_eq!(out.frac, 60 - shift);
        for (&m, &x) in out.m.iter().zip(&x) {
            assert_eq!(m, defined(x, shift, f).0);
        }
    }
}

#[test]
fn the_top_bit_is_the_leading_one_of_the_largest_magnitude() {
    assert_eq!(block::top_bit(&[0, 0]), -1);
    assert_eq!(block::top_bit(&[i64::MIN, 0]), 63);
    for bit in 0..63 {
        assert_eq!(block::top_bit(&[1i64 << bit, -1]), bit);
        assert_eq!(block::top_bit(&[0, -(1i64 << bit)]), bit);
    }
}

//! Powers of two of the inputs change the true values in a trace and no code of any register.

use super::run_one;
use crate::common::{NEEDS, Rng};
use rtl_model::policy::Dnmod;
use rtl_model::unit::{Unit, Words};
use rtl_model::{Config, Reg, Stage};

/// A plain number between 2^−4 and 2^2 in magnitude, as a binary64 word.
fn plain(rng: &mut Rng) -> u64 {
    let exponent = 1023u64.wrapping_add_signed(rng.range(-4, 1));
    (rng.word() & (1 << 63)) | (exponent << 52) | (rng.word() >> 12)
}

fn fragment(rng: &mut Rng) -> Words {
    let mut words = Words::default();
    let all = words
        .v
        .iter_mut()
        .chain(&mut words.n)
        .chain(words.dv.iter_mut().flatten())
        .chain(words.dn.iter_mut().flatten())
        .chain(&mut words.h)
        .chain(&mut words.b)
        .chain(&mut words.d);
    for word in all {
        *word = plain(rng);
    }
    words
}

/// The fragment with v, n and h times 2^v, 2^n and 2^h, derivatives along with their vectors.
fn scaled(words: &Words, v: i64, n: i64, h: i64) -> Words {
    let by = |word: u64, k: i64| word.wrapping_add_signed(k << 52);
    Words {
        v: words.v.map(|w| by(w, v)),
        n: words.n.map(|w| by(w, n)),
        dv: words.dv.map(|d| d.map(|w| by(w, v))),
        dn: words.dn.map(|d| d.map(|w| by(w, n))),
        h: words.h.map(|w| by(w, h)),
        ..*words
    }
}

/// How often v, n and h are factors of a register's true value.
fn powers(reg: Reg) -> [i64; 3] {
    if reg.info().stage == Stage::Footprint {
        return [0; 3];
    }
    match reg.info().name {
        "h" => [0, 0, 1],
        "cross" => [0, 1, 1],
        "inv_length" => [0, -1, -1],
        "scale" => [0, 0, -1],
        "n_cross" => [0, 2, 1],
        "n" | "length" | "e1" | "e2" | "n_mod" | "dn_dx" | "dn_dy" | "dn_perp" | "dn_mod"
        | "de" => [0, 1, 0],
        "v" if reg == Reg::ReflectV => [1, 0, 0],
        "dv_dx" | "dv_dy" => [1, 0, 0],
        "n_dot_v" | "n_dot_dv" | "v_dot_dn" | "v_dot_e" => [1, 1, 0],
        "n_dot_n" | "n_i_dot_dn" | "n_dot_dn" | "n_dot_e" | "perp_dot_e" => [0, 2, 0],
        "inv_nn" => [0, -2, 0],
        "v_r" | "rotated" | "dv_r" | "numerator" => [1, 2, 0],
        "inv_ma" => [-1, -2, 0],
        _ => [0; 3],
    }
}

#[test]
fn powers_of_two_of_v_n_and_h_move_the_point_and_no_code() {
    let mut rng = Rng(61);
    let mut seen = [false; Reg::COUNT];
    for case in 0..400 {
        let mut config = Config::default().with(|p| p.jacobian.dnmod = rng.pick(Dnmod::ALL));
        if rng.one_in(2) {
            let one = 1 << 24;
            config.rotation = Some([[0, one, 0], [-one, 0, 0], [0, 0, one]]);
        }
        let unit = Unit::new(&config, rng.pick(&NEEDS), 256).expect("the default words");
        let words = fragment(&mut rng);
        let (before, plain) = run_one(&unit, &words);
        let [v, n, h] = [0; 3].map(|_: i64| rng.range(-300, 300));
        let (after, moved) = run_one(&unit, &scaled(&words, v, n, h));
        assert_eq!(before.0.len(), after.0.len());
        for (a, b) in before.0.iter().zip(&after.0) {
            let (reg, raw) = (a.1, a.3);
            assert_eq!((a.1, a.2, raw), (b.1, b.2, b.3), "case {case}");
            let [pv, pn, ph] = powers(reg);
            let info = reg.info();
            assert_eq!(
                a.4 - b.4,
                pv * v + pn * n + ph * h,
                "case {case}: {}.{}",
                info.stage,
                info.name
            );
            seen[reg.index()] |= raw != 0;
        }
        assert_eq!(plain.flags, moved.flags);
        assert_eq!(plain.probes, moved.probes);
    }
    // Not run here: without a texture no probe is looked up, and ENV has no search and no cone.
    let missing: Vec<&str> = Reg::ALL
        .iter()
        .filter(|reg| {
            !seen[reg.index()]
                && !matches!(
                    reg.info().stage,
                    Stage::Address | Stage::Filter | Stage::Hit | Stage::SurfaceFootprint
                )
        })
        .map(|reg| reg.info().name)
        .collect();
    assert!(missing.is_empty(), "never seen with a value: {missing:?}");
}

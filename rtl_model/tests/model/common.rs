//! What the tests of the integer model share: a seeded generator, exact rounding, random units.

use rtl_model::fx::{Format, Overflow, Rounding};
use rtl_model::policy::{Axis, Count, Dnmod, Minor, Placement, Weights};
use rtl_model::regs::Kind;
use rtl_model::unit::{Needs, Words};
use rtl_model::{Config, TexelFormat};
use rtl_model::{Reg, Tap};

/// SplitMix64: the same cases on every platform, any of them replayable by its seed.
#[derive(Clone, Debug)]
pub struct Rng(pub u64);

impl Rng {
    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number of low..=high.
    pub fn range(&mut self, low: i64, high: i64) -> i64 {
        let span = high.abs_diff(low) + 1;
        low + i64::try_from(self.word() % span).expect("a span below 2^63")
    }

    /// A small number of low..=high.
    pub fn bits(&mut self, low: u32, high: u32) -> u32 {
        u32::try_from(self.range(low.into(), high.into())).expect("a u32 range")
    }

    /// True once in n.
    pub fn one_in(&mut self, n: u64) -> bool {
        self.word().is_multiple_of(n)
    }

    /// One of a list.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        let n = u64::try_from(of.len()).expect("a short list");
        of[usize::try_from(self.word() % n).expect("an index")]
    }

    /// A signed number with a random number of bits up to `bits`, often at a power of two.
    pub fn signed(&mut self, bits: u32) -> i64 {
        let width = self.bits(0, bits);
        let top = 1i64 << width.min(62);
        let x = match self.word() % 8 {
            0 => top,
            1 => top - 1,
            _ => self.range(0, top),
        };
        let x = x.min(((1i128 << bits) - 1).try_into().unwrap_or(i64::MAX));
        if self.one_in(2) { -x } else { x }
    }
}

/// p/q (q > 0) rounded to an integer, by the definitions.
pub fn round_ratio(p: i128, q: i128, mode: Rounding) -> i128 {
    let (floor, rest) = (p.div_euclid(q), p.rem_euclid(q));
    if rest == 0 {
        return floor;
    }
    let (negative, even) = (p < 0, floor.rem_euclid(2) == 0);
    let tie_up = match mode {
        Rounding::Floor => return floor,
        Rounding::Zero => return floor + i128::from(negative),
        Rounding::HalfUp => true,
        Rounding::HalfDown => false,
        Rounding::HalfAway => !negative,
        Rounding::HalfZero => negative,
        Rounding::HalfEven => !even,
        Rounding::HalfOdd => even,
    };
    match (2 * rest).cmp(&q) {
        std::cmp::Ordering::Less => floor,
        std::cmp::Ordering::Greater => floor + 1,
        std::cmp::Ordering::Equal => floor + i128::from(tie_up),
    }
}

/// An integer brought into a format's range, by the definitions: code and whether it was outside.
pub fn limit(y: i128, format: Format) -> (i128, bool) {
    let magnitude = 1i128 << (format.int + format.frac);
    let max = magnitude - 1;
    let symmetric = format.overflow == Overflow::SaturateSymmetric;
    let min = match (format.signed, symmetric) {
        (false, _) => 0,
        (true, true) => -max,
        (true, false) => -magnitude,
    };
    if (min..=max).contains(&y) {
        return (y, false);
    }
    let code = match format.overflow {
        Overflow::Saturate | Overflow::SaturateSymmetric => {
            if y < min {
                min
            } else {
                max
            }
        }
        Overflow::Zero => 0,
        Overflow::Wrap if format.signed => (y + magnitude).rem_euclid(2 * magnitude) - magnitude,
        Overflow::Wrap => y.rem_euclid(magnitude),
    };
    (code, true)
}

/// Everything that a tap hears, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Record(pub Vec<(usize, Reg, usize, i64, i64)>);

impl Record {
    /// The codes that one lane wrote: (register, component, raw, frac).
    pub fn lane(&self, lane: usize) -> Vec<(Reg, usize, i64, i64)> {
        self.0
            .iter()
            .filter(|entry| entry.0 == lane)
            .map(|&(_, reg, c, raw, frac)| (reg, c, raw, frac))
            .collect()
    }
}

impl Tap for Record {
    fn put(&mut self, lane: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        self.0.push((lane, reg, component, raw, frac));
    }
}

/// What scenes may need.
pub const NEEDS: [Needs; 4] = [
    Needs { bump: false, rough: false },
    Needs { bump: true, rough: false },
    Needs { bump: false, rough: true },
    Needs { bump: true, rough: true },
];

/// A format near the default one, with any rounding and overflow.
fn any_format(rng: &mut Rng, reg: Reg, spread: i64, wild: bool) -> Format {
    let base = reg.info().format;
    let near = |rng: &mut Rng, bits: u32| {
        let shifted = i64::from(bits) + rng.range(-spread, spread);
        u32::try_from(shifted.max(0)).expect("a few bits")
    };
    let (int, frac) = (near(rng, base.int), near(rng, base.frac));
    let most = if reg.info().kind == Kind::Block { 31 } else { 58 };
    let frac = frac.min(most);
    Format {
        signed: base.signed ^ (wild && rng.one_in(16)),
        int: int.min(most - frac).max(u32::from(frac == 0)),
        frac,
        rounding: rng.pick(Rounding::ALL),
        overflow: rng.pick(Overflow::ALL),
    }
}

/// A unit drawn around the default one. `spread` 0 keeps its widths.
pub fn any_config(rng: &mut Rng, spread: i64, wild: bool) -> Config {
    let mut config = Config::default();
    let all = rng.one_in(4);
    for (format, &reg) in config.formats.iter_mut().zip(Reg::ALL) {
        if all || rng.one_in(4) {
            let widened = if rng.one_in(3) { spread } else { spread / 4 };
            *format = any_format(rng, reg, widened, wild);
        } else {
            format.rounding = rng.pick(Rounding::ALL);
            if wild {
                format.overflow = rng.pick(Overflow::ALL);
            }
        }
    }
    for (table, newton) in [
        (&mut config.tables.recip, 3),
        (&mut config.tables.rsqrt, 3),
        (&mut config.tables.sqrt, 3),
        (&mut config.tables.log2, 0),
    ] {
        table.entries = 1 << rng.bits(1, 8);
        table.order = rng.bits(0, 2);
        table.frac = rng.bits(2, 28);
        table.newton = rng.bits(0, newton);
    }
    config.tables.eigen.entries = 2 * rng.bits(1, 64);
    config.tables.eigen.order = rng.bits(0, 1);
    config.tables.eigen.frac = rng.bits(4, 28);
    config.policy.eigen.placement = rng.pick(Placement::ALL);
    config.policy.footprint.max_probes =
        if rng.one_in(4) { rng.pick(&[1, 2, 63, 64]) } else { rng.bits(1, 64) };
    config.policy.footprint.count = rng.pick(Count::ALL);
    config.policy.footprint.axis = rng.pick(Axis::ALL);
    config.policy.footprint.weights = rng.pick(Weights::ALL);
    config.policy.footprint.weight_bits = rng.bits(1, 12);
    config.policy.eigen.minor = rng.pick(Minor::ALL);
    config.policy.jacobian.dnmod = rng.pick(Dnmod::ALL);
    config.roughness_scale = rng.range(0, (16 << 20) - 1);
    if rng.one_in(2) {
        let one = 1 << 24;
        config.rotation =
            Some([[0; 3]; 3].map(|row| {
                row.map(|_: i64| {
                    if rng.one_in(3) { rng.pick(&[-one, 0, one]) } else { rng.range(-one, one) }
                })
            }));
    }
    config.policy.filter.weight_bits = rng.bits(1, 8);
    config.policy.filter.lod_bits = rng.bits(1, 8);
    config.policy.texel.format = rng.pick(TexelFormat::ALL);
    if rng.one_in(2) {
        config.policy.texel.int = rng.bits(1, 17);
        config.policy.texel.frac = rng.bits(4, 24);
    }
    config
}

/// A binary64 word: any bits, or an extreme, or a plain number.
pub fn any_word(rng: &mut Rng, wild: bool) -> u64 {
    const SPECIAL: [u64; 12] = [
        0,
        1 << 63,
        1,
        (1 << 63) | 1,
        (1 << 52) - 1,
        1 << 52,
        0x3ff0_0000_0000_0000,
        0xbff0_0000_0000_0000,
        0x7fef_ffff_ffff_ffff,
        0xffef_ffff_ffff_ffff,
        0x7ff0_0000_0000_0000,
        0x7ff8_0000_0000_0001,
    ];
    let any = rng.word();
    match rng.word() % if wild { 8 } else { 40 } {
        0 => rng.pick(&SPECIAL),
        1 => any,
        // Exponents near 0: plain numbers.
        _ => {
            let exponent = 1023u64.wrapping_add_signed(rng.range(-9, 4));
            let fraction = if rng.one_in(3) { 0 } else { any & ((1 << 52) - 1) };
            (any & (1 << 63)) | (exponent << 52) | fraction
        }
    }
}

/// A fragment of such words.
pub fn any_words(rng: &mut Rng) -> Words {
    let wild = rng.one_in(3);
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
        *word = any_word(rng, wild);
    }
    if rng.one_in(10) {
        words.h = words.n;
    }
    words
}

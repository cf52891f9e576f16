//! The sheet on which the rules note their findings.

use rtl_model::Config;
use rtl_model::fx::{Overflow, Rounding};
use rtl_model::regs::Reg;

use crate::base::num;
use crate::engine::probe::{Code, RtlProbe};
use crate::reference::real::Real;
use crate::reference::wide::Wide;
use crate::stage::Stage;
use crate::unit::bounds::words::TableErrors;

/// A component against its formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// The stage.
    pub stage: Stage,
    /// The register, or `None` for a choice such as the face.
    pub reg: Option<Reg>,
    /// The register's name, or the choice's.
    pub name: &'static str,
    /// Component.
    pub component: usize,
    /// The device's value.
    pub observed: i64,
    /// The formula's value in LSB, unrounded.
    pub exact: f64,
    /// |observed − exact| in LSB, the overflow mode honoured.
    pub error: f64,
    /// Largest |observed − exact| of a correct register, in LSB.
    pub bound: f64,
}

impl Finding {
    /// Whether a correct register may hold this.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.error <= self.bound
    }
}

/// The rules' own arithmetic: sums of at most 2^62 LSB, each operation within 2^−99 of its largest term, a hundred of
/// them: below 2^−30 LSB.
const OWN: f64 = 9.313_225_746_154_785e-10;

/// Registers to judge, and the findings.
pub struct Sheet<'a> {
    /// The unit.
    pub config: &'a Config,
    /// Errors of its tables.
    pub tables: TableErrors,
    /// The stage whose rules run.
    pub stage: Stage,
    /// What was found.
    pub findings: Vec<Finding>,
    probe: &'a RtlProbe,
}

/// An exact value as far as it is known: what a register holds may lie `slack` farther off than its own rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) value: Wide,
    pub(super) slack: Wide,
}

impl From<Wide> for Known {
    fn from(value: Wide) -> Self {
        within(value, Wide::ZERO)
    }
}

/// A value that is known to `slack`.
pub(super) const fn within(value: Wide, slack: Wide) -> Known {
    Known { value, slack }
}

/// 0.
pub(super) const fn zero() -> Wide {
    Wide::ZERO
}

/// A double.
pub(super) fn real(x: f64) -> Wide {
    Wide::from_f64(x)
}

impl<'a> Sheet<'a> {
    /// An empty sheet.
    #[must_use]
    pub fn new(config: &'a Config, probe: &'a RtlProbe) -> Self {
        Self {
            config,
            tables: TableErrors::new(config),
            stage: Stage::LocalFrame,
            findings: Vec::new(),
            probe,
        }
    }

    /// The codes of a register.
    #[must_use]
    pub fn codes(&self, reg: Reg) -> &'a [Code] {
        self.probe.get(reg)
    }

    /// Whether a component was written.
    #[must_use]
    pub fn has(&self, reg: Reg, component: usize) -> bool {
        self.codes(reg).get(component).is_some_and(|c| c.is_written())
    }

    /// The value of a component; 0 where nothing was written.
    #[must_use]
    pub fn value(&self, reg: Reg, component: usize) -> Wide {
        self.codes(reg)
            .get(component)
            .filter(|c| c.is_written())
            .map_or(Wide::ZERO, |c| Wide::code(c.raw, c.frac))
    }

    /// Three components from the first on.
    #[must_use]
    pub fn vector(&self, reg: Reg, first: usize) -> [Wide; 3] {
        [0, 1, 2].map(|i| self.value(reg, first + i))
    }

    /// Largest error of a register's own rounding, in LSB.
    fn rounding(&self, reg: Reg) -> f64 {
        match self.config.format(reg).rounding {
            Rounding::Floor | Rounding::Zero => 1.0,
            Rounding::HalfUp
            | Rounding::HalfDown
            | Rounding::HalfAway
            | Rounding::HalfZero
            | Rounding::HalfEven
            | Rounding::HalfOdd => 0.5,
        }
    }

    /// LSB of a component in true units.
    #[must_use]
    pub fn lsb(&self, reg: Reg, component: usize) -> Wide {
        let frac = self.codes(reg).get(component).map_or(0, |c| c.frac);
        Wide::code(1, frac)
    }

    /// The error of a rounding to a register, in true units.
    #[must_use]
    pub fn unseen(&self, reg: Reg, component: usize) -> Wide {
        self.lsb(reg, component) * real(self.rounding(reg))
    }

    /// Whether a value lies inside of a register's range, a whole LSB from its ends.
    #[must_use]
    pub fn is_inside(&self, reg: Reg, component: usize, x: Wide) -> bool {
        let frac = self.codes(reg).get(component).map_or(0, |c| c.frac);
        x.times_power(frac).abs() < Wide::code(self.config.format(reg).max_raw() - 1, 0)
    }

    /// A component of a fixed register against its exact value in true units. What the register holds comes back, for
    /// the next step's formula.
    pub(super) fn fixed(&mut self, reg: Reg, component: usize, exact: impl Into<Known>) -> Wide {
        self.rounded(reg, component, exact.into());
        self.value(reg, component)
    }

    /// Components of a fixed register from the first on.
    pub(super) fn fixed_all<const N: usize>(
        &mut self,
        reg: Reg,
        first: usize,
        exact: [impl Into<Known>; N],
    ) -> [Wide; N] {
        let mut components = first..;
        exact.map(|x| self.fixed(reg, components.next().unwrap_or(first), x))
    }

    /// [`Sheet::fixed`] of a register that is clamped to ±`limit` in addition to its format's range.
    pub(super) fn fixed_in(
        &mut self,
        reg: Reg,
        component: usize,
        exact: impl Into<Known>,
        limit: Wide,
    ) -> Wide {
        let Known { value, slack } = exact.into();
        let value = if value > limit {
            limit
        } else if value < -limit {
            -limit
        } else {
            value
        };
        self.fixed(reg, component, within(value, slack))
    }

    fn rounded(&mut self, reg: Reg, component: usize, exact: Known) {
        let Some(code) = self.codes(reg).get(component).filter(|c| c.is_written()) else {
            return;
        };
        let lsb = |x: Wide| x.times_power(code.frac);
        let (x, slack) = (lsb(exact.value), lsb(exact.slack).to_f64());
        let bound = if slack == 0.0 && is_whole(x) {
            // Nothing is left to round.
            OWN
        } else {
            self.rounding(reg) + slack + OWN
        };
        let observed = Wide::code(code.raw, 0);
        let mut error = (observed - x).abs().to_f64();
        let format = self.config.format(reg);
        let (low, high) = (Wide::code(format.min_raw(), 0), Wide::code(format.max_raw(), 0));
        let edge = real(bound);
        // Near an end of the range both sides are right.
        if x > high - edge || x < low + edge {
            let other = match format.overflow {
                Overflow::Saturate | Overflow::SaturateSymmetric => {
                    let end = if x > high {
                        high
                    } else if x < low {
                        low
                    } else {
                        x
                    };
                    (observed - end).abs().to_f64()
                }
                Overflow::Zero => observed.abs().to_f64(),
                // Every bit of what is exact lies above the register's.
                Overflow::Wrap if x.abs() > Wide::code(1, -180) => observed.abs().to_f64(),
                Overflow::Wrap => {
                    let turns = ((observed - x).times_power(-i64::from(format.width()))).to_f64();
                    let turn = Wide::from_f64(turns.round()).times_power(i64::from(format.width()));
                    (observed - x - turn).abs().to_f64()
                }
            };
            error = error.min(other);
        }
        self.note(reg, component, code.raw, [x.to_f64(), error, bound]);
    }

    /// A component that rounds nothing.
    pub(super) fn exact(&mut self, reg: Reg, component: usize, exact: Wide) {
        let Some(code) = self.codes(reg).get(component).filter(|c| c.is_written()) else {
            return;
        };
        let x = exact.times_power(code.frac);
        let error = (Wide::code(code.raw, 0) - x).abs().to_f64();
        self.note(reg, component, code.raw, [x.to_f64(), error, OWN]);
    }

    /// A block: its largest mantissa must fill the register, all must be next to the exact values. What the register
    /// holds comes back.
    pub(super) fn block<const N: usize>(
        &mut self,
        reg: Reg,
        first: usize,
        exact: [impl Into<Known>; N],
    ) -> [Wide; N] {
        let width = self.config.format(reg).magnitude_bits();
        let codes = self.codes(reg).get(first..first + N).unwrap_or(&[]);
        if !codes.is_empty() && codes.iter().all(|c| c.is_written()) {
            let most = largest(codes);
            let is_normal = most >= 1 << (width - 1) && most < 1 << width;
            self.mantissas(reg, first, exact, is_normal);
        }
        std::array::from_fn(|c| self.value(reg, first + c))
    }

    /// A block of one number.
    pub(super) fn scalar(&mut self, reg: Reg, component: usize, exact: impl Into<Known>) -> Wide {
        let [held] = self.block(reg, component, [exact]);
        held
    }

    /// A block whose power of two means nothing: codes next to a multiple of the direction by a power of two.
    pub(super) fn block_direction(&mut self, reg: Reg, first: usize, exact: [Wide; 3]) {
        let codes = [0, 1, 2].map(|i| self.codes(reg).get(first + i).copied());
        let [Some(a), Some(b), Some(c)] = codes else {
            return;
        };
        let top = |x: f64| {
            if x == 0.0 { i64::MIN } else { i64::from(libm::ilogb(x)) }
        };
        let most = |v: [f64; 3]| v.into_iter().map(f64::abs).fold(0.0, f64::max);
        let held = most([a, b, c].map(|c| Wide::code(c.raw, c.frac).to_f64()));
        let want = most(exact.map(|x| x.to_f64()));
        if held == 0.0 || want == 0.0 {
            self.block(reg, first, exact);
            return;
        }
        // Rounding up may reach the next power of two: the nearer of the two.
        let shift = top(held) - top(want);
        let error = |shift: i64| {
            let scaled = want * libm::ldexp(1.0, num::i32(shift));
            (scaled - held).abs()
        };
        let shift = [shift - 1, shift, shift + 1]
            .into_iter()
            .min_by(|a, b| error(*a).total_cmp(&error(*b)))
            .unwrap_or(shift);
        self.block(reg, first, exact.map(|x| x.times_power(shift)));
    }

    /// [`Sheet::block`] with its own view of what is normalised.
    pub(super) fn mantissas<const N: usize>(
        &mut self,
        reg: Reg,
        first: usize,
        exact: [impl Into<Known>; N],
        is_normal: bool,
    ) {
        let codes = self.codes(reg).get(first..).unwrap_or(&[]);
        let all_zero = largest(&codes[..codes.len().min(N)]) == 0;
        let end = (1i64 << self.config.format(reg).magnitude_bits()) - 1;
        for (c, (code, exact)) in codes.iter().zip(exact).enumerate() {
            if !code.is_written() {
                continue;
            }
            let Known { value, slack } = exact.into();
            let x = value.times_power(code.frac);
            // What rounds up to the next power of two stays at the largest code.
            let own = if code.raw.abs() == end { 1.0 } else { self.rounding(reg) };
            let bound = own + slack.times_power(code.frac).to_f64() + OWN;
            let error = (Wide::code(code.raw, 0) - x).abs().to_f64();
            let error = if is_normal || (all_zero && x.is_zero()) { error } else { f64::INFINITY };
            self.note(reg, first + c, code.raw, [x.to_f64(), error, bound]);
        }
    }

    fn note(&mut self, reg: Reg, component: usize, observed: i64, numbers: [f64; 3]) {
        self.number(reg.info().name, observed, numbers);
        if let Some(finding) = self.findings.last_mut() {
            (finding.reg, finding.component) = (Some(reg), component);
        }
    }

    /// A number that must be the expected one.
    pub fn choice(&mut self, name: &'static str, observed: i64, expected: i64) {
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        let (exact, error) = (expected as f64, (observed - expected).unsigned_abs() as f64);
        self.number(name, observed, [exact, error, 0.0]);
    }

    /// A number that is no register of the fixed kind, in its own LSB: its exact value, its error and the bound.
    pub fn number(&mut self, name: &'static str, observed: i64, [exact, error, bound]: [f64; 3]) {
        let (stage, reg, component) = (self.stage, None, 0);
        let finding = Finding { stage, reg, name, component, observed, exact, error, bound };
        self.findings.push(finding);
    }

    /// A relative error of a table as an absolute one.
    #[must_use]
    pub fn share(x: Wide, relative: f64) -> Wide {
        x.abs() * real(relative)
    }

    /// 1/x by its table; 0 for 0.
    pub(super) fn recip(&self, x: Wide) -> Known {
        let y = real(1.0) / x;
        within(y, Self::share(y, self.tables.recip))
    }

    /// √x by its table.
    pub(super) fn sqrt(&self, x: Wide) -> Known {
        let y = x.sqrt();
        within(y, Self::share(y, self.tables.sqrt))
    }

    /// 1/√x by its table; 0 for 0.
    pub(super) fn rsqrt(&self, x: Wide) -> Known {
        let y = real(1.0) / x.sqrt();
        within(y, Self::share(y, self.tables.rsqrt))
    }
}

/// Whether a value is a whole number, as the sums of short codes are.
fn is_whole(x: Wide) -> bool {
    let near = x.to_f64();
    near.abs() < 9e15 && (x - real(near.round())).is_zero()
}

/// The largest magnitude of some codes.
fn largest(codes: &[Code]) -> u64 {
    codes.iter().map(|code| code.raw.unsigned_abs()).max().unwrap_or(0)
}

//! The stages of the unit, in pipeline order: one function each, over blocks of up to `N` lanes.
//!
//! A stage is written once. Batches run it with [`crate::NoTap`]; a trace runs it with one lane and
//! a recording tap. Inside a lane every vector lives in a nominal scale, in which the largest
//! component of n and of v lies in [1, 2); the powers of two that were taken out travel with it
//! and come back only where a tap listens.

pub mod address;
pub mod bump;
pub mod covariance;
pub mod cube_face;
pub mod eigen;
pub mod filter;
pub mod footprint;
pub mod hit;
pub mod jacobian;
pub mod local_frame;
pub mod ray_cone;
pub mod reflect;
pub mod roughness;
pub mod surface_footprint;

use alloc::format;

use lanes::Vector;

use crate::config::{Config, ConfigError, LIMIT_BITS};
use crate::fx::{Block, Flags, block};
use crate::port;
use crate::regs::{Reg, Register};
use crate::tables::{AngleRom, Function, Rom};
use crate::tap::Tap;

/// Lanes of up to `N` fragments, one array a component.
pub type Lanes<const N: usize, const C: usize> = [[i64; N]; C];

/// The tables that stages share.
#[derive(Clone, Debug)]
pub struct Roms {
    /// 1/x.
    pub recip: Rom,
    /// 1/√x.
    pub rsqrt: Rom,
    /// √x.
    pub sqrt: Rom,
    /// log2 x.
    pub log2: Rom,
    /// The eigen angle.
    pub angle: AngleRom,
}

impl Roms {
    /// Builds the tables of a configuration.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let tables = &config.tables;
        config.check()?;
        let rom = |name: &str, function, spec| {
            Rom::new(function, spec).ok_or_else(|| ConfigError {
                path: format!("tables.{name}.frac"),
                expected: "a width at which every entry rounds correctly".into(),
                found: "an entry too near to a tie".into(),
            })
        };
        Ok(Self {
            recip: rom("recip", Function::Recip, tables.recip)?,
            rsqrt: rom("rsqrt", Function::Rsqrt, tables.rsqrt)?,
            sqrt: rom("sqrt", Function::Sqrt, tables.sqrt)?,
            log2: rom("log2", Function::Log2, tables.log2)?,
            angle: AngleRom::new(tables.eigen, config.policy.eigen.placement).ok_or_else(|| {
                ConfigError {
                    path: "tables.eigen.frac".into(),
                    expected: "a width at which every entry rounds correctly".into(),
                    found: "an entry too near to a tie".into(),
                }
            })?,
        })
    }
}

/// Refuses an exact sum that needs more magnitude bits than the model's integers have.
pub(crate) fn fits(reg: Reg, bits: u32) -> Result<(), ConfigError> {
    if bits <= LIMIT_BITS {
        return Ok(());
    }
    Err(ConfigError {
        path: format!("registers.{reg}"),
        expected: format!("exact input of at most {LIMIT_BITS} bits"),
        found: format!("{bits} bits"),
    })
}

/// Where one lane's register writes go: its sticky flags and the tap. For stages that work on one
/// fragment at a time; `LaneSink` writes whole lane arrays.
#[derive(Debug)]
pub struct Sink<'a, T> {
    /// The lane.
    pub lane: usize,
    /// Its flags.
    pub flags: &'a mut Flags,
    /// Who listens.
    pub tap: &'a mut T,
}

impl<T: Tap> Sink<'_, T> {
    /// Writes `x` (with the quantizer's own input fraction) to a fixed register whose nominal scale
    /// is 2^`exponent` in true units.
    #[inline(always)]
    pub(crate) fn write(&mut self, q: &Register, c: usize, x: i64, exponent: i64) -> i64 {
        self.finish(q, c, q.write_fixed_as(T::STANDARD, x), exponent)
    }

    /// Writes `x` with a right shift that differs from fragment to fragment.
    #[inline(always)]
    pub(crate) fn shift(
        &mut self,
        q: &Register,
        c: usize,
        x: i64,
        shift: i64,
        exponent: i64,
    ) -> i64 {
        self.finish(q, c, q.write_as(T::STANDARD, x, shift), exponent)
    }

    #[inline(always)]
    fn finish(&mut self, q: &Register, c: usize, (code, over): (i64, bool), exponent: i64) -> i64 {
        // Seldom, and a shift of 128 bits where the register is no constant.
        if over {
            self.flags.register(q.reg, true);
        }
        self.tap.put(self.lane, q.reg, c, code, q.frac() - exponent);
        code
    }

    /// A port of a number, which is divided by 2^`exponent`; clears `finite` where it is not.
    #[inline(always)]
    pub(crate) fn scalar_port(
        &mut self,
        q: &Register,
        c: usize,
        word: u64,
        exponent: i64,
        finite: &mut bool,
    ) -> i64 {
        let (code, over, is_finite) = port::scalar(T::STANDARD, q, word, exponent);
        *finite &= is_finite;
        self.finish(q, c, (code, over), exponent)
    }

    /// A port of a vector; clears `finite` where a component is not.
    #[inline(always)]
    pub(crate) fn vector_port<const C: usize>(
        &mut self,
        q: &Register,
        words: [u64; C],
        finite: &mut bool,
    ) -> Block<C> {
        let (block, all_finite) = port::vector(T::STANDARD, q, words);
        *finite &= all_finite;
        self.put(q, 0, &block, 0);
        block
    }

    /// Normalises into a block register.
    #[inline(always)]
    pub(crate) fn block<const C: usize>(
        &mut self,
        q: &Register,
        x: &[i64; C],
        frac: i64,
        exponent: i64,
    ) -> Block<C> {
        let out = block::normalize(T::STANDARD, q, x, frac);
        self.put(q, 0, &out, exponent);
        out
    }

    /// Tells the tap of a block register's components, from component `first` on.
    #[inline(always)]
    pub(crate) fn put<const C: usize>(
        &mut self,
        q: &Register,
        first: usize,
        block: &Block<C>,
        exponent: i64,
    ) {
        for (c, m) in block.m.iter().enumerate() {
            self.tap.put(self.lane, q.reg, first + c, *m, block.frac - exponent);
        }
    }
}

/// ⟨a, b⟩.
#[inline(always)]
pub(crate) fn dot<V: Vector>(a: [V; 3], b: [V; 3]) -> V {
    a[0].mul(b[0]) + a[1].mul(b[1]) + a[2].mul(b[2])
}

/// a × b.
#[inline(always)]
pub(crate) fn cross<V: Vector>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [
        a[1].mul(b[2]) - a[2].mul(b[1]),
        a[2].mul(b[0]) - a[0].mul(b[2]),
        a[0].mul(b[1]) - a[1].mul(b[0]),
    ]
}

/// Lane `i` of a vector of lanes.
#[inline(always)]
pub(crate) fn take<const N: usize, const C: usize>(lanes: &Lanes<N, C>, i: usize) -> [i64; C] {
    let mut out = [0; C];
    for (o, lane) in out.iter_mut().zip(lanes) {
        *o = lane[i];
    }
    out
}

/// One column of a matrix whose columns lie one after the other.
#[inline(always)]
pub(crate) fn column<V: Vector>(m: &[V; 6], col: usize) -> [V; 3] {
    if col == 0 { [m[0], m[1], m[2]] } else { [m[3], m[4], m[5]] }
}

/// Stores a vector into lane `i`.
#[inline(always)]
pub(crate) fn store<const N: usize, const C: usize>(
    lanes: &mut Lanes<N, C>,
    i: usize,
    x: [i64; C],
) {
    for (lane, value) in lanes.iter_mut().zip(x) {
        lane[i] = value;
    }
}

/// Fraction bits as a signed number.
pub(crate) fn frac(config: &Config, reg: Reg) -> i64 {
    i64::from(config.format(reg).frac)
}

/// Fraction bits of a block register's mantissas in the nominal scale: the largest in [1, 2).
pub(crate) fn block_frac(config: &Config, reg: Reg) -> i64 {
    i64::from(config.format(reg).magnitude_bits()) - 1
}

/// Magnitude bits of a register.
pub(crate) fn bits(config: &Config, reg: Reg) -> u32 {
    config.format(reg).magnitude_bits()
}

/// Integer bits of a register.
pub(crate) fn int(config: &Config, reg: Reg) -> u32 {
    config.format(reg).int
}

//! From circuits to gate equivalents: one formula a kind of circuit, one knob a kind of cell.

use rtl_model::Config;
use rtl_model::regs::Reg;
use rtl_model::tables::TableSpec;

/// Areas of cells in gate equivalents: one two-input NAND is 1. Sources are in docs/cost.md.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// A two-input AND.
    pub and2: f64,
    /// A half adder.
    pub half_adder: f64,
    /// A full adder.
    pub full_adder: f64,
    /// A two-way multiplexer.
    pub mux2: f64,
    /// A D flip-flop.
    pub flip_flop: f64,
    /// A bit of a table.
    pub rom_bit: f64,
    /// A bit of a leading-zero counter.
    pub zero_count_bit: f64,
}

impl Default for Cells {
    fn default() -> Self {
        Self {
            and2: 1.33,
            half_adder: 3.33,
            full_adder: 5.33,
            mux2: 2.33,
            flip_flop: 5.67,
            rom_bit: 0.25,
            zero_count_bit: 4.0,
        }
    }
}

/// The circuits of a stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    /// Multipliers: widths of the two operands, and how many.
    pub multipliers: Vec<([u32; 2], u32)>,
    /// Bits of adders, subtractors and comparators.
    pub adder_bits: u64,
    /// Bits of incrementers: the carry of a rounding.
    pub rounding_bits: u64,
    /// Two-way multiplexers: shifters, saturation, choices.
    pub muxes: u64,
    /// Bits of leading-zero counters.
    pub zero_count_bits: u64,
    /// Bits of tables.
    pub rom_bits: u64,
    /// Bits of registers.
    pub register_bits: u64,
}

/// ceil(log2 n), at least 1.
pub(super) fn log2(n: u32) -> u32 {
    n.max(2).next_power_of_two().trailing_zeros()
}

/// Width of the tables' ports.
pub(super) const PORT: u32 = 31;

/// The operand of a circuit as wide as a register of the unit, or of so many bits.
pub(super) trait Operand: Copy {
    fn bits(self, config: &Config) -> u32;
}

impl Operand for Reg {
    /// With its sign.
    fn bits(self, config: &Config) -> u32 {
        config.format(self).width()
    }
}

impl Operand for u32 {
    fn bits(self, _: &Config) -> u32 {
        self
    }
}

/// The circuits of a stage while they are put together.
#[derive(Debug)]
pub(super) struct Circuit<'a> {
    pub(super) config: &'a Config,
    pub(super) parts: Parts,
}

impl<'a> Circuit<'a> {
    pub(super) fn new(config: &'a Config) -> Self {
        Self { config, parts: Parts::default() }
    }

    pub(super) fn w(&self, reg: Reg) -> u32 {
        reg.bits(self.config)
    }

    pub(super) fn multiply(&mut self, a: impl Operand, b: impl Operand, count: u32) {
        if count > 0 {
            let widths = [a.bits(self.config), b.bits(self.config)];
            self.parts.multipliers.push((widths, count));
        }
    }

    pub(super) fn add(&mut self, width: impl Operand, count: u32) {
        self.parts.adder_bits += u64::from(width.bits(self.config)) * u64::from(count);
    }

    /// Ways of a choice between words, less one: that many two-way multiplexers a bit.
    pub(super) fn choose(&mut self, width: impl Operand, ways: u32, count: u32) {
        let bits = u64::from(width.bits(self.config)) * u64::from(count);
        self.parts.muxes += bits * u64::from(ways.saturating_sub(1));
    }

    /// A shifter over `positions` places.
    pub(super) fn shift(&mut self, width: impl Operand, positions: u32, count: u32) {
        let bits = u64::from(width.bits(self.config)) * u64::from(count);
        self.parts.muxes += bits * u64::from(log2(positions));
    }

    pub(super) fn count_zeros(&mut self, width: u32, count: u32) {
        self.parts.zero_count_bits += u64::from(width) * u64::from(count);
    }

    /// Flip-flops that are no register of the unit.
    pub(super) fn store(&mut self, width: impl Operand, count: u32) {
        self.parts.register_bits += u64::from(width.bits(self.config)) * u64::from(count);
    }

    /// A fixed-point register's write: the carry of its rounding, saturation and the flip-flops.
    pub(super) fn register(&mut self, reg: Reg, components: u32) {
        self.parts.rounding_bits += u64::from(self.w(reg)) * u64::from(components);
        self.choose(reg, 2, components);
        self.store(reg, components);
    }

    /// The same behind a shift that differs from fragment to fragment.
    pub(super) fn shifted_register(&mut self, reg: Reg, components: u32, exact: impl Operand) {
        let exact = exact.bits(self.config);
        self.shift(exact, exact, components);
        self.register(reg, components);
    }

    /// A block register of exact inputs of `exact` bits: the common leading zeros, a shifter for each component, the
    /// carry, and the exponent.
    pub(super) fn block(&mut self, reg: Reg, components: u32, exact: impl Operand) {
        self.count_zeros(exact.bits(self.config), 1);
        self.shifted_register(reg, components, exact);
        self.parts.register_bits += 8;
    }

    /// A sum of `terms` products of `a` × `b` bits.
    pub(super) fn dot(&mut self, a: impl Operand, b: impl Operand, terms: u32, count: u32) {
        let width = a.bits(self.config) + b.bits(self.config) + log2(terms);
        self.multiply(a, b, terms * count);
        self.add(width, (terms - 1) * count);
    }

    /// Inner products of two vectors in a register.
    pub(super) fn dot_in(&mut self, reg: Reg, a: impl Operand, b: impl Operand, count: u32) {
        self.dot(a, b, 3, count);
        self.register(reg, count);
    }

    /// |v| in a register behind a shift.
    pub(super) fn length(&mut self, reg: Reg, v: u32) {
        self.dot(v, v, 3, 1);
        self.root(2 * v + 2);
        self.shifted_register(reg, 1, PORT);
    }

    /// 1/|v| in a block register.
    pub(super) fn inverse_length(&mut self, reg: Reg, v: u32) {
        self.dot(v, v, 3, 1);
        self.block_reciprocal_root(reg, 2 * v + 2);
    }

    /// The components of a × b, or of two vectors of a plane, in a register.
    pub(super) fn cross_in(&mut self, reg: Reg, a: impl Operand, b: impl Operand) {
        self.dot(a, b, 2, 3);
        self.register(reg, 3);
    }

    /// Products in a register, behind a shift.
    pub(super) fn product(&mut self, reg: Reg, a: impl Operand, b: impl Operand, count: u32) {
        self.multiply(a, b, count);
        self.shifted_register(reg, count, a.bits(self.config) + b.bits(self.config));
    }

    /// A product in a block register of its own.
    pub(super) fn block_product(&mut self, reg: Reg, a: impl Operand, b: impl Operand) {
        self.multiply(a, b, 1);
        self.block(reg, 1, a.bits(self.config) + b.bits(self.config));
    }

    /// A look-up of a function of one argument, which comes normalised; the table's own bits and its interpolation.
    pub(super) fn table(&mut self, spec: TableSpec, two_binades: bool) {
        let per_binade = if two_binades { spec.entries / 2 } else { spec.entries };
        let rest = PORT.saturating_sub(log2(per_binade));
        let runs = if two_binades { 2 } else { 1 };
        let entries = match spec.order {
            0 => spec.entries,
            1 => spec.entries + runs,
            _ => 2 * spec.entries + runs,
        };
        self.parts.rom_bits += u64::from(entries) * u64::from(spec.frac + 1);
        match spec.order {
            0 => {}
            1 => {
                self.multiply(rest, spec.frac + 1, 1);
                self.add(PORT, 2);
            }
            _ => {
                self.multiply(rest, rest, 1);
                self.multiply(rest, spec.frac + 4, 2);
                self.add(PORT, 6);
            }
        }
        self.add(PORT, 1);
    }

    /// Normalises an argument of `width` bits for a table.
    pub(super) fn normalise(&mut self, width: impl Operand) {
        let width = width.bits(self.config);
        self.count_zeros(width, 1);
        self.shift(width, width, 1);
    }

    /// 1/x with its normalisation.
    pub(super) fn reciprocal(&mut self, width: impl Operand) {
        let spec = self.config.tables.recip;
        self.normalise(width);
        self.table(spec, false);
        self.multiply(PORT, PORT, 2 * spec.newton);
        self.add(PORT, 2 * spec.newton);
    }

    /// 1/x in a block register of its own.
    pub(super) fn block_reciprocal(&mut self, reg: Reg, width: impl Operand) {
        self.reciprocal(width);
        self.block(reg, 1, PORT);
    }

    /// 1/√x in a block register of its own.
    pub(super) fn block_reciprocal_root(&mut self, reg: Reg, width: u32) {
        self.reciprocal_root(width);
        self.block(reg, 1, PORT);
    }

    /// 1/√x with its normalisation.
    pub(super) fn reciprocal_root(&mut self, width: impl Operand) {
        self.normalise(width);
        self.root_table(self.config.tables.rsqrt);
    }

    fn root_table(&mut self, spec: TableSpec) {
        self.table(spec, true);
        self.multiply(PORT, PORT, 3 * spec.newton);
        self.add(PORT, 2 * spec.newton);
    }

    /// √x with its normalisation; a Newton step has 1/√x of its own.
    pub(super) fn root(&mut self, width: impl Operand) {
        let spec = self.config.tables.sqrt;
        self.normalise(width);
        self.table(spec, true);
        if spec.newton > 0 {
            self.root_table(self.config.tables.rsqrt);
            self.multiply(PORT, PORT, 2 * spec.newton);
            self.add(PORT, 2 * spec.newton);
        }
    }
}

impl Parts {
    /// Sum of the products of all multipliers' operand widths.
    #[must_use]
    pub fn multiplier_bits(&self) -> u64 {
        let bits = |([a, b], n): &([u32; 2], u32)| u64::from(*a) * u64::from(*b) * u64::from(*n);
        self.multipliers.iter().map(bits).sum()
    }

    /// Number of multipliers.
    #[must_use]
    pub fn multiplier_count(&self) -> u64 {
        self.multipliers.iter().map(|(_, n)| u64::from(*n)).sum()
    }

    /// Gate equivalents of multipliers, adders, shifters and the like.
    ///
    /// An m × n multiplier has m·n ANDs; a full adder turns three bits into two, so that m·n bits become m + n with
    /// m·n − m − n of them (the final carry included).
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts of gates")]
    pub fn logic(&self, cells: &Cells) -> f64 {
        let multiplier = |([a, b], n): &([u32; 2], u32)| {
            let (a, b) = (f64::from(*a), f64::from(*b));
            f64::from(*n) * (a * b * cells.and2 + (a * b - a - b).max(0.0) * cells.full_adder)
        };
        self.multipliers.iter().map(multiplier).sum::<f64>()
            + self.adder_bits as f64 * cells.full_adder
            + self.rounding_bits as f64 * cells.half_adder
            + self.muxes as f64 * cells.mux2
            + self.zero_count_bits as f64 * cells.zero_count_bit
    }

    /// Gate equivalents of everything.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts of gates")]
    pub fn gates(&self, cells: &Cells) -> f64 {
        self.logic(cells)
            + self.rom_bits as f64 * cells.rom_bit
            + self.register_bits as f64 * cells.flip_flop
    }

    /// Adds another stage's parts.
    pub fn merge(&mut self, other: &Self) {
        self.multipliers.extend_from_slice(&other.multipliers);
        self.adder_bits += other.adder_bits;
        self.rounding_bits += other.rounding_bits;
        self.muxes += other.muxes;
        self.zero_count_bits += other.zero_count_bits;
        self.rom_bits += other.rom_bits;
        self.register_bits += other.register_bits;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_multiplier_has_the_adders_of_an_array() {
        // 4 × 4: 16 ANDs; the array of the textbooks has 8 full and 4 half adders, which is as much carry-save work as
        // 16 bits to 8 by full adders alone.
        let config = Config::default();
        let mut circuit = Circuit::new(&config);
        circuit.multiply(4, 4, 1);
        let parts = circuit.parts;
        let cells = Cells { and2: 1.0, full_adder: 100.0, ..Cells::default() };
        assert!((parts.logic(&cells) - (16.0 + 8.0 * 100.0)).abs() < 1e-9);
        assert_eq!((parts.multiplier_bits(), parts.multiplier_count()), (16, 1));
    }

    #[test]
    fn tables_count_the_bits_that_tables_show_counts() {
        let config = Config::default();
        let roms = rtl_model::stages::Roms::new(&config).unwrap();
        for (spec, two, bits) in [
            (config.tables.recip, false, roms.recip.bits()),
            (config.tables.rsqrt, true, roms.rsqrt.bits()),
            (config.tables.sqrt, true, roms.sqrt.bits()),
            (config.tables.log2, false, roms.log2.bits()),
        ] {
            for order in 0..3 {
                let mut circuit = Circuit::new(&config);
                circuit.table(TableSpec { order, ..spec }, two);
                if order == spec.order {
                    assert_eq!(circuit.parts.rom_bits, bits);
                }
                assert!(circuit.parts.rom_bits > 0);
            }
        }
    }
}

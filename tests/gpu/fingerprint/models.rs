//! Models whose rules the analysis must find.

use tapline::fingerprint::aniso::{CLAMPS, Count, Lengths, LodRule, Mix, Width};
use tapline::fingerprint::levels::Log;
use tapline::fingerprint::model::{Corner, Line, Model, Rule, Seam, Spacing};
use tapline::fingerprint::rho::{Projection, Rho};
use tapline::fingerprint::steps::{Rounding, Steps};
use tapline::sampler::{Shape, Source};

/// Steps of some bits.
pub(crate) fn bits(bits: u32, rounding: Rounding) -> Steps {
    Steps::Bits { bits, rounding }
}

/// The same rules for given derivatives and for those of quads, at every clamp above 1.
pub(crate) fn rules(shape: Shape, lod: LodRule, line: Line) -> Vec<Rule> {
    let mut rules = Vec::new();
    for clamp in CLAMPS.into_iter().filter(|c| *c > 1) {
        for source in [Source::Gradient, Source::Quad] {
            rules.push(Rule { shape, source, clamp, lod, line });
        }
    }
    rules
}

/// An octave whose λ are multiples of 2^−bits, rounded to nearest.
fn rounded(log: Log, bits: i32) -> Vec<f64> {
    let one = f64::from(1 << bits);
    let octave = log.octave().into_iter();
    octave.map(|l| (l * one).round() / one).collect()
}

/// What a GPU after D3D's rules would do: 8 bits everywhere, taps of equal parts.
pub(crate) fn orthodox() -> Model {
    let lod = LodRule {
        width: Width::PerTap(Count::Ceil),
        lengths: Lengths::Derivatives,
        mix: Mix::Between,
    };
    let line = Line::Taps(Count::Ceil, Spacing::Parts);
    let mut all = rules(Shape::Planar, lod, line);
    all.extend(rules(Shape::Cube, lod, line));
    Model {
        texels: bits(8, Rounding::Nearest),
        mips: bits(8, Rounding::Floor),
        octave: rounded(Log::Exact, 8),
        rho: Rho::Longer,
        cube_rho: (Projection::Exact, Rho::Longer),
        rules: all,
        seam: Seam::Neighbour,
        corner: Corner::Mean,
    }
}

/// Something that no driver does: few bits, cheap lengths, no anisotropy on cubes, faces that know no neighbours.
pub(crate) fn odd() -> Model {
    let lod = LodRule { width: Width::Clamped, lengths: Lengths::Ellipse, mix: Mix::Nearest };
    let cube = LodRule { width: Width::Major, lengths: Lengths::Derivatives, mix: Mix::Between };
    let mut all = rules(Shape::Planar, lod, Line::Taps(Count::Even, Spacing::Between));
    all.extend(rules(Shape::Cube, cube, Line::Single));
    Model {
        texels: bits(6, Rounding::Floor),
        mips: bits(5, Rounding::Nearest),
        octave: Log::Mantissa.octave(),
        rho: Rho::Box,
        cube_rho: (Projection::ThreeComponents, Rho::LargestComponent),
        rules: all,
        seam: Seam::Clamped,
        corner: Corner::Mean,
    }
}

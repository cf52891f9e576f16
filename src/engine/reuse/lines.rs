//! Probe lines of both arithmetics, and how far they are apart.

use rtl_model::Config;
use rtl_model::regs::Reg;
use rtl_model::unit::State;

use crate::base::num;
use crate::engine::dispatch::LANES;
use crate::engine::probe::to_f64;
use crate::reference::{Env, Tex};

/// A probe line of the float reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its direction, a unit vector.
    pub axis: [f64; 2],
    /// λ1 and λ2 in texels of level 0.
    pub texels: [f64; 2],
    /// Probes.
    pub probes: u32,
    /// Level of detail.
    pub lod: f64,
    /// Width of the cone that asked a 2-D texture, world units.
    pub width: Option<f64>,
}

impl Line {
    /// A single probe on level 0.
    pub const NONE: Self =
        Self { axis: [1.0, 0.0], texels: [0.0; 2], probes: 1, lod: 0.0, width: None };

    /// Of ENV or HIT, on faces of `face_size` texels.
    #[must_use]
    pub fn of_env(env: &Env, face_size: usize) -> Self {
        Self {
            axis: env.axis,
            texels: env.lambda.map(|x| x * face_size as f64 / 2.0),
            probes: env.probes,
            lod: env.lod,
            width: None,
        }
    }

    /// Of TEX, for a cone of that width.
    #[must_use]
    pub fn of_tex(tex: &Tex, width: f64) -> Self {
        let Tex { axis, lambda: texels, probes, lod, .. } = *tex;
        Self { axis, texels, probes, lod, width: Some(width) }
    }
}

/// A probe line of the integer model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RtlLine {
    /// Its direction.
    pub axis: [f64; 2],
    /// Probes.
    pub probes: i64,
    /// Level of detail.
    pub lod: f64,
    /// Width of the cone that asked a 2-D texture, world units.
    pub width: Option<f64>,
}

impl RtlLine {
    /// Of a lane of a block that has run.
    #[must_use]
    pub fn new(config: &Config, state: &State<LANES>, lane: usize) -> Self {
        let frac = |reg| num::i32(config.format(reg).frac);
        Self {
            axis: [0, 1].map(|c| to_f64(state.axes.axis[c][lane], frac(Reg::EigenAxis))),
            probes: state.line.count[lane],
            lod: to_f64(state.line.lod[lane], frac(Reg::FootLod)),
            width: None,
        }
    }
}

/// How far the integer model's lines are from the reference's.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    axis_degrees: Vec<f64>,
    line_end: Vec<f64>,
    lod: Vec<f64>,
    other_count: usize,
    lines: usize,
}

impl Apart {
    /// Adds a pair. A line of a single probe has no direction that matters.
    pub fn add(&mut self, rtl: RtlLine, float: &Line) {
        self.lines += 1;
        self.other_count += usize::from(rtl.probes != i64::from(float.probes));
        self.lod.push((rtl.lod - float.lod).abs());
        if float.probes > 1 {
            let sine = rtl.axis[0] * float.axis[1] - rtl.axis[1] * float.axis[0];
            self.axis_degrees.push(libm::asin(sine.abs().min(1.0)).to_degrees());
            // Half of λ1 from the middle to the end, measured in widths of the ellipse, which is never below a texel.
            let width = float.texels[1].max(1.0);
            self.line_end.push(float.texels[0] / 2.0 * sine.abs() / width);
        }
    }

    /// Whether no pair was added.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lines == 0
    }

    /// Share of lines with another number of probes.
    #[must_use]
    pub fn count_differs(&self) -> f64 {
        self.other_count as f64 / self.lines.max(1) as f64
    }

    /// Quantiles: 95 % and all of the axis' error in degrees, of the displacement of the line's end in widths of
    /// the ellipse, and of the level of detail's error.
    #[must_use]
    pub fn quantiles(&mut self) -> [[f64; 2]; 3] {
        [&mut self.axis_degrees, &mut self.line_end, &mut self.lod].map(|errors| {
            errors.sort_by(f64::total_cmp);
            [95, 100].map(|per_cent| quantile(errors, per_cent))
        })
    }
}

/// The value that `per_cent` of sorted values are at or below; 0 where there is none.
#[must_use]
pub fn quantile(sorted: &[f64], per_cent: usize) -> f64 {
    let index = (sorted.len() * per_cent).div_ceil(100).max(1) - 1;
    sorted.get(index).copied().unwrap_or(0.0)
}

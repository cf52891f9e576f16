//! Knobs: every choice about a unit but its registers' formats, one row each.
//!
//! A row of the table below is a field of [`Policy`] with its default, the path `section.field` under which unit
//! files, `--set` and studies know it, its legal values, who honours it, the first stage that it reaches, and its
//! meaning. A knob that all engines honour is part of the algorithm; the rest is the integer model's own.

mod choices;
mod row;

pub use choices::{
    Axis, ConeEnv, ConeGradient, ConeMetric, ConeRules, Count, Curvature, Dnmod, FootprintRule,
    HitFootprint, HitStatus, LookUp, Method, Minor, Outside, Placement, RoughnessInterpolation,
    SetDiffuse, TexelFormat, Weights, Wrap,
};
pub use row::{Legal, Place, Row, Setting};

use crate::cone::{ConeFormat, LaneOrder, StoreRounding};
use Legal::{Counted, Even, Few, Number, Only, OrOff, PowerOfTwo, Range, Rotation};
use row::{knobs, row};

knobs! {
    /// Choices of the probe line.
    footprint: FootprintPolicy {
        max_probes: u32 = 16 => Range(1, 64), All, covariance, "most probes of a fragment";
        count: Count, All, covariance, "rule of the probe count";
        axis: Axis, All, covariance, "direction of the probe line";
        weights: Weights, All, covariance, "weights of the probes";
        weight_bits: u32 = 8 => Range(1, 12), All, covariance, "gaussian and bell probe weights sum to 2^bits";
        policy: FootprintRule, All, covariance, "what the probe line keeps of the ellipse: its axes or its second moments; \"moments\" has no footprint.count, and f64 alone computes it so far";
        tau: u32 = 10 => Range(1, 32), All, covariance, "eighths of the variance of a spacing over that of a probe, at most (moments)";
        tau_cap: u32 = 32 => Range(1, 64), All, covariance, "the same where max_probes are too few, before the probes get wider (moments)";
        kappa: u32 = 4 => Range(3, 5), All, covariance, "variance of a probe in twelfths of a texel², less 2: 3 box mips, 4 soft ones (moments)";
    }
    /// Choices of the roughness pyramid.
    roughness: RoughnessPolicy {
        + row("roughness.scale", Place::Scale, Number(0, 8), true, "roughness", "s in K = D Dᵀ + s² K3");
        interpolate: RoughnessInterpolation, All, scene, "what the roughness pyramid interpolates";
        curvature: Curvature, All, scene, "where the bump map's own curvature is counted";
    }
    /// Choices of `jacobian`.
    jacobian: JacobianPolicy {
        dnmod: Dnmod, All, jacobian, "what stands for the derivative of the modified normal";
    }
    /// Choices of `eigen`.
    eigen: EigenPolicy {
        + row("eigen.entries", Place::Table(|t| &mut t.eigen.entries), Even(2, 1024), false, "eigen", "angle-table entries over 90°");
        placement: Placement, Rtl, eigen, "where the angle table's entries lie";
        minor: Minor, All, covariance, "how λ2 is found";
    }
    /// Words of the filter's weights.
    filter: FilterPolicy {
        weight_bits: u32 = 8 => Range(1, 8), Rtl, filter, "bits of a bilinear weight";
        lod_bits: u32 = 8 => Range(1, 8), Rtl, filter, "bits of the weight between two levels";
    }
    /// Texels in memory and decoded. They change no register in front of the filter, but encoding them costs most.
    texel: TexelPolicy {
        format: TexelFormat, Rtl, scene, "how texels are stored";
        int: u32 = 17 => Range(1, 17), Rtl, scene, "integer bits of a decoded texel";
        frac: u32 = 24 => Range(4, 24), Rtl, scene, "fraction bits of a decoded texel";
    }
    /// Registers and rules of ray cones.
    cone: ConePolicy {
        format: ConeFormat, Rtl, ray_cone, "format of a ray cone's angle and width";
        rounding: StoreRounding, Rtl, ray_cone, "rounding of a ray cone's stores";
        lane_order: LaneOrder, All, ray_cone, "which half of a packed cone is its angle";
        seed: u32 = 0 => Range(0, u32::MAX), Rtl, ray_cone, "seed of stochastic stores";
        rules: ConeRules, All, ray_cone, "formulas of the note or OptiX Toolkit's code";
        set_diffuse: SetDiffuse, All, ray_cone, "what a diffuse scatter of cone.rules = \"otk\" writes into the angle";
        count: u32 = 2 => Range(1, 2), All, ray_cone, "cones of a ray; the wider one counts";
        metric: ConeMetric, All, ray_cone, "a texture request's footprint: the cones, or the distance times a pixel's angle";
        gradient: ConeGradient, All, ray_cone, "how ddx and ddy follow from dPdx and dPdy";
        env: ConeEnv, All, ray_cone, "gradients of a bare cone on a cube map";
    }
    /// Choices of `surface_footprint`.
    surface_footprint: SurfacePolicy {
        max_anisotropy: u32 = 16 => Range(1, 64), All, surface_footprint, "longest dPdx over |w|, at grazing angles";
    }
    /// Choices of `address`.
    address: AddressPolicy {
        wrap_s: Wrap, All, scene, "what a 2-D texture shows beyond its edges";
        wrap_t: Wrap, All, scene, "what a 2-D texture shows beyond its edges";
    }
    /// Choices of the HIT operation.
    hit: HitPolicy {
        iterations: u32 = 4 => Range(0, 64), All, hit, "most look-ups of the search for a hit";
        method: Method, All, hit, "how the search finds its next point";
        tolerance_bits: Option<u32> = Some(10) => OrOff(1, 24), All, hit,
            "τ = 2^-bits, off: τ = 0; the search ends where the ratio lies within 1 ± τ";
        lookup: LookUp, All, hit, "how a distance is read";
        footprint: HitFootprint, All, hit, "shape of a cone's footprint at the hit";
        outside: Outside, All, hit, "what becomes of a ray that starts outside of the reference surface";
    }
    + row("transform.rotation", Place::Rotation, Rotation, true, "cube_face", "rotation A of the environment, row by row");
    tables {
        recip, local_frame, Counted(0, 3, "steps");
        rsqrt, local_frame, Counted(0, 3, "steps");
        sqrt, local_frame, Counted(0, 3, "steps");
        log2, footprint, Only(0, "this table has no Newton step");
    }
    + row("tables.eigen.order", Place::Table(|t| &mut t.eigen.order), Few(1), false, "eigen", "interpolation between angle entries");
    + row("tables.eigen.frac", Place::Table(|t| &mut t.eigen.frac), Counted(4, 28, "bits"), false, "eigen", "fraction bits of sine and cosine");
    + row("tables.eigen.newton", Place::Table(|t| &mut t.eigen.newton), Only(0, "this table has no Newton step"), false, "eigen", "none");
}

impl Policy {
    /// The knobs that all engines honour, and the defaults of the integer model's own.
    #[must_use]
    pub fn shared(&self) -> Self {
        let (mut out, plain) = (*self, Self::default());
        for row in ROWS.iter().filter(|row| !row.all_engines) {
            if let Place::Policy(get, set) = row.place {
                set(&mut out, get(&plain));
            }
        }
        out
    }
}

impl AddressPolicy {
    /// The address modes beyond a texture's edges, column- and row-wise.
    #[must_use]
    pub const fn wrap(&self) -> [Wrap; 2] {
        [self.wrap_s, self.wrap_t]
    }
}

impl Count {
    /// Whether the probe line's ends are probes themselves.
    #[must_use]
    #[inline(always)]
    pub const fn has_end_points(self) -> bool {
        match self {
            Self::Feline => true,
            Self::Ceil | Self::Round | Self::Pow2 => false,
        }
    }

    /// The greatest M/m whose count is at most `max`, as a numerator and a denominator: m is at least that share of M.
    #[must_use]
    pub fn most(self, max: u32) -> [u32; 2] {
        let max = max.max(1);
        match self {
            Self::Ceil | Self::Round => [max, 1],
            Self::Pow2 => [1 << max.ilog2(), 1],
            Self::Feline => [max + 1, 2],
        }
    }
}

//! The list of knobs: every path of a unit with its value, legal values and meaning.

use rtl_model::TexelFormat;
use rtl_model::cone::{ConeFormat, LaneOrder, StoreRounding};
use rtl_model::fx::{Overflow, Rounding};
use rtl_model::regs::{Kind, Reg};

use super::UnitSpec;
use crate::policy::{
    Axis, ConeEnv, ConeGradient, ConeMetric, ConeRules, Count, Curvature, Dnmod, HitFootprint,
    LookUp, Method, Minor, Outside, Placement, RoughnessInterpolation, SetDiffuse, Weights, Wrap,
};
use crate::settings::IDENTITY;

/// A value of a knob, as TOML has it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A decimal.
    Float(f64),
    /// A literal.
    Text(String),
    /// A row-by-row matrix.
    Numbers(Vec<f64>),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(n) => write!(f, "{n}"),
            Self::Float(x) => write!(f, "{x:?}"),
            Self::Text(t) => write!(f, "{t:?}"),
            Self::Numbers(v) => write!(f, "{v:?}"),
        }
    }
}

/// A path with what there is to say about it.
#[derive(Clone, Debug)]
pub struct Knob {
    /// The path, such as `footprint.max_probes`.
    pub path: String,
    /// Its value in this unit.
    pub value: Value,
    /// Legal values.
    pub legal: String,
    /// Whether the float engines honour it; words, roundings and tables are the rtl engine's own.
    pub all_engines: bool,
    /// What it does.
    pub meaning: String,
}

/// The literals of a closed set, as a list of legal values.
pub(super) fn names<T: Copy>(all: &[T], name: impl Fn(T) -> &'static str) -> String {
    all.iter().map(|v| name(*v)).collect::<Vec<_>>().join(" | ")
}

/// The path under which a knob is listed: the angle table's entries go by two names.
pub(super) fn canonical(path: &str) -> &str {
    if path == "tables.eigen.entries" { "eigen.entries" } else { path }
}

const TABLES: [&str; 4] = ["recip", "rsqrt", "sqrt", "log2"];

impl UnitSpec {
    /// Every knob with its value, in the order in which files list them.
    #[must_use]
    pub fn knobs(&self) -> Vec<Knob> {
        let mut out = Vec::new();
        let mut add = |path: &str, value: Value, legal: &str, all_engines: bool, meaning: &str| {
            out.push(Knob {
                path: path.into(),
                value,
                legal: legal.into(),
                all_engines,
                meaning: meaning.into(),
            });
        };
        let text = |t: &str| Value::Text(t.into());
        let int = |n: u32| Value::Integer(n.into());
        let c = &self.config;
        add("footprint.max_probes", int(c.max_probes), "1…64", true, "most probes of a fragment");
        add(
            "footprint.count",
            text(c.count.name()),
            &names(Count::ALL, Count::name),
            true,
            "rule of the probe count",
        );
        add(
            "footprint.axis",
            text(c.axis.name()),
            &names(Axis::ALL, Axis::name),
            true,
            "direction of the probe line",
        );
        add(
            "footprint.weights",
            text(c.weights.name()),
            &names(Weights::ALL, Weights::name),
            true,
            "weights of the probes",
        );
        add(
            "footprint.weight_bits",
            int(c.probe_weight_bits),
            "1…12",
            true,
            "gaussian probe weights sum to 2^bits",
        );
        add(
            "roughness.scale",
            Value::Float(self.roughness_scale),
            "0…8",
            true,
            "s in K = D Dᵀ + s² K3",
        );
        add(
            "roughness.interpolate",
            text(self.roughness_interpolation.name()),
            &names(RoughnessInterpolation::ALL, RoughnessInterpolation::name),
            true,
            "what the roughness pyramid interpolates",
        );
        add(
            "roughness.curvature",
            text(self.roughness_curvature.name()),
            &names(Curvature::ALL, Curvature::name),
            true,
            "where the bump map's own curvature is counted",
        );
        add(
            "jacobian.dnmod",
            text(c.dnmod.name()),
            &names(Dnmod::ALL, Dnmod::name),
            true,
            "what stands for the derivative of the modified normal",
        );
        add(
            "eigen.entries",
            int(c.tables.eigen.entries),
            "even, 2…1024",
            false,
            "angle-table entries over 90°",
        );
        add(
            "eigen.placement",
            text(c.placement.name()),
            &names(Placement::ALL, Placement::name),
            false,
            "where the angle table's entries lie",
        );
        add(
            "eigen.minor",
            text(c.minor.name()),
            &names(Minor::ALL, Minor::name),
            true,
            "how λ2 is found",
        );
        add("filter.weight_bits", int(c.weight_bits), "1…8", false, "bits of a bilinear weight");
        add(
            "filter.lod_bits",
            int(c.lod_bits),
            "1…8",
            false,
            "bits of the weight between two levels",
        );
        add(
            "texel.format",
            text(c.texel_format.name()),
            &names(TexelFormat::ALL, TexelFormat::name),
            false,
            "how texels are stored",
        );
        add("texel.int", int(c.texel_int), "1…17", false, "integer bits of a decoded texel");
        add("texel.frac", int(c.texel_frac), "4…24", false, "fraction bits of a decoded texel");
        add(
            "cone.format",
            text(c.cone.format.name()),
            &names(ConeFormat::ALL, ConeFormat::name),
            false,
            "format of a ray cone's angle and width",
        );
        add(
            "cone.rounding",
            text(c.cone.rounding.name()),
            &names(StoreRounding::ALL, StoreRounding::name),
            false,
            "rounding of a ray cone's stores",
        );
        add(
            "cone.lane_order",
            text(c.cone.order.name()),
            &names(LaneOrder::ALL, LaneOrder::name),
            true,
            "which half of a packed cone is its angle",
        );
        add("cone.seed", int(c.cone.seed), "0…4294967295", false, "seed of stochastic stores");
        add(
            "cone.rules",
            text(c.cone.rules.name()),
            &names(ConeRules::ALL, ConeRules::name),
            true,
            "formulas of the note or OptiX Toolkit's code",
        );
        add(
            "cone.set_diffuse",
            text(c.cone.set_diffuse.name()),
            &names(SetDiffuse::ALL, SetDiffuse::name),
            true,
            "what a diffuse scatter of cone.rules = \"otk\" writes into the angle",
        );
        let tex = &c.tex;
        add("cone.count", int(tex.cones), "1 | 2", true, "cones of a ray; the wider one counts");
        add(
            "cone.metric",
            text(tex.metric.name()),
            &names(ConeMetric::ALL, ConeMetric::name),
            true,
            "a texture request's footprint: the cones, or the distance times a pixel's angle",
        );
        add(
            "cone.gradient",
            text(tex.gradient.name()),
            &names(ConeGradient::ALL, ConeGradient::name),
            true,
            "how ddx and ddy follow from dPdx and dPdy",
        );
        add(
            "cone.env",
            text(tex.env.name()),
            &names(ConeEnv::ALL, ConeEnv::name),
            true,
            "gradients of a bare cone on a cube map",
        );
        add(
            "surface_footprint.max_anisotropy",
            int(tex.max_anisotropy),
            "1…64",
            true,
            "longest dPdx over |w|, at grazing angles",
        );
        for (axis, wrap) in ["s", "t"].into_iter().zip(tex.wrap) {
            add(
                &format!("address.wrap_{axis}"),
                text(wrap.name()),
                &names(Wrap::ALL, Wrap::name),
                true,
                "what a 2-D texture shows beyond its edges",
            );
        }
        let hit = &c.hit;
        add(
            "hit.iterations",
            int(hit.iterations),
            "0…64",
            true,
            "most look-ups of the search for a hit",
        );
        add(
            "hit.method",
            text(hit.method.name()),
            &names(Method::ALL, Method::name),
            true,
            "how the search finds its next point",
        );
        add(
            "hit.tolerance_bits",
            hit.tolerance_bits.map_or_else(|| text("off"), int),
            "off | 1…24",
            true,
            "τ = 2^-bits, off: τ = 0; the search ends where the ratio lies within 1 ± τ",
        );
        add(
            "hit.lookup",
            text(hit.look_up.name()),
            &names(LookUp::ALL, LookUp::name),
            true,
            "how a distance is read",
        );
        add(
            "hit.footprint",
            text(hit.footprint.name()),
            &names(HitFootprint::ALL, HitFootprint::name),
            true,
            "shape of a cone's footprint at the hit",
        );
        add(
            "hit.outside",
            text(hit.outside.name()),
            &names(Outside::ALL, Outside::name),
            true,
            "what becomes of a ray that starts outside of the reference surface",
        );
        let rotation = self.rotation.unwrap_or(IDENTITY);
        add(
            "transform.rotation",
            Value::Numbers(rotation.concat()),
            "nine numbers, a rotation",
            true,
            "rotation A of the environment, row by row",
        );
        let t = &c.tables;
        for (name, spec) in TABLES.iter().zip([t.recip, t.rsqrt, t.sqrt, t.log2]) {
            let path = |knob: &str| format!("tables.{name}.{knob}");
            add(&path("entries"), int(spec.entries), "a power of two, 2…4096", false, "intervals");
            add(
                &path("order"),
                int(spec.order),
                "0 | 1 | 2",
                false,
                "interpolation: none, linear, quadratic",
            );
            add(&path("frac"), int(spec.frac), "2…28", false, "fraction bits of an entry");
            if *name != "log2" {
                add(
                    &path("newton"),
                    int(spec.newton),
                    "0…3",
                    false,
                    "Newton steps after the look-up",
                );
            }
        }
        add(
            "tables.eigen.order",
            int(t.eigen.order),
            "0 | 1",
            false,
            "interpolation between angle entries",
        );
        add(
            "tables.eigen.frac",
            int(t.eigen.frac),
            "4…28",
            false,
            "fraction bits of sine and cosine",
        );
        for reg in Reg::ALL {
            let info = reg.info();
            let format = c.format(*reg);
            let path = |knob: &str| format!("registers.{}.{}.{knob}", info.stage, info.name);
            add(&path("int"), int(format.int), "0…58", false, info.meaning);
            add(&path("frac"), int(format.frac), "0…58", false, info.meaning);
            add(
                &path("rounding"),
                text(format.rounding.name()),
                &names(Rounding::ALL, Rounding::name),
                false,
                info.meaning,
            );
            if info.kind == Kind::Fixed {
                add(
                    &path("overflow"),
                    text(format.overflow.name()),
                    &names(Overflow::ALL, Overflow::name),
                    false,
                    info.meaning,
                );
            }
        }
        out
    }

    /// The value of a knob.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<Value> {
        let path = canonical(path);
        self.knobs().into_iter().find(|k| k.path == path).map(|k| k.value)
    }
}

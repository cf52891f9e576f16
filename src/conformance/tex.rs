//! Harnesses of TEX: `surface_footprint` alone, and the whole operation to the colour.

use rtl_model::cone::{Angle, Cone, Width};
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;

use super::field::{Field, Shape, registers};
use super::harness::{Build, Circuit, Extra, Harness, Numbers, put_words};
use super::memory;
use super::stimuli::Stimulus;
use super::subject::Subject;
use crate::engine::probe::RtlProbe;
use crate::engine::tex::{TexRtl, words};
use crate::error::InputError;
use crate::fragment::{Tangents, TexFragment};
use crate::policy::ConeGradient;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// The harness of the stage, or of the operation.
pub(super) fn harness(
    spec: &UnitSpec,
    subject: Subject,
    build: Build,
) -> Result<Harness, InputError> {
    let map = memory::planar(build.size);
    let whole = subject == Subject::Tex;
    let engine =
        if whole { TexRtl::new(spec, &map)? } else { TexRtl::sized(spec, map.size_u32())? };
    let config = &spec.config;
    let stage = Stage::SurfaceFootprint;
    let word = |name, n, text| Field::words(stage, name, n, text);
    let inputs = vec![
        Field::small(config, stage, "width", "the cone's width at the surface"),
        word("d", 3, "direction of the ray"),
        word("n", 3, "normal of the surface"),
        word("dp_ds", 3, "∂P/∂s, or the triangle's edge AB"),
        word("dp_dt", 3, "∂P/∂t, or the triangle's edge AC"),
        word("edge_st", 4, "differences of s, then of t, along AB and AC (triangles)"),
        Field::count(stage, "triangle", [0, 1], "whether edges of a triangle came"),
        word("st", 2, "texture coordinates s and t"),
    ];
    let mut outputs = Vec::new();
    let mut regs = Vec::new();
    for reg in registers(stage) {
        let gram = [Reg::SurfPlane, Reg::SurfTurned].contains(&reg);
        if gram && config.policy.cone.gradient != ConeGradient::Gram {
            continue;
        }
        regs.push(reg);
        Field::written(config, stage, reg, reg.info().components, &mut outputs);
    }
    outputs.push(Field::flags(stage, &regs));
    if whole {
        for field in &mut outputs {
            field.name = format!("surface_footprint.{}", field.name);
        }
        Field::behind(config, stage, &subject.stages(), &mut outputs);
    }
    Ok(Harness::new(Shape { inputs, outputs }, config, engine))
}

/// A case: the request, and the code of its cone's width.
pub(super) fn request(input: &[i64]) -> (TexFragment, u32) {
    let mut numbers = Numbers::new(input);
    let width = numbers.code();
    let (d, n, dp_ds, dp_dt) = (numbers.reals(), numbers.reals(), numbers.reals(), numbers.reals());
    let [s_b, s_c, t_b, t_c] = numbers.reals();
    let tangents = if numbers.next() == 1 {
        Tangents::Triangle { edges: [dp_ds, dp_dt], st: [[s_b, t_b], [s_c, t_c]] }
    } else {
        Tangents::Surface { dp_ds, dp_dt }
    };
    (TexFragment { d, n, tangents, st: numbers.reals() }, width)
}

impl Circuit for TexRtl {
    fn run(&mut self, input: &[i64], probe: &mut RtlProbe) -> (Flags, Extra) {
        let (fragment, width) = request(input);
        let cone = Cone { angle: Angle(0), width: Width(width) };
        let (block, out) = self.lanes::<1, _>(&[words(&fragment, cone)], probe);
        (out.flags[0], Extra { count: block.env.line.count[0], ..Extra::default() })
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Request(request) = stimulus else {
            return;
        };
        let cone = &self.unit.cone;
        let words = [0.0, request.width].map(f64::to_bits);
        let stored = cone.load(words, &mut cone.dither(0), &mut Flags::default());
        let edge = request.edge.unwrap_or([0.0; 4]);
        let vectors = [request.d, request.n, request.tangents[0], request.tangents[1]];
        let reals = vectors.into_iter().flatten().chain(edge).map(f64::to_bits);
        let triangle = u64::from(request.edge.is_some());
        let all = [u64::from(stored.width.0)].into_iter().chain(reals);
        put_words(all.chain([triangle]).chain(request.st.map(f64::to_bits)), input);
    }
}

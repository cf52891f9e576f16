//! Benches of TEX: `surface_footprint` alone, and the whole operation to the colour.

use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, Width};
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use rtl_model::unit::{Tangents, TexWords};

use super::bench::{Bench, Build, Extra, Model, put_words, record};
use super::field::{Field, Meaning, Shape, registers};
use super::hit::behind;
use super::memory;
use super::stimuli::Stimulus;
use super::subject::Subject;
use crate::base::num;
use crate::engine::probe::RtlProbe;
use crate::engine::tex::TexRtl;
use crate::error::InputError;
use crate::policy::ConeGradient;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// A request through `surface_footprint` and the stages behind it.
pub struct TexBench {
    engine: TexRtl,
    shape: Shape,
    probe: RtlProbe,
}

/// A field of a cone's code.
pub(super) fn small(config: &Config, stage: Stage, name: &str, text: &str) -> Field {
    let bits = config.policy.cone.format.float().width();
    Field::new(stage, name, 1, (false, bits), Meaning::Small, text)
}

impl TexBench {
    /// The bench of the stage, or of the operation.
    pub fn new(spec: &UnitSpec, subject: Subject, build: Build) -> Result<Self, InputError> {
        let map = memory::planar(build.size);
        let whole = subject == Subject::Tex;
        let engine =
            if whole { TexRtl::new(spec, &map)? } else { TexRtl::sized(spec, map.size_u32())? };
        let config = &engine.config;
        let stage = Stage::SurfaceFootprint;
        let word = |name, n, text| Field::words(stage, name, n, text);
        let inputs = vec![
            small(config, stage, "width", "the cone's width at the surface"),
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
            behind(config, stage, &subject.stages(), &mut outputs);
        }
        Ok(Self { engine, shape: Shape { inputs, outputs }, probe: RtlProbe::default() })
    }
}

impl Bench for TexBench {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        let word = |k: usize| input.get(k).map_or(0, |x| x.cast_unsigned());
        let three = |k: usize| [word(k), word(k + 1), word(k + 2)];
        let edges = [three(7), three(10)];
        let request = TexWords {
            cone: Cone { angle: Angle(0), width: Width(num::u32(word(0))) },
            d: three(1),
            n: three(4),
            tangents: if word(17) == 1 {
                Tangents::Triangle { edges, st: [word(13), word(14), word(15), word(16)] }
            } else {
                Tangents::Surface(edges)
            },
            st: [word(18), word(19)],
        };
        self.probe.clear();
        let (block, out) = self.engine.lanes::<1, _>(&[request], &mut self.probe);
        let extra = Extra { face: 0, count: block.env.line.count[0], ..Extra::default() };
        record(&self.shape, &self.probe, out.flags[0], extra, output);
    }
}

impl Model for TexBench {
    fn probe(&self) -> &RtlProbe {
        &self.probe
    }

    fn config(&self) -> &Config {
        &self.engine.config
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Request(request) = stimulus else {
            return;
        };
        let cone = &self.engine.unit.cone;
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

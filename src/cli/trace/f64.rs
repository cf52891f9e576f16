//! The float reference behind `trace`.

use rtl_model::fx::Flags;
use rtl_model::regs::Event;
use rtl_model::stages::ray_cone::Cfg;

use super::Memories;
use super::record::{ConeEnd, Number, Place, Record, Registers, Search};
use super::request::Request;
use crate::engine::cones::event_names;
use crate::engine::hit::HitF64;
use crate::engine::probe::FloatProbe;
use crate::error::InputError;
use crate::fragment::{Fragment, HitFragment, TexFragment};
use crate::reference::ray_cone::{Angle, Cone, Step, Width, ray_cone};
use crate::reference::{self, PlanarTexture, Prepared, Texture, env, tex};
use crate::settings::Settings;
use crate::unit::UnitSpec;

/// The reference with its maps.
pub(super) struct F64<'a> {
    spec: &'a UnitSpec,
    memories: &'a Memories,
    prepared: Prepared,
    texture: Option<Texture<'a>>,
    hit: Option<HitF64<'a>>,
    probe: FloatProbe,
}

impl<'a> F64<'a> {
    pub(super) fn new(spec: &'a UnitSpec, settings: &Settings, memories: &'a Memories) -> Self {
        let map = memories.map.as_ref();
        let hit = |distance| HitF64::new(settings, distance, map, memories.face_size);
        Self {
            spec,
            memories,
            prepared: Prepared::new(settings),
            texture: map.map(Texture::new),
            hit: memories.distance.as_ref().map(hit),
            probe: FloatProbe::default(),
        }
    }

    pub(super) fn answer(&mut self, request: &Request) -> Result<Record<'_>, InputError> {
        self.probe.clear();
        match request {
            Request::Env(fragment) => Ok(self.env(fragment)),
            Request::Hit(ray) => self.hit(ray),
            Request::Tex(fragment, cone) => Ok(self.tex(fragment, *cone)),
            Request::Cone(cone, steps) => Ok(self.cone(*cone, steps)),
        }
    }

    fn record(&self, flags: reference::Flags) -> Record<'_> {
        Record::new(Registers::F64(&self.probe), flags.names().map(str::to_string).collect())
    }

    fn env(&mut self, fragment: &Fragment) -> Record<'_> {
        let (size, texture) = (self.memories.face_size, self.texture.as_ref());
        let found = env(&self.prepared, fragment, size, texture, &mut self.probe);
        Record {
            place: Some(Place::Face(found.face)),
            probes: found.probes,
            ..self.record(found.flags)
        }
    }

    fn hit(&mut self, ray: &HitFragment) -> Result<Record<'_>, InputError> {
        let engine = self.hit.as_ref().ok_or_else(Memories::no_distance)?;
        let reference::HitEnv { hit, env } = engine.trace(ray, &mut self.probe);
        let search = Search {
            d: Number::Float(hit.d),
            l: hit.l.map(Number::Float),
            iterations: hit.iterations,
            status: hit.status,
            ratio: hit.ratio.map(Number::Float),
        };
        Ok(Record {
            search: Some(search),
            place: env.map(|env| Place::Face(env.face)),
            probes: env.map_or(0, |env| env.probes),
            ..self.record(env.map_or(hit.flags, |env| env.flags))
        })
    }

    fn tex(&mut self, fragment: &TexFragment, cone: [f64; 2]) -> Record<'_> {
        let wrap = self.prepared.settings().policy.address.wrap();
        let texture = self.memories.planar.as_ref().map(|map| PlanarTexture::new(map, wrap));
        let size = self.memories.texture_size;
        let probe = &mut self.probe;
        let found = tex(&self.prepared, cone[1], fragment, size, texture.as_ref(), probe);
        let mut record = self.record(found.flags);
        if !cone[0].is_finite() {
            record.flags.insert(0, Event::ConeNotFinite.name().into());
        }
        Record { place: Some(Place::Surface), probes: found.probes, ..record }
    }

    fn cone(&self, cone: [f64; 2], steps: &[Step]) -> Record<'_> {
        let knobs = &self.spec.config.policy.cone;
        let finite = |x: f64| {
            if x.is_nan() { 0.0 } else { x.clamp(-f64::MAX, f64::MAX) + 0.0 }
        };
        let mut state = Cone { angle: Angle(finite(cone[0])), width: Width(finite(cone[1])) };
        let operands = |step: &Step| match *step {
            Step::Propagate(x) | Step::Reflect(x) | Step::Scatter(x) => [x, 0.0, 0.0],
            Step::Refract { curvature, outside, inside } => [curvature, outside, inside],
        };
        let mut numbers = steps.iter().flat_map(operands).chain(cone);
        let mut flags = Flags::default();
        flags.event(Event::ConeNotFinite, numbers.any(|x| !x.is_finite()));
        for step in steps {
            state = ray_cone(state, *step, knobs.rules, knobs.set_diffuse);
            // Only what is beyond the range becomes its end.
            let at_end = |x: f64| x.abs() >= f64::MAX;
            flags.event(Event::ConeAngleSaturated, at_end(state.angle.0));
            flags.event(Event::ConeWidthSaturated, at_end(state.width.0));
        }
        // The packed word is the rounded pair; its own overflow shows in the word alone.
        let cfg = Cfg::new(&self.spec.config);
        let numbers = [state.angle.0, state.width.0];
        let codes = cfg.load(numbers.map(f64::to_bits), &mut cfg.dither(0), &mut Flags::default());
        let flags = event_names(flags).map(str::to_string).collect();
        Record {
            cone: Some(ConeEnd::new(&cfg, codes, numbers.map(Number::Float))),
            ..Record::new(Registers::F64(&self.probe), flags)
        }
    }
}

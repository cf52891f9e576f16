//! The integer model behind `trace`.

use std::collections::HashMap;

use rtl_model::cone::Dyadic;
use rtl_model::fx::Flags;
use rtl_model::regs::{Event, Reg};
use rtl_model::stages::ray_cone::{Cfg, ray_cone};
use rtl_model::unit::Needs;
use rtl_model::{Texture, Unit};

use super::Memories;
use super::record::{ConeEnd, Number, Place, Record, Registers, Search};
use super::request::Request;
use crate::base::num;
use crate::engine::cones::{event_names, rtl_step};
use crate::engine::encode;
use crate::engine::hit::HitRtl;
use crate::engine::probe::{Code, RtlProbe, rtl};
use crate::engine::tex::{TexRtl, words};
use crate::error::InputError;
use crate::fragment::{Fragment, HitFragment, TexFragment};
use crate::policy::HitStatus;
use crate::reference::ray_cone::Step;
use crate::unit::{UnitSpec, refused};

/// Units for each kind of request, compiled for the first of its kind.
pub(super) struct Rtl<'a> {
    spec: &'a UnitSpec,
    memories: &'a Memories,
    texture: Option<Texture>,
    env: HashMap<Needs, Unit>,
    hit: Option<HitRtl>,
    tex: Option<TexRtl>,
    probe: RtlProbe,
}

impl<'a> Rtl<'a> {
    pub(super) fn new(spec: &'a UnitSpec, memories: &'a Memories) -> Result<Self, InputError> {
        let texture = memories.map.as_ref().map(|map| encode::texture(&spec.config, map));
        Ok(Self {
            spec,
            memories,
            texture: texture.transpose().map_err(refused)?,
            env: HashMap::new(),
            hit: None,
            tex: None,
            probe: RtlProbe::default(),
        })
    }

    pub(super) fn answer(&mut self, request: &Request) -> Result<Record<'_>, InputError> {
        self.probe.clear();
        match request {
            Request::Env(fragment) => self.env(fragment),
            Request::Hit(ray) => self.hit(ray),
            Request::Tex(fragment, cone) => self.tex(fragment, *cone),
            Request::Cone(cone, steps) => Ok(self.cone(*cone, steps)),
        }
    }

    fn env(&mut self, fragment: &Fragment) -> Result<Record<'_>, InputError> {
        let (config, needs) = (&self.spec.config, encode::needs(fragment));
        let unit = match self.env.entry(needs) {
            std::collections::hash_map::Entry::Occupied(entry) => entry.into_mut(),
            std::collections::hash_map::Entry::Vacant(entry) => {
                let size = num::u32(self.memories.face_size);
                entry.insert(Unit::new(config, needs, size).map_err(refused)?)
            }
        };
        let found = rtl(unit, config, fragment, self.texture.as_ref(), &mut self.probe);
        Ok(Record {
            place: Some(Place::Face(found.face)),
            probes: num::u32(found.probes),
            ..Record::new(Registers::Rtl(&self.probe), found.flags)
        })
    }

    fn hit(&mut self, ray: &HitFragment) -> Result<Record<'_>, InputError> {
        let Memories { map, face_size, .. } = self.memories;
        let engine = match &mut self.hit {
            Some(engine) => engine,
            empty => {
                let distance = self.memories.distance()?;
                empty.insert(HitRtl::new(self.spec, distance, map.as_ref(), *face_size)?)
            }
        };
        let words = crate::engine::hit::words(ray);
        let (block, results) = engine.lanes::<1, _>(&[words], &mut self.probe);
        let found = engine.result(&block, &results, 0);
        let number = |raw: i64, reg: Reg, scale: i64| {
            Number::Code(Code { raw, frac: i64::from(engine.config.format(reg).frac) - scale })
        };
        let hit = &block.front.hit;
        let scale = engine.memory.distances.scale;
        let escaped = found.status == HitStatus::Escaped;
        let (l, l_scale) = if escaped { (Reg::HitR, 0) } else { (Reg::HitL, scale) };
        let search = Search {
            d: if escaped {
                Number::Float(f64::INFINITY)
            } else {
                number(hit.d[0], Reg::HitD, scale)
            },
            l: hit.l.map(|[raw]| number(raw, l, l_scale)),
            iterations: found.iterations,
            status: found.status,
            ratio: hit.ratio[0].map(|raw| number(raw, Reg::HitRatio, 0)),
        };
        Ok(Record {
            search: Some(search),
            place: ray.cone.map(|_| Place::Face(block.env.face_of(0))),
            probes: found.probes,
            ..Record::new(Registers::Rtl(&self.probe), found.flags)
        })
    }

    fn tex(&mut self, fragment: &TexFragment, cone: [f64; 2]) -> Result<Record<'_>, InputError> {
        let engine = match (&mut self.tex, &self.memories.planar) {
            (Some(engine), _) => engine,
            (empty, Some(map)) => empty.insert(TexRtl::new(self.spec, map)?),
            (empty, None) => {
                let size = self.memories.texture_size.map(num::u32);
                empty.insert(TexRtl::sized(self.spec, size)?)
            }
        };
        let cfg = &engine.unit.cone;
        let mut loaded = Flags::default();
        let cone = cfg.load(cone.map(f64::to_bits), &mut cfg.dither(0), &mut loaded);
        let (_, results) = engine.lanes::<1, _>(&[words(fragment, cone)], &mut self.probe);
        let flags =
            event_names(loaded).map(str::to_string).chain(engine.flag_names(results.flags[0]));
        Ok(Record {
            place: Some(Place::Surface),
            probes: num::u32(results.probes[0]),
            ..Record::new(Registers::Rtl(&self.probe), flags.collect())
        })
    }

    fn cone(&self, cone: [f64; 2], steps: &[Step]) -> Record<'_> {
        let cfg = Cfg::new(&self.spec.config);
        let mut dither = cfg.dither(0);
        let mut flags = Flags::default();
        let mut state = cfg.load(cone.map(f64::to_bits), &mut dither, &mut flags);
        for step in steps {
            let (step, finite) = rtl_step(*step);
            flags.event(Event::ConeNotFinite, !finite);
            state = ray_cone(&cfg, state, step, &mut dither, &mut flags);
        }
        let number = |x: Dyadic| {
            let m = num::i64(x.m);
            Number::Code(Code { raw: if x.negative { -m } else { m }, frac: -x.e })
        };
        let numbers = [number(cfg.angle(state.angle)), number(cfg.width(state.width))];
        let flags = event_names(flags).map(str::to_string).collect();
        Record {
            cone: Some(ConeEnd::new(&cfg, state, numbers)),
            ..Record::new(Registers::Rtl(&self.probe), flags)
        }
    }
}

//! The texture requests of the paths in one row of a picture, with their cones.

use std::collections::BTreeMap;
use std::time::Instant;

use rtl_model::fx::Flags;
use rtl_model::regs::Event as RtlEvent;
use rtl_model::unit::TexWords;

use super::tex::{TexEngine, TexJob};
use crate::base::num;
use crate::engine::cones::{Asked, FloatCones, RtlCones, walk};
use crate::engine::probe::RtlProbe;
use crate::engine::tex::{value, words};
use crate::fragment::{HitFragment, TexFragment};
use crate::scene::tex::TexScene;
use crate::scene::tex::path::{Look, Path};
use crate::settings::Settings;

/// One request of a row: its pixel's column, its weight, and the texture asked.
#[derive(Debug)]
pub(crate) struct Request<A> {
    pub(in crate::engine) column: usize,
    pub(in crate::engine) weight: f64,
    pub(in crate::engine) asked: A,
}

/// A bare cone in a direction: a ray without walls.
pub(in crate::engine) fn bare(direction: [f64; 3], angle: f64) -> HitFragment {
    HitFragment { x: [0.0; 3], r: direction, cone: Some([angle, 0.0]) }
}

impl TexJob {
    /// A row's requests with the integer model's cones.
    pub(in crate::engine) fn ask_rtl(&self, engine: &TexEngine, y: usize) -> AskedRtl {
        let mut out = AskedRtl {
            looks: self.scene.textures.iter().map(|_| Vec::new()).collect(),
            sky: Vec::new(),
            flags: BTreeMap::new(),
            paths: 0.0,
        };
        let Some(first) = engine.textures.first() else {
            return out;
        };
        let cfg = &first.unit.cone;
        let mut cones = RtlCones::new(cfg, &self.scene.camera);
        let mut before = Instant::now();
        scene_row(&self.scene, y, &mut |column, number, path| {
            out.paths += before.elapsed().as_secs_f64();
            cones.ray(number);
            let lens = self.scene.camera.lens;
            walk(
                &mut cones,
                &first.config.policy.cone,
                lens,
                path,
                &mut |asked, cone| match asked {
                    Asked::Look(look) => out.looks[look.texture].push(Request {
                        column,
                        weight: look.weight / f64::from(self.scene.samples),
                        asked: words(&look.fragment, cone),
                    }),
                    Asked::Sky(direction, weight) => out.sky.push(Request {
                        column,
                        weight: weight / f64::from(self.scene.samples),
                        asked: bare(direction, value(cfg.angle(cone.angle))),
                    }),
                },
            );
            let flags = std::mem::take(&mut cones.flags);
            if flags != Flags::default() {
                for event in RtlEvent::ALL.iter().filter(|e| flags.has_event(**e)) {
                    *out.flags.entry(event.name().to_string()).or_default() += 1;
                }
            }
            before = Instant::now();
        });
        out
    }

    /// The float reference's requests of a row: texture requests with their widths, and bare cones.
    pub(in crate::engine) fn ask_f64(&self, settings: &Settings, y: usize) -> AskedF64 {
        let mut out = AskedF64 { looks: Vec::new(), sky: Vec::new(), paths: 0.0 };
        let scene = &self.scene;
        let mut cones = FloatCones::new(
            &scene.camera,
            settings.policy.cone.rules,
            settings.policy.cone.set_diffuse,
        );
        let mut before = Instant::now();
        scene_row(scene, y, &mut |column, _, path| {
            out.paths += before.elapsed().as_secs_f64();
            walk(&mut cones, &settings.policy.cone, scene.camera.lens, path, &mut |asked, cone| {
                let part = 1.0 / f64::from(scene.samples);
                match asked {
                    Asked::Look(look) => out.looks.push(Request {
                        column,
                        weight: look.weight * part,
                        asked: (look.texture, look.fragment, cone.width.0),
                    }),
                    Asked::Sky(direction, weight) => out.sky.push(Request {
                        column,
                        weight: weight * part,
                        asked: bare(direction, cone.angle.0),
                    }),
                }
            });
            before = Instant::now();
        });
        out
    }

    /// Every request of a row through a recording tap: its registers and its probes.
    pub fn trace_row(
        &self,
        engine: &TexEngine,
        y: usize,
        probe: &mut RtlProbe,
        each: &mut dyn FnMut(&RtlProbe, u32),
    ) {
        let asked = self.ask_rtl(engine, y);
        for (unit, looks) in engine.textures.iter().zip(&asked.looks) {
            for request in looks {
                probe.clear();
                let request = std::slice::from_ref(&request.asked);
                let (_, out) = unit.lanes::<1, _>(request, probe);
                each(probe, num::u32(out.probes[0]));
            }
        }
        for request in &asked.sky {
            let (found, _) = engine.sky.trace(&request.asked, probe);
            each(probe, found.probes);
        }
    }

    /// The texture requests of the first path of each pixel of a row, with the integer model's cones.
    pub fn each_look(
        &self,
        engine: &TexEngine,
        y: usize,
        each: &mut dyn FnMut(usize, &Look, &TexWords, f64),
    ) {
        let Some(first) = engine.textures.first() else {
            return;
        };
        let cfg = &first.unit.cone;
        let mut cones = RtlCones::new(cfg, &self.scene.camera);
        let mut path = Path::default();
        for column in 0..self.scene.width {
            let at = [column, y].map(|n| n as f64 + 0.5);
            self.scene.path(at, [0, self.scene.samples], &mut path);
            cones.ray(num::u64((y * self.scene.width + column) * self.scene.samples as usize));
            let lens = self.scene.camera.lens;
            walk(&mut cones, &first.config.policy.cone, lens, &path, &mut |asked, cone| {
                if let Asked::Look(look) = asked {
                    let width = value(cfg.width(cone.width));
                    each(column, look, &words(&look.fragment, cone), width);
                }
            });
        }
    }
}

#[derive(Debug)]
pub(in crate::engine) struct AskedRtl {
    /// By texture.
    pub(in crate::engine) looks: Vec<Vec<Request<TexWords>>>,
    pub(in crate::engine) sky: Vec<Request<HitFragment>>,
    /// Paths whose cones reported each event.
    pub(in crate::engine) flags: BTreeMap<String, u64>,
    /// Seconds that the paths took.
    pub(in crate::engine) paths: f64,
}

pub(in crate::engine) struct AskedF64 {
    /// Texture, request, width.
    pub(in crate::engine) looks: Vec<Request<(usize, TexFragment, f64)>>,
    pub(in crate::engine) sky: Vec<Request<HitFragment>>,
    /// Seconds that the paths took.
    pub(in crate::engine) paths: f64,
}

/// The paths of a row: column, number of the path in the picture, path.
pub(crate) fn scene_row(scene: &TexScene, y: usize, each: &mut dyn FnMut(usize, u64, &Path)) {
    let mut path = Path::default();
    for column in 0..scene.width {
        let at = [column, y].map(|n| n as f64 + 0.5);
        for sample in 0..scene.samples {
            scene.path(at, [sample, scene.samples], &mut path);
            let number = (y * scene.width + column) as u64 * u64::from(scene.samples);
            each(column, number + u64::from(sample), &path);
        }
    }
}

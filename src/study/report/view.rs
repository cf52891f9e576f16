//! The footprint of one pixel's first request: ellipse, axes and probes over the texels.

use crate::base::num;
use crate::cube::CubeMap;
use crate::engine::Job;
use crate::engine::job::Compile as _;
use crate::engine::probe::{FloatProbe, RtlProbe, rtl};
use crate::error::InputError;
use crate::reference::{Env, PlanarTexture, Prepared, env, tex::tex};
use crate::settings::Settings;
use crate::srgb::srgb_encode;
use crate::unit::UnitSpec;
use rtl_model::regs::Reg;
use serde_json::{Value, json};

/// Texels along a footprint view's side.
const WINDOW: [usize; 2] = [8, 28];

/// The texel of a level at a place; nothing beyond a face.
type Texel<'a> = dyn Fn(usize, [i64; 2]) -> Option<[f32; 3]> + 'a;

/// What both arithmetics put about one request, and the texture that it asks.
struct Request<'a> {
    rtl: RtlProbe,
    float: FloatProbe,
    /// u and v of the centre by f64.
    centre: [f64; 2],
    /// λ in texels of level 0.
    scale: f64,
    /// Columns and rows of a level, and its texels.
    sizes: Vec<[usize; 2]>,
    texel: Box<Texel<'a>>,
}

/// The footprint view of a pixel's first request; none where the pixel shows no fragment.
pub(super) fn view(
    job: &Job,
    spec: &UnitSpec,
    settings: &Settings,
    pixel: [u32; 2],
) -> Result<Option<Value>, InputError> {
    let prepared = Prepared::new(settings);
    let (mut mine, mut theirs) = (RtlProbe::default(), FloatProbe::default());
    let request = match job {
        Job::Env(s) => {
            let Some(fragment) = s.scene.fragments.iter().find(|f| f.pixel == pixel) else {
                return Ok(None);
            };
            let engine = s.rtl(spec)?;
            let texture = engine.memory.texture.as_ref();
            rtl(&engine.unit, &engine.config, &fragment.fragment, texture, &mut mine);
            let found = env(&prepared, &fragment.fragment, s.map.size(), None, &mut theirs);
            Request::on_cube(mine, theirs, &s.map, &found)
        }
        Job::Hit(s) => {
            let Some(ray) = s.scene.rays.iter().find(|r| r.pixel == pixel) else {
                return Ok(None);
            };
            let engine = s.rtl(spec)?;
            engine.trace(&ray.fragment, &mut mine);
            let Some(found) = s.reference(settings).trace(&ray.fragment, &mut theirs).env else {
                return Ok(None);
            };
            Request::on_cube(mine, theirs, &s.map, &found)
        }
        Job::Tex(s) => {
            let engine = s.rtl(spec)?;
            let [column, row] = pixel.map(num::usize);
            let mut first = None;
            if row < s.scene.height {
                s.each_look(&engine, row, &mut |x, look, words, width| {
                    if x == column && first.is_none() {
                        first = Some((*look, *words, width));
                    }
                });
            }
            let Some((look, words, width)) = first else {
                return Ok(None);
            };
            let unit = &engine.textures[look.texture];
            unit.lanes::<1, _>(std::slice::from_ref(&words), &mut mine);
            let map = &s.scene.textures[look.texture];
            let wrap = settings.policy.address.wrap();
            let planar = PlanarTexture::new(map, wrap);
            let found =
                tex(&prepared, width, &look.fragment, map.size(), Some(&planar), &mut theirs);
            let texel = move |level: usize, at: [i64; 2]| {
                let level = &map.levels[level];
                let [x, y] = [0, 1].map(|i| wrap[i].texel(at[i], level.size[i]));
                Some(level.texel(x, y))
            };
            let sizes = map.levels.iter().map(|l| l.size).collect();
            Request {
                rtl: mine,
                float: theirs,
                centre: found.centre,
                scale: 1.0,
                sizes,
                texel: Box::new(texel),
            }
        }
    };
    Ok(Some(request.view(pixel)))
}

impl<'a> Request<'a> {
    /// A request to a cube map; the float reference found its footprint.
    fn on_cube(rtl: RtlProbe, float: FloatProbe, map: &'a CubeMap, found: &Env) -> Self {
        let face = found.face;
        let texel = move |level: usize, at: [i64; 2]| {
            let level = &map.levels[level];
            let place = at.map(|x| usize::try_from(x).ok().filter(|x| *x < level.size));
            Some(level.texel(face, place[0]?, place[1]?))
        };
        Self {
            rtl,
            float,
            centre: [found.u, found.v],
            scale: map.size() as f64 / 2.0,
            sizes: map.levels.iter().map(|l| [l.size; 2]).collect(),
            texel: Box::new(texel),
        }
    }
}

impl Request<'_> {
    fn float(&self, reg: Reg, component: usize) -> f64 {
        self.float.get(reg).get(component).copied().unwrap_or(0.0)
    }

    fn mine(&self, reg: Reg, component: usize) -> f64 {
        self.rtl.get(reg).get(component).map_or(0.0, |c| c.value())
    }

    /// Everything in texels of the level that f64's level of detail rounds down to.
    fn view(&self, pixel: [u32; 2]) -> Value {
        let lod = self.float(Reg::FootLod, 0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a level, clamped to the chain"
        )]
        let level = (lod.max(0.0) as usize).min(self.sizes.len() - 1);
        let size = self.sizes[level];
        let shrink = libm::exp2(-(level as f64));
        let texel = |uv: [f64; 2]| [0, 1].map(|i| (uv[i] + 1.0) / 2.0 * size[i] as f64);
        let centre = texel(self.centre);
        let length = self.float(Reg::FootLength, 0) * shrink;
        let minor = self.float(Reg::EigenLambda, 1) * self.scale * shrink;
        let probes = |count: usize, step: [f64; 2]| -> Vec<[f64; 2]> {
            (0..count)
                .map(|i| {
                    let along = 2.0 * i as f64 + 1.0 - count as f64;
                    texel([0, 1].map(|c| self.centre[c] + along * step[c]))
                })
                .collect()
        };
        let exact_probes =
            probes(self.float.get(Reg::AddrU).len(), [0, 1].map(|c| self.float(Reg::FootStep, c)));
        let mine =
            probes(self.rtl.get(Reg::AddrU).len(), [0, 1].map(|c| self.mine(Reg::FootStep, c)));
        let exact = [0, 1].map(|c| self.float(Reg::EigenAxis, c));
        let table = [0, 1].map(|c| self.mine(Reg::EigenAxis, c));
        let sine = exact[0] * table[1] - exact[1] * table[0];
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the window's sizes"
        )]
        let side = (length * 1.3 + 4.0).clamp(WINDOW[0] as f64, WINDOW[1] as f64) as usize;
        let first = centre.map(|c| (c - side as f64 / 2.0).floor());
        let row = |y: usize| -> Vec<String> {
            (0..side)
                .map(|x| {
                    #[expect(clippy::cast_possible_truncation, reason = "texel numbers of a face")]
                    let at = [first[0] + x as f64, first[1] + y as f64].map(|c| c as i64);
                    (self.texel)(level, at).map_or("#777777".into(), hex)
                })
                .collect()
        };
        let texels: Vec<Vec<String>> = (0..side).map(row).collect();
        json!({"id": format!("{}-{}", pixel[0], pixel[1]).replace('-', ""), "pixel": pixel, "level": level, "texels": texels, "first": first, "centre": centre,
            "length": length, "minor": minor, "width": self.float(Reg::FootWidth, 0) * shrink, "exact_axis": exact, "table_axis": table,
            "probes": mine, "exact_probes": exact_probes, "off_degrees": libm::asin(sine.clamp(-1.0, 1.0)).abs().to_degrees()})
    }
}

fn hex(colour: [f32; 3]) -> String {
    let byte = |c: f32| {
        let shown = 255.0 * srgb_encode(f64::from(c).clamp(0.0, 1.0));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 255"
        )]
        let byte = (shown + 0.5) as u8;
        byte
    };
    let [r, g, b] = colour.map(byte);
    format!("#{r:02x}{g:02x}{b:02x}")
}

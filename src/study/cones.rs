//! The effect of a ray cone's registers alone on a level of detail: every other word is exact.

use rayon::prelude::*;
use rtl_model::stages::ray_cone::Cfg;

use crate::engine::TexJob;
use crate::engine::cones::{Asked, FloatCones, RtlCones, walk};
use crate::engine::job::tex_requests::scene_row;
use crate::engine::reuse::lines::quantile;
use crate::engine::tex::value;
use crate::reference::tex::tex;
use crate::reference::{NoTap, Prepared};
use crate::settings::Settings;
use crate::unit::UnitSpec;

/// How far a level has to be off to count as another one altogether.
const FAR: f64 = 2.0;

/// Figures by name: levels of detail of a unit's cones less those of cones in doubles, over the requests to textures.
pub(super) fn figures(
    subject: &TexJob,
    spec: &UnitSpec,
    settings: &Settings,
) -> [(&'static str, f64); 7] {
    let rows = (0..subject.scene.height).into_par_iter();
    let errors: Vec<Vec<f64>> = rows.map(|y| row(subject, spec, settings, y)).collect();
    let errors = errors.concat();
    let count = errors.len().max(1) as f64;
    let mut sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let far = sizes.iter().filter(|e| **e >= FAR).count();
    [
        ("texture_requests", errors.len() as f64),
        ("cone_lod_median", quantile(&sizes, 50)),
        ("cone_lod_p95", quantile(&sizes, 95)),
        ("cone_lod_p99", quantile(&sizes, 99)),
        ("cone_lod_max", quantile(&sizes, 100)),
        ("cone_lod_bias", errors.iter().sum::<f64>() / count),
        ("cone_lod_far_share", far as f64 / count),
    ]
}

/// The errors of a row of the picture.
fn row(subject: &TexJob, spec: &UnitSpec, settings: &Settings, y: usize) -> Vec<f64> {
    let scene = &subject.scene;
    let prepared = Prepared::new(settings);
    let policy = &settings.policy.cone;
    let cfg = Cfg::new(&spec.config);
    let mut registers = RtlCones::new(&cfg, &scene.camera);
    let mut doubles = FloatCones::new(&scene.camera, policy.rules, policy.set_diffuse);
    let mut out = Vec::new();
    scene_row(scene, y, &mut |_, number, path| {
        let lens = scene.camera.lens;
        let mut exact = Vec::new();
        walk(&mut doubles, policy, lens, path, &mut |asked, cone| {
            if let Asked::Look(_) = asked {
                exact.push(cone.width.0);
            }
        });
        let mut exact = exact.into_iter();
        registers.ray(number);
        walk(&mut registers, policy, lens, path, &mut |asked, cone| {
            let Asked::Look(look) = asked else { return };
            let size = scene.textures[look.texture].size();
            let lod = |w: f64| tex(&prepared, w, &look.fragment, size, None, &mut NoTap).lod;
            let here = lod(value(cfg.width(cone.width)));
            out.extend(exact.next().map(|width| here - lod(width)));
        });
    });
    out
}

//! The TEX operation: cones on textured surfaces, 2-D textures, scenes, studies.
#![expect(clippy::float_cmp, reason = "where bits must be equal, that is what is tested")]

mod cones;
mod extremes;
mod knobs;
mod surface;
mod texture;

use tapline::engine::probe::RtlProbe;
use tapline::engine::tex::{TexRtl, words};
use tapline::fragment::{Tangents, TexFragment};
use tapline::reference::{NoTap, Prepared, Tex, tex};
use tapline::unit::{ReferenceAxis, UnitSpec};

pub(crate) use support::reference::{Random, cross, dot};

pub(crate) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    let l = length(a);
    a.map(|c| c / l)
}

/// A request on a surface with derivatives.
pub(crate) fn request(d: [f64; 3], n: [f64; 3], dp_ds: [f64; 3], dp_dt: [f64; 3]) -> TexFragment {
    TexFragment { d, n, tangents: Tangents::Surface { dp_ds, dp_dt }, st: [0.5, 0.5] }
}

pub(crate) fn by_f64(spec: &UnitSpec, fragment: &TexFragment, width: f64, size: [usize; 2]) -> Tex {
    let prepared = Prepared::new(&spec.settings(ReferenceAxis::Exact));
    tex(&prepared, width, fragment, size, None, &mut NoTap)
}

/// The integer model's registers of one request, and its flags. `width` goes through the cone's store.
pub(crate) fn by_rtl(
    engine: &TexRtl,
    fragment: &TexFragment,
    width: f64,
) -> (RtlProbe, i64, Vec<String>) {
    let mut probe = RtlProbe::default();
    let cfg = &engine.unit.cone;
    let mut flags = rtl_model::fx::Flags::default();
    let cone = cfg.load([0, width.to_bits()], &mut cfg.dither(0), &mut flags);
    let (_, out) = engine.lanes::<1, _>(&[words(fragment, cone)], &mut probe);
    (probe, out.probes[0], engine.flag_names(out.flags[0]))
}

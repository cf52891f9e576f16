//! The TEX operation: cones on textured surfaces, 2-D textures, scenes, studies.
#![expect(
    clippy::float_cmp,
    reason = "where bits must be equal, that is what is tested"
)]

mod command;
mod cones;
mod extremes;
mod knobs;
mod scenes;
mod surface;
mod texture;

use tapline::engine::probe::RtlProbe;
use tapline::engine::tex::{TexRtl, words};
use tapline::fragment::{Tangents, TexFragment};
use tapline::reference::{NoTap, Prepared, Tex, tex};
use tapline::unit::{ReferenceAxis, UnitSpec};

/// A deterministic stream of numbers from −1 to 1.
pub(crate) struct Numbers(u64);

impl Numbers {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / 4_503_599_627_370_496.0 - 1.0
    }

    pub(crate) fn vector(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    let l = length(a);
    a.map(|c| c / l)
}

/// A request on a surface with derivatives.
pub(crate) fn request(d: [f64; 3], n: [f64; 3], dp_ds: [f64; 3], dp_dt: [f64; 3]) -> TexFragment {
    TexFragment {
        d,
        n,
        tangents: Tangents::Surface { dp_ds, dp_dt },
        st: [0.5, 0.5],
    }
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
    (probe, out.probes[0], engine.flags(&out, 0))
}

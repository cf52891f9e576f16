//! The TEX operation: the stages wired together.

use super::address::Address;
use super::env::{clean, ellipse};
use super::filter::{Levels, Sampler as _, filter};
use super::flags::{Flag, Flags};
use super::footprint::{Chain, Footprint, footprint};
use super::planar::{PlanarTexture, wrapped};
use super::prepared::{Prepared, finite};
use super::real::{Real as _, saturate};
use super::surface_footprint::surface_footprint;
use super::tap::Tap;
use super::wide::Wide;
use crate::fragment::TexFragment;
use crate::stage::Stage;

/// The unit's result for a texture request. Every number is finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tex {
    /// dPdx and dPdy in world units.
    pub dp: [[f64; 3]; 2],
    /// ddx and ddy: (∂s, ∂t) per pixel.
    pub dd: [[f64; 2]; 2],
    /// D in texels of level 0.
    pub d: [[f64; 2]; 2],
    /// K = (a, b; b, c) in texels of level 0, squared.
    pub k: [f64; 3],
    /// λ1, λ2 in texels of level 0.
    pub lambda: [f64; 2],
    /// Direction of the probe line.
    pub axis: [f64; 2],
    /// Number of probes.
    pub probes: u32,
    /// Level of detail.
    pub lod: f64,
    /// 2s − 1 and 2t − 1.
    pub centre: [f64; 2],
    /// The flags of the request.
    pub flags: Flags,
    /// Linear RGB; zero without a texture.
    pub color: [f64; 3],
}

/// The TEX operation on one request, in doubles of twice the precision up to λ: within 1e-12 of exact arithmetic,
/// relatively, for ddx, ddy and λ1.
///
/// `size` is that of level 0 where there is no texture.
pub fn tex<T: Tap>(
    prepared: &Prepared,
    width: f64,
    fragment: &TexFragment,
    size: [usize; 2],
    texture: Option<&PlanarTexture<'_>>,
    tap: &mut T,
) -> Tex {
    let settings = prepared.settings();
    let mut flags = Flags::default();
    let fragment = cleaned(*fragment, width, &mut flags);
    let size = texture.map_or(size, |texture| texture.level_size(0)).map(|n| n.max(1));
    let width = Wide::from_f64(finite(width).0);
    let surface = surface_footprint(&fragment, width, size, &settings.policy, &mut flags, tap);
    let d = (&surface.d, Flag::SurfSaturated);
    let (k, axes) = ellipse(prepared, d, None, &mut flags, tap);
    let lambda = axes.lambda.map(|x| x.to_f64());
    // λ counts in texels: 2 texels are 2.
    let chain = Chain { size: 2, levels: size[0].max(size[1]).ilog2() as usize + 1 };
    let axis = axes.axis;
    let mut scaled = InPeriods { tap, scale: size.map(|n| 2.0 / n as f64) };
    let policy = (&settings.policy.footprint, prepared.spreads());
    let Footprint { probes, lod, step } =
        footprint(lambda, axis, chain, policy, &mut flags, &mut scaled);
    let step = [0, 1].map(|i| saturate(step[i] * scaled.scale[i]));
    let centre = fragment.st.map(|x| saturate(2.0 * x - 1.0));
    let levels = Levels::new(lod, chain.levels);
    let probe = |i: u32| {
        let offset = 2.0 * f64::from(i) + 1.0 - f64::from(probes);
        let wrap = settings.policy.address.wrap();
        let [u, v] = [0, 1].map(|c| wrapped(saturate(centre[c] + offset * step[c]), wrap[c]));
        Address { face: 0, u, v }
    };
    if T::ACTIVE {
        for i in 0..probes {
            let at = probe(i);
            tap.put(Stage::Address, "u", i as usize, at.u);
            tap.put(Stage::Address, "v", i as usize, at.v);
        }
    }
    let line = (0..probes).map(|i| (probe(i), prepared.weight(i, probes)));
    let color = texture.map_or([0.0; 3], |texture| filter(texture, levels, line, tap));
    if T::ACTIVE {
        for name in flags.names() {
            tap.event(name);
        }
    }
    Tex {
        dp: surface.dp.map(|v| v.map(|c| c.to_f64())),
        dd: surface.dd.map(|v| v.map(|c| c.to_f64())),
        d: surface.d.map(|v| v.map(|c| c.to_f64())),
        k: k.map(|c| c.to_f64()),
        lambda,
        axis,
        probes,
        lod,
        centre,
        flags,
        color,
    }
}

/// A tap that reports steps in u and v, of which a texture has 2 each, instead of texels.
struct InPeriods<'a, T> {
    tap: &'a mut T,
    scale: [f64; 2],
}

impl<T: Tap> Tap for InPeriods<'_, T> {
    const ACTIVE: bool = T::ACTIVE;

    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        let value =
            if register == "step" { saturate(value * self.scale[component % 2]) } else { value };
        self.tap.put(stage, register, component, value);
    }

    fn event(&mut self, name: &'static str) {
        self.tap.event(name);
    }
}

/// The colour of one point of level 0.
#[must_use]
pub fn point(
    texture: &PlanarTexture<'_>,
    st: [f64; 2],
    wrap: [crate::policy::Wrap; 2],
) -> [f64; 3] {
    let [u, v] = [0, 1].map(|i| wrapped(2.0 * st[i] - 1.0, wrap[i]));
    texture.bilinear(0, Address { face: 0, u, v })
}

/// The request with finite numbers, and with +0 for −0.
fn cleaned(mut fragment: TexFragment, width: f64, flags: &mut Flags) -> TexFragment {
    let mut changed = !width.is_finite();
    fragment.for_each(|x| clean(x, &mut changed));
    if changed {
        flags.insert(Flag::SurfNotFinite);
    }
    fragment
}

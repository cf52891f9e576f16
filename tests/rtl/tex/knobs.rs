//! No knob of the TEX operation is dead: each path, set to another legal value, changes a register or a colour.

use std::collections::BTreeMap;

use rtl_model::Tap;
use rtl_model::cone::Cone;
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use tapline::engine::tex::{TexRtl, words};
use tapline::fragment::{Tangents, TexFragment};
use tapline::mips::build_planar_mips;
use tapline::planar::{PlanarLevel, PlanarMap};
use tapline::unit::UnitSpec;

use super::{Random, request};
use support::knobs::{Enables, Sight, assert_none_dead};

/// Values (not codes) of every register of a request.
#[derive(Default, PartialEq)]
struct Values(BTreeMap<(Reg, usize), (i64, i64)>);

impl Tap for Values {
    fn put(&mut self, _: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        let zeros = i64::from(raw.trailing_zeros());
        let value = if raw == 0 { (0, 0) } else { (raw >> zeros, frac - zeros) };
        self.0.insert((reg, component), value);
    }
}

fn map() -> PlanarMap {
    let mut numbers = Random::new(31);
    let texels = (0..32 * 16).map(|_| {
        let byte = |n: &mut Random| f32::from(u8::try_from(n.word() >> 56).unwrap()) / 256.0;
        [byte(&mut numbers), byte(&mut numbers), byte(&mut numbers)]
    });
    build_planar_mips(PlanarLevel { size: [32, 16], texels: texels.collect() })
}

/// Requests along the axes, at any angle, grazing, on triangles, far outside of the texture; and their widths.
fn corpus() -> Vec<(TexFragment, f64)> {
    let mut numbers = Random::new(40);
    let mut out = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut d = [0.0; 3];
            d[axis] = sign;
            let mut n = [0.0; 3];
            n[(axis + 1) % 3] = sign;
            let mut across = [0.0; 3];
            across[(axis + 2) % 3] = sign;
            out.push((request(d, n, d, across), 0.75));
            out.push((request(d, d, n, across), 1.5));
            out.push((request(d, d.map(|c| -c), n, across), -0.3));
            let tilted = [0, 1, 2].map(|i| d[i] + 1e-3 * n[i]);
            out.push((request(tilted, n, d, across), 1.99));
        }
    }
    for i in 0..80 {
        let (d, n) = (numbers.vector(), numbers.vector());
        let mut fragment = request(d, n, numbers.vector(), numbers.vector());
        if i % 3 == 0 {
            fragment.tangents = Tangents::Triangle {
                edges: [numbers.vector(), numbers.vector()],
                st: [0, 1].map(|_| [numbers.signed(), numbers.signed()]),
            };
        }
        let far = if i % 4 == 0 { 500.0 } else { 3.0 };
        fragment.st = [far * numbers.signed(), far * numbers.signed()];
        out.push((fragment, libm::exp2(4.0 * numbers.signed() - 3.0)));
    }
    out
}

type Found = (Vec<Values>, Vec<[i64; 3]>, Vec<Flags>);

struct Requests {
    map: PlanarMap,
    corpus: Vec<(TexFragment, f64)>,
}

impl Sight for Requests {
    type Seen = Found;

    fn enables(&self) -> &Enables {
        &[]
    }

    fn never_below(&self) -> &[Reg] {
        &[]
    }

    fn see(&self, spec: &UnitSpec) -> Option<Found> {
        let engine = TexRtl::new(spec, &self.map).ok()?;
        let cfg = &engine.unit.cone;
        let mut out: Found = Default::default();
        for (fragment, width) in &self.corpus {
            let mut flags = Flags::default();
            let cone: Cone = cfg.load([0, width.to_bits()], &mut cfg.dither(0), &mut flags);
            let mut values = Values::default();
            let (_, results) = engine.lanes::<1, _>(&[words(fragment, cone)], &mut values);
            out.0.push(values);
            out.1.push(results.color[0]);
            out.2.push(results.flags[0]);
        }
        Some(out)
    }

    fn differs(&self, base: &Found, other: &UnitSpec) -> Option<bool> {
        self.see(other).map(|found| found.0 != base.0 || found.1 != base.1)
    }

    fn saturated(&self, seen: &Found, reg: Reg) -> bool {
        seen.2.iter().any(|flags| flags.has(reg))
    }
}

#[test]
fn no_knob_of_tex_is_dead() {
    let ours =
        ["surface_footprint.", "registers.surface_footprint.", "address.wrap_", "cone.gradient"];
    let ours = |path: &str| ours.iter().any(|prefix| path.starts_with(prefix));
    assert_none_dead(&Requests { map: map(), corpus: corpus() }, ours, 81);
}

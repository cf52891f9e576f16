//! No knob is dead: every path of a unit, set to another legal value, changes a register somewhere.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use rtl_model::regs::{Kind, Reg};
use rtl_model::unit::Needs;
use rtl_model::{Texture, Unit};
use support::knobs::{Enables, Sight, assert_none_dead};
use support::reference::{Draw, PLAIN, Random};
use tapline::cube::CubeMap;
use tapline::engine::encode;
use tapline::engine::probe::{RtlProbe, rtl};
use tapline::fragment::Fragment;
use tapline::mips::build_mips;
use tapline::scene::environment::procedural;
use tapline::scene::{SCENES, SceneOptions, build};
use tapline::unit::{ReferenceAxis, UnitSpec};

/// Policies that switch a path on: (prefix of the path, settings of both units).
const ENABLES: &Enables = &[
    ("footprint.weight_bits", &[("footprint.weights", "\"gaussian\"")]),
    ("registers.cube_face.rotated", &[ROTATED]),
    ("registers.jacobian.perp_dot_e", &[FRAME]),
    ("registers.jacobian.tilt", &[FRAME]),
    ("registers.jacobian.turn", &[FRAME]),
    ("registers.jacobian.de", &[FRAME]),
    // Exact by default: it rounds only where it is narrower than the sums.
    ("registers.filter.bilinear.rounding", &[NARROW]),
    ("registers.filter.bilinear.frac", &[NARROW]),
    // As wide as what it is written from; a narrower one rounds.
    ("registers.eigen.axis.rounding", &[("registers.eigen.axis.frac", "12")]),
    ("registers.address.u.rounding", &[("registers.address.u.frac", "12")]),
    ("registers.address.v.rounding", &[("registers.address.v.frac", "12")]),
];

const ROTATED: (&str, &str) =
    ("transform.rotation", "[0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0]");
const FRAME: (&str, &str) = ("jacobian.dnmod", "\"frame\"");
const NARROW: (&str, &str) = ("registers.filter.bilinear.frac", "20");

/// Registers that never fall below the symmetric range: for them `saturate-symmetric` is `saturate`.
///
/// They are never negative, or (u, v, the axis, texel coordinates) at least −1, which is a code of every signed format.
const NEVER_BELOW: &[Reg] = &[
    Reg::FrameLength,
    Reg::ReflectNdotN,
    Reg::FaceU,
    Reg::FaceV,
    Reg::JacInvNn,
    Reg::EigenRoot,
    Reg::EigenSq,
    Reg::EigenLambda,
    Reg::EigenAxis,
    Reg::FootLength,
    Reg::FootWidth,
    Reg::FootLod,
    Reg::AddrS,
    Reg::FilterBilinear,
    Reg::FilterColor,
];

/// Texels along an edge of the environment.
const FACE: usize = 32;

/// Every fragment that the knobs are tried on.
fn corpus(spec: &UnitSpec) -> Vec<Fragment> {
    let settings = spec.settings(ReferenceAxis::Exact);
    let mut out = extremes();
    for info in SCENES {
        let options = SceneOptions { width: 24, height: 24, ..SceneOptions::default() };
        let scene = build(info.name, &options, &settings).unwrap();
        out.extend(scene.fragments.iter().step_by(9).map(|f| f.fragment));
    }
    out
}

/// Fragments at the ends of the registers.
fn extremes() -> Vec<Fragment> {
    let mut out = Vec::new();
    let full = Fragment {
        h: Some([0.0, 1.0, 0.0]),
        bump: Some([0.5, -0.25]),
        rough: Some([0.25, 0.125, 0.5]),
        ..PLAIN
    };
    // n of length 1 in its register, steep bumps and roughness of either sign.
    for (b, d) in [(14.0, 3.0), (-14.0, -3.0), (30.0, 15.0), (0.0, 0.0)] {
        out.push(Fragment {
            bump: Some([b, -b]),
            rough: Some([d, -d, d]),
            dn_dx: [0.01, 0.02, 0.0],
            ..full
        });
    }
    // Corners of the cube, all signs, as directions that reflect into themselves.
    for signs in 0..8u32 {
        let sign = |bit: u32| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let v = [sign(0), sign(1), sign(2)];
        out.push(Fragment {
            v,
            n: v,
            dv_dx: [0.5, -0.25, 0.125],
            dn_dx: [0.0, 0.5, -0.25],
            ..PLAIN
        });
        out.push(Fragment {
            v,
            n: v,
            dv_dx: [0.5 * sign(1), -0.25, 0.125],
            dn_dy: [3.0, -4.0 * sign(0), 1.0],
            dn_dx: [-7.0 * sign(2), 5.0, 1.0],
            ..full
        });
    }
    // Derivatives far above n, of either sign.
    let mut random = Random::new(77);
    for i in 0..40 {
        let scale = f64::from(1u32 << (i % 8));
        let by = |a: [f64; 3], s: f64| a.map(|x| s * x);
        let mut f = random.fragment();
        f.dn_dx = by(f.dn_dx, scale);
        f.dn_dy = by(f.dn_dy, scale);
        f.dv_dx = by(f.dv_dx, scale.min(6.0));
        f.dv_dy = by(f.dv_dy, scale.min(6.0));
        match i % 3 {
            0 => f.h = None,
            1 => {
                f.bump = Some([4.0 * random.signed(), 4.0 * random.signed()]);
            }
            _ => {
                f.bump = Some([random.signed(), random.signed()]);
                f.rough = Some(by(random.vector(), 0.5 * scale.min(16.0)));
            }
        }
        out.push(f);
    }
    out
}

/// An environment with texels beyond 1, so that colours reach the upper integer bits.
fn environment() -> CubeMap {
    let mut level = procedural(FACE);
    for texel in &mut level.texels {
        *texel = texel.map(|c| 8.0 * c);
    }
    build_mips(level)
}

/// One unit on all fragments, and the registers of each as a hash of values (not codes: a shorter
/// word that holds the same value is no change).
struct Bench {
    map: CubeMap,
    plain: Vec<Fragment>,
}

struct Run {
    hashes: Vec<u64>,
    flags: Vec<String>,
}

fn policies(spec: &UnitSpec) -> (String, String) {
    (
        format!("{:?}", spec.config.policy.roughness.interpolate),
        format!("{:?}", spec.config.policy.roughness.curvature),
    )
}

impl Bench {
    fn new() -> Self {
        Self { map: environment(), plain: corpus(&UnitSpec::default()) }
    }

    /// Hashes until `stop` says that the last one was enough; `None` for a unit that is refused.
    fn run(&self, spec: &UnitSpec, mut stop: impl FnMut(usize, u64) -> bool) -> Option<Run> {
        let special = policies(spec) != policies(&UnitSpec::default());
        let rebuilt = if special { corpus(spec) } else { Vec::new() };
        let fragments = if special { &rebuilt } else { &self.plain };
        let texture: Texture = encode::texture(&spec.config, &self.map).ok()?;
        let size = u32::try_from(FACE).unwrap();
        let mut units: Vec<(Needs, Unit)> = Vec::new();
        let mut run = Run { hashes: Vec::new(), flags: Vec::new() };
        let mut probe = RtlProbe::default();
        for (i, fragment) in fragments.iter().enumerate() {
            let needs = encode::needs(fragment);
            if !units.iter().any(|(n, _)| *n == needs) {
                units.push((needs, Unit::new(&spec.config, needs, size).ok()?));
            }
            let unit = units.iter().find(|(n, _)| *n == needs).map(|(_, u)| u)?;
            let out = rtl(unit, &spec.config, fragment, Some(&texture), &mut probe);
            let mut hash = DefaultHasher::new();
            for codes in &probe.registers {
                codes.len().hash(&mut hash);
                for code in codes {
                    let zeros = if code.raw == 0 { 0 } else { code.raw.trailing_zeros() };
                    let frac = if code.raw == 0 { 0 } else { code.frac - i64::from(zeros) };
                    (code.raw >> zeros, frac).hash(&mut hash);
                }
            }
            let hash = hash.finish();
            run.hashes.push(hash);
            for flag in out.flags {
                if !run.flags.contains(&flag) {
                    run.flags.push(flag);
                }
            }
            if stop(i, hash) {
                break;
            }
        }
        Some(run)
    }
}

impl Sight for Bench {
    type Seen = Run;

    fn enables(&self) -> &Enables {
        ENABLES
    }

    fn never_below(&self) -> &[Reg] {
        NEVER_BELOW
    }

    fn see(&self, spec: &UnitSpec) -> Option<Run> {
        self.run(spec, |_, _| false)
    }

    fn differs(&self, base: &Run, other: &UnitSpec) -> Option<bool> {
        let mut changed = false;
        self.run(other, |i, hash| {
            changed |= base.hashes.get(i) != Some(&hash);
            changed
        })?;
        Some(changed)
    }

    fn saturated(&self, seen: &Run, reg: Reg) -> bool {
        let info = reg.info();
        seen.flags.contains(&format!("{}.{}.saturated", info.stage, info.name))
    }
}

#[test]
fn no_knob_is_dead() {
    // `hit`, `ray_cone` and `tex` try those of rays, cones and 2-D textures, which no ENV fragment has.
    let others = [
        "cone.",
        "surface_footprint.",
        "registers.surface_footprint.",
        "address.wrap_",
        "hit.",
        "registers.hit.",
        // The model has no moments yet and refuses them, below; `tests/reference/moments.rs` has these knobs.
        "footprint.policy",
        "footprint.tau",
        "footprint.kappa",
    ];
    let refused = UnitSpec::default().with("footprint.policy=moments").unwrap();
    let error = Unit::new(&refused.config, Needs { bump: false, rough: false }, 32).unwrap_err();
    assert_eq!(error.path, "footprint.policy");
    let ours = |path: &str| !others.iter().any(|prefix| path.starts_with(prefix));
    assert_none_dead(&Bench::new(), ours, 247);
}

#[test]
fn registers_that_never_fall_below_their_range_are_signed_for_uniformity_only() {
    let bench = Bench::new();
    for reg in NEVER_BELOW {
        assert!(reg.info().kind == Kind::Fixed, "{reg:?}");
    }
    // The list is no way out: on the corpus those registers hold no code below −1.
    let spec = UnitSpec::default();
    let texture = encode::texture(&spec.config, &bench.map).unwrap();
    let mut probe = RtlProbe::default();
    for fragment in &bench.plain {
        let unit = Unit::new(&spec.config, encode::needs(fragment), 32).unwrap();
        rtl(&unit, &spec.config, fragment, Some(&texture), &mut probe);
        for reg in NEVER_BELOW {
            for code in probe.get(*reg) {
                assert!(code.value() >= -1.0, "{reg:?}: {}", code.value());
            }
        }
    }
}

//! Extremes of the TEX operation and of ray cones on the device.

use tapline::engine::gpu::check::{Requests, StageChecks, check_requests};
use tapline::fragment::{Tangents, TexFragment};
use tapline::gpu::Gpu;
use tapline::planar::{PlanarLevel, PlanarMap};
use tapline::policy::{ConeGradient, ConeRules, SetDiffuse, Wrap};
use tapline::reference::ray_cone::{Angle, Cone, Step, Width};
use tapline::settings::Settings;

use crate::checks::{assert_explained, compared, noise};
use support::gpu::on_gpu;

const UP: [f64; 3] = [0.0, 1.0, 0.0];
const S: [f64; 3] = [2.0, 0.0, 0.0];
const T: [f64; 3] = [0.0, 0.0, 2.0];

/// A texture of noise, 24 × 16 texels.
fn texture() -> PlanarMap {
    let levels = (0..5)
        .map(|level| {
            let size = [(24 >> level).max(1), (16 >> level).max(1)];
            let texels = (0..size[0] * size[1])
                .map(|i| [0, 1, 2].map(|c| noise(3 * i + c + level)))
                .collect();
            PlanarLevel { size, texels }
        })
        .collect();
    PlanarMap { levels }
}

fn request(d: [f64; 3], n: [f64; 3], dp_ds: [f64; 3], dp_dt: [f64; 3]) -> TexFragment {
    TexFragment { d, n, tangents: Tangents::Surface { dp_ds, dp_dt }, st: [0.3, 0.8] }
}

fn check(gpu: &Gpu, settings: &Settings, requests: &Requests, least: u64) -> StageChecks {
    let checks = check_requests(gpu, settings, &texture(), requests).expect("the device stays");
    assert_explained(&checks, least);
    checks
}

fn surfaces(cases: &[(TexFragment, f64)]) -> Requests {
    let numbered = (0u32..).zip(cases);
    Requests {
        surfaces: numbered.map(|(i, (fragment, width))| ([i, 0], *fragment, *width)).collect(),
        steps: Vec::new(),
    }
}

#[test]
fn extreme_d_parallel_to_n_across_it_and_zero_vectors() {
    on_gpu(|gpu| {
        let zero = [0.0; 3];
        let along = [0.0, -1.0, 0.0];
        let across = [1.0, 0.0, 0.0];
        let slant = [0.5, -1.0, 0.0];
        let cases: Vec<(TexFragment, f64)> = [
            request(along, UP, S, T),
            request(across, UP, S, T),
            request(zero, UP, S, T),
            request(along, zero, S, T),
            request(zero, zero, S, T),
            request(slant, UP, zero, T),
            request(slant, UP, S, [4.0, 0.0, 0.0]),
            request(slant, UP, zero, zero),
        ]
        .map(|fragment| (fragment, 0.25))
        .to_vec();
        let checks = check(gpu, &Settings::default(), &surfaces(&cases), 200);
        // The flags of all eight, exactly.
        assert_eq!(compared(&checks, "surface_footprint", "flags"), 8);
    });
}

#[test]
fn extreme_widths_of_0_of_either_sign_and_from_1e_minus_20_to_1e9() {
    on_gpu(|gpu| {
        let fragment = request([0.5, -1.0, 0.25], UP, S, T);
        let cases: Vec<(TexFragment, f64)> =
            [0.0, -0.0, -0.25, 1e-20, 1e-9, 1.0, 1e9].map(|width| (fragment, width)).to_vec();
        for rules in [ConeRules::Note, ConeRules::Otk] {
            let settings = Settings::default().with(|p| p.cone.rules = rules);
            check(gpu, &settings, &surfaces(&cases), 200);
        }
    });
}

#[test]
fn surfaces_and_triangles_have_every_register_compared_under_both_gradients_and_all_edges() {
    on_gpu(|gpu| {
        let mut next = 7usize;
        let mut number = || {
            next += 1;
            f64::from(noise(next)) - 0.5
        };
        let mut vector = || [number(), number(), number()];
        let mut cases = Vec::new();
        for i in 0..200 {
            let (d, n, a, b, c) = (vector(), vector(), vector(), vector(), vector());
            let tangents = if i % 2 == 0 {
                Tangents::Surface { dp_ds: a, dp_dt: b }
            } else {
                Tangents::Triangle { edges: [a, b], st: [[c[0], c[1]], [c[2], d[0]]] }
            };
            let st = [4.0 * c[0], 3.0 * c[1]];
            cases.push((TexFragment { d, n, tangents, st }, 0.02));
        }
        for gradient in [ConeGradient::Otk, ConeGradient::Gram] {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                let settings = Settings::default().with(|p| {
                    p.cone.gradient = gradient;
                    p.address.wrap_s = wrap;
                    p.address.wrap_t = wrap;
                });
                let checks = check(gpu, &settings, &surfaces(&cases), 10_000);
                for register in
                    ["across", "along", "dp_dx", "dp_dy", "grad_s", "grad_t", "ddx", "ddy", "d"]
                {
                    assert!(compared(&checks, "surface_footprint", register) >= 380, "{register}");
                }
                assert!(compared(&checks, "filter", "bilinear") >= 1000);
            }
        }
    });
}

/// Every step from every cone.
fn steps() -> Requests {
    let cone = |angle, width| Cone { angle: Angle(angle), width: Width(width) };
    let cones = [
        cone(0.0, 0.0),
        cone(-0.0, -0.0),
        cone(0.01, 0.5),
        cone(-0.01, -0.5),
        cone(0.01, -0.5),
        cone(-0.01, 0.5),
        cone(0.3, 2.0),
        cone(1e30, 1e30),
        cone(1e-30, 1e-30),
    ];
    let refract = |curvature, outside, inside| Step::Refract { curvature, outside, inside };
    let steps = [
        Step::Propagate(0.0),
        Step::Propagate(100.0),
        Step::Propagate(50.0),
        Step::Propagate(1e9),
        Step::Reflect(0.0),
        Step::Reflect(3.0),
        Step::Reflect(-3.0),
        refract(0.0, 1.0, 1.0),
        refract(2.0, 1.5, 1.5),
        refract(2.0, 1.0, 3.0),
        refract(-2.0, 3.0, 1.0),
        refract(1.0, 1.0, 1.0 / 3.0),
        Step::Scatter(0.0),
        Step::Scatter(0.25),
        Step::Scatter(10.0),
    ];
    let pairs = cones.iter().flat_map(|cone| steps.map(move |step| (*cone, step)));
    Requests {
        surfaces: Vec::new(),
        steps: (0u32..).zip(pairs).map(|(i, (cone, step))| ([i, 0], cone, step)).collect(),
    }
}

#[test]
fn extreme_cones_under_every_step_and_both_rules() {
    on_gpu(|gpu| {
        for (cone_rules, set_diffuse) in [
            (ConeRules::Note, SetDiffuse::Angle),
            (ConeRules::Otk, SetDiffuse::Angle),
            (ConeRules::Otk, SetDiffuse::Exchanged),
        ] {
            let settings = Settings::default().with(|p| {
                p.cone.rules = cone_rules;
                p.cone.set_diffuse = set_diffuse;
            });
            let checks = check(gpu, &settings, &steps(), 200);
            assert!(compared(&checks, "ray_cone", "cone") >= 240);
        }
    });
}

#[test]
fn extreme_a_cone_of_64_bounces_stays_finite_and_explained() {
    on_gpu(|gpu| {
        let mut cone = Cone { angle: Angle(0.001), width: Width(0.01) };
        let mut requests = Requests::default();
        let settings = Settings::default();
        for i in 0..64 {
            for step in [Step::Propagate(1.0), Step::Reflect(if i % 2 == 0 { 0.5 } else { -0.25 })]
            {
                requests.steps.push(([i, 0], cone, step));
                cone = tapline::reference::ray_cone::ray_cone(
                    cone,
                    step,
                    settings.policy.cone.rules,
                    settings.policy.cone.set_diffuse,
                );
            }
        }
        assert!(cone.width.0.is_finite());
        check(gpu, &settings, &requests, 100);
    });
}

//! Jumps of the colour where a continuous filter would have none: measured and printed.

use rtl_model::regs::Reg;
use support::reference::{PLAIN, Random, plain};
use support::rtl::{Traced, trace};
use tapline::conformance::extremes::straight;
use tapline::engine::encode;
use tapline::fragment::Fragment;
use tapline::unit::UnitSpec;

/// Largest difference of two colours.
fn jump(a: &Traced, b: &Traced) -> f64 {
    let (a, b) = (a.values(Reg::FilterColor), b.values(Reg::FilterColor));
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Fragments one unit in the last place apart on either side of what may be a jump.
fn crossings(random: &mut Random, kind: &str) -> (Fragment, Fragment) {
    let step = libm::ldexp(1.0, -21);
    let tilt = |f: Fragment| {
        // Away from the face's middle, so that texels differ along either axis.
        let v = [0.3, -0.2, 1.0];
        Fragment { v, n: v, ..f }
    };
    let inside = 0.9 * random.signed();
    match kind {
        "face seam" => {
            let at = |t: f64| Fragment {
                dv_dx: [0.02, 0.01, 0.0],
                dv_dy: [0.0, 0.03, 0.01],
                ..plain([1.0, inside, t])
            };
            (at(1.0 - step), at(1.0 + step))
        }
        "angle-table break" => {
            // A long thin ellipse at half a bin: 45°/32 off u.
            let turned = |angle: f64| {
                let (sin, cos) = (libm::sin(angle), libm::cos(angle));
                let length = 0.3 + 0.2 * inside;
                Fragment {
                    dv_dx: [0.5 * length * cos, 0.5 * length * sin, 0.0],
                    dv_dy: [-0.01 * sin, 0.01 * cos, 0.0],
                    ..PLAIN
                }
            };
            let half_bin = std::f64::consts::FRAC_PI_4 / 32.0;
            (tilt(turned(half_bin - 4.0 * step)), tilt(turned(half_bin + 4.0 * step)))
        }
        "lambda 1 = lambda 2" => {
            let at = |more: f64| Fragment {
                dv_dx: [0.05 + 0.02 * inside + more, 0.0, 0.0],
                dv_dy: [0.0, 0.05 + 0.02 * inside, 0.0],
                ..PLAIN
            };
            (at(-step), at(step))
        }
        _ => {
            // M/m at n + 2⁻⁸ with m = 4 texels of 128 a unit.
            let n = 1.0 + (7.0 * inside.abs()).floor();
            let at = |ulps: f64| {
                let length = 4.0 * (n + libm::ldexp(1.0, -8)) + ulps * libm::ldexp(1.0, -12);
                straight([[length / 128.0, 0.0], [0.0, 4.0 / 128.0]])
            };
            (at(0.0), at(1.0))
        }
    }
}

/// Prints the largest jumps of the colour across what a continuous filter would not notice: a finding
/// about the algorithm, for docs/accuracy.md. Nothing is asserted but that both sides differ in their
/// registers as intended.
#[test]
fn continuity_across_seams_breaks_and_counts_is_measured() {
    let spec = UnitSpec::default();
    let scene_map = tapline::mips::build_mips(tapline::scene::environment::procedural(256));
    let texture = encode::texture(&spec.config, &scene_map).expect("a texture");
    println!("| crossing | largest jump | mean jump | in 8-bit steps of the largest |");
    println!("|---|---|---|---|");
    for kind in ["face seam", "angle-table break", "lambda 1 = lambda 2", "count to count + 1"] {
        let mut random = Random::new(99);
        let (mut worst, mut sum, mut crossed) = (0.0f64, 0.0, 0u32);
        for _ in 0..200 {
            let (f, g) = crossings(&mut random, kind);
            let (a, b) =
                (trace(&spec, &f, 256, Some(&texture)), trace(&spec, &g, 256, Some(&texture)));
            let there = match kind {
                "face seam" => a.out.face != b.out.face,
                "count to count + 1" => a.out.probes != b.out.probes,
                _ => a.values(Reg::EigenAxis) != b.values(Reg::EigenAxis),
            };
            crossed += u32::from(there);
            worst = worst.max(jump(&a, &b));
            sum += jump(&a, &b);
        }
        assert!(crossed >= 100, "{kind}: only {crossed} of 200 crossed it");
        println!("| {kind} | {worst:.6} | {:.6} | {:.2} |", sum / 200.0, 255.0 * worst);
    }
}

//! Probe weights, edges and the filter of the float reference.
#![expect(clippy::float_cmp, reason = "what is exact by construction is compared exactly")]

use support::reference::{
    Draw, PLAIN, Random, Strict, map, noise, plain, smaller, symmetries, turned, turned_map,
};
use tapline::fragment::Fragment;
use tapline::policy::{Axis, Count, FootprintPolicy, Weights};
use tapline::reference::{NoTap, Prepared, Tap, Texture, env, ewa, ewa_counted, probe_weights};
use tapline::settings::Settings;
use tapline::stage::Stage;

fn gaussian(weight_bits: u32, end_points: bool) -> FootprintPolicy {
    let count = if end_points { Count::Feline } else { Count::Ceil };
    FootprintPolicy { count, weights: Weights::Gaussian, weight_bits, ..FootprintPolicy::default() }
}

#[test]
fn probe_weights_sum_to_the_power_of_two_and_fall_from_the_middle() {
    for end_points in [false, true] {
        for bits in 0..=20 {
            for count in 1..=64u32 {
                let weights = probe_weights(count, &gaussian(bits, end_points));
                assert_eq!(weights.len(), count as usize);
                let sum: u64 = weights.iter().map(|&w| u64::from(w)).sum();
                assert_eq!(sum, 1 << bits, "{count} probes, {bits} bits");
                let middle = (count as usize - 1) / 2;
                // Eight bits and more never need the other rounding for these counts.
                let error = if bits >= 8 { 0.5 } else { 1.0 };
                let half_line = f64::from(if end_points { (count - 1).max(1) } else { count });
                let bell = |i: usize| {
                    let x = (2.0 * i as f64 + 1.0 - f64::from(count)) / half_line;
                    libm::exp(-2.0 * x * x)
                };
                let total: f64 = (0..count as usize).map(bell).sum();
                for (i, &w) in weights.iter().enumerate() {
                    if i != middle {
                        let exact = bell(i) / total * f64::from(1u32 << bits);
                        assert!((f64::from(w) - exact).abs() <= error + 1e-9);
                        let mirrored = count as usize - 1 - i;
                        assert!(mirrored == middle || weights[mirrored] == w);
                    }
                }
            }
        }
    }
}

#[test]
fn probe_weights_of_a_few_counts_are_these() {
    assert_eq!(probe_weights(1, &gaussian(8, false)), [256]);
    assert_eq!(probe_weights(2, &gaussian(8, false)), [128, 128]);
    // e^(−8/9) = 0.41111: 57.75, 140.49, 57.75 of 256 → 58, 140, 58.
    assert_eq!(probe_weights(3, &gaussian(8, false)), [58, 140, 58]);
    // With end points x = ±1: e^−2 = 0.13534: 27.27, 201.47, 27.27 → 27, 201, 27 and 1 left over.
    assert_eq!(probe_weights(3, &gaussian(8, true)), [27, 202, 27]);
    // The residue goes to the lower of two middle probes: 30.8, 97.2 → … of 2^1: 0, 1, 1, 0.
    assert_eq!(probe_weights(16, &gaussian(1, false))[7], 2);
}

#[test]
fn bell_weights_are_symmetric_and_sum_to_the_power_of_two() {
    for weight_bits in 1..=12 {
        for count in 1..=64u32 {
            let plain = FootprintPolicy::default();
            let policy = FootprintPolicy { weights: Weights::Bell, weight_bits, ..plain };
            let weights = probe_weights(count, &policy);
            assert!(weights.iter().eq(weights.iter().rev()), "{count} probes, {weight_bits} bits");
            assert_eq!(weights.iter().sum::<u32>(), 1 << weight_bits);
        }
    }
    let policy = FootprintPolicy { weights: Weights::Bell, ..FootprintPolicy::default() };
    assert_eq!(probe_weights(2, &policy), [128, 128]);
    // e^(−4/9) = 0.64118: 71.93, 112.15, 71.93 of 256.
    assert_eq!(probe_weights(3, &policy), [72, 112, 72]);
}

#[test]
fn a_footprint_inside_a_face_of_a_ramp_has_the_value_of_its_centre() {
    // Texels rise by 1 per column: every mip level and every symmetric line of probes keeps the ramp.
    let size = 64;
    let cube =
        map(size, |_, x, y| [x, y, x + 2 * y].map(|t| u8::try_from(t).map_or(0.0, f32::from)));
    let texture = Texture::new(&cube);
    let mut random = Random::new(21);
    let mut several = 0;
    for case in 0..2000 {
        let settings = Settings::default().with(|p| {
            p.footprint.count = Count::ALL[case % 4];
            p.footprint.weights = Weights::ALL[case / 4 % 2];
            p.footprint.axis = [Axis::EigenExact, Axis::LongerDerivative][case / 8 % 2];
        });
        let weights_are_symmetric = settings.policy.footprint.weights == Weights::Box;
        let mut f = plain([0.2 * random.signed(), 0.2 * random.signed(), 1.0]);
        f.dv_dx = random.vector().map(|x| 0.05 * x);
        f.dv_dy = random.vector().map(|x| 0.005 * x);
        let out = env(&Prepared::new(&settings), &f, size, Some(&texture), &mut NoTap);
        // With |u|, |v| ≤ 0.2, λ1 ≤ 0.3 and levels up to 8 texels (¼ of a face) wide all taps are inside.
        assert!(out.lambda[0] < 0.3 && out.lod < 3.0 && out.face == 4);
        several += usize::from(out.probes > 1);
        let [x, y] = [out.u, out.v].map(|u| (u + 1.0) * 32.0 - 0.5);
        // Values below 256; at most 16 probes of 12 roundings each. Integer weights of an even number of
        // probes may put a residue on one of the two middle probes: 8 of 256 at most (½ each), times
        // half a spacing (λ1·32/4 texels at most 2.4), times 3 for the third channel.
        let bound = if weights_are_symmetric { 0.0 } else { 8.0 / 256.0 * 2.4 * 3.0 };
        for (got, want) in out.color.into_iter().zip([x, y, x + 2.0 * y]) {
            assert!((got - want).abs() <= bound + 256.0 * 192.0 * f64::EPSILON, "{got} {want}");
        }
    }
    assert!(several > 500, "{several}");
}

#[test]
fn the_cubes_48_symmetries_turn_fragments_maps_and_colors_alike() {
    let size = 16;
    let cube = noise(size, 22);
    let mut random = Random::new(23);
    let fragments: Vec<_> = (0..40).map(|_| smaller(&random.fragment(), 0.05)).collect();
    let prepared = Prepared::new(&Settings::default());
    let texture = Texture::new(&cube);
    let mut several = 0;
    for matrix in symmetries() {
        let turned_map = turned_map(&cube, &matrix);
        let turned_texture = Texture::new(&turned_map);
        for f in &fragments {
            let g = turned(f, &matrix);
            let a = env(&prepared, f, size, Some(&texture), &mut NoTap);
            let b = env(&prepared, &g, size, Some(&turned_texture), &mut NoTap);
            several += usize::from(a.probes > 1);
            assert_eq!(a.probes, b.probes);
            // Sums are added in another order: some 2⁶ roundings of terms below 2⁶ in D (as D ≤ 2⁶ here),
            // relative to the texel (size/2 per unit, values and slopes ≤ 1 and ≤ size): 2⁻³⁴.
            for (a, b) in a.color.into_iter().zip(b.color) {
                assert!((a - b).abs() <= 2f64.powi(-34), "{a} {b} {matrix:?} {f:?}");
            }
            assert!((a.lambda[0] - b.lambda[0]).abs() <= 2f64.powi(-41));
            let mean = ewa(&a, &texture);
            let turned = ewa(&b, &turned_texture);
            for (a, b) in mean.into_iter().zip(turned) {
                // At most 2¹² points here; a point at the cut counts for at most e^(−4.5) of the middle and
                // enters or leaves only within rounding of it, which this seed does not meet.
                assert!((a - b).abs() <= 2f64.powi(-34));
            }
        }
    }
    assert!(several > 100);
}

#[test]
fn extreme_one_ulp_to_each_side_of_edges_and_corners_changes_face_and_not_color() {
    // A map that is continuous across the seams: the direction itself.
    let cube = map(8, |face, x, y| {
        let [u, v] = [x, y].map(|t| (t as f64 + 0.5) / 4.0 - 1.0);
        let d = tapline::cube::direction(face, u, v);
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        #[expect(clippy::cast_possible_truncation, reason = "texels are floats")]
        d.map(|x| (x / length) as f32)
    });
    let texture = Texture::new(&cube);
    let prepared = Prepared::new(&Settings::default());
    let above = 1.0 + f64::EPSILON;
    let below = 1.0 - f64::EPSILON / 2.0;
    for (v, faces) in
        [([1.0, 0.25, 1.0], [4, 0, 4]), ([1.0, 1.0, 0.25], [2, 0, 2]), ([1.0, 1.0, 1.0], [4, 0, 4])]
    {
        let mut colors = vec![];
        for (x, face) in [(1.0, faces[0]), (above, faces[1]), (below, faces[2])] {
            let v = [x, v[1], v[2]];
            let f = Fragment { v, n: v, ..PLAIN };
            let out = env(&prepared, &f, 8, Some(&texture), &mut NoTap);
            assert_eq!(out.face, face, "{v:?}");
            colors.push(out.color);
        }
        for color in &colors {
            for (a, b) in color.iter().zip(&colors[0]) {
                // (u, v) moves by 2 ulp at most, 8/2 texels per unit, texel steps below 1 in value; the
                // taps on both sides are the same texels, mixed in another order: 16 roundings.
                assert!((a - b).abs() <= 16.0 * f64::EPSILON, "{v:?}: {colors:?}");
            }
        }
    }
}

#[test]
fn extreme_a_probe_line_over_two_edges_wraps_round_the_cube() {
    struct Line(Vec<f64>);
    impl Tap for Line {
        fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
            if stage == Stage::Address && register == "u" {
                assert_eq!(component, self.0.len());
                self.0.push(value);
            }
        }
        fn event(&mut self, _: &'static str) {}
    }
    // Texels hold their face's number; a line 8 units long has probes on −x, +z and +x.
    let cube = map(4, |face, _, _| [u8::try_from(face).map_or(0.0, f32::from); 3]);
    let texture = Texture::new(&cube);
    let prepared = Prepared::new(&Settings::default().with(|p| p.footprint.max_probes = 16));
    let f = Fragment { dn_dx: [4.0, 0.0, 0.0], ..PLAIN };
    let mut tap = Line(vec![]);
    let out = env(&prepared, &f, 4, Some(&texture), &mut tap);
    assert_eq!((out.lambda[0], out.probes), (8.0, 16));
    let want: Vec<_> = (0..16).map(|i| f64::from(i) * 0.5 - 3.75).collect();
    assert_eq!(tap.0, want);
    // The same look-ups by direction: (u, 0, 1) is −x, +z or +x. Sums of 16 values below 5: 16 roundings.
    let mean = (0..16).map(|i| {
        let u = f64::from(i) * 0.5 - 3.75;
        let (face, s, t) = tapline::cube::face_uv([u, 0.0, 1.0]);
        texture.bilinear(0, tapline::reference::address::Address { face, u: s, v: -t })[0]
    });
    let mean = mean.sum::<f64>() / 16.0;
    assert!((out.color[0] - mean).abs() <= 16.0 * f64::EPSILON * 5.0, "{} {mean}", out.color[0]);
}

#[test]
fn extreme_faces_of_one_texel_and_of_sizes_that_are_no_power_of_two_are_filtered() {
    let mut random = Random::new(15);
    for size in [1usize, 3, 5, 6, 7, 12] {
        let cube = map(size, |_, _, _| [0.25, 0.5, 0.125]);
        let texture = Texture::new(&cube);
        let prepared = Prepared::new(&Settings::default());
        for _ in 0..100 {
            let f = random.fragment();
            let out = env(&prepared, &f, size, Some(&texture), &mut Strict);
            assert_eq!(out.color, [0.25, 0.5, 0.125]);
            assert!(out.lod <= f64::from(size.ilog2()));
        }
    }
}

#[test]
fn extreme_texels_at_the_ends_of_half_floats_pass_exactly() {
    for value in [65504.0f32, 5.960_464_5e-8, -65504.0, -1.0] {
        for weights in [Weights::Box, Weights::Gaussian] {
            let cube = map(8, |_, _, _| [value; 3]);
            let texture = Texture::new(&cube);
            let prepared =
                Prepared::new(&Settings::default().with(|p| p.footprint.weights = weights));
            let mut random = Random::new(16);
            for _ in 0..50 {
                let out = env(&prepared, &random.fragment(), 8, Some(&texture), &mut NoTap);
                assert_eq!(out.color, [f64::from(value); 3]);
            }
        }
    }
}

#[test]
#[ignore = "a measurement, not a test: run with --ignored --nocapture"]
fn speed_of_the_filter_path() {
    let cube = noise(256, 31);
    let texture = Texture::new(&cube);
    let prepared = Prepared::new(&Settings::default());
    let mut random = Random::new(32);
    for (name, rough) in [("plain", false), ("rough", true)] {
        // A mirror sphere that fills a picture of 316 × 316 pixels, row by row.
        let mut fragments = vec![];
        for y in 0..316 {
            for x in 0..316 {
                let [x, y] = [x, y].map(|t| (f64::from(t) - 157.5) / 160.0);
                let z = 1.0 - x * x - y * y;
                if z <= 0.0 {
                    continue;
                }
                let z = z.sqrt();
                let mut f = plain([-x, -y, 4.0]);
                f.n = [x, y, z];
                f.dv_dx = [-1.0 / 160.0, 0.0, 0.0];
                f.dv_dy = [0.0, -1.0 / 160.0, 0.0];
                f.dn_dx = [1.0 / 160.0, 0.0, -x / z / 160.0];
                f.dn_dy = [0.0, 1.0 / 160.0, -y / z / 160.0];
                f.h = Some([0.0, 1.0, 0.0]);
                if rough {
                    f.bump = Some([0.1 * random.signed(), 0.1 * random.signed()]);
                    f.rough = Some([0.05, 0.01, 0.02]);
                }
                fragments.push(f);
            }
        }
        let count = fragments.len() as f64;
        let nanoseconds = |start: std::time::Instant| start.elapsed().as_secs_f64() * 1e9 / count;
        let start = std::time::Instant::now();
        let probes: f64 = fragments
            .iter()
            .map(|f| env(&prepared, f, 256, Some(&texture), &mut NoTap))
            .map(|out| f64::from(out.probes) + 1e-300 * out.color[0])
            .sum();
        let whole = nanoseconds(start);
        let start = std::time::Instant::now();
        let level: f64 =
            fragments.iter().map(|f| env(&prepared, f, 256, None, &mut NoTap).lod).sum();
        let front = nanoseconds(start);
        let outs: Vec<_> =
            fragments.iter().map(|f| env(&prepared, f, 256, None, &mut NoTap)).collect();
        let start = std::time::Instant::now();
        let points: u64 = outs.iter().map(|out| ewa_counted(out, &texture).points).sum();
        let elliptical = nanoseconds(start);
        eprintln!(
            "{name}: {whole:.0} ns a fragment, {front:.0} without texture; {:.2} probes, LOD {:.2}; \
             ewa {elliptical:.0} ns, {:.0} points",
            probes / count,
            level / count,
            points as f64 / count
        );
    }
}

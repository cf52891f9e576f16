//! Extremes of what the ENV operation reads on the device: faces, edges, corners, sizes and texels.

use crate::checks::{PLAIN, noisy_cube};
use crate::extremes::{agree, bent, extreme, run};
use support::gpu::on_gpu;
use tapline::fragment::Fragment;
use tapline::settings::Settings;

/// A fragment that looks along a direction.
fn looking(to: [f64; 3]) -> Fragment {
    // n = 2v reflects v onto itself: v_r = 4v⟨v,v⟩.
    Fragment {
        v: to,
        n: to,
        dv_dx: [0.0009765625, 0.0, 0.0],
        dv_dy: [0.0, 0.0009765625, 0.0],
        ..PLAIN
    }
}

#[test]
fn extreme_equal_largest_components() {
    let fragments: Vec<Fragment> =
        [[1.0, 1.0, 1.0], [-1.0, 1.0, 0.5], [1.0, -0.5, -1.0], [0.25, 1.0, -1.0]]
            .map(looking)
            .to_vec();
    extreme(&fragments);
}

#[test]
fn extreme_cube_corner_and_edge_exactly_and_one_ulp_to_each_side() {
    let ulp = f64::from(f32::EPSILON);
    let near = [1.0 - ulp, 1.0, 1.0 + ulp];
    let fragments: Vec<Fragment> = near
        .iter()
        .flat_map(|a| {
            near.map(|b| {
                [looking([1.0, *a, b]), looking([1.0, *a, 0.25]), looking([0.25, -1.0, b])]
            })
        })
        .flatten()
        .collect();
    extreme(&fragments);
}

#[test]
fn extreme_a_probe_line_over_two_edges_keeps_a_constant() {
    on_gpu(|gpu| {
        let mut map = noisy_cube(16);
        for level in &mut map.levels {
            level.texels.fill([0.75, 0.5, 0.25]);
        }
        let fragments = [bent([1.5, 1.5, 0.0], [0.0; 3]), bent([4.0, -4.0, 0.0], [0.0; 3])];
        let both = run(gpu, &Settings::default(), &map, &fragments);
        agree(&both, 0.05);
        for b in &both {
            assert_eq!(b.gpu.color, [0.75, 0.5, 0.25], "to the bit");
            assert_eq!(b.gpu.probes, 16);
        }
    });
}

#[test]
fn extreme_faces_of_one_texel_and_of_sizes_that_are_no_power_of_two() {
    on_gpu(|gpu| {
        for size in [1, 3, 6, 17] {
            let fragments: Vec<Fragment> = [[0.1, 0.2, 1.0], [1.0, 1.0, 1.0], [-1.0, 0.9, 0.95]]
                .map(|to| Fragment { dn_dx: [0.125, 0.0625, 0.0], ..looking(to) })
                .to_vec();
            agree(&run(gpu, &Settings::default(), &noisy_cube(size), &fragments), 0.05);
        }
    });
}

#[test]
fn extreme_texels_of_65504_and_2_to_the_minus_24() {
    on_gpu(|gpu| {
        let mut map = noisy_cube(8);
        for level in &mut map.levels {
            for (i, texel) in level.texels.iter_mut().enumerate() {
                let least = 1.0 / 16_777_216.0;
                *texel = [[65504.0, least, 0.0], [least, 65504.0, 65504.0]][i % 2];
            }
        }
        let fragments =
            [bent([0.125, 0.0625, 0.0], [0.0, 0.03125, 0.0]), looking([1.0, 0.9, 0.99])];
        let both = run(gpu, &Settings::default(), &map, &fragments);
        agree(&both, 65504.0 * 0.05);
    });
}

//! The cube's 48 rotations and reflections.

use rtl_model::regs::Reg;
use tapline::cube::{direction, face_uv};
use tapline::engine::encode;
use tapline::fragment::Fragment;
use tapline::unit::UnitSpec;

use crate::reference_support::{Random, apply, map, symmetries};
use crate::rtl_support::trace;

/// Turning the fragment and the map together changes no bit: roundings half to even are odd functions, `|ma|` has no sign, the
/// angle table is symmetric, and mirrored texel coordinates add up to N − 1, an even number of their LSB. What is left
/// of the choice of face on equal magnitudes does not occur at random.
#[test]
fn the_cubes_48_symmetries_change_no_bit_of_the_colour() {
    let spec = UnitSpec::default();
    let size = 16;
    let half = size as f64 / 2.0;
    let mut random = Random::new(41);
    let cube = map(size, |face, x, y| {
        [face, x, y].map(|i| (i * 7 % 16) as f32 / 16.0)
    });
    let fragments: Vec<Fragment> = (0..60)
        .map(|_| {
            let f = random.fragment();
            let small = |d: [f64; 3]| d.map(|x| x * 0.05);
            Fragment {
                dv_dx: small(f.dv_dx),
                dv_dy: small(f.dv_dy),
                dn_dx: small(f.dn_dx),
                dn_dy: small(f.dn_dy),
                h: None,
                ..f
            }
        })
        .collect();
    let texture = encode::texture(&spec.config, &cube).unwrap();
    let (mut several, mut worst) = (0, 0);
    for matrix in symmetries() {
        let inverse: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]));
        let turned = map(size, |face, x, y| {
            let [u, v] = [x, y].map(|t| (t as f64 + 0.5) / half - 1.0);
            let (face, u, v) = face_uv(apply(&inverse, direction(face, u, v)));
            let [x, y] = [u, v].map(|u| ((u + 1.0) * half) as usize);
            cube.levels[0].texel(face, x, y)
        });
        let turned = encode::texture(&spec.config, &turned).unwrap();
        for f in &fragments {
            let g = Fragment {
                v: apply(&matrix, f.v),
                n: apply(&matrix, f.n),
                dv_dx: apply(&matrix, f.dv_dx),
                dv_dy: apply(&matrix, f.dv_dy),
                dn_dx: apply(&matrix, f.dn_dx),
                dn_dy: apply(&matrix, f.dn_dy),
                ..*f
            };
            let a = trace(&spec, f, size as u32, Some(&texture));
            let b = trace(&spec, &g, size as u32, Some(&turned));
            several += u32::from(a.out.probes > 1);
            let (a, b) = (a.raw(Reg::FilterColor), b.raw(Reg::FilterColor));
            worst = a
                .iter()
                .zip(&b)
                .map(|(a, b)| (a - b).abs())
                .fold(worst, i64::max);
        }
    }
    println!("largest difference: {worst} LSB of 2^-24");
    assert_eq!(worst, 0);
    assert!(several > 500, "{several}");
}

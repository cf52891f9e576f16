//! The cube's 48 rotations and reflections.

use rtl_model::regs::Reg;
use tapline::engine::encode;
use tapline::fragment::Fragment;
use tapline::unit::UnitSpec;

use support::reference::{Draw, Random, map, smaller, symmetries, turned, turned_map};
use support::rtl::trace;

/// Turning the fragment and the map together changes no bit: roundings half to even are odd functions, `|ma|` has no sign, the
/// angle table is symmetric, and mirrored texel coordinates add up to N − 1, an even number of their LSB. What is left
/// of the choice of face on equal magnitudes does not occur at random.
#[test]
fn the_cubes_48_symmetries_change_no_bit_of_the_colour() {
    let spec = UnitSpec::default();
    let size = 16;
    let mut random = Random::new(41);
    let cube = map(size, |face, x, y| [face, x, y].map(|i| (i * 7 % 16) as f32 / 16.0));
    let fragments: Vec<Fragment> =
        (0..60).map(|_| Fragment { h: None, ..smaller(&random.fragment(), 0.05) }).collect();
    let texture = encode::texture(&spec.config, &cube).unwrap();
    let (mut several, mut worst) = (0, 0);
    for matrix in symmetries() {
        let turned_texture = encode::texture(&spec.config, &turned_map(&cube, &matrix)).unwrap();
        for f in &fragments {
            let g = turned(f, &matrix);
            let a = trace(&spec, f, size as u32, Some(&texture));
            let b = trace(&spec, &g, size as u32, Some(&turned_texture));
            several += u32::from(a.out.probes > 1);
            let (a, b) = (a.raw(Reg::FilterColor), b.raw(Reg::FilterColor));
            worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(worst, i64::max);
        }
    }
    println!("largest difference: {worst} LSB of 2^-24");
    assert_eq!(worst, 0);
    assert!(several > 500, "{several}");
}

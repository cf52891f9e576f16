//! Borders of the textures against the definition of a texel beyond an edge.

use rtl_model::texture::Texels;
use rtl_model::{Config, TexelFormat};
use support::model::Rng;

use super::{any_texel, build, chain, texel};

#[test]
fn borders_repeat_the_neighbours_and_corners_hold_the_mean_of_three() {
    let mut rng = Rng(21);
    for (format, int, frac) in [
        (TexelFormat::Half, 17, 24),
        (TexelFormat::Half, 12, 20),
        (TexelFormat::Q, 17, 24),
        (TexelFormat::Unorm8, 1, 12),
        (TexelFormat::Rgb9e5, 17, 24),
    ] {
        let config = Config::default().with(|p| {
            p.texel.format = format;
            p.texel.int = int;
            p.texel.frac = frac;
        });
        for size in [1, 2, 3, 5, 8] {
            let levels = vec![chain(&mut rng, size, any_texel).remove(0)];
            let texture = build(&config, &levels);
            let wide = texture.widened();
            let Texels::Wide(texels) = &wide.texels else { panic!("widened texels are wide") };
            let n = i64::try_from(size).expect("small");
            for face in 0..6 {
                for y in -1..=n {
                    for x in -1..=n {
                        let place = |t: i64| usize::try_from(t + 1).expect("not negative");
                        let at = wide.levels[0].index(face, place(x), place(y));
                        let [r, g, b, rest] = texels[at];
                        let want = texel(&config, &levels[0], face, x, y);
                        assert_eq!([r, g, b], want, "{format:?} {size} face {face} ({x}, {y})");
                        assert_eq!(rest, 0);
                    }
                }
            }
        }
    }
}

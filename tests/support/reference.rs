//! What the tests of the float reference share: fragments at random, maps, and a plain independent
//! evaluation of the reflected look-up.

pub use tapline::base::random::Random;
pub use tapline::conformance::extremes::PLAIN;
use tapline::cube::{CubeLevel, CubeMap, FACE_AXES, direction, face_uv};
use tapline::fragment::Fragment;
use tapline::reference::{Env, Tap};
use tapline::stage::Stage;

/// What tests draw at random.
pub trait Draw {
    /// A vector of length 0.5 … √3.
    fn direction(&mut self) -> [f64; 3];
    /// A fragment with terms of order one, n and v not near grazing.
    fn fragment(&mut self) -> Fragment;
    /// A rotation.
    fn rotation(&mut self) -> [[f64; 3]; 3];
}

impl Draw for Random {
    fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = self.vector();
            if dot(v, v) > 0.25 {
                return v;
            }
        }
    }

    fn fragment(&mut self) -> Fragment {
        loop {
            let (v, n, h) = (self.direction(), self.direction(), self.direction());
            let c = cross(h, n);
            if dot(v, n).abs() < 0.1 || dot(c, c) < 0.05 {
                continue;
            }
            return Fragment {
                v,
                n,
                dv_dx: self.vector(),
                dv_dy: self.vector(),
                dn_dx: self.vector(),
                dn_dy: self.vector(),
                h: Some(h),
                bump: None,
                rough: None,
            };
        }
    }

    fn rotation(&mut self) -> [[f64; 3]; 3] {
        let a = unit(self.direction());
        let b = unit(cross(a, self.direction()));
        [a, b, cross(a, b)]
    }
}

/// The inner product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// s times a vector.
pub fn scaled(s: f64, a: [f64; 3]) -> [f64; 3] {
    a.map(|x| s * x)
}

/// The sum of two vectors.
pub fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// A vector of length 1 along another.
pub fn unit(a: [f64; 3]) -> [f64; 3] {
    scaled(1.0 / dot(a, a).sqrt(), a)
}

/// A matrix times a vector.
pub fn apply(matrix: &[[f64; 3]; 3], a: [f64; 3]) -> [f64; 3] {
    [dot(matrix[0], a), dot(matrix[1], a), dot(matrix[2], a)]
}

/// (u, v) of a direction in the plane of a given face.
pub fn project(face: usize, d: [f64; 3]) -> [f64; 2] {
    let [s, t, m] = FACE_AXES[face].map(|(axis, sign)| sign * d[axis]);
    [s / m, t / m]
}

/// The mirror direction of v about n.
pub fn mirror(v: [f64; 3], n: [f64; 3]) -> [f64; 3] {
    sum(scaled(2.0 * dot(n, v) / dot(n, n), n), scaled(-1.0, v))
}

/// e1 and e2 as long as n.
pub fn frame(n: [f64; 3], h: [f64; 3]) -> [[f64; 3]; 2] {
    let c = unit(cross(h, n));
    [scaled(dot(n, n).sqrt(), c), cross(n, c)]
}

/// A cube map whose level-0 texels come from a function of face, column and row, with box-filtered mips.
pub fn map(size: usize, texel: impl Fn(usize, usize, usize) -> [f32; 3]) -> CubeMap {
    let mut texels = Vec::new();
    for face in 0..6 {
        for y in 0..size {
            for x in 0..size {
                texels.push(texel(face, x, y));
            }
        }
    }
    let mut levels = vec![CubeLevel { size, texels }];
    while levels[levels.len() - 1].size > 1 {
        let below = &levels[levels.len() - 1];
        let size = (below.size / 2).max(1);
        let mut texels = Vec::new();
        for face in 0..6 {
            for y in 0..size {
                for x in 0..size {
                    let four = [(0, 0), (1, 0), (0, 1), (1, 1)]
                        .map(|(i, j)| below.texel(face, 2 * x + i, 2 * y + j));
                    texels.push(std::array::from_fn(|c| {
                        four.iter().map(|t| t[c]).sum::<f32>() / 4.0
                    }));
                }
            }
        }
        levels.push(CubeLevel { size, texels });
    }
    CubeMap { levels }
}

/// A fragment with v = n and nothing else.
pub fn plain(v: [f64; 3]) -> Fragment {
    Fragment { v, n: v, ..PLAIN }
}

/// A map of random texels in 0…1, multiples of 1/256: sums of four halve exactly in floats.
pub fn noise(size: usize, seed: u64) -> CubeMap {
    let mut random = Random::new(seed);
    let texels: Vec<[f32; 3]> = (0..6 * size * size)
        .map(|_| {
            #[expect(clippy::cast_possible_truncation, reason = "texels are floats")]
            random.vector().map(|x| (x * 128.0 + 128.0).floor() as f32 / 256.0)
        })
        .collect();
    map(size, |face, x, y| texels[(face * size + y) * size + x])
}

/// Fails on a value that is not finite, and on −0.
pub struct Strict;

impl Tap for Strict {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        let bits = value.to_bits();
        assert!(
            value.is_finite() && bits != (-0.0f64).to_bits(),
            "{stage:?} {register} {component}: {value}"
        );
    }

    fn event(&mut self, _: &'static str) {}
}

/// Fails on a result that is not finite or leaves its range.
pub fn assert_finite(out: &Env) {
    let values = [out.u, out.v, out.lod]
        .into_iter()
        .chain(out.d.as_flattened().iter().copied())
        .chain(out.k)
        .chain(out.lambda)
        .chain(out.axis)
        .chain(out.color);
    for value in values {
        assert!(value.is_finite(), "{out:?}");
    }
    assert!(out.u.abs() <= 1.0 && out.v.abs() <= 1.0 && out.face < 6, "{out:?}");
    assert!(out.probes >= 1 && out.lod >= 0.0, "{out:?}");
    assert!(out.lambda[0] >= 0.0 && out.lambda[1] >= 0.0, "{out:?}");
}

/// The 48 signed permutations of the axes.
pub fn symmetries() -> Vec<[[f64; 3]; 3]> {
    let mut all = vec![];
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for signs in 0..8u32 {
            let mut matrix = [[0.0; 3]; 3];
            for (row, axis) in order.into_iter().enumerate() {
                matrix[row][axis] = if signs >> row & 1 == 1 { -1.0 } else { 1.0 };
            }
            all.push(matrix);
        }
    }
    all
}

/// A fragment whose derivatives are scaled.
pub fn smaller(f: &Fragment, scale: f64) -> Fragment {
    Fragment {
        dv_dx: scaled(scale, f.dv_dx),
        dv_dy: scaled(scale, f.dv_dy),
        dn_dx: scaled(scale, f.dn_dx),
        dn_dy: scaled(scale, f.dn_dy),
        ..*f
    }
}

/// A fragment turned by a symmetry of the cube.
pub fn turned(f: &Fragment, matrix: &[[f64; 3]; 3]) -> Fragment {
    Fragment {
        v: apply(matrix, f.v),
        n: apply(matrix, f.n),
        dv_dx: apply(matrix, f.dv_dx),
        dv_dy: apply(matrix, f.dv_dy),
        dn_dx: apply(matrix, f.dn_dx),
        dn_dy: apply(matrix, f.dn_dy),
        ..*f
    }
}

/// The map of `cube`'s level 0 turned by a symmetry of the cube, with its own mips.
pub fn turned_map(cube: &CubeMap, matrix: &[[f64; 3]; 3]) -> CubeMap {
    let half = cube.size() as f64 / 2.0;
    let inverse: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]));
    map(cube.size(), |face, x, y| {
        let [u, v] = [x, y].map(|t| (t as f64 + 0.5) / half - 1.0);
        let (face, u, v) = face_uv(apply(&inverse, direction(face, u, v)));
        let [x, y] = [u, v].map(|u| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a texel's index"
            )]
            let index = ((u + 1.0) * half) as usize;
            index
        });
        cube.levels[0].texel(face, x, y)
    })
}

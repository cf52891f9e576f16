//! The tree against every triangle tried in turn; edges without gaps; derivatives.
#![expect(
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "small indices; where bits must be equal, that is what is tested"
)]

use glam::{DVec3, dvec3};
use proptest::prelude::*;
use tapline::base::dual::Dual;
use tapline::mesh::{Corner, Mesh, Soup, meet};

/// A soup of separate triangles.
fn soup(corners: &[[f64; 3]]) -> Soup {
    let corner = |i: usize| Corner { position: i as u32, normal: None, texcoord: None };
    Soup {
        positions: corners.to_vec(),
        triangles: (0..corners.len() / 3)
            .map(|t| [corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)])
            .collect(),
        ..Soup::default()
    }
}

fn brute(mesh: &Mesh, o: [f64; 3], d: [f64; 3]) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for (i, triangle) in mesh.triangles().iter().enumerate() {
        if let Some(b) = meet(triangle, o, d)
            && b.distance > 0.0
            && best.is_none_or(|(t, _)| b.distance < t)
        {
            best = Some((b.distance, i));
        }
    }
    best.map(|(_, i)| i)
}

/// Coordinates on a coarse grid, so that rays run along sides, edges and corners and triangles coincide.
fn coarse() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3((-4i8..=4).prop_map(|c| f64::from(c) / 4.0))
}

fn fine() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-1.0f64..1.0)
}

proptest! {
    #[test]
    fn the_tree_finds_what_trying_every_triangle_finds(
        corners in prop::collection::vec(prop_oneof![coarse(), fine()], 9..120),
        rays in prop::collection::vec((prop_oneof![coarse(), fine()], prop_oneof![coarse(), fine()]), 40),
    ) {
        let Ok((mesh, _)) = Mesh::new(&soup(&corners), "random", DVec3::ZERO, 1.0) else { return Ok(()) };
        for (o, d) in rays {
            if d != [0.0; 3] {
                prop_assert_eq!(mesh.nearest(o.into(), d.into(), 0.0), brute(&mesh, o, d));
            }
        }
    }
}

/// A ball of `n` times 2n quads, each cut in two; closed, as rows share their corners' bits.
fn ball(n: usize) -> Soup {
    let at = |i: usize, j: usize| {
        let (a, b) = (
            i as f64 / n as f64 * std::f64::consts::PI,
            (j % (2 * n)) as f64 / n as f64 * std::f64::consts::PI,
        );
        if i == 0 || i == n {
            return [0.0, libm::cos(a).signum(), 0.0];
        }
        [libm::sin(a) * libm::sin(b), libm::cos(a), libm::sin(a) * libm::cos(b)]
    };
    let mut corners = Vec::new();
    for i in 0..n {
        for j in 0..2 * n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if i + 1 < n {
                corners.extend([a, b, c]);
            }
            if i > 0 {
                corners.extend([a, c, d]);
            }
        }
    }
    soup(&corners)
}

#[test]
fn no_ray_slips_through_an_edge_or_a_corner_of_a_closed_mesh() {
    let (mesh, repairs) = Mesh::new(&ball(8), "ball", DVec3::ZERO, 1.0).unwrap();
    assert_eq!(repairs.degenerate, 0);
    let mut tried = 0;
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.positions;
        for origin in [DVec3::ZERO, dvec3(0.1, -0.2, 0.3), dvec3(0.5, 0.5, -0.25)] {
            for (k, l) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.0), (0.3, 0.7), (0.0, 0.123), (0.2, 0.3)]
            {
                let d = a * (1.0 - k - l) + b * k + c * l - origin;
                assert!(mesh.nearest(origin, d, 0.0).is_some(), "{origin:?} {d:?}");
                tried += 1;
            }
        }
    }
    assert!(tried > 4000);
}

#[test]
fn computed_normals_of_a_ball_point_outwards_within_a_cell() {
    let (mesh, repairs) = Mesh::new(&ball(24), "ball", DVec3::ZERO, 1.0).unwrap();
    assert_eq!(repairs.normals_computed, 3 * mesh.triangles().len());
    for triangle in mesh.triangles() {
        for (p, n) in triangle.positions.iter().zip(triangle.normals) {
            let cosine = p.dot(n);
            // Faces lean from the ball's normal at a corner by at most half a cell's diagonal; their
            // mean leans less. The cell is π/24 wide.
            let bound = libm::cos(std::f64::consts::PI / 24.0 / std::f64::consts::SQRT_2);
            assert!(cosine >= bound, "{cosine} {bound}");
        }
    }
}

#[test]
fn weights_carry_the_derivatives_that_differences_show() {
    let (mesh, _) = Mesh::new(&ball(6), "ball", dvec3(0.0, 0.0, -3.0), 1.0).unwrap();
    let ray = |x: f64, y: f64| [x, y, -1.0];
    let step = 1e-6;
    let mut compared = 0;
    for (x, y) in [(0.013, 0.021), (-0.11, 0.07), (0.2, -0.13), (0.05, 0.22)] {
        let dual = [
            Dual { value: x, dx: 1.0, dy: 0.0 },
            Dual { value: y, dx: 0.0, dy: 1.0 },
            Dual { value: -1.0, dx: 0.0, dy: 0.0 },
        ];
        let zero = [Dual { value: 0.0, dx: 0.0, dy: 0.0 }; 3];
        let triangle = &mesh.triangles()[mesh.nearest(DVec3::ZERO, ray(x, y).into(), 0.0).unwrap()];
        let exact = meet(triangle, zero, dual).unwrap();
        let plain = meet(triangle, [0.0; 3], ray(x, y)).unwrap();
        let at = |x, y| meet(triangle, [0.0; 3], ray(x, y)).unwrap().weights;
        let (right, left) = (at(x + step, y), at(x - step, y));
        for i in 0..3 {
            assert_eq!(exact.weights[i].value, plain.weights[i]);
            // Weights are smooth with third derivatives below 1e3 here: error 1e3·step²/6, and rounding
            // 1e-14/step.
            let difference = (right[i] - left[i]) / (2.0 * step);
            assert!((difference - exact.weights[i].dx).abs() < 1e-7);
            compared += usize::from(exact.weights[i].dx.abs() > 0.1);
        }
    }
    assert!(compared > 6);
}

#[test]
fn of_coinciding_triangles_the_first_is_met() {
    let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let (mesh, _) = Mesh::new(&soup(&[one, one, one].concat()), "three", DVec3::ZERO, 1.0).unwrap();
    for (x, y) in [(-0.1, -0.2), (0.0, 0.0), (-0.3, 0.1)] {
        assert_eq!(mesh.nearest(dvec3(x, y, 1.0), DVec3::NEG_Z, 0.0), Some(0));
    }
}

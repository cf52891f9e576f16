//! A tree of boxes over the triangles, built by the crate `obvhs`, walked here in doubles.
//!
//! The tree's boxes are singles, rounded outwards, so they hold their triangles. The walk tests them in
//! doubles with the far side moved out, after Ize, *Robust BVH Ray Traversal* (JCGT 2013): it
//! may visit a box too many, never one too few. What is hit is decided by [`super::meet`] alone, and ties
//! by the triangle's index, so the tree's shape cannot be seen in a picture.

use std::time::Duration;

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use super::{Triangle, meet};

/// Boxes around boxes around triangles.
#[derive(Clone)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl std::fmt::Debug for Tree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Tree of {} boxes", self.nodes.len())
    }
}

/// A box; `count` triangles of the order from `first` on, or, with none, two boxes from `first` on.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f32; 3],
    high: [f32; 3],
    first: u32,
    count: u32,
}

/// A triangle's box for the builder.
struct Boxed {
    low: [f32; 3],
    high: [f32; 3],
}

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        Aabb { min: self.low.into(), max: self.high.into() }
    }
}

/// Singles on either side of a double.
#[expect(clippy::cast_possible_truncation, reason = "rounded outwards after it")]
fn around(value: f64) -> (f32, f32) {
    let near = value as f32;
    (near.next_down(), near.next_up())
}

impl Tree {
    /// The tree of triangles, of which there is at least one and at most 2²².
    pub(super) fn new(triangles: &[Triangle]) -> Self {
        let boxes: Vec<Boxed> = triangles
            .iter()
            .map(|triangle| {
                let mut out = Boxed { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };
                for corner in triangle.positions {
                    for (i, c) in corner.to_array().into_iter().enumerate() {
                        let (below, above) = around(c);
                        out.low[i] = out.low[i].min(below);
                        out.high[i] = out.high[i].max(above);
                    }
                }
                out
            })
            .collect();
        let Bvh2 { nodes, primitive_indices: order, .. } =
            build_bvh2(&boxes, BvhBuildParams::fast_build(), &mut Duration::default());
        let nodes = nodes
            .iter()
            .map(|node| Node {
                low: node.aabb().min.into(),
                high: node.aabb().max.into(),
                first: node.first_index,
                count: node.prim_count,
            })
            .collect();
        Self { nodes, order }
    }

    /// See [`super::Mesh::nearest`].
    pub(super) fn nearest(
        &self,
        triangles: &[Triangle],
        origin: DVec3,
        direction: DVec3,
        after: f64,
    ) -> Option<usize> {
        let ray = Ray { origin, inverse: 1.0 / direction, after };
        let [origin, direction] = [origin, direction].map(DVec3::into);
        let mut best: Option<(f64, usize)> = None;
        let mut stack = Stack::default();
        let root = self.nodes.first()?;
        if ray.enters(root, f64::INFINITY).is_some() {
            stack.push(0);
        }
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            let limit = best.map_or(f64::INFINITY, |(distance, _)| distance);
            if node.count == 0 {
                let pair = [node.first, node.first + 1]
                    .map(|i| (i, ray.enters(&self.nodes[i as usize], limit)));
                match pair {
                    [(left, Some(near)), (right, Some(far))] => {
                        // The nearer one is popped first.
                        let (near, far) = if near <= far { (left, right) } else { (right, left) };
                        stack.push(far);
                        stack.push(near);
                    }
                    [(one, Some(_)), (_, None)] | [(_, None), (one, Some(_))] => stack.push(one),
                    [(_, None), (_, None)] => {}
                }
                continue;
            }
            if ray.enters(node, limit).is_none() {
                continue;
            }
            let range = node.first as usize..(node.first + node.count) as usize;
            for &triangle in &self.order[range] {
                let triangle = triangle as usize;
                let Some(found) = meet(&triangles[triangle], origin, direction) else {
                    continue;
                };
                let candidate = (found.distance, triangle);
                if found.distance > after
                    && best.is_none_or(|(distance, index)| candidate < (distance, index))
                {
                    best = Some(candidate);
                }
            }
        }
        best.map(|(_, triangle)| triangle)
    }
}

/// A ray as the boxes see it.
struct Ray {
    origin: DVec3,
    inverse: DVec3,
    after: f64,
}

impl Ray {
    /// The multiple of the direction at which a box begins, or nothing where the ray misses it or
    /// enters it beyond `limit`.
    ///
    /// Each side's multiple has the rounding of a difference, a reciprocal and a product: 3 ulp at most
    /// (γ₃), on both ends. What [`meet`] finds is a mean of the corners' multiples with positive weights,
    /// to 8 ulp. The far end is moved out by 16.
    fn enters(&self, node: &Node, limit: f64) -> Option<f64> {
        const SLACK: f64 = 1.0 + 16.0 * f64::EPSILON;
        let (mut near, mut far) = (self.after, limit);
        for i in 0..3 {
            let (low, high) = (f64::from(node.low[i]), f64::from(node.high[i]));
            if self.inverse[i].is_infinite() {
                // Along the sides: between them or beside the box. (0·∞ would not be a number.)
                if self.origin[i] < low || self.origin[i] > high {
                    return None;
                }
                continue;
            }
            let one = (low - self.origin[i]) * self.inverse[i];
            let other = (high - self.origin[i]) * self.inverse[i];
            near = near.max(one.min(other));
            far = far.min(one.max(other));
        }
        (near <= far * SLACK).then_some(near)
    }
}

/// A stack that needs no memory of its own until a tree is unusually deep.
struct Stack {
    first: [u32; 64],
    length: usize,
    rest: Vec<u32>,
}

impl Default for Stack {
    fn default() -> Self {
        Self { first: [0; 64], length: 0, rest: Vec::new() }
    }
}

impl Stack {
    fn push(&mut self, value: u32) {
        if let Some(slot) = self.first.get_mut(self.length) {
            *slot = value;
            self.length += 1;
        } else {
            self.rest.push(value);
        }
    }

    fn pop(&mut self) -> Option<u32> {
        if let Some(value) = self.rest.pop() {
            return Some(value);
        }
        self.length = self.length.checked_sub(1)?;
        Some(self.first[self.length])
    }
}

//! Stage `address`: where a probe lies on the cube.

use super::real::saturate;
use super::tap::Tap;
use crate::cube::{direction, face_uv};
use crate::stage::Stage;

/// A point of the cube's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Address {
    /// Face, 0…5.
    pub face: usize,
    /// sc/|ma| on that face.
    pub u: f64,
    /// tc/|ma| on that face.
    pub v: f64,
}

/// The texel coordinate of a face coordinate: (u + 1)/2·N − ½; texel i has its centre at i.
#[inline]
#[must_use]
pub fn texel_coordinate(u: f64, size: usize) -> f64 {
    (u + 1.0) / 2.0 * size as f64 - 0.5
}

/// Probe `index` of `probes` at centre + (2·index + 1 − probes)·step. Where it leaves the face
/// (|u| or |v| > 1) the direction (1, u, v) of the plane chooses face and coordinates anew.
#[inline]
pub fn address<T: Tap>(
    centre: Address,
    step: [f64; 2],
    index: u32,
    probes: u32,
    level_sizes: [usize; 2],
    tap: &mut T,
) -> Address {
    let offset = 2.0 * f64::from(index) + 1.0 - f64::from(probes);
    let u = saturate(centre.u + offset * step[0]);
    let v = saturate(centre.v + offset * step[1]);
    let address = if u.abs() > 1.0 || v.abs() > 1.0 {
        let (face, u, v) = face_uv(direction(centre.face, u, v));
        Address { face, u, v }
    } else {
        Address { face: centre.face, u, v }
    };
    if T::ACTIVE {
        let component = index as usize;
        tap.put(Stage::Address, "u", component, u);
        tap.put(Stage::Address, "v", component, v);
        for (level, size) in level_sizes.into_iter().enumerate() {
            for (axis, value) in [address.u, address.v].into_iter().enumerate() {
                let s = texel_coordinate(value, size);
                tap.put(Stage::Address, "s", component * 4 + level * 2 + axis, s);
            }
        }
    }
    address
}

//! Cube maps: faces, directions, texels and the neighbours across an edge.
//!
//! Faces are ordered +X −X +Y −Y +Z −Z with (sc, tc, ma) as in Vulkan, OpenGL and WebGPU;
//! u = sc/|ma| and v = tc/|ma| run from −1 to 1; texel centres lie at half texels.

/// Names of the faces as trace lines print them.
pub const FACE_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// Per face: index and sign of the component that is sc, tc and ma.
pub const FACE_AXES: [[(usize, f64); 3]; 6] = [
    [(2, -1.0), (1, -1.0), (0, 1.0)],
    [(2, 1.0), (1, -1.0), (0, -1.0)],
    [(0, 1.0), (2, 1.0), (1, 1.0)],
    [(0, 1.0), (2, -1.0), (1, -1.0)],
    [(0, 1.0), (1, -1.0), (2, 1.0)],
    [(0, -1.0), (1, -1.0), (2, -1.0)],
];

/// The direction (not normalised, major component ±1) of the point (u, v) of a face.
#[inline]
#[must_use]
pub fn direction(face: usize, u: f64, v: f64) -> [f64; 3] {
    // FACE_AXES, without an index that is a variable: this and `face_uv` run once a texel.
    match face {
        0 => [1.0, -v, -u],
        1 => [-1.0, -v, u],
        2 => [u, 1.0, v],
        3 => [u, -1.0, -v],
        4 => [u, -v, 1.0],
        _ => [-u, -v, -1.0],
    }
}

/// The face that a direction meets; on equal magnitudes z wins over y wins over x.
///
/// The zero vector counts as +z; −0 counts as +0.
#[inline]
#[must_use]
pub fn major_face(d: [f64; 3]) -> usize {
    face_uv(d).0
}

/// Face and coordinates (u, v) of a direction that is not zero.
#[inline]
#[must_use]
pub fn face_uv([x, y, z]: [f64; 3]) -> (usize, f64, f64) {
    // Values that are chosen, not branches: directions of samples jump from face to face.
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let by_z = az >= ax && az >= ay;
    let by_y = !by_z && ay >= ax;
    let choose = |of_x: f64, of_y: f64, of_z: f64| {
        let of_xy = if by_y { of_y } else { of_x };
        if by_z { of_z } else { of_xy }
    };
    let major = choose(x, y, z);
    let sign = if major < 0.0 { -1.0 } else { 1.0 };
    let (s, t) = (choose(sign * -z, x, sign * x), choose(-y, sign * z, -y));
    let axis = if by_z { 2 } else { usize::from(by_y) };
    (2 * axis + usize::from(major < 0.0), s / major.abs(), t / major.abs())
}

/// The texel that stands in for (x, y) of `face` where exactly one of x, y is −1 or `size`.
///
/// Returns face, column and row of the neighbour's edge texel; (x, y) inside the face is returned
/// as it is. Corners (both outside) have no texel: the filter takes the mean of the other three.
#[must_use]
pub fn across_edge(size: usize, face: usize, x: i64, y: i64) -> Option<(usize, usize, usize)> {
    let n = i64::try_from(size).ok()?;
    let inside = |t: i64| (0..n).contains(&t);
    if let (true, true, Ok(x), Ok(y)) =
        (inside(x), inside(y), usize::try_from(x), usize::try_from(y))
    {
        return Some((face, x, y));
    }
    if !(inside(x) || inside(y)) || x < -1 || y < -1 || x > n || y > n {
        return None;
    }
    // Twice the coordinates in half texels, so that everything stays an integer: the edge texel's
    // centre moved onto the edge plane has the outer coordinate ±n and the inner one 2t + 1 − n.
    let outer = |t: i64| (2 * t + 1 - n).clamp(-n, n);
    let mut d = [0i64; 3];
    for ((axis, sign), value) in FACE_AXES[face].into_iter().zip([outer(x), outer(y), n]) {
        d[axis] = if sign < 0.0 { -value } else { value };
    }
    // On the edge two components have magnitude n: the neighbour's major one is not this face's.
    let own = FACE_AXES[face][2].0;
    let major = (0..3).find(|&axis| axis != own && d[axis].abs() == n)?;
    let other = 2 * major + usize::from(d[major] < 0);
    let pick = |(axis, sign): (usize, f64)| {
        let value = if sign < 0.0 { -d[axis] } else { d[axis] };
        usize::try_from((value + n - 1).div_euclid(2).clamp(0, n - 1)).ok()
    };
    Some((other, pick(FACE_AXES[other][0])?, pick(FACE_AXES[other][1])?))
}

/// One level of a cube map: linear RGB, six faces of `size` × `size` texels.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeLevel {
    /// Texels along an edge.
    pub size: usize,
    /// Face-major, then row-major: index (face·size + y)·size + x.
    pub texels: Vec<[f32; 3]>,
}

impl CubeLevel {
    /// The texel of a face.
    #[must_use]
    pub fn texel(&self, face: usize, x: usize, y: usize) -> [f32; 3] {
        self.texels[(face * self.size + y) * self.size + x]
    }
}

/// A cube map with its mip chain down to 1×1: level L has max(1, ⌊size/2^L⌋) texels along an edge.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    /// Level 0 first.
    pub levels: Vec<CubeLevel>,
}

impl CubeMap {
    /// Texels along an edge of level 0.
    #[must_use]
    pub fn size(&self) -> usize {
        self.levels[0].size
    }
}

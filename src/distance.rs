//! Distances of the environment from a reference point, which HIT looks up.
//!
//! A distance is Euclidean, from the reference point (the origin) along the looked-up direction. Infinite
//! means that there is nothing in that direction.

use crate::error::InputError;

/// Where distances come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Distance {
    /// A cube map of distances.
    Cube(DistanceCube),
    /// Inside of an axis-aligned box about the reference point: half of its edges. Exact in every direction.
    Box([f64; 3]),
    /// Inside of a sphere about the reference point: its radius.
    Sphere(f64),
}

/// A cube map of distances: six faces of `size` × `size` texels in Vulkan's order.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceCube {
    /// Texels along an edge.
    pub size: usize,
    /// Face-major, then row-major: index (face·size + y)·size + x. No NaN and nothing negative.
    pub texels: Vec<f32>,
}

impl DistanceCube {
    /// A cube of 6·size² texels, cleaned, and how many texels had to be: NaN and negative numbers become +∞
    /// (nothing is known there), −0 becomes +0 uncounted. `None` where the number of texels is another one.
    #[must_use]
    pub fn cleaned(size: usize, mut texels: Vec<f32>) -> Option<(Self, u64)> {
        let whole = size.checked_mul(size)?.checked_mul(6)?;
        if whole == 0 || texels.len() != whole {
            return None;
        }
        let mut changed = 0;
        for texel in &mut texels {
            if texel.is_nan() || *texel < 0.0 {
                *texel = f32::INFINITY;
                changed += 1;
            } else {
                *texel += 0.0;
            }
        }
        Some((Self { size, texels }, changed))
    }
}

impl Distance {
    /// No wall anywhere: every ray escapes.
    #[must_use]
    pub fn nothing() -> Self {
        Self::Cube(DistanceCube { size: 1, texels: vec![f32::INFINITY; 6] })
    }

    /// Reads `box:HX,HY,HZ` or `sphere:R`; `None` where the text starts with neither (it is a file then).
    ///
    /// Every number must be finite and positive.
    #[must_use]
    pub fn analytic(text: &str) -> Option<Result<Self, InputError>> {
        if let Some(rest) = text.strip_prefix("box:") {
            return Some(
                numbers::<3>(rest)
                    .map(Self::Box)
                    .ok_or_else(|| wrong("box:HX,HY,HZ: three positive half edges", text)),
            );
        }
        let rest = text.strip_prefix("sphere:")?;
        Some(
            numbers::<1>(rest)
                .map(|[r]| Self::Sphere(r))
                .ok_or_else(|| wrong("sphere:R: a positive radius", text)),
        )
    }
}

fn wrong(expected: &str, text: &str) -> InputError {
    let mut found: String = text.chars().filter(|c| !c.is_control()).take(60).collect();
    if text.chars().count() > 60 {
        found.push('…');
    }
    InputError::new(
        "--distance",
        expected,
        format!("`{found}`"),
        "give finite decimals above 0, such as box:4,3,2.5",
    )
}

/// Exactly `N` comma-separated positive finite numbers.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut parts = text.split(',');
    let mut out = [0.0; N];
    for value in &mut out {
        let part = parts.next()?.trim();
        // "inf" and "nan" parse as doubles, too.
        *value = part.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0)?;
    }
    parts.next().is_none().then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_and_spheres_are_read_and_wrong_ones_are_named() {
        let read = |text| Distance::analytic(text).map(Result::ok);
        assert_eq!(read("box:1,2.5,3e2"), Some(Some(Distance::Box([1.0, 2.5, 300.0]))));
        assert_eq!(read("sphere:0.5"), Some(Some(Distance::Sphere(0.5))));
        for bad in [
            "box:1,2",
            "box:1,2,3,4",
            "box:1,-2,3",
            "box:1,nan,3",
            "box:",
            "sphere:0",
            "sphere:inf",
            "sphere:1,2",
        ] {
            let error = Distance::analytic(bad).and_then(Result::err);
            assert!(error.is_some_and(|e| e.to_string().contains(bad)), "{bad} is read");
        }
        assert_eq!(read("room.exr"), None);
    }

    #[test]
    fn a_cube_is_cleaned_and_counted() {
        let mut texels = vec![1.0; 6];
        texels[1] = f32::NAN;
        texels[2] = -1.0;
        texels[3] = f32::INFINITY;
        texels[4] = -0.0;
        let (cube, changed) = DistanceCube::cleaned(1, texels).expect("six texels");
        assert_eq!(changed, 2);
        assert!(cube.texels[1..4].iter().all(|t| t.is_infinite()));
        assert!(cube.texels[4].is_sign_positive());
        assert_eq!(DistanceCube::cleaned(1, vec![1.0; 5]), None);
        assert_eq!(DistanceCube::cleaned(0, Vec::new()), None);
    }
}

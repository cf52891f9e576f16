//! How far two pictures are apart.
//!
//! Shown values are clamp(linear · 2^exposure, 0, 1), sRGB encoded in doubles, peak 1. Only
//! fragments count: a background of thousands of equal pixels would flatter every figure. Rows are
//! summed one by one and then in order, so the result does not depend on the number of threads.

use rayon::prelude::*;

use super::shown::{Show, same_size};
use crate::base::num;
use crate::error::InputError;
use crate::picture::Picture;

/// ε of the relative error: a value of 0.01 is where it turns from relative to absolute.
const RELATIVE_FLOOR: f64 = 0.01 * 0.01;

/// A difference counts as more than one 8-bit step above this many steps.
///
/// Two neighbouring 8-bit codes that went through linear light differ by 1 ± 1e-12 steps (two
/// calls of pow, each within an ulp); the margin keeps them on the side of "not more than one".
const ONE_STEP: f64 = 1.0 + 1e-9;

/// The distance of picture `a` from picture `b`, the one further down the ladder.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct Pair {
    /// 10·log10(1/MSE) of the shown values, in dB; `None` when none of them differs.
    pub psnr_db: Option<f64>,
    /// Largest difference of a shown channel, 0…1.
    pub max_abs: f64,
    /// Root of the mean square difference of the shown channels, 0…1.
    pub rmse: f64,
    /// Mean of (a − b)²/(b² + 0.01²) over linear channels, without exposure or clamp; a term
    /// beyond the largest double counts as that double.
    pub rel_mse: f64,
    /// Share (0…1) of fragments with a shown channel more than one 8-bit step (1/255) off.
    pub share_over_1_lsb8: f64,
    /// `max_abs` in 8-bit steps.
    pub max_lsb8: f64,
    /// Mean magnitude of the difference of a shown channel, in 8-bit steps.
    pub mean_lsb8: f64,
    /// Mean of a − b over shown channels, in 8-bit steps: a rounding that leans shows here.
    pub bias_lsb8: f64,
    /// Column and row of `max_abs`; the first one in reading order.
    pub worst_pixel: [u32; 2],
    /// Pixels that count: those covered in either picture.
    pub fragments: usize,
    /// Pixels covered in one picture only (they count, with the other one's background value).
    pub coverage_differs: usize,
    /// Mean FLIP error over fragments where it was asked for, 0…1; see `report::flip`.
    pub flip: Option<f64>,
}

#[cfg(feature = "files")]
impl Pair {
    /// The object of `pairs` in `compare --json`: the names, then every field.
    #[must_use]
    pub fn to_json(&self, a: &str, b: &str) -> serde_json::Value {
        let mut object = serde_json::Map::new();
        object.insert("a".into(), a.into());
        object.insert("b".into(), b.into());
        if let Ok(serde_json::Value::Object(fields)) = serde_json::to_value(self) {
            object.extend(fields);
        }
        serde_json::Value::Object(object)
    }
}

/// Sums of one row, or of the picture.
#[derive(Clone, Copy, Default)]
struct Sums {
    fragments: usize,
    coverage_differs: usize,
    over: usize,
    square: f64,
    magnitude: f64,
    signed: f64,
    relative: f64,
    worst: f64,
    worst_pixel: [u32; 2],
}

impl Sums {
    fn then(self, next: Self) -> Self {
        let worse = next.worst > self.worst || self.fragments == 0;
        Self {
            fragments: self.fragments + next.fragments,
            coverage_differs: self.coverage_differs + next.coverage_differs,
            over: self.over + next.over,
            square: self.square + next.square,
            magnitude: self.magnitude + next.magnitude,
            signed: self.signed + next.signed,
            relative: self.relative + next.relative,
            worst: if worse { next.worst } else { self.worst },
            worst_pixel: if worse { next.worst_pixel } else { self.worst_pixel },
        }
    }
}

/// Compares `a` with `b`.
///
/// `exposure` is in stops. A pixel that only one picture covers counts and is reported.
///
/// # Errors
///
/// The pictures differ in size, have no fragment at all, hold a value that is not finite in a
/// fragment, or `exposure` is not within ±64.
pub fn compare(a: &Picture, b: &Picture, exposure: f64) -> Result<Pair, InputError> {
    let show = Show::new(exposure)?;
    same_size(a, b)?;
    let rows: Result<Vec<Sums>, InputError> = (0..a.height)
        .into_par_iter()
        .map(|y| (0..a.width).try_fold(Sums::default(), |sums, x| pixel(a, b, show, sums, x, y)))
        .collect();
    let total = rows?.into_iter().fold(Sums::default(), Sums::then);
    if total.fragments == 0 {
        return Err(InputError::new(
            "the pictures",
            "at least one fragment",
            "only background",
            "choose a larger --size or a scene that is in view",
        ));
    }
    let channels = 3.0 * as_f64(total.fragments);
    let mse = total.square / channels;
    Ok(Pair {
        psnr_db: (mse > 0.0).then(|| -10.0 * libm::log10(mse)),
        max_abs: total.worst,
        rmse: mse.sqrt(),
        rel_mse: total.relative.min(f64::MAX) / channels,
        share_over_1_lsb8: as_f64(total.over) / as_f64(total.fragments),
        max_lsb8: total.worst * 255.0,
        mean_lsb8: total.magnitude / channels * 255.0,
        bias_lsb8: total.signed / channels * 255.0,
        worst_pixel: total.worst_pixel,
        fragments: total.fragments,
        coverage_differs: total.coverage_differs,
        flip: None,
    })
}

fn pixel(
    a: &Picture,
    b: &Picture,
    show: Show,
    mut sums: Sums,
    x: usize,
    y: usize,
) -> Result<Sums, InputError> {
    let at = y * a.width + x;
    if !(a.covered[at] || b.covered[at]) {
        return Ok(sums);
    }
    let mut worst = 0.0f64;
    for (&p, &q) in a.rgb[at].iter().zip(&b.rgb[at]) {
        if !(p.is_finite() && q.is_finite()) {
            let which = if p.is_finite() { "second" } else { "first" };
            return Err(InputError::new(
                format!("the {which} picture"),
                "finite values",
                format!("{}", if p.is_finite() { q } else { p }),
                "clean the picture before it is compared",
            )
            .at(format!("pixel {x},{y}")));
        }
        let difference = show.channel(p) - show.channel(q);
        let linear = p - q;
        worst = worst.max(difference.abs());
        sums.square += difference * difference;
        sums.magnitude += difference.abs();
        sums.signed += difference;
        let relative = linear * linear / (q * q + RELATIVE_FLOOR);
        sums.relative += if relative.is_finite() { relative } else { f64::MAX };
    }
    if sums.fragments == 0 || worst > sums.worst {
        sums.worst = worst;
        sums.worst_pixel = [x, y].map(num::u32);
    }
    sums.fragments += 1;
    sums.coverage_differs += usize::from(a.covered[at] != b.covered[at]);
    sums.over += usize::from(worst * 255.0 > ONE_STEP);
    Ok(sums)
}

#[expect(clippy::cast_precision_loss, reason = "counts of pixels are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

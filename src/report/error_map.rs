//! Error maps and rows of pictures, drawn to be looked at.
//!
//! The pictures hold linear RGB like any other; written as 8-bit sRGB at exposure 0 they show
//! exactly the colours that are named here.

use super::font::{self, HEIGHT, draw_text, fill, text_width};
use super::shown::{Show, same_size};
use crate::error::InputError;
use crate::picture::Picture;
use crate::srgb::linear_of_bytes;

/// The ramp, by log2 of the difference in 8-bit steps: dark to light, cold below one step, hot
/// from one step on. The jump at 0 is meant: it draws the contour of the 8-bit limit.
const RAMP: [(f64, [u8; 3]); 8] = [
    (-8.0, [24, 24, 60]),
    (-5.0, [28, 48, 120]),
    (-2.0, [36, 88, 150]),
    (-0.0, [58, 128, 160]),
    (0.0, [232, 104, 24]),
    (2.0, [246, 158, 40]),
    (5.0, [252, 216, 96]),
    (8.0, [255, 255, 240]),
];
/// Where the ramp turns from cold to hot: the index of its first hot entry.
const HOT: usize = 4;
/// Identical shown values.
const IDENTICAL: [u8; 3] = [0, 0, 0];
/// Background: a neutral grey that the ramp does not have.
const OUTSIDE: [u8; 3] = [88, 88, 88];
/// Paper and ink of legends and labels.
const PAPER: [u8; 3] = [20, 20, 20];
const INK: [u8; 3] = [235, 235, 235];

/// Rows that the legend adds below the map.
pub const LEGEND_HEIGHT: usize = 24;

/// The colour of a difference in 8-bit steps (8-bit sRGB), log scale from 1/256 to 256 steps.
///
/// Black is no difference at all. Exactly one step is already hot, as it can change an 8-bit
/// picture; beyond either end the end's colour stands.
#[must_use]
pub fn colour_of_steps(steps: f64) -> [u8; 3] {
    if steps <= 0.0 || steps.is_nan() {
        return IDENTICAL;
    }
    let log = libm::log2(steps);
    let part = if log < 0.0 { &RAMP[..HOT] } else { &RAMP[HOT..] };
    let (first, last) = (part[0], part[part.len() - 1]);
    let log = log.clamp(first.0, last.0);
    let above = part[1..].iter().position(|&(at, _)| log <= at);
    let above = above.map_or(part.len() - 1, |position| position + 1);
    let ((from, low), (to, high)) = (part[above - 1], part[above]);
    let share = (log - from) / (to - from);
    let mut out = [0; 3];
    for ((out, low), high) in out.iter_mut().zip(low).zip(high) {
        let value = f64::from(low) + share * (f64::from(high) - f64::from(low));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between two bytes by construction"
        )]
        {
            *out = (value + 0.5).floor() as u8;
        }
    }
    out
}

/// The difference of two pictures per pixel: the largest of the three shown channels, in colour.
///
/// The map has the pictures' width, and [`LEGEND_HEIGHT`] more rows with the legend. Background is
/// grey. NaN counts as the largest difference.
///
/// # Errors
///
/// The pictures differ in size, or `exposure` is not within ±64.
pub fn error_map(a: &Picture, b: &Picture, exposure: f64) -> Result<Picture, InputError> {
    same_size(a, b)?;
    let show = Show::new(exposure)?;
    let mut map = Picture::new(a.width, a.height + LEGEND_HEIGHT);
    for (at, (p, q)) in a.rgb.iter().zip(&b.rgb).enumerate() {
        let bytes = if a.covered[at] || b.covered[at] {
            let differences = p.iter().zip(q).map(|(&p, &q)| {
                let difference = (show.channel(p) - show.channel(q)).abs();
                if difference.is_nan() { 1.0 } else { difference }
            });
            colour_of_steps(differences.fold(0.0, f64::max) * 255.0)
        } else {
            OUTSIDE
        };
        map.rgb[at] = linear_of_bytes(bytes);
        map.covered[at] = true;
    }
    legend(&mut map, a.height);
    Ok(map)
}

/// Draws the ramp and its labels into the rows from `top` on.
fn legend(map: &mut Picture, top: usize) {
    let (width, ink) = (map.width, linear_of_bytes(INK));
    fill(map, (0, top), (width, LEGEND_HEIGHT), linear_of_bytes(PAPER));
    let margin = if width > 60 { 8 } else { 0 };
    let bar = width.saturating_sub(2 * margin);
    let (low, high) = (RAMP[0].0, RAMP[RAMP.len() - 1].0);
    for x in 0..bar {
        let log = low + (high - low) * (as_f64(x) + 0.5) / as_f64(bar);
        let colour = linear_of_bytes(colour_of_steps(libm::exp2(log)));
        fill(map, (margin + x, top + 3), (1, 8), colour);
    }
    // Ticks where there is room, most wanted first. The unit: steps of an 8-bit picture.
    let ticks = [(0.0, "1"), (8.0, "256"), (-8.0, "1/256"), (4.0, "16"), (-4.0, "1/16")];
    let mut taken: Vec<(usize, usize)> = Vec::new();
    let mut place = |map: &mut Picture, centre: usize, text: &str| {
        let half = text_width(text, 1) / 2;
        let left = centre.saturating_sub(half);
        let left = left.min(width.saturating_sub(text_width(text, 1) + 1));
        let right = left + text_width(text, 1);
        let free = taken.iter().all(|&(l, r)| right + 4 <= l || r + 4 <= left);
        if free && right <= width {
            draw_text(map, (left, top + 15), text, 1, ink);
            taken.push((left, right));
        }
        free
    };
    for (log, text) in ticks {
        let share = (log - low) / (high - low);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of the bar's width, within it"
        )]
        let x = margin + (share * as_f64(bar)).floor() as usize;
        if place(map, x, text) {
            fill(map, (x.min(width.saturating_sub(1)), top + 11), (1, 3), ink);
        }
    }
    // The unit's name, half way between two ticks where it fits.
    place(map, margin + bar * 5 / 8, "8-BIT STEPS");
    place(map, margin + bar * 3 / 8, "0 = BLACK");
}

/// Numbers of pixels from dark to white by their share of the largest, the first of each pixel. Pixels without one are
/// dark and not covered.
#[must_use]
pub fn ramp(
    [width, height]: [usize; 2],
    numbers: impl Iterator<Item = ([u32; 2], f64)>,
) -> Picture {
    let numbers: Vec<([u32; 2], f64)> = numbers.collect();
    let most = numbers.iter().fold(1.0f64, |most, (_, n)| most.max(*n));
    let mut picture = Picture::new(width, height);
    picture.rgb.fill([0.1; 3]);
    for (pixel, n) in numbers {
        let index = picture.index(pixel);
        if !picture.covered[index] {
            picture.covered[index] = true;
            picture.rgb[index] =
                linear_of_bytes(colour_of_steps(libm::exp2(16.0 * n / most - 8.0)));
        }
    }
    picture
}

/// A row of pictures with a label under each, for instance rtl, f64 and their difference.
///
/// Pictures are aligned at the top and `gap` columns apart; everything around them is dark. The
/// result holds linear light as the pictures do and is covered everywhere. No picture: 0 × 0.
#[must_use]
pub fn mosaic(pictures: &[(&Picture, &str)], gap: usize) -> Picture {
    let (paper, ink) = (linear_of_bytes(PAPER), linear_of_bytes(INK));
    let scale = |picture: &Picture| if picture.width >= 256 { 2 } else { 1 };
    let row = pictures.iter().map(|(picture, _)| picture.height).max();
    let Some(row) = row else {
        return Picture::new(0, 0);
    };
    let labels = pictures.iter().map(|(picture, _)| scale(picture) * (HEIGHT + 6));
    let height = row + labels.max().unwrap_or(0);
    let width = pictures.iter().map(|(picture, _)| picture.width).sum::<usize>()
        + gap * (pictures.len() - 1);
    let mut out = Picture::new(width, height);
    fill(&mut out, (0, 0), (width, height), paper);
    let mut left = 0;
    for (picture, label) in pictures {
        for y in 0..picture.height {
            let from = y * picture.width;
            let to = y * width + left;
            out.rgb[to..to + picture.width]
                .copy_from_slice(&picture.rgb[from..from + picture.width]);
        }
        let scale = scale(picture);
        let room = picture.width / (font::ADVANCE * scale);
        let label: String = label.chars().take(room).collect();
        let inset = (picture.width - text_width(&label, scale)) / 2;
        draw_text(&mut out, (left + inset, row + 3 * scale), &label, scale, ink);
        left += picture.width + gap;
    }
    out
}

#[expect(clippy::cast_precision_loss, reason = "columns of a picture are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "colours are looked up, not computed")]
mod tests {
    use super::*;

    /// Rec. 709 luma of the bytes: enough to order colours by lightness.
    fn luma([r, g, b]: [u8; 3]) -> f64 {
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    }

    #[test]
    fn the_ramp_grows_lighter_with_every_doubling_of_the_error() {
        let mut last = luma(colour_of_steps(0.0));
        for log in -8..=8 {
            let now = luma(colour_of_steps(libm::exp2(f64::from(log))));
            assert!(now > last, "2^{log}: {now} after {last}");
            last = now;
        }
    }

    #[test]
    fn one_step_is_hot_and_just_below_it_is_cold() {
        let hot = |[r, _, b]: [u8; 3]| r > b;
        assert!(hot(colour_of_steps(1.0)));
        assert!(!hot(colour_of_steps(1.0f64.next_down())));
        assert_eq!(colour_of_steps(0.0), IDENTICAL);
        assert_eq!(colour_of_steps(1e-300), RAMP[0].1);
        assert_eq!(colour_of_steps(f64::INFINITY), RAMP[7].1);
    }

    fn with_fragments(width: usize, height: usize, value: f64) -> Picture {
        let mut picture = Picture::new(width, height);
        picture.rgb.fill([value; 3]);
        picture.covered.fill(true);
        picture
    }

    #[test]
    fn background_identity_and_difference_look_different() {
        let mut a = with_fragments(4, 1, 0.5);
        let mut b = a.clone();
        (a.covered[0], b.covered[0]) = (false, false);
        b.rgb[2][1] = 0.9;
        b.rgb[3][1] = f64::NAN;
        let map = error_map(&a, &b, 0.0).unwrap();
        assert_eq!((map.width, map.height), (4, 1 + LEGEND_HEIGHT));
        assert_eq!(map.rgb[0], linear_of_bytes(OUTSIDE));
        assert_eq!(map.rgb[1], linear_of_bytes(IDENTICAL));
        assert!(map.rgb[2][0] > map.rgb[2][2], "a visible difference is hot");
        assert_eq!(map.rgb[3], linear_of_bytes(colour_of_steps(255.0)));
        assert!(map.covered.iter().all(|&covered| covered));
    }

    #[test]
    fn pictures_of_any_size_get_a_legend_without_a_panic() {
        for (width, height) in [(0, 0), (1, 1), (5, 3), (17, 2), (61, 2), (300, 1)] {
            let picture = with_fragments(width, height, 0.1);
            let map = error_map(&picture, &picture, 0.0).unwrap();
            assert_eq!(map.rgb.len(), width * (height + LEGEND_HEIGHT));
            let row = mosaic(&[(&picture, "A LONG LABEL"), (&map, "map")], 3);
            assert_eq!(row.width, 2 * width + 3);
        }
        assert_eq!(mosaic(&[], 3).width, 0);
    }

    #[test]
    fn sizes_and_exposures_that_make_no_sense_are_refused() {
        let [a, b] = [with_fragments(2, 2, 0.0), with_fragments(2, 3, 0.0)];
        assert!(error_map(&a, &b, 0.0).is_err());
        assert!(error_map(&a, &a, f64::NAN).is_err());
    }
}

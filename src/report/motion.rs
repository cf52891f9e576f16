//! Flicker: how a picture moves when its scene moves by a part of a pixel, against how the truth moves.

use super::shown::{Show, same_size};
use crate::error::InputError;
use crate::picture::Picture;

/// The motion of a picture A against that of the truth T, over pixels that are covered before and after in both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// PSNR in dB of (A' − A) − (T' − T) over shown channels, peak 1; `None` where it is zero everywhere.
    pub flicker_db: Option<f64>,
    /// RMS of A' − A over that of T' − T: above 1 the picture aliases, below it blurs; `None` where the truth stands still.
    pub act: Option<f64>,
    /// Pixels that count.
    pub fragments: usize,
}

/// Compares the motions of two pictures, each before and after the scene's shift.
///
/// # Errors
/// The pictures differ in size, or `exposure` is not within ±64.
pub fn motion(a: [&Picture; 2], truth: [&Picture; 2], exposure: f64) -> Result<Motion, InputError> {
    let show = Show::new(exposure)?;
    let all = [a[0], a[1], truth[0], truth[1]];
    for other in all {
        same_size(a[0], other)?;
    }
    let covered = |at: &usize| all.iter().all(|picture| picture.covered[*at]);
    let (mut fragments, mut error, mut own, mut real) = (0, 0.0, 0.0, 0.0);
    for at in (0..a[0].rgb.len()).filter(covered) {
        fragments += 1;
        for channel in 0..3 {
            let moved = |[before, after]: [&Picture; 2]| {
                show.channel(after.rgb[at][channel]) - show.channel(before.rgb[at][channel])
            };
            let (mine, its) = (moved(a), moved(truth));
            error += (mine - its) * (mine - its);
            own += mine * mine;
            real += its * its;
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "counts of pixels are far below 2^53")]
    let mse = error / (3.0 * fragments as f64);
    Ok(Motion {
        flicker_db: (error > 0.0).then(|| -10.0 * libm::log10(mse)),
        act: (real > 0.0).then(|| libm::sqrt(own / real)),
        fragments,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: [f64; 4]) -> Picture {
        Picture {
            width: 2,
            height: 2,
            rgb: values.map(|v| [v; 3]).to_vec(),
            covered: vec![true; 4],
        }
    }

    #[test]
    fn a_motion_against_itself_is_zero_and_a_still_truth_has_no_act() {
        let (before, after) = (grey([0.1, 0.2, 0.3, 0.4]), grey([0.4, 0.1, 0.2, 0.3]));
        let same = motion([&before, &after], [&before, &after], 0.0).unwrap();
        assert_eq!(same, Motion { flicker_db: None, act: Some(1.0), fragments: 4 });
        let still = motion([&before, &after], [&before, &before], 0.0).unwrap();
        assert!(still.act.is_none() && still.flicker_db.is_some());
    }

    #[test]
    fn half_the_motion_has_half_the_act_and_an_error_of_the_other_half() {
        // Linear values below 0.0031308 show as 12.92 times themselves.
        let x = 0.002;
        let (before, half, whole) = (grey([0.0; 4]), grey([x / 2.0; 4]), grey([x; 4]));
        let found = motion([&before, &half], [&before, &whole], 0.0).unwrap();
        assert!((found.act.unwrap() - 0.5).abs() < 1e-12);
        let error = 12.92 * x / 2.0;
        assert!((found.flicker_db.unwrap() + 20.0 * error.log10()).abs() < 1e-9);
        // A pixel that one picture does not cover does not count.
        let mut holed = whole.clone();
        holed.covered[3] = false;
        assert_eq!(motion([&before, &half], [&before, &holed], 0.0).unwrap().fragments, 3);
    }
}

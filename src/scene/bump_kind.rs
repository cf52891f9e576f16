//! What the planes of a bump map hold, decided by the bulk of their texels.

use super::bump::{BumpSource, Difference, default_height_scale};
use crate::base::num;
use crate::error::InputError;

/// What a bump map holds, as a user names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum BumpKind {
    /// Heights: grey, white is high.
    Heights,
    /// Tangent-space normals in three channels.
    Normals,
    /// X and Y of tangent-space normals; Z follows from them.
    NormalsTwoChannel,
}

/// Where a normal map's green channel points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Green {
    /// Up the picture (OpenGL).
    #[default]
    Up,
    /// Down the picture (Direct3D).
    Down,
}

/// A user's word about a bump map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BumpChoice {
    /// Its kind, instead of what the texels show.
    pub kind: Option<BumpKind>,
    /// Where green points.
    pub green: Green,
    /// Texels per unit of height.
    pub scale: Option<f64>,
}

/// Share of the texels that decides.
const BULK: f64 = 0.9;

/// Shares of the texels that have a property.
#[derive(Clone, Copy, Debug, Default)]
struct Shares {
    /// Three channels that are equal, or nearly so as lossy files have them.
    grey: f64,
    /// Of unit length, 0…1 codes taken for −1…1.
    coded: f64,
    /// Of unit length as they are.
    signed: f64,
    /// Well below zero in some channel.
    negative: f64,
    /// Blue 0, red or green not.
    no_blue: f64,
    /// Blue 1.
    full_blue: f64,
    /// Least correlation of two channels: heights in one colour have 1.
    together: f64,
    /// Blue above red and green, 0…1 codes: what a normal map that is not normalised still has.
    bluish: f64,
}

impl Shares {
    fn new([r, g, b]: [&[f32]; 3]) -> Self {
        let texels = || r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b].map(f64::from));
        let count = r.len().max(1) as f64;
        let mean = texels().flatten().map(f64::abs).sum::<f64>() / (3.0 * count);
        let within_one = texels().flatten().filter(|c| c.abs() <= 1.0).count() as f64;
        // An eighth of the mean, and where all are codes 16 of 255 steps: the tint of a JPEG file.
        let codes = if within_one >= 3.0 * count * BULK { 16.0 / 255.0 } else { 0.0 };
        let tolerance = (mean / 8.0).max(codes);
        let step = 1.5 / 255.0;
        let unit =
            |v: [f64; 3]| v[2] > 0.0 && (v.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() <= 0.3;
        let together = correlation(r, g).min(correlation(g, b));
        let mut out = Self { together, ..Self::default() };
        for t @ [r, g, b] in texels() {
            let spread = r.max(g).max(b) - r.min(g).min(b);
            let share = |yes: bool| f64::from(u8::from(yes)) / count;
            out.grey += share(spread <= tolerance);
            out.coded += share(unit(t.map(|c| 2.0 * c - 1.0)));
            out.signed += share(unit(t));
            out.negative += share(t.iter().any(|c| *c < -0.05));
            out.no_blue += share(b.abs() <= step && spread > step);
            // Exactly: a shallow map of normals has blues just below 1.
            out.full_blue += share((b - 1.0).abs() <= 1e-6);
            out.bluish += share(b > 0.5 && b > r.max(g) && r.min(g) >= -step);
        }
        out
    }
}

/// Correlation of two planes; 0 where one of them is constant.
fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let mean = |p: &[f32]| p.iter().map(|c| f64::from(*c)).sum::<f64>() / p.len().max(1) as f64;
    let (ma, mb) = (mean(a), mean(b));
    let [mut ab, mut aa, mut bb] = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (f64::from(*a) - ma, f64::from(*b) - mb);
        ab += a * b;
        aa += a * a;
        bb += b * b;
    }
    let scale = (aa * bb).sqrt();
    if scale > 0.0 { ab / scale } else { 0.0 }
}

/// Takes planes for what they are: the source, and its kind in words.
///
/// One plane holds heights, two hold normals. Three hold heights where nine texels in ten are grey, normals where at
/// least half are of unit length, and X and Y of normals where blue is 0 or 1 throughout.
///
/// # Errors
/// Three planes that are none of these, and a kind that the planes cannot be.
pub fn source(
    width: usize,
    height: usize,
    planes: &[Vec<f32>],
    choice: BumpChoice,
    subject: &str,
) -> Result<(BumpSource, String), InputError> {
    let first = planes.first().map(Vec::as_slice).unwrap_or_default();
    let plane = |i: usize| planes.get(i).map_or(first, Vec::as_slice);
    let rgb = [plane(0), plane(1), plane(2)];
    let shares = Shares::new(rgb);
    let percent = |share: f64| format!("{:.1} % of texels", 100.0 * share);
    let flag = || "by --bump-kind".to_owned();
    let two = |why: String| (BumpKind::NormalsTwoChannel, why);
    let (kind, why) = match (choice.kind, planes.len()) {
        (Some(BumpKind::Normals), 0..=2) | (Some(BumpKind::NormalsTwoChannel), 0..=1) => {
            return Err(InputError::new(
                subject,
                "as many channels as --bump-kind asks for",
                format!("{}", planes.len()),
                "choose another kind",
            )
            .at("channels"));
        }
        (Some(kind), _) => (kind, flag()),
        (None, 0..=1) => (BumpKind::Heights, "one channel".into()),
        (None, 2) => two("two channels".into()),
        _ if shares.no_blue >= BULK => two(format!("blue is 0 in {}", percent(shares.no_blue))),
        _ if shares.grey >= BULK => {
            (BumpKind::Heights, format!("grey in {}", percent(shares.grey)))
        }
        _ if shares.full_blue >= 0.999 => {
            two(format!("blue is 1 in {}", percent(shares.full_blue)))
        }
        _ if shares.coded.max(shares.signed) >= 0.5 => (
            BumpKind::Normals,
            format!("unit length in {}", percent(shares.coded.max(shares.signed))),
        ),
        _ if shares.together >= 0.98 => {
            (BumpKind::Heights, format!("one tint, correlation {:.3}", shares.together))
        }
        _ if shares.bluish >= BULK => {
            (BumpKind::Normals, format!("blue leads in {}", percent(shares.bluish)))
        }
        _ => {
            return Err(InputError::new(
                subject,
                "heights (grey) or tangent-space normals (of unit length, blue up)",
                format!(
                    "{} grey, {} of unit length",
                    percent(shares.grey),
                    percent(shares.coded.max(shares.signed))
                ),
                "say what it holds by --bump-kind heights, normals or normals-two-channel",
            )
            .at("texels"));
        }
    };
    if kind == BumpKind::Heights {
        let values: Vec<f32> = rgb[0]
            .iter()
            .zip(rgb[1])
            .zip(rgb[2])
            .map(|((r, g), b)| r.min(*g).max(r.max(*g).min(*b)))
            .collect();
        let scale = choice.scale.unwrap_or_else(|| default_height_scale(width));
        let words = format!("heights {width}x{height} ({why}), white is {scale} texels high");
        let difference = Difference::default();
        return Ok((BumpSource::Height { width, height, values, scale, difference }, words));
    }
    let two = kind == BumpKind::NormalsTwoChannel;
    // Of two channels, and where lengths do not tell, signs do.
    let signed = if two { shares.negative >= 0.01 } else { shares.signed > shares.coded };
    let decode = |x: f32| if signed { f64::from(x) } else { 2.0 * f64::from(x) - 1.0 };
    let up = if choice.green == Green::Up { 1.0 } else { -1.0 };
    let values = rgb[0]
        .iter()
        .zip(rgb[1])
        .zip(rgb[2])
        .map(|((r, g), b)| {
            let (x, y) = (decode(*r), decode(*g));
            let z = if two { (1.0 - x * x - y * y).max(0.0).sqrt() } else { decode(*b) };
            [x, up * y, z].map(num::f32)
        })
        .collect();
    let words = format!(
        "tangent normals {width}x{height}{} ({why}), {}, green {}",
        if two { " of two channels, Z from X and Y" } else { "" },
        if signed { "signed" } else { "coded 0..1" },
        if choice.green == Green::Up { "up (OpenGL)" } else { "down (Direct3D)" },
    );
    Ok((BumpSource::Normals { width, height, values }, words))
}

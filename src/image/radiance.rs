//! Radiance HDR: the header is read here, the pixels are decoded by `image`.
//!
//! Values are mantissa · 2^(exponent − 136), divided by every `EXPOSURE` and `COLORCORR` of the header. XYZ becomes RGB of
//! Radiance's own primaries. All eight orders of the axes are turned upright.

use super::limits::{LoadOptions, room};
use super::planar::Planar;
use super::turn::Turn;
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

/// Reads planes R, G, B.
pub(super) fn read(
    bytes: &[u8],
    subject: &str,
    options: &LoadOptions,
) -> Result<Planar, InputError> {
    let header = header(bytes, subject)?;
    let [width, height] = header.size;
    let (w, h) = (u128::from(width), u128::from(height));
    options.admit(subject, 12 * w * h, &format!("{width}x{height} pixels"))?;
    // The densest row that any of the formats allows: one pixel and a run marker, 4 bytes each.
    let least = h * if w > 1 { 8 } else { 4 };
    let pixels = &bytes[header.end..];
    if least > pixels.len() as u128 {
        return Err(damaged(
            subject,
            format!("at least {least} bytes of pixels for {width}x{height}"),
            format!("{} bytes", pixels.len()),
        )
        .at("pixels"));
    }
    // The decoder sees the rows as stored, under a header that it knows.
    let plain = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    let mut file: Vec<u8> = room(plain.len() + pixels.len(), subject)?;
    file.extend(plain.as_bytes());
    file.extend(pixels);
    let size = num::usize(12 * w * h);
    let mut buffer: Vec<u8> = room(size, subject)?;
    let decode = || -> image::ImageResult<()> {
        let decoder = HdrDecoder::new_nonstrict(file.as_slice())?;
        buffer.resize(size, 0);
        decoder.read_image(&mut buffer)
    };
    guarded(decode)
        .and_then(|result| result.map_err(|e| e.to_string()))
        .map_err(|e| damaged(subject, "an intact Radiance file", e).at("pixels"))?;
    let mut planes = [const { Vec::new() }; 3];
    for (plane, offset) in planes.iter_mut().zip([0, 4, 8]) {
        *plane = room(size / 12, subject)?;
        plane.extend(buffer.chunks_exact(12).map(|pixel| {
            let sample: [u8; 4] = pixel[offset..offset + 4].try_into().unwrap_or_default();
            f32::from_ne_bytes(sample)
        }));
    }
    let remarks = header.correct(&mut planes);
    let channels = ["R", "G", "B"].map(str::to_owned).into_iter().zip(planes).collect();
    let mut planar = Planar::plain(width as usize, height as usize, channels);
    planar.remarks = remarks;
    header.turn.apply(&mut planar, subject, "axes")?;
    Ok(planar)
}

fn damaged(subject: &str, expected: impl Into<String>, found: impl Into<String>) -> InputError {
    InputError::new(subject, expected, found, "the file is damaged or truncated; export it again")
}

/// The contents of a header.
struct Header {
    /// Columns and rows as stored.
    size: [u32; 2],
    turn: Turn,
    /// Where the pixels start.
    end: usize,
    xyz: bool,
    /// Product of all exposures and colour corrections.
    factors: [f64; 3],
    primaries: Option<String>,
}

impl Header {
    /// Undoes exposure and colour correction, makes RGB of XYZ, and says so.
    fn correct(&self, planes: &mut [Vec<f32>; 3]) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.factors.iter().any(|f| f.to_bits() != 1.0f64.to_bits()) {
            for (plane, factor) in planes.iter_mut().zip(self.factors) {
                for sample in plane {
                    *sample = num::f32(f64::from(*sample) / factor);
                }
            }
            let [r, g, b] = self.factors;
            remarks.push(format!("divided by its EXPOSURE and COLORCORR, {r} {g} {b}"));
        }
        if self.xyz {
            let [x, y, z] = planes;
            for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                let from = [*x, *y, *z].map(f64::from);
                [*x, *y, *z] = XYZ_TO_RGB
                    .map(|row| num::f32(row.iter().zip(from).map(|(m, c)| m * c).sum::<f64>()));
            }
            remarks.push("XYZ converted to RGB of Radiance's primaries".into());
        }
        if let Some(primaries) = &self.primaries {
            remarks.push(format!("primaries {primaries} kept as they are"));
        }
        remarks
    }
}

/// CIE XYZ to RGB of Radiance's default primaries (0.64 0.33, 0.29 0.60, 0.15 0.06, white 1/3 1/3).
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [2.565312843029638, -1.166849615806806, -0.398463227222832],
    [-1.022108172127911, 1.978286616660086, 0.043821555467825],
    [0.074724377296856, -0.251939567170274, 1.177215189873417],
];

/// The header's lines: what is not known is skipped, as Radiance's own readers do.
fn header(bytes: &[u8], subject: &str) -> Result<Header, InputError> {
    let bad = |expected: &str, found: String| damaged(subject, expected, found).at("header");
    let unsupported = |expected: &str, found: String| {
        InputError::new(
            subject,
            expected,
            found,
            "convert the image with Radiance's ra_xyze or pfilt",
        )
        .at("header")
    };
    let mut out = Header {
        size: [0; 2],
        turn: Turn::default(),
        end: 0,
        xyz: false,
        factors: [1.0; 3],
        primaries: None,
    };
    let mut lines = bytes.split_inclusive(|b| *b == b'\n');
    let mut next = || {
        let line = lines.next().and_then(|line| line.strip_suffix(b"\n"))?;
        out.end += line.len() + 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    };
    loop {
        let line = next().ok_or_else(|| {
            bad("header lines, an empty line, then a resolution line", "the end of the file".into())
        })?;
        if line.is_empty() {
            break;
        }
        let Some(at) = line.iter().position(|b| *b == b'=') else { continue };
        let (key, value) = (line[..at].trim_ascii(), line[at + 1..].trim_ascii());
        let words: Vec<f64> = String::from_utf8_lossy(value)
            .split_ascii_whitespace()
            .map_while(|w| w.parse().ok())
            .take(9)
            .collect();
        let factors = match (key, &words[..]) {
            (b"FORMAT", _) => {
                out.xyz = match value {
                    b"32-bit_rle_rgbe" => false,
                    b"32-bit_rle_xyze" => true,
                    _ => {
                        let known = "FORMAT=32-bit_rle_rgbe or 32-bit_rle_xyze";
                        return Err(unsupported(known, text(line)));
                    }
                };
                continue;
            }
            (b"PRIMARIES", [_, _, _, _, _, _, _, _]) => {
                out.primaries = Some(text(value));
                continue;
            }
            (b"EXPOSURE", [all]) => [*all; 3],
            (b"COLORCORR", [r, g, b]) => [*r, *g, *b],
            (b"EXPOSURE" | b"COLORCORR" | b"PRIMARIES", _) => {
                return Err(bad("numbers", text(line)));
            }
            _ => continue,
        };
        for (product, factor) in out.factors.iter_mut().zip(factors) {
            *product *= factor;
        }
    }
    if !out.factors.iter().all(|f| f.is_normal() && *f > 0.0) {
        let found = format!("a product of {:?}", out.factors);
        return Err(bad("EXPOSURE and COLORCORR above 0", found));
    }
    let line = next().map(text).unwrap_or_default();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let known = match words[..] {
        [first, rows, second, columns] => orientation(first, second)
            .zip(rows.parse::<u32>().ok().zip(columns.parse::<u32>().ok())),
        _ => None,
    };
    match known {
        Some((turn, (rows, columns)))
            if (1..1 << 30).contains(&rows) && (1..1 << 30).contains(&columns) =>
        {
            Ok(Header { size: [columns, rows], turn, ..out })
        }
        _ => Err(bad("a resolution line such as \"-Y height +X width\"", format!("\"{line}\""))),
    }
}

/// The turn for a resolution line whose first axis counts the stored rows.
fn orientation(first: &str, second: &str) -> Option<Turn> {
    let (transpose, rows, columns) = match (first, second) {
        ("-Y" | "+Y", "-X" | "+X") => (false, first == "+Y", second == "-X"),
        ("-X" | "+X", "-Y" | "+Y") => (true, first == "-X", second == "+Y"),
        _ => return None,
    };
    Some(Turn { transpose, columns, rows })
}

fn text(bytes: &[u8]) -> String {
    bytes
        .iter()
        .take(60)
        .map(|b| if b.is_ascii_graphic() || *b == b' ' { char::from(*b) } else { '?' })
        .collect()
}

//! Wavefront OBJ: `v`, `vt`, `vn` and `f`; everything else is skipped.
//!
//! Convex polygons are cut into a fan from their first corner, others into ears, see [`polygon`](super::polygon). Indices count
//! from 1 or, negative, back from the latest; an index must name something that stands above its face
//! or below it, so ranges are checked at the end. A texture coordinate's v grows upwards: t = 1 − v.

use super::polygon::recut;
use super::{Corner, Soup, admit};
use crate::base::num;
use crate::error::InputError;

/// Reads the bytes of a file. A byte-order mark is skipped, a `\` at the end of a line joins it with the next, and
/// what is not UTF-8 can only stand in names and comments, which are skipped.
///
/// # Errors
/// A number or an index that cannot be read or is out of range, too many triangles, or no face; with the line.
pub(super) fn parse(bytes: &[u8], subject: &str) -> Result<Soup, InputError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let remedy = "save the mesh as UTF-8";
        return Err(InputError::new(subject, "text of single bytes", "UTF-16", remedy).at("byte 0"));
    }
    let mut soup = Soup::default();
    // The line of each face, and the face of each triangle, so that a wrong index can be placed.
    let mut lines: Vec<u32> = Vec::new();
    // First triangle and number of triangles of each polygon of more than three corners.
    let mut polygons: Vec<(usize, usize)> = Vec::new();
    let mut number = 0u32;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut rest = bytes.split(|b| *b == b'\n');
    while let Some(line) = rest.next() {
        number = number.saturating_add(1);
        let first = number;
        let fail = |expected: &str, found: String| {
            InputError::new(subject, expected, found, "export the mesh again")
                .at(format!("line {first}"))
        };
        let mut text = String::from_utf8_lossy(line);
        while let Some(joined) = text.trim_end().strip_suffix('\\') {
            let next = rest.next().unwrap_or_default();
            number = number.saturating_add(1);
            text = format!("{joined} {}", String::from_utf8_lossy(next)).into();
        }
        // A comment ends a line, wherever it begins.
        let text = text.split('#').next().unwrap_or_default();
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                soup.positions.push(position(&mut words).map_err(|w| fail("v X Y Z [W]", w))?)
            }
            Some("vn") => {
                soup.normals.push(numbers::<3>(&mut words).map_err(|w| fail("vn X Y Z", w))?)
            }
            Some("vt") => {
                // The second coordinate may be left out; a third is for solid textures.
                let [s] = numbers::<1>(&mut words).map_err(|w| fail("vt U [V [W]]", w))?;
                let v = words.next().map_or(Ok(0.0), |w| number_of(Some(w)));
                let v = v.map_err(|w| fail("vt U [V [W]]", w))?;
                soup.texcoords.push([s, 1.0 - v]);
            }
            // The old name of a face, `fo`, is still written by some.
            Some("f" | "fo") => {
                let before = soup.triangles.len();
                face(&mut words, &mut soup).map_err(|w| {
                    fail("f with three corners V, V/VT, V//VN or V/VT/VN or more", w)
                })?;
                admit(soup.triangles.len(), subject, || format!("line {first}"))?;
                let count = soup.triangles.len() - before;
                lines.resize(lines.len() + count, first);
                if count > 1 {
                    polygons.push((before, count));
                }
            }
            _ => {}
        }
    }
    check_ranges(&soup, &lines, subject)?;
    if soup.triangles.is_empty() {
        return Err(InputError::new(
            subject,
            "at least one face (f)",
            format!("none in {number} lines"),
            "export the mesh with its faces",
        ));
    }
    let kept = polygons.into_iter().filter(|(start, count)| recut(&mut soup, *start, *count));
    let kept = kept.count();
    if kept > 0 {
        let what = "polygons that are not convex stay fans: they cross themselves or are too large";
        soup.remarks.push(format!("{kept} {what}"));
    }
    Ok(soup)
}

/// A position; a fourth number alone is the weight of a rational one, three more are a colour.
fn position<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<[f64; 3], String> {
    let place = numbers::<3>(words)?;
    let rest: Vec<&str> = words.take(5).collect();
    match rest[..] {
        [weight] => {
            let weight = number_of(Some(weight))?;
            if weight == 0.0 {
                return Err("a weight of 0".into());
            }
            Ok(place.map(|c| c / weight))
        }
        [] | [_, _, _] | [_, _, _, _] => Ok(place),
        _ => Err(format!("{} numbers", 3 + rest.len())),
    }
}

/// So many numbers.
fn numbers<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a str>,
) -> Result<[f64; N], String> {
    let mut out = [0.0; N];
    for value in &mut out {
        *value = number_of(words.next())?;
    }
    Ok(out)
}

fn number_of(word: Option<&str>) -> Result<f64, String> {
    let word = word.ok_or("fewer numbers")?;
    word.parse().map_err(|_| format!("`{}`", shortened(word)))
}

/// At most 40 characters of a word.
fn shortened(word: &str) -> String {
    let mut out: String = word.chars().take(40).collect();
    if out.len() < word.len() {
        out.push('…');
    }
    out
}

/// The corners of a face, as a fan.
fn face<'a>(words: &mut impl Iterator<Item = &'a str>, soup: &mut Soup) -> Result<(), String> {
    let first = words.next().map(|w| corner(w, soup)).transpose()?;
    let second = words.next().map(|w| corner(w, soup)).transpose()?;
    let (Some(first), Some(mut before)) = (first, second) else {
        return Err("fewer than three corners".into());
    };
    let start = soup.triangles.len();
    for word in words {
        let next = corner(word, soup)?;
        soup.triangles.push([first, before, next]);
        before = next;
    }
    if soup.triangles.len() == start {
        return Err("two corners".into());
    }
    Ok(())
}

/// `V`, `V/VT`, `V//VN` or `V/VT/VN`.
fn corner(word: &str, soup: &Soup) -> Result<Corner, String> {
    let mut parts = word.split('/');
    let mut part = |length: usize| match parts.next() {
        None | Some("") => Ok(None),
        Some(text) => index(text, length).map(Some),
    };
    let position = part(soup.positions.len())?;
    let texcoord = part(soup.texcoords.len())?;
    let normal = part(soup.normals.len())?;
    match (position, parts.next()) {
        (Some(position), None) => Ok(Corner { position, normal, texcoord }),
        _ => Err(format!("`{}`", shortened(word))),
    }
}

/// An index from 0: counted from 1, or back from the `length` that there are.
fn index(text: &str, length: usize) -> Result<u32, String> {
    let wrong = || format!("index `{}`", shortened(text));
    let value: i64 = text.parse().map_err(|_| wrong())?;
    let from_zero = if value > 0 {
        value - 1
    } else {
        let length = num::i64(length);
        length.checked_add(value).filter(|i| value < 0 && *i >= 0).ok_or_else(wrong)?
    };
    u32::try_from(from_zero).map_err(|_| wrong())
}

/// Refuses an index beyond the lists' ends.
fn check_ranges(soup: &Soup, lines: &[u32], subject: &str) -> Result<(), InputError> {
    for (corners, line) in soup.triangles.iter().zip(lines) {
        for corner in corners {
            let three = [
                ("positions", Some(corner.position), soup.positions.len()),
                ("texture coordinates", corner.texcoord, soup.texcoords.len()),
                ("normals", corner.normal, soup.normals.len()),
            ];
            for (what, index, length) in three {
                if let Some(index) = index.filter(|i| *i as usize >= length) {
                    return Err(InputError::new(
                        subject,
                        format!("an index into {length} {what}"),
                        (u64::from(index) + 1).to_string(),
                        "export the mesh again; part of the file may be missing",
                    )
                    .at(format!("line {line}")));
                }
            }
        }
    }
    Ok(())
}

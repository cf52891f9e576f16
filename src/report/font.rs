//! A 5 × 7 dot font for labels inside pictures: digits, capitals and a few signs.

use crate::picture::Picture;

/// Width of a character with the gap after it.
pub const ADVANCE: usize = 6;
/// Height of a character.
pub const HEIGHT: usize = 7;

/// The seven rows of a character, five bits each, the leftmost in bit 4.
///
/// Small letters look like capitals; a character that the font lacks is a hollow box.
fn rows(c: char) -> [u8; 7] {
    match c.to_ascii_uppercase() {
        ' ' => [0; 7],
        '0' => [14, 17, 19, 21, 25, 17, 14],
        '1' => [4, 12, 4, 4, 4, 4, 14],
        '2' => [14, 17, 1, 2, 4, 8, 31],
        '3' => [31, 2, 4, 2, 1, 17, 14],
        '4' => [2, 6, 10, 18, 31, 2, 2],
        '5' => [31, 16, 30, 1, 1, 17, 14],
        '6' => [6, 8, 16, 30, 17, 17, 14],
        '7' => [31, 1, 2, 4, 8, 8, 8],
        '8' => [14, 17, 17, 14, 17, 17, 14],
        '9' => [14, 17, 17, 15, 1, 2, 12],
        'A' => [14, 17, 17, 17, 31, 17, 17],
        'B' => [30, 17, 17, 30, 17, 17, 30],
        'C' => [14, 17, 16, 16, 16, 17, 14],
        'D' => [28, 18, 17, 17, 17, 18, 28],
        'E' => [31, 16, 16, 30, 16, 16, 31],
        'F' => [31, 16, 16, 30, 16, 16, 16],
        'G' => [14, 17, 16, 23, 17, 17, 15],
        'H' => [17, 17, 17, 31, 17, 17, 17],
        'I' => [14, 4, 4, 4, 4, 4, 14],
        'J' => [7, 2, 2, 2, 2, 18, 12],
        'K' => [17, 18, 20, 24, 20, 18, 17],
        'L' => [16, 16, 16, 16, 16, 16, 31],
        'M' => [17, 27, 21, 21, 17, 17, 17],
        'N' => [17, 17, 25, 21, 19, 17, 17],
        'O' => [14, 17, 17, 17, 17, 17, 14],
        'P' => [30, 17, 17, 30, 16, 16, 16],
        'Q' => [14, 17, 17, 17, 21, 18, 13],
        'R' => [30, 17, 17, 30, 20, 18, 17],
        'S' => [15, 16, 16, 14, 1, 1, 30],
        'T' => [31, 4, 4, 4, 4, 4, 4],
        'U' => [17, 17, 17, 17, 17, 17, 14],
        'V' => [17, 17, 17, 17, 17, 10, 4],
        'W' => [17, 17, 17, 21, 21, 21, 10],
        'X' => [17, 17, 10, 4, 10, 17, 17],
        'Y' => [17, 17, 17, 10, 4, 4, 4],
        'Z' => [31, 1, 2, 4, 8, 16, 31],
        '/' => [0, 1, 2, 4, 8, 16, 0],
        '-' => [0, 0, 0, 31, 0, 0, 0],
        '.' => [0, 0, 0, 0, 0, 12, 12],
        ',' => [0, 0, 0, 0, 12, 4, 8],
        ':' => [0, 12, 12, 0, 12, 12, 0],
        '=' => [0, 0, 31, 0, 31, 0, 0],
        '+' => [0, 4, 4, 31, 4, 4, 0],
        '<' => [2, 4, 8, 16, 8, 4, 2],
        '>' => [8, 4, 2, 1, 2, 4, 8],
        '(' => [2, 4, 8, 8, 8, 4, 2],
        ')' => [8, 4, 2, 2, 2, 4, 8],
        '|' => [4, 4, 4, 4, 4, 4, 4],
        ';' => [0, 12, 12, 0, 12, 4, 8],
        '^' => [4, 10, 17, 0, 0, 0, 0],
        '\'' => [4, 4, 8, 0, 0, 0, 0],
        _ => [31, 17, 17, 17, 17, 17, 31],
    }
}

/// Columns that a text takes, without the gap after its last character.
#[must_use]
pub fn text_width(text: &str, scale: usize) -> usize {
    let advance = ADVANCE * scale;
    (text.chars().count() * advance).saturating_sub(scale)
}

/// Draws a text in linear RGB with its top left corner at (x, y); what leaves the picture is cut.
pub fn draw_text(
    picture: &mut Picture,
    (x, y): (usize, usize),
    text: &str,
    scale: usize,
    linear: [f64; 3],
) {
    for (index, c) in text.chars().enumerate() {
        for (row, bits) in rows(c).into_iter().enumerate() {
            for column in (0..5).filter(|column| bits >> (4 - column) & 1 == 1) {
                let left = x + (index * ADVANCE + column) * scale;
                fill(picture, (left, y + row * scale), (scale, scale), linear);
            }
        }
    }
}

/// Fills a rectangle with a linear colour and marks it as covered; what leaves the picture is cut.
pub fn fill(
    picture: &mut Picture,
    (x, y): (usize, usize),
    (width, height): (usize, usize),
    linear: [f64; 3],
) {
    for row in y..(y + height).min(picture.height) {
        for column in x..(x + width).min(picture.width) {
            let at = row * picture.width + column;
            picture.rgb[at] = linear;
            picture.covered[at] = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_characters_look_alike_and_all_fit_five_columns() {
        let known = " 0123456789ABCDEFGHIJKLMNPQRSTUVWXYZ/-.,:=+<>()|;^'O?";
        let shapes: Vec<[u8; 7]> = known.chars().map(rows).collect();
        for (at, shape) in shapes.iter().enumerate() {
            assert!(shape.iter().all(|&bits| bits < 32));
            assert!(!shapes[..at].contains(shape), "{:?}", known.chars().nth(at));
        }
        assert_eq!(rows('a'), rows('A'));
    }

    #[test]
    fn text_is_drawn_where_it_is_put_and_cut_at_the_edge() {
        let mut picture = Picture::new(12, 9);
        draw_text(&mut picture, (1, 1), "1-", 1, [1.0; 3]);
        let lit = |x: usize, y: usize| picture.covered[y * 12 + x];
        assert!(lit(3, 1) && lit(2, 7) && lit(7, 4) && lit(11, 4));
        assert!(!lit(0, 0) && !lit(6, 4) && !lit(1, 1));
        draw_text(&mut picture, (10, 7), "88", 3, [1.0; 3]);
        assert_eq!(picture.rgb.len(), 12 * 9);
        assert_eq!(text_width("88", 3), 33);
    }
}

//! The tap map and unfolded cubes of the picture.

use super::cube::{SMALL, Shown};
use super::plot::{Canvas, FAINT, IDEAL, INK, heat};
use super::taps::Tap;
use super::transfer::Transfer;
use super::{Fingerprint, MAP, MAP_ANGLES, Mapped};
use crate::base::num;
use crate::sampler::Source;

/// How large the tap map is drawn.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    /// Pixels of a texel.
    texel: usize,
    /// Texels that a cell shows.
    shown: usize,
}

/// One map alone.
pub(super) const LARGE: Scale = Scale { texel: 8, shown: 24 };
/// Two maps side by side; a filter over an ellipse needs more texels than a line of taps.
pub(super) const SMALL_SCALE: Scale = Scale { texel: 4, shown: 32 };

impl Scale {
    /// Pixels of a cell.
    const fn inside(self) -> usize {
        self.shown * self.texel
    }

    /// Pixels of a cell with its gap.
    pub(super) const fn cell(self) -> usize {
        self.inside() + 4
    }
}

/// Pixels of a texel on a cube.
pub(super) const CUBE_TEXEL: usize = 9;

/// Every texel's weight over ratio and angle, taps as dots.
pub(super) fn tap_map(
    canvas: &mut Canvas,
    (x, y): (usize, usize),
    scale: Scale,
    source: Source,
    map: &[Mapped],
    found: &Fingerprint,
) {
    let clamp = map.first().map_or(1, |m| m.footprint.clamp);
    let title = format!(
        "texels of {} on a 2-D texture, clamp {clamp}: darkest = largest weight; black dots: bilinear taps",
        source.name()
    );
    canvas.text((x, y), &title, 1, INK);
    for (column, angle) in MAP_ANGLES.iter().enumerate() {
        canvas.text((x + column * scale.cell(), y + 16), &format!("{angle} deg"), 1, INK);
    }
    for (row, m) in map.chunks(MAP_ANGLES.len()).enumerate() {
        for (column, m) in m.iter().enumerate() {
            let corner = (x + column * scale.cell(), y + 28 + row * scale.cell());
            let taps = found
                .taps
                .iter()
                .find(|t| source == Source::Gradient && t.footprint == m.footprint && t.explains());
            cell(canvas, corner, scale, &m.transfer, taps.map_or(&[], |t| &t.taps));
            if column == 0 {
                let label = format!("ratio {}", m.footprint.ratio);
                canvas.text((corner.0 + 3, corner.1 + 3), &label, 1, INK);
            }
            let label = format!("level {}", m.transfer.main_level());
            canvas.text((corner.0 + 3, corner.1 + scale.inside() - 10), &label, 1, INK);
        }
    }
}

/// The texels around the middle of the level that is read most.
fn cell(
    canvas: &mut Canvas,
    (x, y): (usize, usize),
    scale: Scale,
    transfer: &Transfer,
    taps: &[Tap],
) {
    let level = transfer.main_level();
    let side = MAP >> level;
    let most = transfer.levels[level].iter().fold(0.0f32, |a, b| a.max(*b));
    canvas.frame((x, y), (scale.inside() + 1, scale.inside() + 1), FAINT);
    for row in 0..scale.shown {
        for column in 0..scale.shown {
            let place =
                |c: usize| (c + side / 2).checked_sub(scale.shown / 2).filter(|c| *c < side);
            let (Some(column_at), Some(row_at)) = (place(column), place(row)) else {
                continue;
            };
            let weight = transfer.levels[level][row_at * side + column_at];
            if weight > 0.0 {
                let color = heat(f64::from(weight / most));
                canvas.rect(
                    (x + column * scale.texel + 1, y + row * scale.texel + 1),
                    (scale.texel - 1, scale.texel - 1),
                    color,
                );
            }
        }
    }
    let middle = (scale.shown / 2) as f64 + 0.5;
    for tap in taps {
        let [tx, ty] = tap.offset.map(|o| (middle + o) * scale.texel as f64);
        if tx >= 0.0 && ty >= 0.0 {
            canvas.rect((x + num::index(tx), y + num::index(ty)), (2, 2), INK);
        }
    }
}

/// The faces of a cube around +z, unfolded, with the weights of the level that is read most.
pub(super) fn net(canvas: &mut Canvas, (x, y): (usize, usize), shown: &Shown) {
    let level = shown.transfer.main_level();
    let side = SMALL >> level;
    let texel = CUBE_TEXEL << level;
    let face_size = SMALL * CUBE_TEXEL;
    let most = shown.transfer.levels[level].iter().fold(0.0f32, |a, b| a.max(*b));
    // Columns −x, +z, +x, −z; +y above +z and −y below it.
    let places = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)];
    for (face, (column, row)) in places.into_iter().enumerate() {
        let corner = (x + column * face_size, y + row * face_size);
        for t in 0..side * side {
            let weight = shown.transfer.levels[level][face * side * side + t];
            if weight > 0.0 {
                let at = (corner.0 + t % side * texel, corner.1 + t / side * texel);
                canvas.rect(at, (texel, texel), heat(f64::from(weight / most)));
            }
        }
        canvas.frame(corner, (face_size, face_size), IDEAL);
    }
    canvas.text((x, y), &format!("{}, level {level}", shown.title), 1, INK);
}

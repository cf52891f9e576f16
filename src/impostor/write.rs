//! An impostor as one EXR file.

use std::io::Write;

use super::Impostor;
use crate::image::write_planes;

/// Writes level 0 of an impostor: six faces stacked vertically, +X −X +Y −Y +Z −Z from the top, each
/// oriented as Vulkan has it, texel centres at half texels.
///
/// Channels, all f32: `R G B` linear colour, `distance` Euclidean (+∞ where nothing is seen), `wall.index`
/// the number of the wall (−1: none) and `wall.u wall.v` the place on it, 0…1. There is no `envmap`
/// attribute, because that would claim OpenEXR's own cube (samples on the edges, mirrored faces); the
/// attribute `tapline.faces` says in words what the file has. [`crate::image::load_environment`] and
/// [`crate::image::load_distance`] read it back without a change of a bit.
///
/// # Errors
/// As [`write_planes()`].
pub fn write_impostor(
    target: &mut impl Write,
    impostor: &Impostor,
    attributes: &[(String, String)],
) -> std::io::Result<()> {
    let level = &impostor.colour.levels[0];
    let colour = |c: usize| level.texels.iter().map(|t| t[c]).collect::<Vec<f32>>();
    let wall = |f: &dyn Fn(&super::WallPlace) -> f32| {
        impostor.walls.texels.iter().map(f).collect::<Vec<f32>>()
    };
    #[expect(
        clippy::cast_precision_loss,
        reason = "a world has few walls; f32 is exact up to 2^24"
    )]
    let planes = [
        ("R", colour(0)),
        ("G", colour(1)),
        ("B", colour(2)),
        ("distance", impostor.distance.texels.clone()),
        ("wall.index", wall(&|w| w.wall as f32)),
        ("wall.u", wall(&|w| w.uv[0])),
        ("wall.v", wall(&|w| w.uv[1])),
    ];
    let mut all = attributes.to_vec();
    all.push((
        "tapline.faces".into(),
        "+x -x +y -y +z -z from the top, Vulkan orientation, centres at half texels".into(),
    ));
    let planes = planes.map(|(name, samples)| (name.to_string(), samples));
    write_planes(target, [level.size, 6 * level.size], planes.to_vec(), &all)
}

//! Footprints at the hit: a cone's disc, its cut with the wall, the mirror's own derivative and the exact
//! differential, each through the elliptical Gaussian and against supersampled rays.

use glam::DVec3;
use rayon::prelude::*;

use crate::cube::{CubeMap, FACE_AXES, face_uv};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::picture::Picture;
use crate::reference::hit::{basis, onto_plane};
use crate::reference::{Env, Flags, Texture, ewa_counted};
use crate::report::metrics;
use crate::scene::hit::HitScene;
use crate::truth::texels::PaddedCube;
use crate::truth::{TruthOptions, TruthPicture, each, supersample};

/// What spans the footprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Footprint {
    /// |w|·[t1 t2] across the ray.
    Disc,
    /// The disc's cut with the wall, stretched at most by the unit's 16 probes.
    Plane,
    /// The change of R alone, as if the wall were infinitely far: |l|·[∂R/∂x ∂R/∂y].
    Mirror,
    /// The change of the real hit over a pixel; the disc where the pixel meets two walls.
    Differential,
}

/// All of them, with the figure that each has.
const FOOTPRINTS: [(Footprint, &str); 4] = [
    (Footprint::Disc, "footprint_disc_psnr_db"),
    (Footprint::Plane, "footprint_plane_psnr_db"),
    (Footprint::Mirror, "footprint_mirror_psnr_db"),
    (Footprint::Differential, "footprint_differential_psnr_db"),
];

/// Face, u, v and K of a footprint spanned by two changes of l.
fn spanned(l: DVec3, columns: [DVec3; 2]) -> Env {
    let (face, u, v) = face_uv(l.to_array());
    let [(s, s_sign), (t, t_sign), (m, m_sign)] = FACE_AXES[face];
    let major = l[m].abs();
    let column = |c: DVec3| {
        let along = m_sign * c[m];
        [(s_sign * c[s] - u * along) / major, (t_sign * c[t] - v * along) / major]
    };
    let [[a, b], [c, d]] = columns.map(column);
    Env {
        face,
        u,
        v,
        d: [[a, c], [b, d]],
        k: [a * a + c * c, a * b + c * d, b * b + d * d],
        lambda: [0.0; 2],
        axis: [1.0, 0.0],
        probes: 1,
        lod: 0.0,
        flags: Flags::default(),
        color: [0.0; 3],
    }
}

/// The first ray at an image position.
fn first(scene: &HitScene, px: f64, py: f64) -> Option<HitFragment> {
    let mut found = None;
    scene.view.leaving(px, py, &mut |leaving| {
        if found.is_none() {
            found = Some(leaving.fragment);
        }
    });
    found
}

fn differences(
    scene: &HitScene,
    [px, py]: [f64; 2],
    of: &dyn Fn(HitFragment) -> Option<DVec3>,
) -> Option<[DVec3; 2]> {
    let at = |px: f64, py: f64| first(scene, px, py).and_then(of);
    Some([at(px + 0.5, py)? - at(px - 0.5, py)?, at(px, py + 0.5)? - at(px, py - 0.5)?])
}

/// The picture of real hits whose footprints are filtered by the elliptical Gaussian on the impostor's
/// texels.
fn filtered(scene: &HitScene, map: &CubeMap, kind: Footprint) -> Picture {
    let texture = Texture::new(map);
    let pixels = scene.pixels();
    let colours: Vec<[f64; 3]> = pixels
        .par_iter()
        .map(|pixel| {
            let [px, py] = pixel.map(|c| f64::from(c) + 0.5);
            let one = || {
                let ray = first(scene, px, py)?;
                let sight = scene.view.world.look(ray.x.into(), ray.r.into())?;
                let [angle, width] = ray.cone?;
                let w = (width + angle * sight.meeting.t).abs();
                let disc = basis(ray.r).map(|t| DVec3::from(t) * w);
                let l = sight.point;
                let columns = match kind {
                    Footprint::Disc => disc,
                    Footprint::Plane => {
                        let normal = sight.meeting.normal.to_array();
                        onto_plane(ray.r, disc.map(|t| t.to_array()), normal, 16).map(DVec3::from)
                    }
                    Footprint::Mirror => {
                        let change = |ray: HitFragment| Some(DVec3::from(ray.r) * l.length());
                        differences(scene, [px, py], &change).unwrap_or(disc)
                    }
                    Footprint::Differential => differences(scene, [px, py], &|ray| {
                        let other = scene.view.world.look(ray.x.into(), ray.r.into())?;
                        (other.wall == sight.wall).then_some(other.point)
                    })
                    .unwrap_or(disc),
                };
                Some(ewa_counted(&spanned(l, columns), &texture).color)
            };
            one().unwrap_or([0.0; 3])
        })
        .collect();
    let mut picture = Picture::new(scene.width, scene.height);
    for ([column, row], colour) in pixels.into_iter().zip(colours) {
        let index = row as usize * scene.width + column as usize;
        picture.rgb[index] = colour;
        picture.covered[index] = true;
    }
    picture
}

/// Real rays through every pixel that read the impostor's texels; the footprints approximate them.
fn supersampled(scene: &HitScene, map: &CubeMap, options: &TruthOptions) -> TruthPicture {
    let colours = PaddedCube::new(&map.levels[0]);
    let shade = |px: f64, py: f64| {
        let ray = first(scene, px, py)?;
        Some(
            scene
                .view
                .world
                .look(ray.x.into(), ray.r.into())
                .map_or([0.0; 3], |sight| colours.look_up(sight.point.to_array())),
        )
    };
    let pixels = scene.pixels();
    supersample([scene.width, scene.height], &pixels, &each(shade), options, &|_| {})
}

/// Figures by name: each footprint's PSNR against supersampled rays, and the error of those as they are shown.
pub(super) fn figures(
    scene: &HitScene,
    map: &CubeMap,
    options: &TruthOptions,
    exposure: f64,
) -> Result<Vec<(&'static str, Option<f64>)>, InputError> {
    let truth = supersampled(scene, map, options);
    let mut out = vec![("footprint_rays_lsb8", Some(255.0 * truth.rms_display_error))];
    for (kind, figure) in FOOTPRINTS {
        let pair = metrics::compare(&filtered(scene, map, kind), &truth.picture, exposure)?;
        out.push((figure, pair.psnr_db));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::cube::direction;

    #[test]
    fn a_span_is_the_derivative_of_the_face_coordinates() {
        for face in 0..6 {
            let l = 2.5 * DVec3::from(direction(face, 0.3, -0.6));
            let columns = [dvec3(0.2, -0.1, 0.3), dvec3(-0.4, 0.25, 0.15)];
            let got = spanned(l, columns);
            for (j, column) in columns.iter().enumerate() {
                let h = 1e-6;
                let at = |s: f64| face_uv((l + s * *column).to_array());
                let ((_, u0, v0), (_, u1, v1)) = (at(-h), at(h));
                // Central differences: h² of curvature and 1e-16/h of rounding.
                assert!(((u1 - u0) / (2.0 * h) - got.d[0][j]).abs() < 1e-9);
                assert!(((v1 - v0) / (2.0 * h) - got.d[1][j]).abs() < 1e-9);
            }
        }
    }
}

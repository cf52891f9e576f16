//! Triangle meshes: read from OBJ and glTF files, checked, fitted into a ball, met by rays.
//!
//! A file is read into corners as it has them ([`Soup`]), which is then checked, fitted and completed
//! ([`Mesh`]). Only [`Mesh`] meets rays, so nothing that a ray sees has not been checked.

#[cfg(feature = "files")]
mod accessors;
#[cfg(feature = "files")]
mod buffers;
mod bvh;
mod fit;
#[cfg(feature = "files")]
mod gltf_file;
mod intersect;
mod normals;
#[cfg(feature = "files")]
mod obj;
#[cfg(feature = "files")]
mod polygon;
#[cfg(feature = "files")]
mod pose;
#[cfg_attr(not(feature = "files"), path = "unread.rs")]
mod read;

use std::path::Path;

use glam::DVec3;

use crate::error::InputError;
use crate::taken::Taken;
pub use intersect::{Barycentric, meet};
#[cfg(feature = "files")]
pub use read::MAX_TRIANGLES;
use read::read;
#[cfg(feature = "files")]
use read::{MAX_BYTES, admit};

/// Largest magnitude of a coordinate: squares and cubes of it are far from the largest double.
const MAX_COORDINATE: f64 = 1e18;

/// One corner of a triangle: indices into the lists of a [`Soup`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Position.
    pub position: u32,
    /// Normal, if the file gives one.
    pub normal: Option<u32>,
    /// Texture coordinates, if the file gives some.
    pub texcoord: Option<u32>,
}

/// Triangles as a file has them. Indices are in range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Positions.
    pub positions: Vec<[f64; 3]>,
    /// Normals of any length.
    pub normals: Vec<[f64; 3]>,
    /// Texture coordinates: s to the right, t **down** the picture.
    pub texcoords: Vec<[f64; 2]>,
    /// Corners, counter-clockwise seen from outside.
    pub triangles: Vec<[Corner; 3]>,
    /// What the reader has to say about the file.
    pub remarks: Vec<String>,
}

/// The axis of a file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Up {
    /// y, as in glTF.
    #[default]
    Y,
    /// z, as CAD programs have it: (x, y, z) becomes (x, z, −y).
    Z,
}

/// The changes to a file's triangles, for a line on stderr.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Triangles without area, left out.
    pub degenerate: usize,
    /// Corners whose normal was absent or zero and was computed.
    pub normals_computed: usize,
}

impl Repairs {
    /// In words, or nothing where nothing was done.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        (*self != Self::default()).then(|| {
            format!(
                "{} triangles without area left out, normals of {} corners computed",
                self.degenerate, self.normals_computed
            )
        })
    }
}

/// A triangle that rays meet: everything at its corners, ready to be interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Positions of the corners, counter-clockwise from outside.
    pub positions: [DVec3; 3],
    /// Unit normals at the corners.
    pub normals: [DVec3; 3],
    /// Texture coordinates at the corners; zero where the mesh is not textured.
    pub texcoords: [[f64; 2]; 3],
}

impl Triangle {
    /// A vector across the triangle's plane, outwards: twice its area long.
    #[must_use]
    pub fn plane_normal(&self) -> DVec3 {
        let [a, b, c] = self.positions;
        (b - a).cross(c - a)
    }

    /// Directions in the plane along which s and t grow; of any length. Where the texture coordinates
    /// span no area: an edge, and the direction across it that is right for a map seen from outside.
    #[must_use]
    pub fn tangents(&self) -> (DVec3, DVec3) {
        let [a, b, c] = self.positions;
        let (ab, ac) = (b - a, c - a);
        let [ta, tb, tc] = self.texcoords;
        let (s1, t1) = (tb[0] - ta[0], tb[1] - ta[1]);
        let (s2, t2) = (tc[0] - ta[0], tc[1] - ta[1]);
        let area = s1 * t2 - s2 * t1;
        if area == 0.0 || !area.is_finite() {
            return (ab, ab.cross(self.plane_normal()));
        }
        let sign = area.signum();
        (sign * (ab * t2 - ac * t1), sign * (ac * s1 - ab * s2))
    }
}

/// A mesh that rays meet.
#[derive(Clone, Debug)]
pub struct Mesh {
    triangles: Vec<Triangle>,
    untextured: usize,
    tree: bvh::Tree,
}

impl Mesh {
    /// Reads a file (`.obj`, `.glb` or `.gltf`, by its contents) and fits it into a ball: the middle of its
    /// bounding box goes to `centre`, its farthest corner to the distance `radius`.
    ///
    /// # Errors
    /// A file that cannot be read, is of neither kind, is damaged or too large, or has no triangle
    /// with an area.
    pub fn load(
        path: &Path,
        up: Up,
        centre: DVec3,
        radius: f64,
    ) -> Result<(Self, Repairs, Taken), InputError> {
        let subject = path.display().to_string();
        let (mut soup, format) = read(path, &subject)?;
        if up == Up::Z {
            for vector in soup.positions.iter_mut().chain(&mut soup.normals) {
                *vector = [vector[0], vector[2], -vector[1]];
            }
        }
        let (mesh, repairs) = Self::new(&soup, &subject, centre, radius)?;
        let (count, up) = (mesh.triangles.len(), if up == Up::Y { "y" } else { "z" });
        let mut remarks = soup.remarks;
        remarks.extend(repairs.note());
        if (1..count).contains(&mesh.untextured) {
            remarks.push(format!("{} triangles without texture coordinates", mesh.untextured));
        }
        let taken = Taken {
            option: "--mesh",
            file: subject,
            kind: format!("{format}, {count} triangles, {up} up"),
            remarks,
            flags: &["--mesh-up"],
            ..Taken::default()
        };
        Ok((mesh, repairs, taken))
    }

    /// The mesh of a soup, fitted into a ball.
    ///
    /// # Errors
    /// A coordinate that is not finite or beyond 10¹⁸, or no triangle with an area.
    pub fn new(
        soup: &Soup,
        subject: &str,
        centre: DVec3,
        radius: f64,
    ) -> Result<(Self, Repairs), InputError> {
        check_numbers(soup, subject)?;
        let positions = fit::fitted(soup, subject, centre, radius)?;
        let (kept, degenerate) = fit::with_area(&soup.triangles, &positions);
        if kept.is_empty() {
            return Err(InputError::new(
                subject,
                "a triangle with an area",
                format!("{degenerate} triangles, all without"),
                "check the mesh in the program that wrote it",
            ));
        }
        let (corner_normals, normals_computed) = normals::complete(soup, &kept, &positions);
        let untextured = kept.iter().filter(|t| t.iter().any(|c| c.texcoord.is_none())).count();
        let triangles: Vec<Triangle> = kept
            .iter()
            .zip(corner_normals)
            .map(|(corners, normals)| Triangle {
                positions: corners.map(|c| positions[c.position as usize]),
                normals,
                texcoords: corners
                    .map(|c| c.texcoord.map_or([0.0; 2], |i| soup.texcoords[i as usize])),
            })
            .collect();
        let tree = bvh::Tree::new(&triangles);
        let mesh = Self { triangles, untextured, tree };
        let repairs = Repairs { degenerate, normals_computed };
        Ok((mesh, repairs))
    }

    /// The triangles in the file's order, without those that have no area.
    #[must_use]
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Triangles without texture coordinates.
    #[must_use]
    pub fn untextured(&self) -> usize {
        self.untextured
    }

    /// The nearest triangle that a ray meets at a multiple of `direction` within (`after`, ∞): its
    /// index. Of triangles at the same distance the first.
    #[must_use]
    pub fn nearest(&self, origin: DVec3, direction: DVec3, after: f64) -> Option<usize> {
        self.tree.nearest(&self.triangles, origin, direction, after)
    }
}

/// Refuses numbers that no surface can be made of, by the first triangle that uses one.
fn check_numbers(soup: &Soup, subject: &str) -> Result<(), InputError> {
    let bad = |c: &f64| c.is_nan() || c.abs() > MAX_COORDINATE;
    let fail = |triangle: usize, what: &str, values: &[f64]| {
        let shown: Vec<String> = values.iter().map(f64::to_string).collect();
        Err(InputError::new(
            subject,
            format!("finite {what} of at most 1e18"),
            shown.join(" "),
            "export the mesh again",
        )
        .at(format!("triangle {triangle}")))
    };
    for (index, corners) in soup.triangles.iter().enumerate() {
        for corner in corners {
            let position = &soup.positions[corner.position as usize];
            if position.iter().any(bad) {
                return fail(index, "position", position);
            }
            if let Some(normal) = corner.normal.map(|i| &soup.normals[i as usize])
                && normal.iter().any(bad)
            {
                return fail(index, "normal", normal);
            }
            if let Some(texcoord) = corner.texcoord.map(|i| &soup.texcoords[i as usize])
                && texcoord.iter().any(bad)
            {
                return fail(index, "texture coordinates", texcoord);
            }
        }
    }
    Ok(())
}

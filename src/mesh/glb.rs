//! glTF 2.0 binary (`.glb`): the triangles of the default scene's nodes, in world space.
//!
//! The crate `gltf` reads the JSON and checks its indices; the accessors' bytes are read here, with every
//! range checked. Nodes are transformed by matrix or by translation, rotation and scale, parents first; normals by the inverse
//! transpose; a transform that mirrors turns the winding around, as the specification asks. Materials, skins, morph targets and stored tangents are not used.
//! Refused: external or inline (`uri`) buffers, sparse accessors, and required extensions that may
//! change geometry.

use glam::{DMat3, DMat4, DVec3};
use gltf::Semantic;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;

use super::{Corner, Soup, admit};
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;

/// Reads the bytes of a file.
///
/// # Errors
/// A damaged file, a feature that is refused by name above, or no triangle; with the place in the JSON.
pub(super) fn parse(bytes: &[u8], subject: &str) -> Result<Soup, InputError> {
    let damaged = |found: String| {
        InputError::new(subject, "a glTF 2.0 binary file", found, "export the mesh again")
    };
    let file = guarded(|| gltf::Glb::from_slice(bytes))
        .map_err(damaged)?
        .map_err(|e| damaged(e.to_string()))?;
    let root: serde_json::Value =
        serde_json::from_slice(&file.json).map_err(|e| damaged(e.to_string()).at("JSON"))?;
    refuse_extensions(&root, subject)?;
    let document = guarded(|| gltf::Gltf::from_slice(bytes))
        .map_err(damaged)?
        .map_err(|e| damaged(e.to_string()))?
        .document;
    for buffer in document.buffers() {
        if let gltf::buffer::Source::Uri(uri) = buffer.source() {
            let start: String = uri.chars().take(40).collect();
            return Err(InputError::new(
                subject,
                "all data in the file's own binary chunk",
                format!("a buffer at `{start}`"),
                "export as one .glb without external or inline buffers",
            )
            .at(format!("buffers[{}].uri", buffer.index())));
        }
    }
    let reader = Reader { subject, data: file.bin.as_deref().unwrap_or_default() };
    // The iterators of the crate trust indices that it has checked; a gap in that is an error too.
    guarded(|| reader.scene(&document)).map_err(damaged)?
}

/// Refuses required extensions but those that concern light, material and texture.
fn refuse_extensions(root: &serde_json::Value, subject: &str) -> Result<(), InputError> {
    let harmless = ["KHR_materials_", "KHR_texture_", "KHR_lights_"];
    let list = root.get("extensionsRequired").and_then(|v| v.as_array());
    for (index, name) in list.into_iter().flatten().enumerate() {
        let name = name.as_str().unwrap_or_default();
        if !harmless.iter().any(|h| name.starts_with(h)) {
            return Err(InputError::new(
                subject,
                "no required extension that changes geometry",
                format!("`{name}`"),
                "export without compression and quantisation",
            )
            .at(format!("extensionsRequired[{index}]")));
        }
    }
    Ok(())
}

/// The file's binary chunk and its name.
struct Reader<'a> {
    subject: &'a str,
    data: &'a [u8],
}

impl Reader<'_> {
    fn error(&self, place: String, expected: &str, found: String) -> InputError {
        InputError::new(self.subject, expected, found, "export the mesh again").at(place)
    }

    /// Every triangle below the default scene, or the first, or, without a scene, below all nodes that
    /// are no other's child.
    fn scene(&self, document: &gltf::Document) -> Result<Soup, InputError> {
        let mut soup = Soup::default();
        let identity = DMat4::IDENTITY;
        let mut open: Vec<(gltf::Node<'_>, DMat4)> =
            match document.default_scene().or_else(|| document.scenes().next()) {
                Some(scene) => scene.nodes().map(|n| (n, identity)).collect(),
                None => {
                    let mut child = vec![false; document.nodes().count()];
                    for node in document.nodes().flat_map(|n| n.children()) {
                        child[node.index()] = true;
                    }
                    let roots = document.nodes().filter(|n| !child[n.index()]);
                    roots.map(|n| (n, identity)).collect()
                }
            };
        open.reverse();
        let mut seen = vec![false; document.nodes().count()];
        while let Some((node, parent)) = open.pop() {
            let index = node.index();
            if std::mem::replace(&mut seen[index], true) {
                return Err(self.error(
                    format!("nodes[{index}]"),
                    "a node with at most one parent",
                    "one that is reached twice".into(),
                ));
            }
            let local = node.transform().matrix().map(|column| column.map(f64::from));
            let own = parent * DMat4::from_cols_array_2d(&local);
            if let Some(mesh) = node.mesh() {
                for primitive in mesh.primitives() {
                    let place =
                        format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
                    self.primitive(&primitive, own, &place, &mut soup)?;
                }
            }
            let children: Vec<_> = node.children().map(|n| (n, own)).collect();
            open.extend(children.into_iter().rev());
        }
        if soup.triangles.is_empty() {
            return Err(self.error(
                "scene".into(),
                "a node with a mesh of triangles",
                "none".into(),
            ));
        }
        Ok(soup)
    }

    /// Adds a primitive's triangles; points and lines have none.
    fn primitive(
        &self,
        primitive: &gltf::Primitive<'_>,
        node: DMat4,
        place: &str,
        soup: &mut Soup,
    ) -> Result<(), InputError> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let at = |name: &str| format!("{place}.attributes.{name}");
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Err(self.error(at("POSITION"), "positions", "none".into()));
        };
        let positions = self.floats::<3>(&accessor, &at("POSITION"))?;
        let normals = match primitive.get(&Semantic::Normals) {
            None => None,
            Some(accessor) => Some(self.floats::<3>(&accessor, &at("NORMAL"))?),
        };
        let texcoords = match primitive.get(&Semantic::TexCoords(0)) {
            None => None,
            Some(accessor) => Some(self.floats::<2>(&accessor, &at("TEXCOORD_0"))?),
        };
        for (name, length) in [
            ("NORMAL", normals.as_ref().map(Vec::len)),
            ("TEXCOORD_0", texcoords.as_ref().map(Vec::len)),
        ] {
            if let Some(length) = length.filter(|n| *n != positions.len()) {
                let expected = format!("{} entries, as POSITION has", positions.len());
                return Err(self.error(at(name), &expected, length.to_string()));
            }
        }
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, &format!("{place}.indices"))?,
            None => (0..num::u32(positions.len())).collect(),
        };
        if let Some(index) = indices.iter().position(|i| *i as usize >= positions.len()) {
            return Err(self.error(
                format!("{place}.indices, entry {index}"),
                &format!("an index into {} positions", positions.len()),
                indices[index].to_string(),
            ));
        }
        let count = if mode == Mode::Triangles {
            indices.len() / 3
        } else {
            indices.len().saturating_sub(2)
        };
        admit(soup.triangles.len() + count, self.subject, || place.to_string())?;
        let base = [soup.positions.len(), soup.normals.len(), soup.texcoords.len()];
        // Below 2²² triangles and 2²⁸ bytes a list, so the sums fit; a gap would be out of range later.
        let shifted = |base: usize, i: u32| num::u32(base + i as usize);
        let corner = |i: u32| Corner {
            position: shifted(base[0], i),
            normal: normals.as_ref().map(|_| shifted(base[1], i)),
            texcoord: texcoords.as_ref().map(|_| shifted(base[2], i)),
        };
        let (turn, mirrors) = for_normals(node);
        for k in 0..count {
            let [a, b, c] = if mode == Mode::Triangles {
                [3 * k, 3 * k + 1, 3 * k + 2]
            } else if mode == Mode::TriangleFan {
                [k + 1, k + 2, 0]
            } else if k % 2 == 1 {
                // Every other triangle of a strip is wound the other way.
                [k, k + 2, k + 1]
            } else {
                [k, k + 1, k + 2]
            };
            let [a, b, c] = if mirrors { [a, c, b] } else { [a, b, c] };
            soup.triangles.push([a, b, c].map(|i| corner(indices[i])));
        }
        let place = |p: &[f64; 3]| node.transform_point3(DVec3::from(*p)).to_array();
        let turn = |n: &[f64; 3]| (turn * DVec3::from(*n)).to_array();
        soup.positions.extend(positions.iter().map(place));
        soup.normals.extend(normals.iter().flatten().map(turn));
        soup.texcoords.extend(texcoords.iter().flatten());
        Ok(())
    }

    /// The bytes of each entry of an accessor.
    fn entries(
        &self,
        accessor: &gltf::Accessor<'_>,
        size: usize,
        place: &str,
    ) -> Result<impl Iterator<Item = &[u8]>, InputError> {
        let place = format!("{place} (accessors[{}])", accessor.index());
        if accessor.sparse().is_some() {
            return Err(self.error(place, "a dense accessor", "a sparse one".into()));
        }
        let Some(view) = accessor.view() else {
            let found = "none (compressed data has none)".into();
            return Err(self.error(place, "a bufferView", found));
        };
        let stride = view.stride().unwrap_or(size);
        let count = accessor.count();
        let range = (|| {
            if view.buffer().index() != 0 || stride < size || count == 0 {
                return None;
            }
            let inside = (count - 1).checked_mul(stride)?.checked_add(size)?;
            if accessor.offset().checked_add(inside)? > view.length() {
                return None;
            }
            if view.offset().checked_add(view.length())? > self.data.len() {
                return None;
            }
            let start = view.offset().checked_add(accessor.offset())?;
            self.data.get(start..start.checked_add(inside)?)
        })();
        let Some(bytes) = range else {
            let found = format!(
                "{count} of {size} bytes every {stride} at {} in a view of {} at {} of {}",
                accessor.offset(),
                view.length(),
                view.offset(),
                self.data.len()
            );
            return Err(self.error(place, "entries inside the binary chunk", found));
        };
        Ok(bytes.chunks(stride).map(move |chunk| &chunk[..size]))
    }

    /// Vectors of floats, or of normalised unsigned bytes and shorts.
    fn floats<const N: usize>(
        &self,
        accessor: &gltf::Accessor<'_>,
        place: &str,
    ) -> Result<Vec<[f64; N]>, InputError> {
        let dimensions = if N == 2 { Dimensions::Vec2 } else { Dimensions::Vec3 };
        let kind = (accessor.data_type(), accessor.normalized());
        let width = match kind {
            (DataType::F32, _) => 4,
            (DataType::U16, true) if N == 2 => 2,
            (DataType::U8, true) if N == 2 => 1,
            _ => 0,
        };
        if width == 0 || accessor.dimensions() != dimensions {
            let found = format!("{:?} of {:?}", accessor.dimensions(), accessor.data_type());
            return Err(self.error(place.to_string(), &format!("{dimensions:?} of floats"), found));
        }
        let number = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            [a, b] => f64::from(u16::from_le_bytes([a, b])) / 65535.0,
            [a] => f64::from(a) / 255.0,
            _ => f64::NAN,
        };
        let entries = self.entries(accessor, N * width, place)?;
        Ok(entries
            .map(|entry| std::array::from_fn(|i| number(&entry[i * width..(i + 1) * width])))
            .collect())
    }

    /// Unsigned indices.
    fn indices(&self, accessor: &gltf::Accessor<'_>, place: &str) -> Result<Vec<u32>, InputError> {
        let width = match accessor.data_type() {
            DataType::U8 => 1,
            DataType::U16 => 2,
            DataType::U32 => 4,
            DataType::I8 | DataType::I16 | DataType::F32 => 0,
        };
        if width == 0 || accessor.dimensions() != Dimensions::Scalar {
            let found = format!("{:?} of {:?}", accessor.dimensions(), accessor.data_type());
            return Err(self.error(place.to_string(), "unsigned integers", found));
        }
        let number = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            [a, b] => u32::from(u16::from_le_bytes([a, b])),
            [a] => u32::from(a),
            _ => u32::MAX,
        };
        Ok(self.entries(accessor, width, place)?.map(number).collect())
    }
}

/// The cofactors of a place, turned around where it mirrors: a positive multiple of the inverse transpose, which exists
/// even where a scale is zero. Second: whether it mirrors.
fn for_normals(place: DMat4) -> (DMat3, bool) {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = DMat3::from_mat4(place);
    let mirrors = x.cross(y).dot(z) < 0.0;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    (if mirrors { -cofactors } else { cofactors }, mirrors)
}

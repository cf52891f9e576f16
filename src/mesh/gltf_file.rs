//! glTF 2.0, binary (`.glb`) or text (`.gltf`): the triangles of the default scene's nodes, in world space.
//!
//! The crate `gltf` reads what JSON concerns geometry and checks its indices; the accessors' bytes are read in
//! [`accessors`](super::accessors). Nodes are transformed by matrix or by translation, rotation and scale, parents
//! first; normals by the inverse transpose; a transform that mirrors turns the winding around, as the specification
//! asks. A skinned mesh stands where its joints put it, morph targets have their default weights, and a mesh without normals is flat.
//! Materials, animations and stored tangents are not used.

use std::borrow::Cow;
use std::cell::Cell;
use std::path::Path;

use glam::{DMat4, DVec3};
use gltf::Semantic;
use gltf::mesh::Mode;
use serde_json::Value;

use super::accessors::{MAX_VERTICES, Reader};
use super::pose::{Places, local, posed};
use super::{Corner, Soup, admit, buffers};
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;

/// Beginnings of the extensions that concern neither the vertices nor where they stand.
const HARMLESS: [&str; 24] = [
    "ADOBE_materials_",
    "AGI_",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_",
    "GODOT_",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_interactivity",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_physics_",
    "KHR_techniques_webgl",
    "KHR_texture_",
    "KHR_xmp",
    "MSFT_",
    "NV_materials_",
    "VRM",
];

/// The extension whose integer positions are read.
const QUANTIZATION: &str = "KHR_mesh_quantization";

/// Keys of the root that geometry does not need.
const UNUSED: [&str; 8] = [
    "animations",
    "cameras",
    "extensionsUsed",
    "extensions",
    "images",
    "materials",
    "samplers",
    "textures",
];

/// Reads the bytes of a file.
///
/// # Errors
/// A damaged file, a required extension that may change geometry, or no triangle; with the place in the JSON.
pub(super) fn parse(bytes: &[u8], path: &Path, subject: &str) -> Result<Soup, InputError> {
    let damaged =
        |found: String| InputError::new(subject, "a glTF 2.0 file", found, "export the mesh again");
    let (json, chunk): (Cow<'_, [u8]>, _) = if bytes.starts_with(b"glTF") {
        let file = guarded(|| gltf::Glb::from_slice(bytes))
            .map_err(damaged)?
            .map_err(|e| damaged(e.to_string()))?;
        (file.json, file.bin)
    } else {
        (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).into(), None)
    };
    let mut root: Value =
        serde_json::from_slice(&json).map_err(|e| damaged(e.to_string()).at("JSON"))?;
    let mut remarks = extensions(&root, subject)?;
    strip(&mut root);
    let text = serde_json::to_vec(&root).map_err(|e| damaged(e.to_string()))?;
    let document = guarded(|| gltf::Gltf::from_slice(&text))
        .map_err(damaged)?
        .map_err(|e| damaged(e.to_string()))?
        .document;
    let buffers = buffers::read(&document, chunk, path, subject)?;
    let reader = Reader { subject, buffers, read: Cell::new(0) };
    // The iterators of the crate trust indices that it has checked; a gap in that is an error too.
    let mut soup = guarded(|| scene(&reader, &document)).map_err(damaged)??;
    remarks.append(&mut soup.remarks);
    soup.remarks = remarks;
    Ok(soup)
}

/// Refuses required extensions that may touch geometry, and names what is used of the others.
fn extensions(root: &Value, subject: &str) -> Result<Vec<String>, InputError> {
    let names = |key: &str| {
        let list = root.get(key).and_then(Value::as_array).into_iter().flatten();
        list.map(|name| name.as_str().unwrap_or_default().to_owned()).collect::<Vec<_>>()
    };
    for (index, name) in names("extensionsRequired").iter().enumerate() {
        if name != QUANTIZATION && !HARMLESS.iter().any(|h| name.starts_with(h)) {
            return Err(InputError::new(
                subject,
                "no required extension that changes geometry, but for KHR_mesh_quantization",
                format!("`{name}`"),
                "export without compression and instancing",
            )
            .at(format!("extensionsRequired[{index}]")));
        }
    }
    let mut remarks = Vec::new();
    let used = names("extensionsUsed");
    if used.iter().any(|name| name == QUANTIZATION) {
        remarks.push("quantized attributes".into());
    }
    if used.iter().any(|name| name == "EXT_mesh_gpu_instancing") {
        remarks.push("instances of EXT_mesh_gpu_instancing are not repeated".into());
    }
    Ok(remarks)
}

/// Removes what geometry does not need, so that nothing in it is a reason to refuse the file.
fn strip(root: &mut Value) {
    let Some(map) = root.as_object_mut() else { return };
    map.retain(|key, _| key != "extensionsRequired" && !UNUSED.contains(&key.as_str()));
    let mut each = |key: &str, change: &mut dyn FnMut(&mut serde_json::Map<String, Value>)| {
        let list = map.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten();
        list.filter_map(Value::as_object_mut).for_each(change);
    };
    each("nodes", &mut |node| node.retain(|key, _| key != "camera" && key != "extensions"));
    each("meshes", &mut |mesh| {
        let list = mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten();
        for primitive in list.filter_map(Value::as_object_mut) {
            primitive.retain(|key, _| key != "material" && key != "extensions");
        }
    });
}

/// Every triangle below the default scene, or the first, or, without a scene, below all nodes that
/// are no other's child.
fn scene(reader: &Reader<'_>, document: &gltf::Document) -> Result<Soup, InputError> {
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
    let places = Places::new(document);
    let mut seen = vec![false; document.nodes().count()];
    let (mut flat, mut skinned, mut morphed) = (false, false, false);
    while let Some((node, parent)) = open.pop() {
        let index = node.index();
        if std::mem::replace(&mut seen[index], true) {
            return Err(reader.error(
                format!("nodes[{index}]"),
                "a node with at most one parent",
                "one that is reached twice".into(),
            ));
        }
        let own = parent * local(&node);
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let place = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
                let of = (&primitive, place.as_str());
                add(reader, &node, own, of, &places, &mut soup)?;
                flat |= primitive.get(&Semantic::Normals).is_none();
                morphed |= primitive.morph_targets().next().is_some();
            }
            skinned |= node.skin().is_some();
        }
        let children: Vec<_> = node.children().map(|n| (n, own)).collect();
        open.extend(children.into_iter().rev());
    }
    if soup.triangles.is_empty() {
        let expected = "a node with a mesh of triangles";
        return Err(reader.error("scene".into(), expected, "none".into()));
    }
    let said = [
        (flat, "flat where NORMAL is absent"),
        (skinned, "posed by its joints"),
        (morphed, "morph targets at their default weights"),
    ];
    soup.remarks.extend(said.iter().filter(|(yes, _)| *yes).map(|(_, what)| (*what).to_owned()));
    Ok(soup)
}

/// Adds a primitive's triangles; points and lines have none.
fn add(
    reader: &Reader<'_>,
    node: &gltf::Node<'_>,
    own: DMat4,
    (primitive, place): (&gltf::Primitive<'_>, &str),
    places: &Places,
    soup: &mut Soup,
) -> Result<(), InputError> {
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let posed = posed(reader, node, own, (primitive, place), places)?;
    let length = posed.positions.len();
    if soup.positions.len() + length > MAX_VERTICES {
        let expected = format!("at most {MAX_VERTICES} vertices");
        return Err(reader.error(place.to_string(), &expected, "more".into()));
    }
    let texcoords = match primitive.get(&Semantic::TexCoords(0)) {
        None => None,
        Some(accessor) => {
            let place = format!("{place}.attributes.TEXCOORD_0");
            let texcoords = reader.floats::<2>(&accessor, &place)?;
            if texcoords.len() != length {
                let expected = format!("{length} entries, as POSITION has");
                return Err(reader.error(place, &expected, texcoords.len().to_string()));
            }
            Some(texcoords)
        }
    };
    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => {
            let indices = reader.unsigned::<1>(&accessor, &format!("{place}.indices"))?;
            indices.into_iter().flatten().collect()
        }
        None => (0..num::u32(length)).collect(),
    };
    if let Some(index) = indices.iter().position(|i| *i as usize >= length) {
        return Err(reader.error(
            format!("{place}.indices, entry {index}"),
            &format!("an index into {length} positions"),
            indices[index].to_string(),
        ));
    }
    let count =
        if mode == Mode::Triangles { indices.len() / 3 } else { indices.len().saturating_sub(2) };
    admit(soup.triangles.len() + count, reader.subject, || place.to_string())?;
    let base = [soup.positions.len(), soup.normals.len(), soup.texcoords.len()];
    // Below 2²² triangles and thrice as many entries a list, so the sums fit; a gap would be out of range later.
    let shifted = |base: usize, i: u32| num::u32(base + i as usize);
    let corner = |i: u32| Corner {
        position: shifted(base[0], i),
        normal: posed.normals.as_ref().map(|_| shifted(base[1], i)),
        texcoord: texcoords.as_ref().map(|_| shifted(base[2], i)),
    };
    soup.positions.extend(&posed.positions);
    soup.normals.extend(posed.normals.iter().flatten());
    soup.texcoords.extend(texcoords.iter().flatten());
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
        let [a, b, c] = if posed.mirrors(indices[a]) { [a, c, b] } else { [a, b, c] };
        let mut triangle = [a, b, c].map(|i| corner(indices[i]));
        if posed.normals.is_none() {
            // glTF 2.0, 3.7.2.1: flat normals.
            let [a, b, c] = triangle.map(|t| DVec3::from(soup.positions[t.position as usize]));
            let normal = num::u32(soup.normals.len());
            soup.normals.push((b - a).cross(c - a).normalize_or_zero().to_array());
            triangle.iter_mut().for_each(|corner| corner.normal = Some(normal));
        }
        soup.triangles.push(triangle);
    }
    Ok(())
}

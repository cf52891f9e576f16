//! Meshes as exporters write them: what a file may hold and where its vertices then stand.

use std::path::Path;

use glam::{DVec3, dvec3};
use serde_json::{Value, json};
use tapline::error::InputError;
use tapline::mesh::{Mesh, Up};
use tapline::taken::Taken;

use super::hostile::glb_of;

/// The triangles' positions as the file has them (the fit undone), normals, and what was said.
type Read = (Vec<[DVec3; 3]>, Vec<[DVec3; 3]>, Taken);

fn read(path: &Path, up: Up) -> Result<Read, InputError> {
    let (mesh, _, taken) = Mesh::load(path, up, DVec3::ZERO, 1.0)?;
    let all = mesh.triangles();
    Ok((all.iter().map(|t| t.positions).collect(), all.iter().map(|t| t.normals).collect(), taken))
}

fn of(name: &str, bytes: &[u8]) -> Result<Read, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, Up::Y)
}

fn near(a: &[[DVec3; 3]], b: &[[DVec3; 3]]) -> bool {
    let pairs = || a.iter().flatten().zip(b.iter().flatten());
    // Singles in the file: 2⁻²⁴ of coordinates up to 1, through a handful of products.
    a.len() == b.len() && pairs().all(|(a, b)| a.distance(*b) < 1e-6)
}

const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n";

#[test]
fn an_obj_may_have_a_mark_joined_lines_and_names_in_any_encoding() {
    let plain = of("a.obj", format!("{SQUARE}f 1 2 3 4\n").as_bytes()).unwrap();
    let marked = format!("\u{feff}{SQUARE}f 1 2 3 4\n");
    let joined = format!("{}f 1 2 \\\r\n3 \\\n 4\n", SQUARE.replace("v 2 0 0", "v 2 \\\n0 0"));
    let mut latin = b"g na\xefve # caf\xe9\n".to_vec();
    latin.extend(format!("{SQUARE}f 1 2 3 4\n").bytes());
    for bytes in [marked.as_bytes(), joined.as_bytes(), &latin] {
        let read = of("a.obj", bytes).unwrap();
        assert_eq!((&read.0, &read.1), (&plain.0, &plain.1));
    }
    let error = of("a.obj", b"v 0 0 \\\n0\nv 1 0 0\nv x 0 0\n").err().unwrap();
    assert_eq!(error.place.as_deref(), Some("line 4"));
}

#[test]
fn a_polygon_with_an_inward_corner_is_cut_inside_itself() {
    // An arrow head in a slanted plane; its first corner sees only two others.
    for turn in 0..4usize {
        let order: Vec<String> = (0..4).map(|i| format!("{}", (i + turn) % 4 + 1)).collect();
        let text = format!("v 0 0 0\nv 4 1 1\nv 1 1 1\nv 1 4 4\nf {}\n", order.join(" "));
        let (triangles, normals, _) = of("a.obj", text.as_bytes()).unwrap();
        assert_eq!(triangles.len(), 2);
        let wound = triangles.iter().map(|[a, b, c]| (b - a).cross(c - a));
        let facing: Vec<DVec3> = wound.collect();
        // Both turn the same way, and their areas add up to the polygon's.
        assert!(facing[0].dot(facing[1]) > 0.0, "{turn}");
        assert!(normals.iter().flatten().all(|n| n.dot(facing[0]) > 0.0));
    }
    let star = "v 0 3 0\nv 2 -3 0\nv -3 1 0\nv 3 1 0\nv -2 -3 0\nf 1 2 3 4 5\n";
    let (_, _, taken) = of("a.obj", star.as_bytes()).unwrap();
    assert!(taken.to_string().contains("triangles"), "{taken}");
}

/// A node with a triangle of floats and what `change` adds.
fn triangle(change: impl Fn(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let mut data: Vec<u8> = Vec::new();
    floats(&mut data, &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let mut root = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [0, 0, 0], "max": [2, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}]
    });
    change(&mut root, &mut data);
    root["buffers"][0]["byteLength"] = data.len().into();
    glb_of(&root, &data)
}

fn floats(data: &mut Vec<u8>, numbers: &[f32]) {
    data.extend(numbers.iter().flat_map(|c| c.to_le_bytes()));
}

/// Adds a view of what `data` gains and an accessor of it; its index.
fn accessor(root: &mut Value, data: &mut Vec<u8>, bytes: &[u8], rest: Value) -> usize {
    data.resize(data.len().next_multiple_of(4), 0);
    let list = |root: &Value, key: &str| root[key].as_array().unwrap().len();
    let (view, index) = (list(root, "bufferViews"), list(root, "accessors"));
    let new = json!({"buffer": 0, "byteOffset": data.len(), "byteLength": bytes.len()});
    root["bufferViews"].as_array_mut().unwrap().push(new);
    let mut new = rest;
    new["bufferView"] = view.into();
    root["accessors"].as_array_mut().unwrap().push(new);
    data.extend(bytes);
    index
}

fn bytes(numbers: &[f32]) -> Vec<u8> {
    let mut out = Vec::new();
    floats(&mut out, numbers);
    out
}

#[test]
fn required_extensions_pass_where_they_do_not_touch_geometry() {
    let plain = of("a.glb", &triangle(|_, _| {})).unwrap();
    for name in
        ["KHR_materials_unlit", "EXT_texture_webp", "KHR_texture_transform", "KHR_xmp_json_ld"]
    {
        let file = triangle(|root, _| {
            root["extensionsRequired"] = json!([name]);
            root["extensionsUsed"] = json!([name]);
            // As a file has it whose pictures are known to the extension alone.
            root["textures"] = json!([{"extensions": {name: {"source": 0}}}]);
            root["images"] = json!([{"uri": "a.webp"}]);
        });
        assert_eq!(of("a.glb", &file).unwrap().0, plain.0, "{name}");
    }
    for name in [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "EXT_mesh_gpu_instancing",
        "ACME_shape",
    ] {
        let file = triangle(|root, _| root["extensionsRequired"] = json!([name]));
        assert!(of("a.glb", &file).err().unwrap().found.contains(name));
    }
}

#[test]
fn without_normals_a_mesh_is_flat() {
    let file = triangle(|root, data| {
        let roof = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 0.0, 0.0];
        let positions = json!({"componentType": 5126, "count": 5, "type": "VEC3",
                               "min": [0, 0, 0], "max": [2, 1, 1]});
        let at = accessor(root, data, &bytes(&roof), positions);
        let indices: Vec<u8> = [0u8, 1, 2, 1, 4, 3].to_vec();
        let scalar = json!({"componentType": 5121, "count": 6, "type": "SCALAR"});
        let index = accessor(root, data, &indices, scalar);
        root["meshes"][0]["primitives"][0] =
            json!({"attributes": {"POSITION": at}, "indices": index});
    });
    let (triangles, normals, taken) = of("a.glb", &file).unwrap();
    for ([a, b, c], normals) in triangles.iter().zip(&normals) {
        let face = (*b - *a).cross(*c - *a).normalize();
        assert!(normals.iter().all(|n| n.distance(face) < 1e-12));
    }
    assert!(normals[0][0].distance(normals[1][0]) > 0.5 && taken.to_string().contains("flat"));
}

#[test]
fn integers_of_quantization_and_sparse_accessors_are_read() {
    let plain = of("a.glb", &triangle(|_, _| {})).unwrap();
    let quantized = triangle(|root, data| {
        let codes: [i16; 12] = [-100, 0, 0, 0, 300, 0, 0, 0, -100, 200, 0, 0];
        let codes: Vec<u8> = codes.iter().flat_map(|c| c.to_le_bytes()).collect();
        let kind = json!({"componentType": 5122, "count": 3, "type": "VEC3",
                          "min": [-100, 0, 0], "max": [300, 200, 0]});
        let at = accessor(root, data, &codes, kind);
        root["bufferViews"][1]["byteStride"] = 8.into();
        root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = at.into();
        root["nodes"][0]["scale"] = json!([0.005, 0.005, 0.005]);
        root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        root["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    });
    let (triangles, _, taken) = of("a.glb", &quantized).unwrap();
    assert!(near(&triangles, &plain.0) && taken.to_string().contains("quantized"), "{triangles:?}");
    // Three zeros, two of them replaced.
    let sparse = triangle(|root, data| {
        let values = bytes(&[2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        accessor(root, data, &values, json!({"componentType": 5126, "count": 2, "type": "VEC3"}));
        accessor(root, data, &[1, 2], json!({"componentType": 5121, "count": 2, "type": "SCALAR"}));
        let position = root["accessors"][0].as_object_mut().unwrap();
        position.remove("bufferView");
        position.insert(
            "sparse".into(),
            json!({"count": 2,
            "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 1}}),
        );
    });
    assert_eq!(of("a.glb", &sparse).unwrap().0, plain.0);
}

#[test]
fn morph_targets_have_their_default_weights_and_skins_stand_where_their_joints_are() {
    // A target that doubles every x makes the triangle twice as wide.
    let target = |weight: f32, of_node: Option<f32>| {
        triangle(|root, data| {
            let moves = bytes(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let kind = json!({"componentType": 5126, "count": 3, "type": "VEC3",
                              "min": [0, 0, 0], "max": [2, 0, 0]});
            let at = accessor(root, data, &moves, kind);
            root["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": at}]);
            root["meshes"][0]["weights"] = json!([weight]);
            if let Some(weight) = of_node {
                root["nodes"][0]["weights"] = json!([weight]);
            }
        })
    };
    let ratio = |file: &[u8]| {
        let [a, b, c] = of("a.glb", file).unwrap().0[0];
        a.distance(b) / a.distance(c)
    };
    for (weight, of_node, wanted) in [(0.0, None, 2.0), (1.0, None, 4.0), (0.0, Some(0.5), 3.0)] {
        assert!((ratio(&target(weight, of_node)) - wanted).abs() < 1e-6);
    }
    // One joint, turned by a quarter about z and bound there turned back; the node's own transform does not count.
    let skinned = triangle(|root, data| {
        let joints = accessor(
            root,
            data,
            &[0u8; 12],
            json!({"componentType": 5121, "count": 3, "type": "VEC4"}),
        );
        let weights = bytes(&[1.0, 0.0, 0.0, 0.0].repeat(3));
        let weights = accessor(
            root,
            data,
            &weights,
            json!({"componentType": 5126, "count": 3, "type": "VEC4"}),
        );
        let bound = bytes(&[
            0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]);
        let bound = accessor(
            root,
            data,
            &bound,
            json!({"componentType": 5126, "count": 1, "type": "MAT4"}),
        );
        let attributes = &mut root["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = joints.into();
        attributes["WEIGHTS_0"] = weights.into();
        let half = std::f32::consts::FRAC_1_SQRT_2;
        root["nodes"] = json!([
            {"mesh": 0, "skin": 0, "rotation": [half, 0.0, 0.0, half], "scale": [1.0, 7.0, -1.0]},
            {"rotation": [0.0, 0.0, half, half]}]);
        root["skins"] = json!([{"joints": [1], "inverseBindMatrices": bound}]);
        root["scenes"] = json!([{"nodes": [0, 1]}]);
    });
    let (triangles, _, taken) = of("a.glb", &skinned).unwrap();
    assert!(near(&triangles, &of("a.glb", &triangle(|_, _| {})).unwrap().0), "{triangles:?}");
    assert!(taken.to_string().contains("posed by its joints"));
}

#[test]
fn buffers_may_be_inline_or_lie_beside_the_mesh_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("in side");
    std::fs::create_dir(&inside).unwrap();
    let data = bytes(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    std::fs::write(inside.join("mesh data.bin"), &data).unwrap();
    std::fs::write(folder.path().join("secret.bin"), &data).unwrap();
    let text = |uri: &str| {
        let json = json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                           "min": [0, 0, 0], "max": [2, 1, 0]}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": uri}]
        });
        let path = inside.join("mesh.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        read(&path, Up::Y)
    };
    let plain = of("a.glb", &triangle(|_, _| {})).unwrap().0;
    let inline = "data:application/octet-stream;base64,\
        AAAAAAAAAAAAAAAAAAAAQAAAAAAAAAAAAAAAAAAAgD8AAAAA";
    for uri in ["mesh%20data.bin", "./mesh data.bin", inline] {
        assert_eq!(text(uri).unwrap().0, plain, "{uri}");
    }
    let absolute = folder.path().join("secret.bin").display().to_string();
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        &absolute,
        "none.bin",
        ".",
        "http://a/b",
        "data:;base64,A",
    ] {
        let error = text(uri).err().unwrap();
        assert_eq!(error.place.as_deref(), Some("buffers[0].uri"), "{uri}: {error}");
    }
}

#[test]
fn z_up_turns_the_mesh_about_x() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 0 1\nvn 0 -1 0\nf 1//1 2//1 3//1\n").unwrap();
    let (triangles, normals, taken) = read(&path, Up::Z).unwrap();
    let [a, b, c] = triangles[0];
    assert!((b - a).normalize().distance(dvec3(1.0, 0.0, 0.0)) < 1e-12);
    assert!((c - a).normalize().distance(dvec3(0.0, 1.0, 0.0)) < 1e-12);
    assert!(normals[0][0].distance(dvec3(0.0, 0.0, 1.0)) < 1e-12);
    assert!(taken.to_string().contains("z up"), "{taken}");
}

#[test]
fn the_shared_meshes_are_what_they_stand_for() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/field");
    if !folder.is_dir() {
        eprintln!("skipped: no {}", folder.display());
        return;
    }
    let of = |name: &str| read(&folder.join(name), Up::Y).unwrap();
    let wanted = of("mesh-reference.glb");
    for name in [
        "mesh-skinned-node-turned.glb",
        "mesh-requires-materials-unlit.glb",
        "mesh-requires-texture-webp.glb",
    ] {
        assert!(near(&of(name).0, &wanted.0), "{name}");
    }
    assert!(!near(&of("mesh-reference-turned.glb").0, &wanted.0));
    let marked = of("mesh-bom-before-first-vertex.obj");
    assert_eq!(marked.0, of("mesh-bom-reference.obj").0);
    for name in [
        "mesh-line-continuation.obj",
        "mesh-latin1-group-name.obj",
        "mesh-morph-default-weight.glb",
    ] {
        assert!(!of(name).0.is_empty(), "{name}");
    }
    let (triangles, normals, _) = of("mesh-no-normals.glb");
    for ([a, b, c], normals) in triangles.iter().zip(&normals) {
        let face = (*b - *a).cross(*c - *a).normalize();
        assert!(normals.iter().all(|n| n.distance(face) < 1e-9));
    }
}

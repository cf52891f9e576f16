//! What a mesh file may not do: every one is an error with the file's name, never a panic.

use std::io::Write as _;
use std::path::Path;

use glam::DVec3;
use tapline::mesh::{Mesh, Up};

/// Loads bytes under a name's ending; the error's text, or nothing where they load.
fn refused(ending: &str, bytes: &[u8]) -> Option<String> {
    let mut file = tempfile::Builder::new().suffix(ending).tempfile().unwrap();
    file.write_all(bytes).unwrap();
    file.flush().unwrap();
    let error = Mesh::load(file.path(), Up::Y, DVec3::ZERO, 1.0).err()?;
    assert_eq!(error.subject, file.path().display().to_string());
    Some(error.to_string())
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn a_wrong_obj_is_refused_at_its_line() {
    let with = |text: &str| format!("{TRIANGLE}{text}");
    for (text, place) in [
        (with(""), "at least one face"),
        (String::new(), "at least one face"),
        (with("f 1 2 4"), "line 4"),
        (with("f 1 2 -4"), "line 4"),
        (with("f 1 2 0"), "line 4"),
        (with("f 1/1 2/1 3/1"), "line 4"),
        (with("f 1//9 2//9 3//9"), "line 4"),
        (with("f 1 2"), "line 4"),
        (with("f 1"), "line 4"),
        (with("f"), "line 4"),
        (with("f 1 2 x"), "line 4"),
        (with("f 1/1/1/1 2 3"), "line 4"),
        (with("f 1 2 99999999999999999999"), "line 4"),
        (with("f 1 2 -9223372036854775808"), "line 4"),
        ("v 0 0\nf 1 1 1".into(), "line 1"),
        ("v 0 0 zero\nf 1 1 1".into(), "line 1"),
        ("v 1 2 3 0\nf 1 1 1".into(), "line 1"),
        ("v 1 2 3 1 1 1 1 1\nf 1 1 1".into(), "line 1"),
        ("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3".into(), "triangle 0"),
        ("v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3".into(), "triangle 0"),
        ("v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3".into(), "triangle 0"),
        ("v 1 1 1\nf 1 1 1".into(), "an extent"),
        ("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3".into(), "with an area"),
    ] {
        let error = refused(".obj", text.as_bytes());
        assert!(error.as_ref().is_some_and(|e| e.contains(place)), "{text:?}: {error:?}");
    }
    let error = refused(".obj", b"v 0 0 0\nv \xff\xfe 0 0\n").unwrap();
    assert!(error.contains("line 2"));
    assert!(refused(".obj", b"\xff\xfev\0 \0").unwrap().contains("UTF-16"));
}

#[test]
fn a_missing_file_a_folder_and_another_kind_are_refused() {
    for path in ["/nowhere/mesh.obj", "/"] {
        assert!(Mesh::load(Path::new(path), Up::Y, DVec3::ZERO, 1.0).is_err());
    }
    assert!(refused(".stl", b"solid").unwrap().contains(".obj, .glb or .gltf"));
    assert!(refused(".glb", b"solid").unwrap().contains("glTF binary"));
}

/// A binary file of one triangle; `change` edits the JSON, `data` is the binary chunk.
fn glb(change: impl Fn(&mut serde_json::Value), data: &[u8]) -> Vec<u8> {
    let mut root = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "buffers": [{"byteLength": data.len()}]
    });
    change(&mut root);
    glb_of(&root, data)
}

/// A binary file of this JSON and this chunk.
pub(super) fn glb_of(root: &serde_json::Value, data: &[u8]) -> Vec<u8> {
    let pad = |mut bytes: Vec<u8>, with: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let json = pad(serde_json::to_vec(root).unwrap(), b' ');
    let data = pad(data.to_vec(), 0);
    let length = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend(length(12 + 8 + json.len() + 8 + data.len()));
    out.extend(length(json.len()));
    out.extend(b"JSON");
    out.extend(json);
    out.extend(length(data.len()));
    out.extend(b"BIN\0");
    out.extend(data);
    out
}

fn triangle(indices: [u16; 3], first: f32) -> Vec<u8> {
    let positions = [first, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut data: Vec<u8> = positions.iter().flat_map(|c: &f32| c.to_le_bytes()).collect();
    data.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    data
}

#[test]
fn a_wrong_glb_is_refused_with_its_place() {
    let data = triangle([0, 1, 2], 0.0);
    assert_eq!(refused(".glb", &glb(|_| {}, &data)), None);
    type Change = fn(&mut serde_json::Value);
    let cases: [(Change, &str); 10] = [
        (|r| r["buffers"][0]["uri"] = "mesh.bin".into(), "buffers[0].uri"),
        (
            |r| r["extensionsRequired"] = serde_json::json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired[0]",
        ),
        (|r| r["accessors"][1]["count"] = 4.into(), "accessors[1]"),
        (|r| r["accessors"][1]["count"] = u32::MAX.into(), "accessors[1]"),
        (|r| r["bufferViews"][0]["byteLength"] = u32::MAX.into(), "export"),
        (|r| r["bufferViews"][0]["byteOffset"] = u32::MAX.into(), "accessors[0]"),
        (|r| r["meshes"][0]["primitives"][0]["attributes"] = serde_json::json!({}), "glTF"),
        (|r| r["meshes"][0]["primitives"][0]["mode"] = 1.into(), "scene"),
        (|r| r["nodes"][0]["children"] = serde_json::json!([0]), "nodes[0]"),
        (|r| r["nodes"][0]["mesh"] = 7.into(), "glTF"),
    ];
    for (change, place) in cases {
        let error = refused(".glb", &glb(change, &data));
        assert!(error.as_ref().is_some_and(|e| e.contains(place)), "{place}: {error:?}");
    }
    let error = refused(".glb", &glb(|_| {}, &triangle([0, 1, 3], 0.0))).unwrap();
    assert!(error.contains("indices, entry 2"), "{error}");
    let error = refused(".glb", &glb(|_| {}, &triangle([0, 1, 2], f32::NAN))).unwrap();
    assert!(error.contains("triangle 0"), "{error}");
}

#[test]
fn a_glb_that_is_cut_anywhere_is_an_error() {
    let whole = glb(|_| {}, &triangle([0, 1, 2], 0.0));
    for length in 4..whole.len() {
        assert!(refused(".glb", &whole[..length]).is_some(), "{length} bytes");
    }
}

proptest::proptest! {
    #[test]
    fn a_glb_with_changed_bytes_loads_or_is_an_error(at in 0usize..700, byte in 0u8..=255) {
        let mut file = glb(|_| {}, &triangle([0, 1, 2], 0.0));
        let at = at % file.len();
        file[at] = byte;
        let _ = refused(".glb", &file);
    }

    #[test]
    fn any_text_loads_as_obj_or_is_an_error(text in "(v|f|vt|vn)( -?[0-9/.e]{1,4}){0,5}\n(v 1 2 3\n){0,3}(f( -?[0-9/]{1,3}){0,5}\n){0,3}") {
        let _ = refused(".obj", text.as_bytes());
    }
}

//! Tests glTF files that are written here, valid and broken.

use crate::robot::TriangleMesh;
use crate::robot::formats::gltf::*;
use crate::robot::formats::{parse, parse_among};

/// A tetrahedron: its corners, then the indices of its faces.
const CORNERS: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn data(index_bytes: fn(u32) -> Vec<u8>) -> Vec<u8> {
    let corners = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes());
    corners.chain(FACES.iter().flatten().flat_map(|&index| index_bytes(index))).collect()
}

/// `component` is the type of indices: 5125 for u32, 5123 for u16, 5121 for u8.
fn json(nodes: &str, component: u32, length: usize, uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":7}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"componentType":{component},"count":12,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":{}}}],
        "buffers":[{{"byteLength":{length}{uri}}}]}}"#,
        length - 48
    )
    .replace(",\"material\":7", "")
}

fn glb(json: &str, data: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut padded = bytes.to_vec();
        padded.resize(bytes.len().next_multiple_of(4), with);
        padded
    };
    let (json, data) = (padded(json.as_bytes(), b' '), padded(data, 0));
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((12 + 8 + json.len() + 8 + data.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", data)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn wide() -> Vec<u8> {
    data(|index| index.to_le_bytes().to_vec())
}

fn tetrahedron(nodes: &str) -> Vec<u8> {
    glb(&json(nodes, 5125, wide().len(), ""), &wide())
}

fn farthest(mesh: &TriangleMesh) -> Vec3 {
    mesh.vertices.iter().fold(Vec3::repeat(f64::MIN), |most, v| most.sup(v))
}

#[test]
fn indices_of_all_sizes_and_buffers_of_all_places_are_read() {
    let mesh = parse("a.GLB", &tetrahedron(r#"{"mesh":0}"#)).unwrap();
    assert!(mesh.is_closed() && mesh.triangles.len() == 4);
    let node = r#"{"mesh":0}"#;
    let short = data(|index| (index as u16).to_le_bytes().to_vec());
    assert_eq!(parse("a.glb", &glb(&json(node, 5123, short.len(), ""), &short)).unwrap(), mesh);
    let byte = data(|index| vec![index as u8]);
    assert_eq!(parse("a.glb", &glb(&json(node, 5121, byte.len(), ""), &byte)).unwrap(), mesh);
    let inline = base64::engine::general_purpose::STANDARD.encode(wide());
    let uri = format!(r#","uri":"data:application/octet-stream;base64,{inline}""#);
    assert_eq!(parse("a.gltf", json(node, 5125, wide().len(), &uri).as_bytes()).unwrap(), mesh);
    let named = json(node, 5125, wide().len(), r#","uri":"my%20data.bin""#);
    let mut neighbour = |uri: &str| {
        assert_eq!(uri, "my data.bin");
        Ok(wide())
    };
    assert_eq!(
        parse_among("a.gltf", named.as_bytes(), &LoadLimits::default(), &mut neighbour, &mut vec![]).unwrap(),
        mesh
    );
    let message = parse("a.gltf", named.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("a.gltf: uri: got `my data.bin`, expected all in one file"), "{message}");
}

#[test]
fn nodes_place_meshes() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let node = format!(
        r#"{{"mesh":0,"translation":[1,2,3],"rotation":[0,0,{half},{half}],"scale":[2,1,-1],"children":[1]}},
        {{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,10,0,0,1]}}"#
    );
    let mesh = parse("a.glb", &tetrahedron(&node)).unwrap();
    assert_eq!((mesh.components.len(), mesh.is_closed()), (2, true));
    // Nodes mirror, rotate by a quarter and move: x up to 10 + 1 along y, times 2.
    let expected = Vec3::new(1.0, 2.0 + 2.0 * 11.0, 3.0);
    assert!((farthest(&mesh) - expected).norm() < 1e-6, "{:?}", farthest(&mesh));
}

#[test]
fn sparse_and_absent_numbers_are_read() {
    let text = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,
        "indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":1}}}],
        "bufferViews":[{"buffer":0,"byteLength":2},{"buffer":0,"byteOffset":4,"byteLength":24}],
        "buffers":[{"byteLength":28}]}"#;
    let mut bytes = vec![1, 2, 0, 0];
    [1f32, 0., 0., 0., 2., 0.].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    let mesh = parse("a.glb", &glb(text, &bytes)).unwrap();
    assert_eq!(mesh.vertices, [Vec3::zeros(), Vec3::x(), 2.0 * Vec3::y()]);
    bytes[1] = 3;
    let message = parse("a.glb", &glb(text, &bytes)).unwrap_err().to_string();
    assert_eq!(message, "a.glb: accessors[0]: got the sparse index 3, expected one of 3");
}

#[test]
fn faults_are_named() {
    let node = r#"{"mesh":0}"#;
    let good = json(node, 5125, wide().len(), "");
    let message = |text: &str| parse("a.glb", &glb(text, &wide())).unwrap_err().to_string();
    assert!(
        message(&good.replace("\"count\":12", "\"count\":13")).contains("accessors[1]: got a buffer that ends before")
    );
    assert!(message(&good.replace("\"mesh\":0", "\"mesh\":9")).contains("nodes[0].mesh"));
    assert!(message(&good.replace("VEC3", "VEC2")).contains("accessors[0]: got Vec2, expected 3 numbers"));
    assert!(
        message(&good.replace("\"scene\":0", "\"scene\":0,\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"))
            .contains("extensionsRequired: got KHR_draco_mesh_compression, expected a file that is not compressed")
    );
    let mut wrong = wide();
    wrong[48] = 9;
    let index = parse("a.glb", &glb(&good, &wrong)).unwrap_err().to_string();
    assert_eq!(index, "a.glb: accessors[1]: got index 9, expected one of 4 vertices");
    assert!(message("{}").contains("JSON: got what is no glTF 2.0"));
    assert!(message(&good.replace(node, r#"{"mesh":0,"children":[0]}"#)).contains("nested deeper than 64"));
    let doubled: Vec<String> = (1..40).map(|k| format!(r#"{{"children":[{k},{k}]}}"#)).collect();
    let exploding = format!("{},{node}", doubled.join(","));
    assert!(message(&good.replace(node, &exploding)).contains("`placed="));
}

#[test]
fn what_is_cut_or_spoiled_never_panics() {
    let bytes = tetrahedron(r#"{"mesh":0,"children":[1]},{"mesh":0,"translation":[5,0,0]}"#);
    for length in 0..bytes.len() {
        assert!(parse("a.glb", &bytes[..length]).is_err(), "{length}");
        for value in [0, 1, 0x7f, 0xff, bytes[length].wrapping_add(1)] {
            let mut spoiled = bytes.clone();
            spoiled[length] = value;
            let _ = parse("a.glb", &spoiled);
        }
    }
}

//! Tests with worlds of every format, as the other programs write them.

use std::path::Path;

use crate::robot::Geometry;
use crate::scene::file::{AttachedEntry, ObstacleEntry};
use crate::scene::import::*;

/// An export of rviz: a table at a pose of its own, a cone and a plane in one object, a mesh.
const SCENE: &str = "(noname)+++\n\
    * table top\n0.5 0 0.1\n0 0 0.70710678 0.70710678\n1\nbox\n0.4 0.6 0.2\n0.1 0 0\n0 0 0 1\n0.2 0.4 1 1\n0\n\
    * both\n0 0 0\n0 0 0 1\n2\ncone\n0.1 0.3\n0 0 1\n0 0 0 1\n0 0 0 0\nplane\n0 0 2 -1\n0 0 0\n0 0 0 1\n0 0 0 0\n\
    1\nhandle\n0 0 1\n0 0 0 1\n\
    * wedge\n1 0 0\n0 0 0 1\n1\nmesh\n4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 2 1\n0 1 3\n1 2 3\n2 0 3\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n";

/// The older form, in which objects have no pose.
const OLDER: &str = "(noname)+\n* ball\n1\nsphere\n0.25\n1 2 3\n0 0 0 1\n0 0 0 0\n* can\n1\ncylinder\n0.05 0.2\n0 0 1\n0 0 1 0\n0 0 0 0\n.\n";

const MESSAGE: &str = r#"
name: (noninitialized)
robot_state:
  joint_state: {name: [j0], position: [0.5]}
  attached_collision_objects:
  - link_name: l2
    object:
      header: {frame_id: l2}
      id: can
      pose: {position: {x: 0, y: 0, z: 0.1}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      primitives: [{type: 3, dimensions: [0.2, 0.05]}]
      primitive_poses: [{position: {x: 0, y: 0, z: 0.05}, orientation: {x: 0, y: 0, z: 0, w: 0}}]
      operation: "\0"
    touch_links: [l1, l2]
  is_diff: false
link_padding: [{link_name: l1, padding: 0.01}, {link_name: l2, padding: 0.0}]
link_scale: [{link_name: l1, scale: 1.1}]
allowed_collision_matrix:
  entry_names: [l0, l2, shelf, can]
  entry_values:
  - enabled: [false, true, false, true]
  - enabled: [true, false, true, false]
  - enabled: [false, true, false, false]
  - enabled: [true, false, false, false]
  default_entry_names: []
  default_entry_values: []
world:
  collision_objects:
  - header: {stamp: {sec: 0, nanosec: 0}, frame_id: world}
    pose: {position: {x: 1, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 1, w: 0}}
    id: shelf
    type: {key: '', db: ''}
    primitives:
    - {type: 1, dimensions: [0.1, 0.2, 0.3]}
    - {type: 2, dimensions: [0.4]}
    primitive_poses:
    - {position: {x: 0.5, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
    - {position: {x: 0, y: 0, z: 2}, orientation: {x: 0, y: 0, z: 0, w: 1}}
    meshes:
    planes: []
    subframe_names: [top]
    operation: 0
  - header: {frame_id: world}
    id: floor
    planes: [{coef: [0, 0, 1, 0.5]}]
    plane_poses: [{position: {x: 0, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}]
  - header: {frame_id: world}
    id: wedge
    meshes:
    - vertices: [{x: 0, y: 0, z: 0}, {x: 1, y: 0, z: 0}, {x: 0, y: 1, z: 0}, {x: 0, y: 0, z: 1}]
      triangles: [{vertex_indices: [0, 2, 1]}, {vertex_indices: [0, 1, 3]}, {vertex_indices: [1, 2, 3]}, {vertex_indices: [2, 0, 3]}]
    mesh_poses: [{position: {x: 0, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}]
  octomap:
    header: {frame_id: world}
    origin: {position: {x: 0, y: 0, z: 2}, orientation: {x: 0, y: 0, z: 0, w: 1}}
    octomap: {binary: true, id: OcTree, resolution: 0.05, data: [0, -64, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 3, 0, 10, 0]}
is_diff: true
---
name: another
"#;

fn read(name: &str, text: &str) -> Imported {
    import(Path::new(name), text, None, &LoadLimits::default()).unwrap()
}

fn message(name: &str, text: &str) -> String {
    import(Path::new(name), text, None, &LoadLimits::default()).unwrap_err().to_string()
}

fn obstacle<'a>(imported: &'a Imported, name: &str) -> &'a ObstacleEntry {
    imported.entries.obstacle.iter().find(|entry| entry.name == name).unwrap_or_else(|| panic!("no {name}"))
}

fn told(imported: &Imported, part: &str) {
    assert!(imported.notes.iter().any(|note| note.contains(part)), "{part}: {:?}", imported.notes);
}

fn near(found: [f64; 3], expected: [f64; 3]) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-8), "{found:?} {expected:?}");
}

#[test]
fn scene_text_is_read_with_the_poses_of_objects_and_shapes() {
    let imported = read("rviz.scene", SCENE);
    let names: Vec<&str> = imported.entries.obstacle.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(names, ["table top", "both-1", "both-2", "wedge"]);
    let table = obstacle(&imported, "table top");
    assert_eq!(table.shape.cuboid, Some([0.4, 0.6, 0.2]));
    near(table.pose.xyz, [0.5, 0.1, 0.1]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert!((table.pose.quat_xyzw.unwrap()[2] - half).abs() < 1e-8);
    let plane = &obstacle(&imported, "both-2").shape;
    assert_eq!((plane.half_space, plane.offset), (Some([0.0, 0.0, 1.0]), Some(0.5)));
    let cone = &obstacle(&imported, "both-1").shape;
    assert!(cone.convex && cone.triangles.as_ref().unwrap().is_closed());
    assert_eq!(obstacle(&imported, "wedge").shape.triangles.as_ref().unwrap().triangles.len(), 4);
    for part in ["colours are not taken", "`both-1` to `both-2`", "a cone is taken", "a plane is taken", "1 subframes"]
    {
        told(&imported, part);
    }
}

#[test]
fn the_older_scene_text_has_no_poses_of_objects() {
    let imported = read("old.scene", OLDER);
    assert_eq!(obstacle(&imported, "ball").shape.sphere, Some(0.25));
    assert_eq!(obstacle(&imported, "ball").pose.xyz, [1.0, 2.0, 3.0]);
    let can = obstacle(&imported, "can");
    assert_eq!((can.shape.cylinder, can.pose.quat_xyzw), (Some([0.05, 0.2]), Some([0.0, 0.0, 1.0, 0.0])));
    assert!(imported.notes.is_empty(), "{:?}", imported.notes);
}

#[test]
fn faults_of_scene_text_name_line_word_and_expectation() {
    for (from, to, expected) in [
        ("box", "cube", "a.scene: line 6: got `cube`, expected a shape: box, sphere"),
        ("0.4 0.6 0.2", "0.4 x 0.2", "line 7: got `x`, expected the sides x, y, z of a box [m]"),
        ("0.4 0.6 0.2", "0.4 nan 0.2", "line 7: got `nan`, expected the sides"),
        (
            "0 0 0.70710678 0.70710678",
            "0 0 1 1",
            "line 4: got `[0.0, 0.0, 1.0, 1.0]`, expected a quaternion x, y, z, w of length 1",
        ),
        ("\n.\n", "\n", "got nothing, expected * before an object, or . at the end"),
        ("* both", "+ both", "line 12: got `+`, expected * before"),
        ("1\nbox", "-1\nbox", "line 5: got `-1`, expected the number of shapes"),
        ("* table top", "* ", "line 2: got nothing, expected the name of an object behind *"),
        ("2 0 3\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.", "2 0 9\n.", "got `9`, expected the index of a vertex below 4"),
        ("4 4\n", "4000000000 4\n", "got `4000000000`, expected the number of vertices"),
    ] {
        let text = SCENE.replacen(from, to, 1);
        assert_ne!(text, SCENE, "{from}");
        assert!(message("a.scene", &text).contains(expected), "{from}: {}", message("a.scene", &text));
    }
    assert!(message("a.scene", "").contains("got nothing"));
    assert!(message("a.txt", SCENE).contains("expected one that ends in .scene, .yaml, .yml or .json"));
}

fn attached(imported: &Imported) -> &AttachedEntry {
    &imported.entries.attached[0]
}

#[test]
fn a_planning_scene_becomes_obstacles_attached_objects_pairs_and_padding() {
    let json = value::of_yaml("m", MESSAGE, &LoadLimits::default()).unwrap();
    let rosbridge = serde_json::json!({"op": "publish", "topic": "/s", "msg": json}).to_string();
    for (name, text) in [("m.yaml", MESSAGE.to_string()), ("m.json", rosbridge)] {
        let imported = read(name, &text);
        let first = obstacle(&imported, "shelf-1");
        assert_eq!(first.shape.cuboid, Some([0.1, 0.2, 0.3]));
        near(first.pose.xyz, [0.5, 0.0, 0.0]);
        assert_eq!(first.pose.quat_xyzw, Some([0.0, 0.0, 1.0, 0.0]));
        near(obstacle(&imported, "shelf-2").pose.xyz, [1.0, 0.0, 2.0]);
        let floor = &obstacle(&imported, "floor").shape;
        assert_eq!((floor.half_space, floor.offset), (Some([0.0, 0.0, 1.0]), Some(-0.5)));
        assert_eq!(obstacle(&imported, "wedge").shape.triangles.as_ref().unwrap().triangles.len(), 4);
        let can = attached(&imported);
        assert_eq!((can.name.as_str(), can.link.as_str(), can.shape.cylinder), ("can", "l2", Some([0.05, 0.2])));
        near(can.pose.xyz, [0.0, 0.0, 0.15]);
        assert_eq!(can.touch, ["l1"]);
        let pairs = [["can", "l0"], ["l0", "l2"], ["l2", "shelf-1"], ["l2", "shelf-2"]];
        assert_eq!(imported.entries.pairs.disable, pairs.map(|pair| pair.map(String::from)));
        assert_eq!(imported.entries.padding, [("l1".to_string(), 0.01)].into());
        for part in [
            "the positions of joints are no part of a scene",
            "link_scale of `l1`: 1.1 is not taken",
            "\"shelf\": its subframes are not taken",
            "is_diff",
        ] {
            told(&imported, part);
        }
    }
}

/// Returns an octomap of two cells, x = 0 and 1, as a list of signed bytes.
fn tree() -> Vec<i8> {
    let mut data = vec![0, -64];
    data.extend([3, 0].repeat(14));
    data.extend([0b1010, 0]);
    data
}

#[test]
fn an_octomap_is_one_obstacle_that_the_matrix_can_name() {
    use base64::Engine;
    let list = tree();
    let bytes: Vec<u8> = list.iter().map(|byte| *byte as u8).collect();
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    for data in [format!("{list:?}"), text] {
        let with = |extra: &str| {
            format!(
                "world:\n  octomap:\n    header: {{frame_id: world}}\n    origin: {{position: {{x: 0, y: 0, z: 2}}}}\n    \
                 octomap: {{binary: true, id: OcTree, resolution: 0.05, data: {data}}}\n{extra}"
            )
        };
        let imported = read("m.yaml", &with(""));
        assert!(imported.notes.is_empty(), "{:?}", imported.notes);
        let map = obstacle(&imported, "<octomap>");
        let Some(Geometry::Voxels(voxels)) = &map.shape.scenery else { panic!() };
        assert_eq!((voxels.cells(), voxels.size(), map.pose.xyz), (&[[0; 3], [1, 0, 0]][..], 0.05, [0.0, 0.0, 2.0]));
        let matrix = "allowed_collision_matrix: {entry_names: [hand, <octomap>], entry_values: [[0, 1], [1, 0]]}";
        assert_eq!(read("m.yaml", &with(matrix)).entries.pairs.disable, [["<octomap>", "hand"].map(String::from)]);
    }
    let matrix =
        "world: {}\nallowed_collision_matrix: {entry_names: [hand, <octomap>], entry_values: [[0, 1], [1, 0]]}";
    let without = read("m.yaml", matrix);
    assert!(without.entries.pairs.disable.is_empty() && without.notes.is_empty());
    for (map, expected) in [
        ("{data: [300]}", "world.octomap.octomap.data[0]: got 300, expected a whole number from -128 to 255"),
        ("{data: '?'}", "world.octomap.octomap.data: got \"?\", expected bytes, as a list or in base64"),
        ("{data: [1]}", "world.octomap.octomap: got {\"data\":[1]}, expected a mapping with `binary`"),
        ("{data: [1], binary: 3}", "world.octomap.octomap.binary: got 3, expected true or false"),
        ("{data: [1], binary: true}", "expected a mapping with `resolution`"),
        ("{data: [1], binary: true, resolution: 0.1}", "world.octomap.octomap.id: got ``, expected OcTree or"),
        (
            "{data: [1], binary: true, resolution: 0.1, id: OcTree}",
            "world.octomap.octomap.data: got 1 bytes, expected a",
        ),
    ] {
        let found = message("m.yaml", &format!("world: {{octomap: {{octomap: {map}}}}}"));
        assert!(found.contains(expected), "{map}: {found}");
    }
}

#[test]
fn robowflex_writes_lists_and_words() {
    let imported = read(
        "r.yml",
        "world:\n  collision_objects:\n    - id: can\n      primitives:\n        - {type: cylinder, dimensions: [0.12, 0.03]}\n      \
         primitive_poses:\n        - {position: [1, 2, 3], orientation: [0, 0, 1, 0]}\n    - id: part\n      meshes:\n        \
         - {resource: parts/a.stl, dimensions: [1, 1, 2]}\nallowed_collision_matrix:\n  entry_names: [hand, can]\n  \
         entry_values:\n    - [0, 1]\n    - [1, 0]\n  default_entry_names: [foot]\n  default_entry_values: [true]\n",
    );
    let can = obstacle(&imported, "can");
    assert_eq!((can.shape.cylinder, can.pose.xyz), (Some([0.03, 0.12]), [1.0, 2.0, 3.0]));
    assert_eq!(can.pose.quat_xyzw, Some([0.0, 0.0, 1.0, 0.0]));
    assert_eq!(obstacle(&imported, "part").shape.mesh.as_deref(), Some("parts/a.stl"));
    let pairs = [["can", "foot"], ["can", "hand"], ["foot", "hand"], ["foot", "part"]];
    assert_eq!(imported.entries.pairs.disable, pairs.map(|pair| pair.map(String::from)));
    told(&imported, "`foot` may touch everything");
    told(
        &read("m.yaml", &MESSAGE.replace("frame_id: world", "frame_id: base_link")),
        "the frame `base_link`, which is taken for",
    );
}

#[test]
fn a_robot_tells_frames_and_which_names_mean_nothing() {
    use crate::robot::JointKind::{Fixed, Revolute};
    use crate::scene::testing::{PLAIN, chain, scene};
    let robots = scene(PLAIN, &[chain(&[Fixed, Revolute])]).unwrap();
    let ask = |text: &str| import(Path::new("m.yaml"), text, Some(&robots), &LoadLimits::default());
    // The first joint is fixed and 1 m along x.
    let imported = ask(&MESSAGE.replace("frame_id: world", "frame_id: l1")).unwrap();
    near(obstacle(&imported, "shelf-2").pose.xyz, [2.0, 0.0, 2.0]);
    let fault = |from: &str, to: &str| ask(&MESSAGE.replace(from, to)).unwrap_err().to_string();
    let moving = fault("frame_id: world", "frame_id: l2");
    assert!(
        moving.contains(
            "collision object \"shelf\".header.frame_id: got the frame `l2`, expected one that does not move"
        )
    );
    let two = fault("{frame_id: world}\n    id: floor", "{frame_id: map}\n    id: floor");
    assert!(two.contains("\"floor\".header.frame_id: got the frame `map`, expected `world`"), "{two}");
    let elsewhere = fault("header: {frame_id: l2}", "header: {frame_id: world}");
    assert!(elsewhere.contains("got the frame `world`, expected `l2`, the link that holds it"), "{elsewhere}");
    let known = ask(&format!(
        "{}fixed_frame_transforms: [{{header: {{frame_id: world}}, child_frame_id: map, transform: {{translation: {{x: 9, y: 0, z: 0}}, rotation: {{x: 0, y: 0, z: 0, w: 1}}}}}}]\n",
        MESSAGE
            .split("---")
            .next()
            .unwrap()
            .replace("{frame_id: world}\n    id: floor", "{frame_id: map}\n    id: floor")
    ));
    assert_eq!(obstacle(&known.unwrap(), "floor").pose.xyz, [9.0, 0.0, 0.0]);
    let imported = ask(&MESSAGE.replace("[l0, l2, shelf, can]", "[gone, l2, shelf, can]")).unwrap();
    assert!(imported.entries.pairs.disable.iter().flatten().all(|name| name != "gone"));
    told(&imported, "neither the robot nor the world has `gone`");
    let all = ask(
        "world: {collision_objects: [{id: a, primitives: [{type: 2, dimensions: [1]}]}]}\nallowed_collision_matrix: \
                   {default_entry_names: [a], default_entry_values: [true]}",
    );
    assert_eq!(all.unwrap().entries.pairs.disable.len(), 3);
}

#[test]
fn faults_of_messages_name_field_value_and_expectation() {
    for (from, to, expected) in [
        (
            "dimensions: [0.1, 0.2, 0.3]",
            "dimensions: [0.1, 0.2]",
            "collision object \"shelf\".primitives[0].dimensions: got [0.1,0.2], expected 3 numbers x, y, z",
        ),
        (
            "dimensions: [0.4]",
            "dimensions: [wide]",
            "primitives[1].dimensions[0]: got \"wide\", expected a finite number",
        ),
        ("dimensions: [0.4]", "dimensions: [.nan]", "m.yaml: line 35: YAML: non-finite float `.nan`"),
        ("type: 2", "type: 7", "primitives[1].type: got 7, expected 1 (box), 2 (sphere), 3 (cylinder) or 4 (cone)"),
        (
            "{x: 0, y: 0, z: 1, w: 0}",
            "{x: 0, y: 0, z: 2, w: 0}",
            "\"shelf\".pose.orientation: got {\"w\":0,\"x\":0,\"y\":0,\"z\":2}, expected a quaternion of length 1",
        ),
        ("z: 1, w: 0}", "z: 1}", "\"shelf\".pose.orientation: got"),
        ("vertex_indices: [2, 0, 3]", "vertex_indices: [2, 0, 4]", "expected three indices below the 4 vertices"),
        ("vertex_indices: [2, 0, 3]", "vertex_indices: [2, 0, '...']", "give it --full-length"),
        (
            "enabled: [false, true, false, true]",
            "enabled: [false]",
            "entry_values[0]: got {\"enabled\":[false]}, expected 4 values",
        ),
        (
            "enabled: [false, true, false, true]",
            "enabled: [2, true, false, true]",
            "entry_values[0].enabled[0]: got 2, expected true or false",
        ),
        ("operation: 0", "operation: 9", "\"shelf\".operation: got 9, expected 0 (add)"),
        ("id: floor", "id: shelf", "object \"shelf\": the name occurs twice"),
        ("link_name: l2\n    object", "link_name: ''\n    object", "attached object \"can\".link_name: got"),
        (
            "primitives: [{type: 3, dimensions: [0.2, 0.05]}]\n      primitive_poses",
            "planes: [{coef: [0, 0, 1, 0]}]\n      plane_poses",
            "attached object \"can\": got a plane",
        ),
        ("world:\n", "world: 3\nother:\n", "world: got 3, expected a mapping"),
        ("    - {type: 2, dimensions: [0.4]}\n", "", "got 1 primitives and 2 poses, expected as many"),
        ("is_diff: true", "is_diff: [", "m.yaml: line "),
    ] {
        let text = MESSAGE.replacen(from, to, 1);
        assert_ne!(text, MESSAGE, "{from}");
        assert!(message("m.yaml", &text).contains(expected), "{from}: {}", message("m.yaml", &text));
    }
    assert!(message("m.json", "{").contains("m.json: line 1, column 1: not JSON"));
    assert!(message("m.yaml", "a: 1").contains("expected a PlanningScene"));
    assert!(message("m.json", "[1]").contains("m.json: message: got [1], expected a mapping"));
    let mistyped = read("m.yaml", &MESSAGE.replacen("primitive_poses:", "primitives_poses:", 1));
    told(&mistyped, "attached object \"can\": the key `primitives_poses` is not taken, expected header, pose");
    told(
        &read("m.yaml", &MESSAGE.replacen("is_diff: true", "diff: true", 1)),
        "the key `diff` is not taken, expected name,",
    );
    let removed = read("m.yaml", &MESSAGE.replacen("operation: 0", "operation: 1", 1));
    assert!(removed.entries.obstacle.iter().all(|entry| !entry.name.starts_with("shelf")));
    told(&removed, "its operation is to remove it");
}

#[test]
fn hostile_messages_end_in_messages() {
    for text in ["[".repeat(100_000), "- ".repeat(100_000), format!("a: {}", "{a: ".repeat(50_000))] {
        assert!(message("m.yaml", &text).len() < 1000);
        assert!(message("m.json", &text).len() < 1000);
    }
    let mut bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n".to_string();
    for level in 1..12 {
        let inner = vec![format!("*a{}", level - 1); 10].join(", ");
        bomb += &format!("a{level}: &a{level} [{inner}]\n");
    }
    assert!(message("m.yaml", &bomb).len() < 1000);
}

#[test]
fn what_is_written_is_read_again() {
    for (name, text) in [("a.scene", SCENE), ("m.yaml", MESSAGE)] {
        let imported = read(name, text);
        let (toml, meshes) = to_toml(&imported.entries, &["a \"note\"\nof two lines".into()], "w-meshes");
        let again = crate::scene::file::parse("w.toml", &toml).unwrap_or_else(|error| panic!("{error}\n{toml}"));
        assert!(toml.starts_with("# a \"note\"\n# of two lines\n"));
        assert_eq!(again.pairs.disable, imported.entries.pairs.disable);
        assert_eq!(again.padding, imported.entries.padding);
        for (a, b) in again.obstacle.iter().zip(&imported.entries.obstacle) {
            assert_eq!((&a.name, a.pose, a.shape.cuboid), (&b.name, b.pose, b.shape.cuboid));
            assert_eq!((a.shape.half_space, a.shape.offset), (b.shape.half_space, b.shape.offset));
            assert_eq!(a.shape.mesh.is_some(), b.shape.triangles.is_some());
        }
        for (a, b) in again.attached.iter().zip(&imported.entries.attached) {
            assert_eq!((&a.name, &a.link, &a.touch, a.pose), (&b.name, &b.link, &b.touch, b.pose));
        }
        let map = meshes.iter().find(|file| file.path == "w-meshes/_octomap_.csv").map(|file| file.text.as_str());
        assert_eq!(map, (name == "m.yaml").then_some("0,0,0\n1,0,0\n"));
        assert_eq!(map.is_some(), toml.contains("voxels = \"w-meshes/_octomap_.csv\", size = 0.05"), "{toml}");
        let wedge = meshes.iter().find(|file| file.path == "w-meshes/wedge.obj").unwrap();
        let read = crate::robot::formats::parse(&wedge.path, wedge.text.as_bytes()).unwrap();
        assert_eq!(read.triangles.len(), 4);
    }
}

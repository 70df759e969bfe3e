//! Worlds of MoveIt, queried directly and as scene files.

use crate::process::Workspace;

/// A ball that moves along three axes.
const BALL: &str = r#"<robot name="ball"><link name="w"/><link name="x"/><link name="y"/>
<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="jx" type="prismatic"><parent link="w"/><child link="x"/><axis xyz="1 0 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
<joint name="jy" type="prismatic"><parent link="x"/><child link="y"/><axis xyz="0 1 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
<joint name="jz" type="prismatic"><parent link="y"/><child link="ball"/><axis xyz="0 0 1"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint></robot>"#;
const TABLE: &str = "(noname)+\n* table\n0.5 0 0\n0 0 0 1\n1\nbox\n0.4 0.6 0.2\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n";
const TABLE_TOML: &str =
    "[[obstacle]]\nname = 'table'\nshape = { box = [0.4, 0.6, 0.2] }\npose = { xyz = [0.5, 0, 0] }\n";
const MESSAGE: &str = r#"{"robot_state": {"attached_collision_objects": [{"link_name": "ball", "touch_links": ["ball", "y"], "object":
  {"header": {"frame_id": "ball"}, "id": "rod", "primitives": [{"type": 1, "dimensions": [0.02, 0.02, 0.6]}]}}]},
  "allowed_collision_matrix": {"entry_names": ["ball", "rod", "tray"], "entry_values":
    [{"enabled": [false, true, true]}, {"enabled": [true, false, false]}, {"enabled": [true, false, false]}]},
  "world": {"collision_objects": [{"header": {"frame_id": "w"}, "id": "tray", "meshes": [{"vertices":
    [{"x": 0, "y": 0, "z": 0}, {"x": 1, "y": 0, "z": 0}, {"x": 0, "y": 1, "z": 0}, {"x": 0, "y": 0, "z": 1}],
    "triangles": [{"vertex_indices": [0, 2, 1]}, {"vertex_indices": [0, 1, 3]}, {"vertex_indices": [1, 2, 3]}, {"vertex_indices": [2, 0, 3]}]}],
    "mesh_poses": [{"position": {"x": 1, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}]}],
    "octomap": {"octomap": {"binary": false, "id": "", "resolution": 0.0, "data": []}}}, "object_colors": [{"id": "tray"}]}"#;

fn workspace() -> Workspace {
    let workspace = Workspace::new();
    workspace.write("ball.urdf", BALL);
    workspace.write("table.scene", TABLE);
    workspace.write("table.toml", TABLE_TOML);
    workspace.write("tray.json", MESSAGE);
    workspace
}

/// Depth and colliding pairs of a query at (x, 0, 0).
fn asked(workspace: &Workspace, scene: &str, x: f64) -> (f64, String) {
    let line = format!("query {scene} --q {x},0,0 --json");
    let answer = workspace.run(&line).expect_code(0).json().remove(0);
    (answer["depth"].as_f64().unwrap(), answer["colliding"].to_string())
}

#[test]
fn a_scene_of_rviz_is_asked_as_it_is_or_written_as_a_scene_file() {
    let workspace = workspace();
    let by_hand = asked(&workspace, "ball.urdf --world table.toml", 0.25);
    // The ball is 0.05 m inside the box; it is free 1e-4 m away from it.
    assert!((by_hand.0 - 0.0501).abs() < 1e-6, "{by_hand:?}");
    assert_eq!(by_hand.1, r#"[["ball","table"]]"#);
    assert_eq!(asked(&workspace, "ball.urdf --world table.scene", 0.25), by_hand);
    let told = workspace.run("query ball.urdf --world table.scene --q 0.25,0,0").expect_code(0).stderr;
    assert_eq!(told, "", "the robot alone has no pair, its world has");
    let wrote = workspace.run("import table.scene -o world.toml").expect_code(0);
    assert_eq!(wrote.stdout, "wrote world.toml: 1 obstacle, 0 attached objects, 0 disabled pairs\n");
    assert_eq!(wrote.stderr, "");
    assert_eq!(asked(&workspace, "ball.urdf --world world.toml", 0.25), by_hand);
    // With a robot it is a scene of its own, in any folder.
    std::fs::create_dir(workspace.path("below")).unwrap();
    let report = workspace.run("import table.scene --robot ball.urdf -o below/scene.toml --json").expect_code(0).json();
    assert_eq!((&report[0]["obstacles"], &report[0]["scene"]), (&1.into(), &"below/scene.toml".into()));
    assert_eq!(asked(&workspace, "below/scene.toml", 0.25), by_hand);
    // A second import replaces its own output, and no other file.
    workspace.run("import table.scene -o world.toml").expect_code(0);
    workspace
        .run("import table.scene -o table.toml")
        .expect_failure(&["table.toml", "exists and is no scene written by import"]);
}

#[test]
fn a_planning_scene_brings_what_is_held_and_what_may_touch() {
    let workspace = workspace();
    let wrote = workspace.run("import tray.json --robot ball.urdf -o tray.toml").expect_code(0);
    assert_eq!(
        wrote.stdout,
        "wrote tray.toml: 1 obstacle, 1 attached object, 2 disabled pairs\nwrote tray-meshes/tray.obj\n"
    );
    assert!(wrote.stderr.contains("extricate: warning: colours are not taken"), "{}", wrote.stderr);
    let head = std::fs::read_to_string(workspace.path("tray.toml")).unwrap();
    assert!(head.starts_with("# Imported by extricate from tray.json\n# colours are not taken"), "{head}");
    // The ball may touch the tray, but the rod that it holds may not.
    for scene in ["tray.toml", "ball.urdf --world tray.json"] {
        let (depth, colliding) = asked(&workspace, scene, 1.2);
        assert!(depth > 0.0 && colliding == r#"[["tray","rod"]]"#, "{scene}: {depth} {colliding}");
    }
}

#[test]
fn faults_of_worlds_are_told_with_their_place() {
    let workspace = workspace();
    workspace.write("bad.scene", TABLE.replace("0.4 0.6 0.2", "0.4 0.6m 0.2"));
    workspace
        .run("import bad.scene -o w.toml")
        .expect_failure(&["bad.scene: line 7: got `0.6m`, expected the sides x, y, z of a box"]);
    workspace.run("query ball.urdf --q 0,0,0 --world bad.scene").expect_failure(&["bad.scene: line 7"]);
    workspace.write("flat.scene", TABLE.replace("0.4 0.6 0.2", "0.4 0 0.2"));
    workspace
        .run("import flat.scene -o w.toml")
        .expect_failure(&["flat.scene: obstacle \"table\": box: got 0.0, expected full sides"]);
    workspace.write(
        "held.json",
        MESSAGE
            .replace("\"link_name\": \"ball\"", "\"link_name\": \"hand\"")
            .replace("\"frame_id\": \"ball\"", "\"frame_id\": \"hand\""),
    );
    workspace
        .run("import held.json --robot ball.urdf -o w.toml")
        .expect_failure(&["held.json: attached \"rod\": link: got `hand`, expected one of `w`"]);
    workspace.run("check table.scene --q 0,0,0").expect_failure(&["table.scene: file: got a world without a robot"]);
    workspace.run("import none.scene -o w.toml").expect_failure(&["cannot read none.scene"]);
    workspace
        .run("import ball.urdf -o w.toml")
        .expect_failure(&["expected one that ends in .scene, .yaml, .yml or .json"]);
    assert!(!workspace.path("w.toml").exists());
}

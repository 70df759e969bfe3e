//! What people write first, and the text that they see: every spelling of a configuration, units,
//! URDFs and models in the place of scenes.

use crate::process::{COLLIDING, Workspace};

/// The arm of the other tests with a finger that follows the elbow, and a lid that is locked.
fn with_fingers() -> Workspace {
    let workspace = Workspace::new();
    let urdf = std::fs::read_to_string(workspace.path("planar.urdf")).unwrap();
    let more = "<link name=\"tip\"/><link name=\"cover\"/>
      <joint name=\"finger\" type=\"prismatic\"><parent link=\"fore\"/><child link=\"tip\"/><axis xyz=\"1 0 0\"/>
        <limit lower=\"-9\" upper=\"9\" effort=\"1\" velocity=\"1\"/><mimic joint=\"elbow\" multiplier=\"0.5\"/></joint>
      <joint name=\"lid\" type=\"revolute\"><parent link=\"fore\"/><child link=\"cover\"/><axis xyz=\"0 0 1\"/>
        <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>";
    workspace.write("planar.urdf", urdf.replace("</robot>", more));
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    workspace.write("scene.toml", scene.replace("\"planar.urdf\"", "\"planar.urdf\"\nlocked = { lid = 0.25 }"));
    workspace
}

#[test]
fn every_spelling_of_a_configuration_is_answered_alike() {
    let workspace = with_fingers();
    let ask = |line: &str| workspace.run_with_input("check scene.toml --input - --json", line).expect_code(0);
    let expected = ask(COLLIDING).stdout;
    assert!(expected.contains("\"free\":false"), "{expected}");
    for line in [
        "0.1,0",
        "0.1 0.0",
        "[[0.1, 0]]",
        "# a note\nshoulder,elbow\n0.1,0",
        "elbow;shoulder\n0;0.1",
        r#"{"q": [0.1, 0]}"#,
        r#"{"q": {"elbow": 0, "shoulder": 0.1}}"#,
        r#"{"name": ["elbow", "finger", "lid", "shoulder"], "position": [0, 0, 0.25, 0.1], "velocity": []}"#,
    ] {
        let finished = ask(line);
        assert_eq!((finished.stdout.as_str(), finished.stderr.as_str()), (expected.as_str(), ""), "{line}");
    }
    assert_eq!(workspace.run("check scene.toml --q 0.1,0 --json").expect_code(0).stdout, expected);
    let ends = r#"{"from": {"name": ["shoulder", "elbow"], "position": [0.1, 0]}, "to": {"q": {"shoulder": 0.1, "elbow": 0}}}"#;
    let way = workspace.run_with_input("check scene.toml --input - --segments --json", ends).expect_code(0).json();
    assert_eq!(way[0]["outcome"], "contact");
}

#[test]
fn joints_that_the_scene_holds_still_are_told_once() {
    let workspace = with_fingers();
    let line = r#"{"name": ["elbow", "finger", "lid", "shoulder"], "position": [0, 0.2, 0.5, 0.1]}"#;
    let finished = workspace.run_with_input("query scene.toml --input - --json", &format!("{line}\n{line}"));
    let told: Vec<String> = finished.expect_code(0).stderr.lines().map(String::from).collect();
    assert_eq!(
        told,
        [
            "extricate: warning: standard input: line 1: joint `finger` follows another joint: got 0.2, the scene has it at 0",
            "extricate: warning: standard input: line 1: joint `lid` is locked: got 0.5, the scene has it at 0.25",
        ]
    );
    let unknown = r#"{"name": ["elbow", "wrist"], "position": [0, 0]}"#;
    let finished = workspace.run_with_input("query scene.toml --input -", unknown).expect_code(1);
    assert!(finished.stderr.contains("positions: name: got `wrist`, expected one of `shoulder`, `elbow`"));
}

#[test]
fn degrees_are_told() {
    let workspace = Workspace::new();
    let hint = "angles are in rad: all of them would be within their limits if these were degrees";
    let refused = workspace.run("check scene.toml --q 45,-30").expect_code(1);
    assert!(refused.stderr.contains(hint), "{}", refused.stderr);
    let answered = workspace.run("query scene.toml --q 45,-30").expect_code(0);
    assert_eq!(answered.stderr, format!("extricate: warning: --q: line 1: {hint}\n"));
    assert_eq!(workspace.run("query scene.toml --q -2.0,2.6").expect_code(0).stderr, "");
}

#[test]
fn millimetres_are_told() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    workspace.write("mm.toml", scene.replace("[0.1, 0.5]", "[100, 500]").replace("[0.6, 0.1, 0]", "[600, 100, 0]"));
    let told = workspace.run("check mm.toml --q 0,0").expect_code(0).stderr;
    let expected = "extricate: warning: obstacle `post` is 200 m thick, more than 50 times the robot's reach of 0.982 m: \
                    lengths are in m, not mm\n";
    assert_eq!(told, expected);
}

#[test]
fn a_batch_of_one_is_taken_and_more_are_told_where_they_belong() {
    let workspace = Workspace::new();
    let finished = workspace.run_with_input("check scene.toml --input -", "[[0, 0], [1, 1]]").expect_code(1);
    assert!(finished.stderr.contains("line 1: got an array of 2 configurations, expected one a line"));
    // No heading without a row.
    assert_eq!(finished.stdout, "");
    let ways = workspace.run_with_input("check scene.toml --input - --segments", "[[0, 0]]").expect_code(1);
    assert_eq!(ways.stdout, "");
}

#[test]
fn a_urdf_is_a_scene_and_a_model_holds_one() {
    let workspace = Workspace::learned();
    workspace.write("q.jsonl", COLLIDING);
    for command in ["check {} --input q.jsonl --json", "sample {} -n 3 --seed 2 --colliding"] {
        let of = |file: &str| workspace.run(&command.replace("{}", file)).expect_code(0).stdout;
        assert_eq!(of("scene.toml"), of("small.model"), "{command}");
    }
    workspace.run("sample planar.urdf -n 3").expect_code(0);
    workspace.run("info planar.urdf").expect_code(0);
    workspace.run("check planar.urdf --q 0,0").expect_code(0);
    workspace.run("learn small.model -o again.model --labels 4000 --seed 1").expect_code(0);
    assert_eq!(
        std::fs::read(workspace.path("again.model")).unwrap(),
        std::fs::read(workspace.path("small.model")).unwrap()
    );
    let there = workspace.run("query small.model --q 0.1,0 --world small.model --json").expect_code(0).json();
    assert!(there[0]["depth"].as_f64() > Some(0.0));
}

#[test]
fn poses_take_quaternions_of_both_orders_by_name() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    let clearance = |pose: &str| {
        workspace.write(
            "posed.toml",
            scene
                .replace("{ cylinder = [0.1, 0.5] }", "{ box = [0.1, 0.6, 0.2] }")
                .replace("xyz = [0.6, 0.1, 0]", pose),
        );
        let found = workspace.run("check posed.toml --q -1,0 --json").expect_code(0).json();
        found[0]["clearance"].as_f64().unwrap()
    };
    let by_angles = clearance("xyz = [0.8, 0.1, 0], rpy = [0, 0, 1.0471975511965976]");
    for quaternion in ["quat_xyzw = [0, 0, 0.5, 0.8660254037844386]", "quat_wxyz = [0.8660254037844386, 0, 0, 0.5]"] {
        let found = clearance(&format!("xyz = [0.8, 0.1, 0], {quaternion}"));
        assert!((found - by_angles).abs() < 1e-9, "{quaternion}: {found} {by_angles}");
    }
    workspace.write("posed.toml", scene.replace("xyz = [0.6, 0.1, 0]", "xyz = [0.6, 0.1, 0], quat = [0, 0, 0, 1]"));
    workspace
        .run("check posed.toml --q 0,0")
        .expect_failure(&["got the unknown key `quat`", "`quat_xyzw`, `quat_wxyz`"]);
}

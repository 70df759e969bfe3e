//! Input as people first write it, and the text that they see: every spelling of a configuration,
//! units, URDFs, and models in place of scenes.

use crate::process::{COLLIDING, Finished, Workspace};

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
    // No heading is printed without a row.
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

#[test]
fn help_fits_the_terminal_and_lists_commands_in_groups() {
    let workspace = Workspace::new();
    let help = |line: &str| {
        let mut command = workspace.command(&format!("{line} --help"));
        Finished::new(command.env("COLUMNS", "80").output().unwrap()).expect_code(0).stdout.clone()
    };
    let top = help("");
    let at = |part: &str| top.find(part).unwrap_or_else(|| panic!("{part} is not in\n{top}"));
    assert!(at("\nAsk:\n  query") < at("\nSee:\n  info"), "{top}");
    assert!(at("\nLearn:\n  learn") < at("\nFiles:\n  sample"), "{top}");
    let commands = top.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with([' ', '-']));
    let commands: Vec<&str> = commands.map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(commands.len(), 16, "{commands:?}");
    for command in commands.into_iter().chain([""]) {
        let help = help(command);
        let longest = help.lines().max_by_key(|line| line.chars().count()).unwrap();
        assert!(longest.chars().count() <= 80, "{command}: {longest}");
    }
}

#[test]
fn counts_may_have_an_exponent() {
    let workspace = Workspace::new();
    let drawn = workspace.run("sample scene.toml -n 1e1 --seed 2e0").expect_code(0).stdout;
    assert_eq!(drawn, workspace.run("sample scene.toml -n 10 --seed 2").expect_code(0).stdout);
    assert_eq!(drawn.lines().count(), 10);
    let refused = workspace.run("sample scene.toml -n 1.5e0").expect_code(2);
    assert!(refused.stderr.contains("expected a whole number"), "{}", refused.stderr);
}

#[test]
fn a_single_query_has_no_statistics() {
    let workspace = Workspace::new();
    let one = workspace.run("query scene.toml --q 0.1,0").expect_code(0).stdout;
    assert!(one.contains("[rad]") && !one.contains("median"), "{one}");
    let two = workspace.run("query scene.toml --q 0.1,0 --q -0.0,0").expect_code(0).stdout;
    assert!(two.contains("queries      2 (0 of them free already)") && two.contains("median"), "{two}");
    assert!(!one.contains("counts as"), "{one}{two}");
    let checked = workspace.run("check scene.toml --q 0.1,0").expect_code(0).stdout;
    assert!(checked.ends_with("\n1 configuration, 0 free (0 %)\n"), "{checked}");
    let free = workspace.run("query scene.toml --q -2,-0.0").expect_code(0).stdout;
    assert!(free.ends_with("[-2, 0]\n"), "{free}");
}

#[test]
fn lines_with_the_same_fault_are_told_once() {
    let workspace = Workspace::new();
    let lines: String =
        (0..2000).map(|k| format!("[{}, 0]\n", 9 + k)).chain(["x\n".into(), "[0, 0]\n".into()]).collect();
    let told = workspace.run_with_input("check scene.toml --input -", &lines).expect_code(1).stderr.clone();
    let expected = [
        "extricate: error: standard input: line 1: configuration: `shoulder` (coordinate 0): got 9, expected a value within",
        "extricate: error: standard input: line 2001: got x, expected an array",
        "extricate: error: standard input: line 1: and 1,999 more like it: lines 2, 3, 4, 5, 6, ..",
        "extricate: error: standard input: 2,001 of 2,002 configurations could not be used; the others were answered",
    ];
    assert_eq!(told.lines().count(), expected.len(), "{told}");
    for (line, expected) in told.lines().zip(expected) {
        assert!(line.starts_with(expected), "{line}");
    }
    let rows = workspace.run_with_input("check scene.toml --input - --json", &lines).expect_code(1).json();
    assert_eq!((rows.len(), rows[1999]["line"].as_u64()), (2002, Some(2000)));
}

#[test]
fn what_a_unit_of_metres_and_radians_is_is_told() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    let base = "\"planar.urdf\"\nbase = \"planar\"\nbounds = { min = [-1, -1], max = [1, 1] }";
    workspace.write("base.toml", scene.replace("\"planar.urdf\"", base));
    let unit = "1 m counts as 1 rad; `weights` of the metric";
    let info = workspace.run("info base.toml").expect_code(0).stdout;
    assert!(info.contains(&format!("joint [rad, m]: {unit} changes that")), "{info}");
    let asked = workspace.run("query base.toml --q 0,0,0,0.1,0").expect_code(0).stdout;
    assert!(asked.contains(&format!("in depths, {unit}, or --weights, changes that")), "{asked}");
    let escaped = workspace.run("escape base.toml --q 0,0,0,0.1,0").expect_code(0).stdout;
    assert!(escaped.contains(&format!("in lengths, {unit} changes that")), "{escaped}");
    let weighted = workspace.run("query base.toml --q 0,0,0,0.1,0 --weights elbow=2").expect_code(0).stdout;
    assert!(weighted.contains("each joint by its weight"), "{weighted}");
    assert!(!workspace.run("info scene.toml").expect_code(0).stdout.contains("counts as"));
}

#[test]
fn info_names_pairs_that_nearly_always_collide_and_counts_triangles() {
    let workspace = Workspace::new();
    // The forearm is a tetrahedron, in a box that it leaves only at the ends of the shoulder's
    // range.
    workspace.write("t.obj", "v 0 -0.1 -0.1\nv 0 0.1 -0.1\nv 0 0 0.1\nv 0.4 0 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    let urdf = std::fs::read_to_string(workspace.path("planar.urdf")).unwrap();
    workspace.write("planar.urdf", urdf.replace("<box size=\"0.46 0.04 0.04\"/>", "<mesh filename=\"t.obj\"/>"));
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    let around = "{ box = [2.57, 4, 2] }\npose = { xyz = [0.62, 0, 0] }\n[[obstacle]]\nname = \"all\"\nshape = { box = [9, 9, 9] }";
    let all = scene.replace("{ cylinder = [0.1, 0.5] }\npose = { xyz = [0.6, 0.1, 0] }", around);
    workspace.write("scene.toml", all);
    let told = workspace.run("info scene.toml").expect_code(0).stdout;
    assert!(told.contains("4 triangles, taken as they are (4 in fore), as many as their convex hulls have"), "{told}");
    assert!(told.contains("pairs that collide in all of 1,000 sampled configurations:\n  upper - post\n"), "{told}");
    assert!(told.contains("  fore - all\n"), "{told}");
    let info = &workspace.run("info scene.toml --json").expect_code(0).json()[0];
    assert_eq!(info["meshes"], serde_json::json!([{ "link": "fore", "triangles": 4, "hull_triangles": 4 }]));
    let share = info["nearly_always_colliding"][0]["share"].as_f64();
    assert_eq!(info["nearly_always_colliding"][0]["pair"], serde_json::json!(["fore", "post"]));
    assert!(share > Some(0.95) && share < Some(1.0), "{share:?}");
}

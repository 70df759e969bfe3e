//! Tests the release of hands from their objects.

use std::io::{BufRead, BufReader};
use std::time::Instant;

use crate::process::{Workspace, exists};

/// A gripper of two boxes that slide toward each other along x, and a ball between them.
const GRIPPER: &str = r#"<robot name="gripper"><link name="palm"/>
<link name="left"><collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
<link name="right"><collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
<joint name="close_left" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="-0.1 0 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
<joint name="close_right" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0.1 0 0"/><axis xyz="-1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint></robot>"#;

const SCENE: &str = "clearance = 1e-4\n[[robot]]\nurdf = 'gripper.urdf'\n";
const BALL: &str = "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.03 }\n";

/// A regular tetrahedron around the origin, its faces outward.
const MESH: &str = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";

pub fn workspace() -> Workspace {
    let workspace = Workspace::new();
    add_files(&workspace);
    workspace
}

/// Writes a hand, an object and meshes.
pub fn add_files(workspace: &Workspace) {
    workspace.write("gripper.urdf", GRIPPER);
    workspace.write("hand.toml", SCENE);
    workspace.write("grip.toml", format!("{SCENE}{BALL}"));
    std::fs::create_dir(workspace.path("meshes")).unwrap();
    workspace.write("meshes/cup.obj", MESH);
}

/// Lines with `count` grasps of one mesh.
pub fn grasps_of_a_mesh(count: usize) -> String {
    let line = |k: usize| {
        format!("{{\"q\": [0.0{}, 0.07], \"object\": \"cup.obj\", \"scale\": 0.0{}}}\n", 5 + k % 4, 2 + k % 2)
    };
    (0..count).map(line).collect()
}

/// Lines with `count` grasps, up to a thousand, each of a mesh of a different size, which takes
/// longer.
pub fn grasps_of_meshes(count: usize) -> String {
    let line = |k: usize| format!("{{\"q\": [0.05, 0.07], \"object\": \"cup.obj\", \"scale\": 0.02{k:03}}}\n");
    (0..count).map(line).collect()
}

/// Fingers reach the ball at 0.06; the left one is 0.02 inside it and the right one 0.005.
#[test]
fn fingers_back_out_to_where_they_touch() {
    let workspace = workspace();
    let run = workspace.run("grasp grip.toml --q 0.08,0.065 --object ball --json").expect_code(0);
    let answer: serde_json::Value = serde_json::from_str(run.stdout.trim()).unwrap();
    let config: Vec<f64> = serde_json::from_value(answer["config"].clone()).unwrap();
    for x in &config {
        assert!((x - 0.0599).abs() < 1e-5, "{config:?}");
    }
    assert_eq!(answer["fingers"], serde_json::json!([2, 2]));
    assert_eq!(answer["kept"], serde_json::json!(["left", "right"]));
    assert!(answer["verified"].as_bool().unwrap() && answer["kept_sides"].as_bool().unwrap());
    assert!((answer["depth_before"].as_f64().unwrap() - 0.02).abs() < 1e-6, "{answer}");
    let text = workspace.run("grasp grip.toml --q 0.08,0.065 --object ball").expect_code(0).stdout;
    assert!(text.contains("2/2") && text.contains("1 grasp, 1 released; 2 of 2 fingers kept (100 %)"), "{text}");
    let unknown = workspace.run("grasp grip.toml --q 0.08,0.065 --object cup").expect_code(1);
    assert!(unknown.stderr.contains("got `cup`, expected one of `left`, `right`, `ball`"), "{}", unknown.stderr);
}

/// A run that was cut in the middle of a line resumes to the bytes of an uninterrupted one.
#[test]
fn a_run_over_many_objects_resumes() {
    let workspace = workspace();
    workspace.write("g.jsonl", grasps_of_a_mesh(40));
    workspace.run("grasp hand.toml --input g.jsonl --objects meshes -o whole.jsonl").expect_code(0);
    let whole = std::fs::read_to_string(workspace.path("whole.jsonl")).unwrap();
    assert_eq!(whole.lines().count(), 40);
    workspace.write("cut.jsonl", &whole[..whole.len() / 2]);
    workspace.run("grasp hand.toml --input g.jsonl --objects meshes -o cut.jsonl --resume --threads 1").expect_code(0);
    assert_eq!(std::fs::read_to_string(workspace.path("cut.jsonl")).unwrap(), whole);
    // Other files are neither resumed nor changed.
    workspace.write("other.jsonl", "{\"a\": 1}\n");
    let refused =
        workspace.run("grasp hand.toml --input g.jsonl --objects meshes -o other.jsonl --resume").expect_code(1);
    assert!(refused.stderr.contains("other.jsonl: it exists and is no file of grasps"), "{}", refused.stderr);
    assert_eq!(std::fs::read_to_string(workspace.path("other.jsonl")).unwrap(), "{\"a\": 1}\n");
    // Nor is a file without a whole line, or a part that is an input.
    workspace.write("notes.txt", "precious");
    let line = "grasp hand.toml --input g.jsonl --objects meshes -o notes.txt --resume";
    workspace.run(line).expect_failure(&["notes.txt: it exists and is no file of grasps"]);
    assert_eq!(std::fs::read_to_string(workspace.path("notes.txt")).unwrap(), "precious");
    let rows = "[0.05, 0.07]\n";
    workspace.write("in.jsonl.part", rows);
    let line = "grasp hand.toml --input in.jsonl.part --objects meshes -o in.jsonl";
    workspace.run(line).expect_failure(&["in.jsonl.part"]);
    assert_eq!(std::fs::read_to_string(workspace.path("in.jsonl.part")).unwrap(), rows);
}

#[test]
fn lines_that_name_no_object_in_the_folder_are_told() {
    let workspace = workspace();
    let lines = "[0.05, 0.05]\n{\"q\": [0.05, 0.05], \"object\": \"../grip.toml\"}\n{\"q\": [0.05, 0.05], \"object\": \"no.obj\"}\n\
                 {\"q\": [0.05, 0.05], \"object\": \"cup.obj\", \"scale\": -1}\n";
    workspace.write("g.jsonl", lines);
    let run = workspace.run("grasp hand.toml --input g.jsonl --objects meshes --json").expect_code(1);
    for expected in ["got no \"object\"", "expected a file in the folder", "no.obj", "expected a positive number"] {
        assert!(
            run.stderr.contains(expected) || run.stdout.contains(expected),
            "{expected}: {} {}",
            run.stderr,
            run.stdout
        );
    }
    assert_eq!(run.stdout.lines().count(), 4);
}

#[test]
fn an_output_replaces_grasps_alone_and_when_it_is_whole() {
    let workspace = workspace();
    workspace.write("g.jsonl", "[0.08, 0.065]\n[0.07, 0.07]\n");
    let scene = std::fs::read(workspace.path("grip.toml")).unwrap();
    let line = |output: &str| format!("grasp grip.toml --input g.jsonl --object ball -o {output}");
    for resume in ["", " --resume"] {
        for input in ["grip.toml", "./g.jsonl"] {
            let refused = workspace.run(&format!("{}{resume}", line(input)));
            refused.expect_failure(&[input, "the same command reads it"]);
        }
    }
    workspace.write("p.txt", "precious");
    workspace.run(&line("p.txt")).expect_failure(&["p.txt", "exists and is no file of grasps"]);
    workspace.write("new.jsonl.part", "precious");
    workspace.run(&line("new.jsonl")).expect_failure(&["new.jsonl.part", "exists and is no file of grasps"]);
    assert_eq!(std::fs::read(workspace.path("grip.toml")).unwrap(), scene);
    assert_eq!(std::fs::read_to_string(workspace.path("p.txt")).unwrap(), "precious");
    workspace.run(&line("o.jsonl")).expect_code(0);
    let whole = std::fs::read_to_string(workspace.path("o.jsonl")).unwrap();
    // A line that cannot be answered leaves the old file.
    workspace.run("grasp grip.toml --input g.jsonl --object cup -o o.jsonl").expect_failure(&["`cup`"]);
    assert_eq!(std::fs::read_to_string(workspace.path("o.jsonl")).unwrap(), whole);
    // A new run warns of the part that it replaces, and --resume uses it.
    let (first, _) = whole.split_at(whole.find('\n').unwrap() + 1);
    workspace.write("o.jsonl.part", first);
    workspace.write("o.jsonl", "");
    workspace.run(&format!("{} --resume", line("o.jsonl"))).expect_code(0);
    assert_eq!(std::fs::read_to_string(workspace.path("o.jsonl")).unwrap(), whole);
    workspace.write("o.jsonl.part", first);
    let told = workspace.run(&line("o.jsonl")).expect_code(0).stderr;
    assert!(told.contains("o.jsonl.part is what another run left"), "{told}");
    assert!(!exists(&workspace.path("o.jsonl.part")));
}

/// The first answers are written long before the last, in a file as on standard output, so that
/// whoever ends the run has them.
#[test]
fn answers_are_written_when_they_are_known() {
    let workspace = workspace();
    // Fewer lines than are read at a time.
    workspace.write("g.jsonl", grasps_of_meshes(1000));
    for output in ["", " -o o.jsonl"] {
        let line = format!("grasp hand.toml --input g.jsonl --objects meshes --json --threads 1{output}");
        let started = Instant::now();
        let mut child = workspace.command(&line).spawn().unwrap();
        let mut rows = BufReader::new(child.stdout.take().unwrap());
        let part = || std::fs::read_to_string(workspace.path("o.jsonl.part")).unwrap_or_default();
        if output.is_empty() {
            rows.read_line(&mut String::new()).unwrap();
        } else {
            while !part().contains('\n') {
                assert!(child.try_wait().unwrap().is_none(), "it ended before it was looked at");
            }
        }
        let first = started.elapsed();
        std::io::copy(&mut rows, &mut std::io::sink()).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0));
        let all = started.elapsed();
        assert!(2 * first < all, "the first after {first:?}, all after {all:?}");
    }
}

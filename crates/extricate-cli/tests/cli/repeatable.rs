//! Equal lines have equal answers: twice in one run, in either order, on one and on three threads,
//! and for raw meshes.

use serde_json::Value;

use crate::process::Workspace;

/// An L-shaped bracket between the fingers of a gripper, which are brackets too: no shape is
/// convex.
fn workspace() -> Workspace {
    let workspace = crate::grasps::workspace();
    let corners = [[0.0, 0.0], [0.02, 0.0], [0.02, 0.05], [0.045, 0.05], [0.045, 0.07], [0.0, 0.07]];
    let mut bracket = String::new();
    for y in [-0.01, 0.01] {
        corners.iter().for_each(|[x, z]| bracket += &format!("v {x} {y} {z}\n"));
    }
    bracket += "f 1 2 3\nf 1 3 6\nf 3 4 5\nf 3 5 6\nf 9 8 7\nf 12 9 7\nf 11 10 9\nf 12 11 9\n";
    (1..=6).for_each(|at| bracket += &format!("f {at} {} {} {}\n", at + 6, at % 6 + 7, at % 6 + 1));
    workspace.write("bracket.obj", bracket);
    let urdf = std::fs::read_to_string(workspace.path("gripper.urdf")).unwrap();
    workspace
        .write("brackets.urdf", urdf.replace("<box size=\"0.02 0.02 0.02\"/>", "<mesh filename=\"bracket.obj\"/>"));
    workspace.write(
        "brackets.toml",
        "[[robot]]\nurdf = 'brackets.urdf'\n[[obstacle]]\nname = 'held'\nshape = { mesh = 'bracket.obj' }\n",
    );
    workspace
}

/// Returns a line of output without its number and its time.
fn said(line: &str) -> String {
    let mut row: Value = serde_json::from_str(line).unwrap_or_else(|_| panic!("no JSON: {line}"));
    let fields = row.as_object_mut().expect("a row is an object");
    fields.remove("line");
    fields.remove("seconds");
    row.to_string()
}

#[test]
fn equal_lines_have_equal_answers() {
    let workspace = workspace();
    let lines = ["[0.08, 0.065]", "[0.09, 0.02]", "[0.05, 0.095]"];
    let files = [("twice.jsonl", [lines, lines].concat()), ("back.jsonl", lines.iter().rev().copied().collect())];
    for (name, lines) in &files {
        workspace.write(name, lines.join("\n") + "\n");
    }
    for command in [
        "query brackets.toml --json",
        "query brackets.toml --json --effort proved --max-checks 200",
        "query brackets.toml --json --exits 3 --clearance 0.002",
        "escape brackets.toml --json",
        "grasp brackets.toml --json --object held",
        "check brackets.toml --json",
    ] {
        let run = |file: &str, more: &str| -> Vec<String> {
            let run = workspace.run(&format!("{command} --input {file}{more}"));
            assert!(run.code.is_some_and(|code| code < 2), "{command}: {}", run.stderr);
            run.stdout.lines().map(said).collect()
        };
        let has_threads = command.starts_with("query") || command.starts_with("grasp");
        let one = run("twice.jsonl", if has_threads { " --threads 1" } else { "" });
        assert_eq!((one.len(), &one[..3]), (6, &one[3..]), "{command}: the second time");
        let back: Vec<String> = run("back.jsonl", "").into_iter().rev().collect();
        assert_eq!(back, one[..3], "{command}: the last first");
        if has_threads {
            assert_eq!(run("twice.jsonl", " --threads 3"), one, "{command}: on three threads");
        }
    }
    workspace.write("path.jsonl", "[0.0, 0.0]\n[0.08, 0.065]\n[0.0, 0.09]\n");
    for command in [
        "repair brackets.toml --path path.jsonl --max-checks 2000 --json",
        "plan brackets.toml --from 0,0 --to 0.03,0.03 --json",
        "sample brackets.toml -n 20 --colliding",
        "info brackets.toml --json",
    ] {
        let [first, second] = [0, 1].map(|_| workspace.run(command).stdout);
        assert!(!first.is_empty(), "{command}");
        assert_eq!(first, second, "{command}");
    }
}

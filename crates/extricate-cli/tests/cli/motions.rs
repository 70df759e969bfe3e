//! Tests of paths: escapes, plans, roadmap files, repairs.

use std::io::{BufRead, BufReader};
use std::sync::mpsc;
use std::time::Duration;

use crate::process::{COLLIDING, Workspace, exists, kill};

#[test]
fn an_escape_leads_out() {
    let workspace = Workspace::learned();
    let q = COLLIDING.trim_matches(['[', ']']).replace(' ', "");
    for asked in ["scene.toml", "small.model"] {
        let rows = workspace.run(&format!("escape {asked} --q {q} --q 3,0 --json")).expect_code(0).json();
        let points = rows[0]["points"].as_array().unwrap();
        assert!(points.len() >= 2 && rows[0]["checks"].as_u64().unwrap() > 1, "{}", rows[0]);
        assert_eq!(serde_json::from_str::<serde_json::Value>(COLLIDING).unwrap(), points[0]);
    }
    workspace.run(&format!("escape scene.toml --q {q}")).expect_code(0);
}

#[test]
fn a_plan_is_a_path_that_check_calls_free() {
    let workspace = Workspace::learned();
    let line = "plan scene.toml --from 2.5,0 --to -2.5,0 --roadmap kept --json";
    let plan = &workspace.run(line).expect_code(0).json()[0];
    let points = plan["points"].as_array().unwrap();
    let segments: Vec<String> = points.iter().zip(&points[1..]).map(|(a, b)| format!("[{a},{b}]\n")).collect();
    workspace.write("segments", segments.concat());
    for verdict in workspace.run("check scene.toml --input segments --segments --json").expect_code(0).json() {
        assert_eq!(verdict["outcome"], "free");
    }
    let again = &workspace.run(line).expect_code(0).json()[0];
    assert_eq!(again["points"][0], plan["points"][0]);
    let path = workspace.run("plan scene.toml --from 2.5,0 --to -2.5,0").expect_code(0).json();
    assert_eq!(path[0]["q"], plan["points"][0]);
    let q = COLLIDING.trim_matches(['[', ']']).replace(' ', "");
    workspace.run(&format!("plan scene.toml --from 2.5,0 --to {q}")).expect_code(0);
    workspace.run("plan scene.toml --from 2.5,0 --to 1").expect_failure(&["--to"]);
    workspace.write("kept", "not a roadmap");
    workspace.run(line).expect_failure(&["kept", "expected a roadmap file"]);
}

#[test]
fn a_repaired_path_is_read_again() {
    let workspace = Workspace::learned();
    workspace.write("path.jsonl", "[2.5, 0.0]\n[-2.5, 0.0]\n");
    let rows = workspace.run("repair scene.toml --path path.jsonl").expect_code(0).json();
    assert_eq!((&rows[0]["place"], rows[0]["q"][0].as_f64()), (&serde_json::json!(0.0), Some(2.5)));
    let lines: Vec<String> = rows.iter().map(|row| format!("{row}\n")).collect();
    workspace.write("new.jsonl", lines.concat());
    let again = &workspace.run("repair small.model --path new.jsonl --json").expect_code(0).json()[0];
    assert_eq!(again["stretches"], 0);
    // The same path in one line, in all forms that `view --paths` reads.
    for path in [
        "[[2.5, 0.0], [-2.5, 0.0]]",
        r#"{"path": [[2.5, 0.0], [-2.5, 0.0]]}"#,
        r#"{"joint_names": ["elbow", "shoulder"], "points": [{"positions": [0, 2.5]}, {"positions": [0, -2.5]}]}"#,
    ] {
        workspace.write("whole.jsonl", path);
        assert_eq!(workspace.run("repair scene.toml --path whole.jsonl").expect_code(0).json(), rows, "{path}");
    }
    workspace.write("two.jsonl", "[[2.5, 0.0], [-2.5, 0.0]]\n[[2.5, 0.0], [-2.5, 0.0]]\n");
    workspace.run("repair scene.toml --path two.jsonl").expect_failure(&["got a whole path and more lines"]);
    workspace.write("bad.jsonl", "[2.5, 0.0]\n[9]\n");
    workspace.run("repair scene.toml --path bad.jsonl").expect_failure(&["line 2"]);
}

/// A ball on a line, in a plate between two others: in both directions it meets another plate.
const SHUT_IN: &str = r#"<robot name="slide"><link name="base"/>
<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"#;
const PLATES: &str = r#"
[[robot]]
urdf = "slide.urdf"
[[obstacle]]
name = "in"
shape = { box = [0.6, 1, 1] }
[[obstacle]]
name = "left"
shape = { box = [0.4, 1, 1] }
pose = { xyz = [-0.4, 0, 0] }
[[obstacle]]
name = "right"
shape = { box = [0.4, 1, 1] }
pose = { xyz = [0.4, 0, 0] }
"#;

fn shut_in() -> Workspace {
    let workspace = Workspace::new();
    workspace.write("slide.urdf", SHUT_IN);
    workspace.write("shut.toml", PLATES);
    workspace.write("q.jsonl", "[2]\n[0]\n");
    workspace
}

#[test]
fn paths_that_were_found_are_there_while_the_next_is_looked_for() {
    let workspace = shut_in();
    let endless = "--tree-checks 1000000000000";
    for json in ["--json", ""] {
        let line = format!("escape shut.toml --input q.jsonl {endless} {json}");
        let mut child = workspace.command(&line).spawn().unwrap();
        let rows = BufReader::new(child.stdout.take().unwrap()).lines();
        let (send, found) = mpsc::channel();
        std::thread::spawn(move || rows.map_while(Result::ok).try_for_each(|row| send.send(row)));
        let next = || found.recv_timeout(Duration::from_secs(60)).expect("a line before the last one is known");
        let first = if json.is_empty() { [next(), next()].concat() } else { next() };
        assert!(first.contains("free"), "{first}");
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        kill(child);
    }
}

#[test]
fn queries_without_a_path_are_counted() {
    let workspace = shut_in();
    let told = workspace.run("escape shut.toml --input q.jsonl --tree-checks 500").expect_code(1);
    assert!(told.stdout.ends_with("\nfound a path for 1 of 2 queries (50 %)\n"), "{}", told.stdout);
    assert!(told.stderr.contains("found no path for 1 of 2 queries"), "{}", told.stderr);
    workspace.write("q.jsonl", "[2]\n[0]\n[1, 2]\n");
    let told = workspace.run("escape shut.toml --input q.jsonl --tree-checks 500").expect_code(1).stderr;
    let last = told.lines().last().unwrap();
    assert!(last.contains("1 of 3 configurations could not be used") && last.contains("1 of 2 queries"), "{told}");
    let whole = workspace.run("escape shut.toml --q 2").expect_code(0).stdout;
    assert!(whole.ends_with("found a path for 1 of 1 query (100 %)\n"), "{whole}");
}

/// Only one run may use a roadmap, because the other would overwrite its additions.
#[cfg(unix)]
#[test]
fn a_roadmap_has_one_run() {
    let workspace = shut_in();
    let line = "plan shut.toml --from 2 --to -2 --roadmap kept";
    // No path leads through the plates.
    let mut first = workspace.command(&format!("{line} --max-checks 1000000000000")).spawn().unwrap();
    while !exists(&workspace.path(".extricate-kept.lock")) {
        assert!(first.try_wait().unwrap().is_none(), "it ended before another one could begin");
    }
    workspace.run(line).expect_failure(&["cannot write kept: another run writes it"]);
    kill(first);
    workspace.run(&format!("{line} --max-checks 1000")).expect_failure(&["no path was found"]);
    assert!(exists(&workspace.path("kept")) && !exists(&workspace.path(".extricate-kept.lock")));
    workspace.run("plan shut.toml --from 2 --to -2 --roadmap shut.toml").expect_failure(&["the same command reads it"]);
}

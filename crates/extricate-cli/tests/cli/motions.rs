//! Paths: escapes, plans, roadmap files, repairs.

use crate::process::{COLLIDING, Workspace};

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
    workspace.run(&format!("plan scene.toml --from 2.5,0 --to {q}")).expect_failure(&["to: got a collision of"]);
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
    workspace.write("bad.jsonl", "[2.5, 0.0]\n[9]\n");
    workspace.run("repair scene.toml --path bad.jsonl").expect_failure(&["line 2"]);
}

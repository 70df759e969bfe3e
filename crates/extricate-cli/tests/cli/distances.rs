//! Runs `distance` on one small scene.

use serde_json::{Value, json};

use crate::process::{COLLIDING, FREE, Workspace, assert_keys};

#[test]
fn distances_have_a_sign_a_bound_and_a_witness() {
    let workspace = Workspace::new();
    workspace.write("q.jsonl", format!("{{\"q\": {COLLIDING}}}\n{FREE}\n[1.0]\n"));
    let finished = workspace.run("distance scene.toml --input q.jsonl --json").expect_code(1);
    let rows = finished.json();
    let keys = ["distance", "bound", "witness", "gradient", "pairs", "checks", "cut_short"];
    rows[..2].iter().for_each(|row| assert_keys(row, &keys));
    assert!(rows[2]["error"].is_string() && finished.stderr.contains("line 3"), "{}", finished.stderr);
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    let depth = &workspace.run("query scene.toml --input q.jsonl --json").expect_code(1).json()[0];
    assert_eq!(number(&rows[0], "distance"), -number(depth, "depth"));
    assert_eq!(
        (&rows[0]["bound"].as_f64(), &rows[0]["witness"]),
        (&Some(-number(depth, "lower_bound")), &depth["witness"])
    );
    let (far, bound) = (number(&rows[1], "distance"), number(&rows[1], "bound"));
    assert!(0.0 < bound && bound <= far && far < 2.0, "{far} {bound}");
    assert_eq!(rows[1]["pairs"], json!([["fore", "post"]]));
    let text = workspace.run("distance scene.toml --input q.jsonl").expect_code(1).stdout;
    assert!(text.contains("[rad]") && text.contains("fore, post"), "{text}");
    let near = workspace.run("distance scene.toml --input q.jsonl --json --within 0.1").expect_code(1).json();
    assert_eq!((&near[1]["distance"], &near[1]["witness"]), (&Value::Null, &Value::Null));
    workspace.run("distance scene.toml --input q.jsonl --within 0").expect_code(2);
}

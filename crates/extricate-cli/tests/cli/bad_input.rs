//! What cannot be used is refused with a message that names it, and with the right exit code.

use crate::process::{COLLIDING, FREE, Workspace, assert_keys, exists};

#[test]
fn senseless_command_lines_exit_with_2() {
    let workspace = Workspace::new();
    for line in
        ["", "solve", "query", "check scene.toml", "learn scene.toml", "sample scene.toml -n many", "info --fast x"]
    {
        let finished = workspace.run(line).expect_code(2);
        assert!(finished.stderr.contains("Usage") || finished.stderr.contains("--help"), "{line}: {}", finished.stderr);
    }
}

#[test]
fn several_ways_out_are_refused_where_nothing_is_refined() {
    let workspace = Workspace::learned();
    workspace.write("q.jsonl", COLLIDING);
    let ask = |options: &str| workspace.run(&format!("query small.model --input q.jsonl --effort nearest {options}"));
    let finished = ask("--exits 3").expect_code(2);
    assert_eq!(finished.stdout, "");
    for part in ["--effort nearest", "--exits 1", "Usage: extricate query"] {
        assert!(finished.stderr.contains(part), "{}", finished.stderr);
    }
    ask("--exits 1").expect_code(0);
    let finished = ask("--starts 4").expect_code(2);
    assert!(finished.stderr.contains("expected no --starts"), "{}", finished.stderr);
}

#[test]
fn help_and_version_exit_with_0() {
    let workspace = Workspace::new();
    workspace.run("--version").expect_code(0);
    for command in ["", "demo", "info", "check", "sample", "learn", "adapt", "query", "import"] {
        assert!(workspace.run(&format!("{command} --help")).expect_code(0).stdout.contains("--json"));
    }
    assert!(workspace.run("query --help").expect_code(0).stdout.contains("error"), "what happens to bad lines");
}

#[test]
fn files_that_are_missing_or_foreign_are_named() {
    let workspace = Workspace::new();
    workspace.write("q.jsonl", FREE);
    workspace.run("info nowhere.toml").expect_failure(&["nowhere.toml"]);
    workspace.run("info nowhere").expect_failure(&["nowhere"]);
    workspace.run("check nowhere.toml --input q.jsonl").expect_failure(&["nowhere.toml"]);
    workspace.run("check scene.toml --input nowhere.jsonl").expect_failure(&["nowhere.jsonl"]);
    workspace.run("check scene.toml --input .").expect_failure(&["directory"]);
    workspace.run("query nowhere.model --input q.jsonl").expect_failure(&["nowhere.model"]);
    workspace.write("not.model", [0; 64]);
    workspace.run("query not.model --input q.jsonl").expect_failure(&["not.model"]);
    workspace.run("learn not.model -o m.model").expect_failure(&["not.model"]);
    workspace.write("bad.toml", "clearance = [");
    workspace.run("info bad.toml").expect_failure(&["bad.toml"]);
    workspace.write("lost.toml", "[[robot]]\nurdf = \"lost.urdf\"\n");
    workspace.run("info lost.toml").expect_failure(&["lost.urdf"]);
}

#[test]
fn damaged_models_are_refused() {
    let workspace = Workspace::learned();
    workspace.write("q.jsonl", COLLIDING);
    let whole = std::fs::read(workspace.path("small.model")).unwrap();
    workspace.write("cut.model", &whole[..whole.len() / 2]);
    workspace.write("empty.model", b"");
    let mut altered = whole.clone();
    altered[whole.len() * 3 / 4] ^= 0x10;
    workspace.write("altered.model", &altered);
    for name in ["cut.model", "empty.model", "altered.model"] {
        workspace.run(&format!("query {name} --input q.jsonl")).expect_failure(&[name]);
        workspace.run(&format!("info {name}")).expect_failure(&[name]);
    }
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_learning() {
    let workspace = Workspace::new();
    workspace.run("learn scene.toml -o no/where.model").expect_failure(&["no directory"]);
    workspace.run("learn scene.toml -o .").expect_failure(&["is a directory"]);
    workspace.run("demo --out no/where.svg").expect_failure(&["no directory"]);
    assert!(!exists(&workspace.path("no")));
}

#[test]
fn a_bad_line_is_named_and_the_good_ones_are_answered() {
    let workspace = Workspace::learned();
    let lines = [FREE, "", "[NaN, 0]", "[0, 0, 0]", "[\"a\", 0]", "[[0], 0]", "[9, 0]", "{}", "nonsense", COLLIDING];
    workspace.write("q.jsonl", lines.join("\n"));
    for command in ["check scene.toml", "query small.model --limits refuse"] {
        let finished = workspace.run(&format!("{command} --input q.jsonl --json")).expect_code(1);
        let answers = finished.json();
        assert_eq!(answers.len(), 9, "one for each line that is not empty");
        for (answer, line) in answers[1..8].iter().zip(3..) {
            assert_keys(answer, &["line", "error"]);
            assert_eq!(answer["line"], line);
            let message = format!("extricate: error: q.jsonl: line {line}: {}", answer["error"].as_str().unwrap());
            assert!(finished.stderr.lines().any(|l| l == message), "{message}\n{}", finished.stderr);
        }
        assert!(answers[0].get("error").is_none() && answers[8].get("error").is_none());
        assert!(finished.stderr.lines().last().unwrap().contains("7 of 9"), "{}", finished.stderr);
        let errors = |i: usize| answers[i]["error"].as_str().unwrap();
        assert!(errors(1).contains("NaN") && errors(2).contains("2 coordinates") && errors(5).contains("`shoulder`"));
    }
}

#[test]
fn an_empty_input_is_told() {
    let workspace = Workspace::new();
    let finished = workspace.run_with_input("check scene.toml --input - --json", "\n\n").expect_code(0);
    assert_eq!(finished.stdout, "");
    assert!(finished.stderr.contains("no configurations"), "{}", finished.stderr);
}

#[test]
fn sampling_collisions_where_there_are_none_ends() {
    let workspace = Workspace::new();
    workspace.write("free.toml", "[[robot]]\nurdf = \"planar.urdf\"\n");
    let finished = workspace.run("sample free.toml -n 1 --colliding").expect_code(1);
    assert!(finished.stderr.contains("no colliding configuration"), "{}", finished.stderr);
}

//! Unusable input is refused with a message that names it, and with the right exit code.

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
    for part in ["--exits: got 3, expected 1 with effort \"nearest\"", "Usage: extricate query"] {
        assert!(finished.stderr.contains(part), "{}", finished.stderr);
    }
    ask("--exits 1").expect_code(0);
    let finished = ask("--starts 4").expect_code(2);
    assert!(finished.stderr.contains("--starts: got 4, expected none with effort"), "{}", finished.stderr);
}

#[test]
fn help_and_version_exit_with_0() {
    let workspace = Workspace::new();
    workspace.run("--version").expect_code(0);
    for command in ["", "demo", "info", "check", "sample", "learn", "query", "import"] {
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
    workspace.run("demo --out no/where.html").expect_failure(&["no directory"]);
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
            if line == 6 {
                let like = "extricate: error: q.jsonl: line 5: and 1 more like it: line 6";
                assert!(finished.stderr.lines().any(|l| l == like), "{}", finished.stderr);
                continue;
            }
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

/// Files of strangers cannot colour, overwrite or forge what a terminal shows.
#[test]
fn control_characters_of_files_are_shown_as_such() {
    const ACTING: &str = "\u{1b}[31m\u{9b}2J\u{202e}";
    let workspace = Workspace::new();
    let scene = |shape: &str| format!("[[robot]]\nurdf = 'planar.urdf'\n[[obstacle]]\nname = 'o'\nshape = {shape}\n");
    // TOML accepts control characters only as escapes.
    let escaped = "\\u001b[31m\\u009b2J\\u202e";
    workspace.write("key.toml", format!("\"{escaped}\" = 1\n"));
    workspace.write("path.toml", format!("[[robot]]\nurdf = \"{escaped}\"\n"));
    workspace.write("a.obj", format!("v {ACTING} 1 2\n"));
    workspace.write("obj.toml", scene("{ mesh = 'a.obj' }"));
    workspace.write("a.ply", format!("ply\nformat {ACTING} 1.0\nend_header\n"));
    workspace.write("ply.toml", scene("{ mesh = 'a.ply' }"));
    workspace.write("w.scene", format!("(noname)+\n* box\n{ACTING}\n"));
    workspace.write("q.jsonl", format!("{{\"{ACTING}\": 1}}\n"));
    let named = format!("no-{ACTING}-\r.toml");
    workspace.write(&format!("{ACTING}.toml"), "clearance = 'far'\n");
    let said = |words: &[&str]| {
        let mut command = workspace.command("");
        let output = command.args(words).output().unwrap();
        assert!(output.status.code().is_some_and(|code| code > 0), "{words:?}");
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    for words in [
        &["info", "key.toml"][..],
        &["info", "path.toml"],
        &["info", "obj.toml"],
        &["info", "ply.toml"],
        &["info", &format!("{ACTING}.toml")],
        &["info", &named],
        &["query", "scene.toml", "--world", "w.scene", "--q", "0,0"],
        &["query", "scene.toml", "--input", "q.jsonl"],
        &["query", "scene.toml", "--q", ACTING],
        &["learn", "scene.toml", "-o", &format!("none/{ACTING}")],
    ] {
        let (out, told) = said(words);
        let acts = |c: char| c != '\n' && (c.is_control() || c == '\u{202e}');
        assert!(!told.contains(acts) && !out.contains(acts), "{words:?}: {told:?}");
        assert!(told.contains(r"\u{1b}[31m") || told.contains(r"\u001b[31m"), "{words:?}: {told}");
        assert!(told.lines().all(|line| line.starts_with("extricate: ")), "{words:?}: {told}");
    }
    // A pattern on the command line may find a file of such a name.
    let (_, told) = said(&["info", "scene.toml", &format!("{ACTING}\r")]);
    assert!(!told.contains(['\u{1b}', '\u{9b}', '\u{202e}', '\r']), "{told:?}");
}

#[test]
fn nothing_is_written_over_what_is_read() {
    let workspace = Workspace::learned();
    workspace.write("empty", "");
    let before = workspace.files();
    for (line, file) in [
        ("learn small.model -o small.model", "small.model"),
        ("import empty -o empty", "empty"),
        ("import other.json --robot empty -o empty", "empty"),
        ("view scene.toml --input empty -o empty", "empty"),
        ("view scene.toml --q 0,0 --world empty -o empty", "empty"),
        ("report empty -o empty", "empty"),
        ("plan small.model --from 0,0 --to 1,0 --roadmap small.model", "small.model"),
        ("grasp scene.toml --input empty --object post -o empty", "empty"),
    ] {
        workspace.run(line).expect_failure(&["cannot write", file, "the same command reads it"]);
    }
    assert!(workspace.files() == before);
}

#[test]
fn manual_pages_replace_manual_pages_alone() {
    let workspace = Workspace::new();
    workspace.run("man pages").expect_code(0);
    let whole = workspace.files();
    assert!(exists(&workspace.path("pages/extricate.1")) && exists(&workspace.path("pages/extricate-view.1")));
    workspace.write("pages/extricate-view.1", "");
    workspace.run("man pages").expect_code(0);
    assert!(workspace.files() == whole);
    workspace.write("pages/extricate-view.1", "my own notes");
    workspace.write("pages/extricate-learn.1", "");
    let before = workspace.files();
    workspace.run("man pages").expect_failure(&["extricate-view.1: it exists and is no manual page of this program"]);
    assert!(workspace.files() == before);
}

//! Pipes that close, programs that wait for each answer, and Ctrl-C.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use crate::process::{COLLIDING, FREE, Workspace, exists};

#[test]
fn a_reader_that_leaves_ends_the_program_quietly() {
    let workspace = Workspace::new();
    let mut child = workspace.command("sample scene.toml -n 1000000").spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(first.starts_with("{\"q\":["), "{first}");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn each_line_from_a_pipe_is_answered_before_the_next_is_asked() {
    let workspace = Workspace::new();
    let mut child = workspace.command("check scene.toml --input - --json").stdin(Stdio::piped()).spawn().unwrap();
    let mut questions = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
    for (question, free) in [(FREE, true), (COLLIDING, false), (FREE, true)] {
        writeln!(questions, "{question}").unwrap();
        let answer = answers.next().unwrap().unwrap();
        assert!(answer.contains(&format!("\"free\":{free}")), "{answer}");
    }
    drop(questions);
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[cfg(unix)]
#[test]
fn the_first_interrupt_keeps_what_was_learned() {
    let workspace = Workspace::new();
    let line = "learn scene.toml -o stopped.model --labels 50000000 --seconds 120";
    let mut child = workspace.command(line).spawn().unwrap();
    let mut messages = BufReader::new(child.stderr.take().unwrap()).lines();
    let started = messages.next().unwrap().unwrap();
    assert!(started.starts_with("extricate: learning: "), "{started}");
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupted.success());
    let rest: Vec<String> = messages.map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{rest:?}");
    assert!(rest.iter().any(|l| l.contains("keeping the model learned so far")), "{rest:?}");
    assert!(exists(&workspace.path("stopped.model")));
    workspace.run_with_input("query stopped.model --input - --json", COLLIDING).expect_code(0);
}

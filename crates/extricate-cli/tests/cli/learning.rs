//! Learning that is interrupted, and two runs with the same model as output.

use std::process::Child;
use std::thread::sleep;
use std::time::Duration;

use crate::process::{Workspace, exists, kill};

/// Starts a long run, and waits until it holds its output.
fn a_long_run(workspace: &Workspace) -> Child {
    let mut child = workspace.command("learn scene.toml -o a.model --labels 90000000").spawn().unwrap();
    while !exists(&workspace.path(".extricate-a.model.lock")) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before another one could begin");
        sleep(Duration::from_millis(1));
    }
    // The file exists, and is locked immediately after.
    sleep(Duration::from_millis(100));
    child
}

#[test]
fn two_runs_do_not_share_an_output() {
    let workspace = Workspace::new();
    let first = a_long_run(&workspace);
    workspace.run("learn scene.toml -o ./a.model --labels 2000").expect_failure(&["a.model: another run writes it"]);
    kill(first);
    workspace.run("learn scene.toml -o a.model --labels 2000").expect_code(0);
}

#[cfg(unix)]
#[test]
fn interrupted_it_leaves_a_model() {
    let workspace = Workspace::new();
    let mut child = a_long_run(&workspace);
    // Allow enough time to find something free.
    sleep(Duration::from_secs(1));
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let info = &workspace.run("info a.model --json").expect_code(0).json()[0];
    assert_eq!(info["statistics"]["ended_by"], "interruption");
    workspace.run_with_input("query a.model --input - --json", "[0.1, 0.0]").expect_code(0);
}

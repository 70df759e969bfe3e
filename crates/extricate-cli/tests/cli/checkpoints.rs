//! Learning and adapting that are interrupted and resumed, and what cannot be: what is left behind
//! is whole.

use std::thread::sleep;
use std::time::Duration;

use crate::process::{Workspace, exists, kill};

/// A model with exits, and a scene whose post has moved.
pub fn with_an_old_model() -> Workspace {
    let workspace = Workspace::new();
    workspace.run("learn scene.toml -o old.model --labels 150000 --seed 2").expect_code(0);
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    workspace.write("moved.toml", scene.replace("0.6, 0.1", "0.63, 0.12"));
    workspace
}

#[test]
fn two_runs_do_not_share_an_output() {
    let workspace = Workspace::new();
    let line = "learn scene.toml -o a.model --labels 400000 --checkpoint-every 0";
    let mut first = workspace.command(line).spawn().unwrap();
    while !exists(&workspace.path("a.model.checkpoint")) {
        assert!(first.try_wait().unwrap().is_none(), "it ended before another one could begin");
        sleep(Duration::from_millis(1));
    }
    workspace.run(line).expect_failure(&["a.model: another run writes it"]);
    let by_checkpoint = "learn scene.toml -o b.model --checkpoint a.model.checkpoint";
    workspace.run(by_checkpoint).expect_failure(&["a.model.checkpoint: another run writes it"]);
    kill(first);
    workspace.run("learn scene.toml -o a.model --labels 2000").expect_code(0);
}

#[test]
fn a_checkpoint_is_not_the_model() {
    let workspace = Workspace::new();
    let learn = "learn scene.toml --labels 500 -o";
    for model in ["a.model", "./a.model"] {
        workspace
            .run(&format!("{learn} {model} --checkpoint a.model"))
            .expect_failure(&["--checkpoint: got a.model, which is the model to write"]);
    }
    workspace.run(&format!("{learn} a.model --checkpoint b.model")).expect_code(0);
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.model", workspace.path("link")).unwrap();
    #[cfg(unix)]
    workspace
        .run(&format!("{learn} a.model --checkpoint link"))
        .expect_failure(&["--checkpoint: got link, which is the model to write"]);
}

#[cfg(unix)]
#[test]
fn interrupted_it_leaves_a_model_and_a_checkpoint() {
    let workspace = Workspace::new();
    let line = "learn scene.toml -o a.model --labels 400000 --seed 5";
    workspace.run(line).expect_code(0);
    let whole = std::fs::read(workspace.path("a.model")).unwrap();
    std::fs::remove_file(workspace.path("a.model")).unwrap();
    let mut child = workspace.command(&format!("{line} --checkpoint-every 0")).spawn().unwrap();
    while !exists(&workspace.path("a.model.checkpoint")) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be interrupted");
        sleep(Duration::from_millis(1));
    }
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let info = &workspace.run("info a.model --json").expect_code(0).json()[0];
    assert_eq!(info["statistics"]["ended_by"], "interruption");
    workspace.run_with_input("query a.model --input - --json", "[0.1, 0.0]").expect_code(0);
    workspace.run("learn scene.toml -o a.model --resume").expect_code(0);
    assert!(std::fs::read(workspace.path("a.model")).unwrap() == whole);
}

#[cfg(unix)]
#[test]
fn adapting_that_is_interrupted_leaves_a_model_and_a_checkpoint() {
    let workspace = with_an_old_model();
    let line = "adapt old.model moved.toml -o a.model --labels 400000 --seed 5";
    let report = &workspace.run(&format!("{line} --json")).expect_code(0).json()[0];
    assert!(report["interrupted"] == false && report["checkpoint"].is_null(), "{report}");
    assert!(!cfg!(target_os = "linux") || report["memory"].as_u64().unwrap() > 1 << 20, "{report}");
    let whole = std::fs::read(workspace.path("a.model")).unwrap();
    let interrupted = |stage: &str| {
        let _ = std::fs::remove_file(workspace.path("a.model"));
        let mut child = workspace.command(&format!("{line} --checkpoint-every 0")).spawn().unwrap();
        // A checkpoint says in which stage its run is.
        let is_there = || {
            let bytes = std::fs::read(workspace.path("a.model.checkpoint")).unwrap_or_default();
            let head = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]).into_owned();
            head.contains(stage)
        };
        while !is_there() {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it could be interrupted");
            sleep(Duration::from_millis(1));
        }
        let pid = child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        child.wait_with_output().unwrap()
    };
    let ended = interrupted("Solving");
    assert_eq!(ended.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&ended.stdout).contains("--resume goes on from there"));
    let info = &workspace.run("info a.model --json").expect_code(0).json()[0];
    assert_eq!(info["statistics"]["ended_by"], "interruption");
    workspace.run_with_input("query a.model --input - --json", "[0.1, 0.0]").expect_code(0);
    workspace.run("adapt old.model moved.toml -o a.model --resume").expect_code(0);
    assert!(std::fs::read(workspace.path("a.model")).unwrap() == whole);
}

#[test]
fn adapting_that_cannot_be_resumed_is_refused() {
    let workspace = with_an_old_model();
    let resume = "adapt old.model moved.toml -o a.model --resume";
    workspace.run(resume).expect_failure(&["a.model.checkpoint", "cannot read"]);
    let line = "adapt old.model moved.toml -o a.model --labels 9000000 --checkpoint-every 0";
    let mut child = workspace.command(line).spawn().unwrap();
    while !exists(&workspace.path("a.model.checkpoint")) {
        assert!(child.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(1));
    }
    kill(child);
    workspace.run(&format!("{resume} --labels 7")).expect_failure(&["--labels", "got 7", "begun with 9000000"]);
    workspace.run(&format!("{resume} --memory 7")).expect_failure(&["--memory", "got 7", "begun with 4096"]);
    workspace.run("adapt old.model scene.toml -o a.model --resume").expect_failure(&["another scene"]);
    workspace.run("learn moved.toml -o a.model --resume").expect_failure(&["another kind of run"]);
    workspace.run("learn scene.toml -o other.model --labels 5000").expect_code(0);
    workspace.run("adapt other.model moved.toml -o a.model --resume").expect_failure(&["another model"]);
    let small = workspace.run("adapt old.model moved.toml -o a.model --labels 60000 --memory 1 --json").expect_code(0);
    assert!(small.stderr.contains("unfinished run") && small.stderr.contains("--resume"), "{}", small.stderr);
    assert_eq!(small.json()[0]["statistics"]["ended_by"], "memory");
    // Gone with the run that replaced it.
    workspace.run(resume).expect_failure(&["cannot read"]);
}

#[test]
fn what_cannot_be_resumed_is_refused() {
    let workspace = Workspace::new();
    let resume = "learn scene.toml -o a.model --resume";
    workspace.run(resume).expect_failure(&["a.model.checkpoint", "cannot read"]);
    let mut child =
        workspace.command("learn scene.toml -o a.model --labels 9000000 --checkpoint-every 0").spawn().unwrap();
    while !exists(&workspace.path("a.model.checkpoint")) {
        assert!(child.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(1));
    }
    kill(child);
    workspace.run(&format!("{resume} --labels 7")).expect_failure(&["--labels", "got 7", "begun with 9000000"]);
    workspace.run(&format!("{resume} --seconds 3")).expect_failure(&["--seconds", "no limit"]);
    workspace.run("learn scene.toml -o a.model.checkpoint").expect_failure(&["is no model"]);
    let warned = workspace.run("learn scene.toml -o a.model --labels 500").expect_code(0).stderr;
    assert!(warned.contains("unfinished run") && warned.contains("--resume"), "{warned}");
    // Gone with the run that replaced it.
    workspace.run(resume).expect_failure(&["cannot read"]);
    workspace.write("a.model.checkpoint", "text");
    workspace.run(resume).expect_failure(&["a.model.checkpoint", "is no checkpoint"]);
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    let mut child =
        workspace.command("learn scene.toml -o b.model --labels 9000000 --checkpoint-every 0").spawn().unwrap();
    while !exists(&workspace.path("b.model.checkpoint")) {
        assert!(child.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(1));
    }
    kill(child);
    workspace.write("scene.toml", scene.replace("0.6, 0.1", "0.7, 0.1"));
    workspace.run("learn scene.toml -o b.model --resume").expect_failure(&["b.model.checkpoint", "another scene"]);
}

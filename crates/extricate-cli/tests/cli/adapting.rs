//! `adapt`: an obstacle of a built-in scene moves, and the old model becomes one of the new scene.

use serde_json::Value;

use crate::process::{Workspace, exists};

const LABELS: usize = 60_000;

#[test]
fn a_moved_obstacle_costs_a_fifth_and_no_quality() {
    let workspace = Workspace::new();
    workspace.run("demo --scene planar-arm --export arm").expect_code(0);
    let scene = std::fs::read_to_string(workspace.path("arm/planar-arm.toml")).unwrap();
    let moved = scene.replace("xyz = [0.62, 0.3, 0]", "xyz = [0.65, 0.28, 0]");
    assert_ne!(scene, moved);
    workspace.write("arm/moved.toml", &moved);
    let learn = |scene: &str, model: &str| {
        let line = format!("learn arm/{scene}.toml -o {model}.model --labels {LABELS} --seed 2 --json");
        workspace.run(&line).expect_code(0).json().remove(0)
    };
    learn("planar-arm", "old");
    let anew = learn("moved", "anew");
    let adapted =
        workspace.run("adapt old.model arm/moved.toml -o adapted.model --json").expect_code(0).json().remove(0);
    let labels = |report: &Value| report["statistics"]["labels"].as_u64().unwrap();
    assert!(5 * labels(&adapted) <= LABELS as u64 && labels(&anew) * 10 > LABELS as u64 * 9, "{adapted}");
    assert_eq!(adapted["interrupted"], false);
    assert!(adapted["statistics"]["accuracy_free_interval"][1].as_f64().unwrap() > 0.8, "{adapted}");

    let queries = workspace.run("sample arm/moved.toml -n 80 --seed 3 --colliding").expect_code(0).stdout;
    workspace.write("q.jsonl", &queries);
    let depths = |model: &str| -> Vec<f64> {
        let answers = workspace.run(&format!("query {model}.model --input q.jsonl --json")).expect_code(0).json();
        assert!(answers.iter().all(|answer| answer["verified"] == true), "{model}");
        let witnesses: String = answers.iter().map(|answer| format!("{}\n", answer["witness"])).collect();
        let line = "check arm/moved.toml --input - --json";
        let verdicts = workspace.run_with_input(line, &witnesses).expect_code(0).json();
        assert!(verdicts.len() == 80 && verdicts.iter().all(|verdict| verdict["free"] == true), "{model}");
        answers.iter().map(|answer| answer["depth"].as_f64().unwrap()).collect()
    };
    let (of_adapted, of_anew) = (depths("adapted"), depths("anew"));
    let excesses = |a: &[f64], b: &[f64]| -> Vec<f64> {
        let mut all: Vec<f64> = a.iter().zip(b).map(|(a, b)| a / a.min(*b) - 1.0).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    // Each beside the better of both, on the same queries.
    let (adapted, anew) = (excesses(&of_adapted, &of_anew), excesses(&of_anew, &of_adapted));
    assert!(adapted[40] < 1e-3 && anew[40] < 1e-3, "medians {} {}", adapted[40], anew[40]);
    let within = |excesses: &[f64]| excesses.iter().filter(|excess| **excess <= 0.05).count();
    assert!(within(&adapted) + 2 >= within(&anew), "{} and {} of 80 within 5 %", within(&adapted), within(&anew));
}

#[test]
fn what_cannot_be_adapted_is_refused() {
    let workspace = Workspace::learned();
    workspace.run("demo --scene planar-arm --export arm").expect_code(0);
    workspace.run("adapt small.model arm/planar-arm.toml -o new.model").expect_failure(&["learn the scene anew"]);
    workspace.run("adapt nowhere.model scene.toml -o new.model").expect_failure(&["nowhere.model"]);
    workspace.run("adapt scene.toml scene.toml -o new.model").expect_failure(&["scene.toml"]);
    workspace.run("adapt small.model scene.toml -o no/new.model").expect_failure(&["no directory"]);
    workspace.run("adapt small.model scene.toml").expect_code(2);
    assert!(!exists(&workspace.path("new.model")));
}

//! Runs info, sample, check, learn and query on one small scene.

use serde_json::{Value, json};

use crate::process::{COLLIDING, FREE, Workspace, assert_keys};

const ANSWER_KEYS: &[&str] = &[
    "depth",
    "lower_bound",
    "witness",
    "seconds",
    "checks",
    "max_displacement",
    "colliding",
    "outside",
    "touching",
    "clearance",
    "cut_short",
    "verified",
    "effort",
    "contacts",
    "gap",
    "gradient",
    "unique",
    "unproved",
    "unseen",
];

#[test]
fn info_lists_joints_in_order_and_pairs() {
    let workspace = Workspace::new();
    let info = &workspace.run("info scene.toml --json").expect_code(0).json()[0];
    assert_eq!(info["kind"], "scene");
    assert_eq!(info["joints"][0]["name"], "shoulder");
    assert_eq!(info["joints"][1]["coordinates"], json!([1]));
    assert_eq!(info["joints"][1]["factors"][0]["limits"], json!([-2.5, 2.5]));
    assert_eq!(info["pairs"], json!([["upper", "post"], ["fore", "post"]]));
    assert_eq!(info["pair_count"], 2);
    assert_eq!(info["always_colliding"]["pairs"], json!([]));
    let text = workspace.run("info scene.toml --pairs").expect_code(0).stdout;
    assert!(text.contains("shoulder") && text.contains("fore - post"), "{text}");
}

#[test]
fn info_names_pairs_that_always_collide_with_the_line_to_add() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    let shelf = "[[obstacle]]\nname = \"slab\"\nshape = { box = [0.5, 0.5, 0.02] }\n";
    workspace.write("scene.toml", scene.clone() + shelf);
    let info = workspace.run("info scene.toml").expect_code(0).stdout;
    let line = "disable = [[\"upper\", \"slab\"]]";
    assert!(info.contains(line), "{info}");
    workspace.write("scene.toml", format!("{scene}{shelf}[pairs]\n{line}\n"));
    let info = workspace.run("info scene.toml").expect_code(0).stdout;
    assert!(!info.contains("disable"), "{info}");
}

#[test]
fn check_says_whether_the_ways_between_configurations_are_free() {
    let workspace = Workspace::new();
    let lines =
        format!("[{FREE}, [-2.0, 1.0]]\n{{\"from\": {FREE}, \"to\": [2.0, 0.0]}}\n[{COLLIDING}, {FREE}]\n{FREE}\n");
    workspace.write("ways.jsonl", lines);
    let finished = workspace.run("check scene.toml --segments --input ways.jsonl --json").expect_code(1);
    assert!(finished.stderr.contains("line 4"), "{}", finished.stderr);
    let answers = finished.json();
    assert_eq!(answers[0], json!({ "outcome": "free", "free_until": 1.0, "at": null, "pair": null }));
    // Both ends are free; the arm meets the post on the way, at about -0.1 rad of the shoulder.
    let (until, at) = (answers[1]["free_until"].as_f64().unwrap(), answers[1]["at"].as_f64().unwrap());
    assert_eq!(answers[1]["outcome"], "contact");
    assert_eq!(answers[1]["pair"][1], "post");
    assert!(until < at && at - until < 1e-3 && (0.4..0.5).contains(&at), "{until} {at}");
    assert_eq!((&answers[2]["free_until"], &answers[2]["at"]), (&json!(0.0), &json!(0.0)));
    assert!(answers[3]["error"].as_str().unwrap().contains("from"));
    let text = workspace.run("check scene.toml --segments --input ways.jsonl").expect_code(1).stdout;
    assert!(text.contains("contact") && text.contains("3 segments, 1 free"), "{text}");
    workspace.run("check scene.toml --segments --resolution 0 --input ways.jsonl").expect_code(2);
}

#[test]
fn check_says_free_clearance_and_pairs() {
    let workspace = Workspace::new();
    workspace.write("q.jsonl", format!("{{\"q\": {COLLIDING}}}\n{FREE}\n"));
    let verdicts = workspace.run("check scene.toml --input q.jsonl --json").expect_code(0).json();
    assert_eq!(verdicts.len(), 2);
    verdicts.iter().for_each(|v| assert_keys(v, &["free", "clearance", "colliding"]));
    assert_eq!(verdicts[0]["free"], false);
    assert!(verdicts[0]["clearance"].as_f64().unwrap() < 0.0);
    assert!(verdicts[0]["colliding"].as_array().unwrap().contains(&json!(["fore", "post"])));
    assert_eq!(verdicts[1]["free"], true);
    assert!(verdicts[1]["clearance"].as_f64().unwrap() > 0.1);
    assert_eq!(verdicts[1]["colliding"], json!([]));
    let text = workspace.run("check scene.toml --input q.jsonl").expect_code(0).stdout;
    assert!(text.contains("2 configurations, 1 free (50 %)"), "{text}");
}

#[test]
fn samples_depend_on_the_seed_alone_and_are_read_back() {
    let workspace = Workspace::new();
    let sample = |line: &str| workspace.run(line).expect_code(0).stdout;
    let first = sample("sample scene.toml -n 20 --seed 3");
    assert_eq!(first, sample("sample scene.toml -n 20 --seed 3 --json"));
    assert_ne!(first, sample("sample scene.toml -n 20 --seed 4"));
    assert!(sample("sample scene.toml -n 30 --seed 3").starts_with(&first));
    assert_eq!(sample("sample scene.toml -n 0 --seed 3"), "");
    let colliding = sample("sample scene.toml -n 25 --seed 3 --colliding");
    let verdicts = workspace.run_with_input("check scene.toml --input - --json", &colliding).expect_code(0).json();
    assert_eq!(verdicts.len(), 25);
    assert!(verdicts.iter().all(|v| v["free"] == false));
}

#[test]
fn answers_are_free_and_at_the_stated_depth() {
    let workspace = Workspace::learned();
    let queries = workspace.run("sample scene.toml -n 20 --seed 9 --colliding").expect_code(0).stdout;
    workspace.write("q.jsonl", &queries);
    for effort in ["nearest", "refined", "exhaustive", "proved"] {
        let line = format!("query small.model --input q.jsonl --json --effort {effort}");
        let answers = workspace.run(&line).expect_code(0).json();
        assert_eq!(answers.len(), 20);
        let witnesses: String = answers.iter().map(|a| format!("{}\n", a["witness"])).collect();
        let verdicts = workspace.run_with_input("check scene.toml --input - --json", &witnesses).expect_code(0).json();
        for ((query, answer), verdict) in queries.lines().zip(&answers).zip(&verdicts) {
            assert_keys(answer, ANSWER_KEYS);
            assert_eq!(answer["effort"], effort);
            assert_eq!(verdict["free"], true, "{answer}");
            assert_eq!(answer["verified"], effort != "nearest", "{answer}");
            let query: Value = serde_json::from_str(query).unwrap();
            let distance =
                (0..2).map(|k| difference(&answer["witness"][k], &query["q"][k]).powi(2)).sum::<f64>().sqrt();
            let depth = answer["depth"].as_f64().unwrap();
            assert!((depth - distance).abs() < 1e-9, "{depth} {distance}");
            assert!(answer["lower_bound"].as_f64().unwrap() <= depth);
            assert!(!answer["colliding"].as_array().unwrap().is_empty());
        }
    }
}

#[test]
fn exits_the_way_budgets_and_threads_are_asked_for() {
    let workspace = Workspace::learned();
    let queries = workspace.run("sample scene.toml -n 30 --seed 4 --colliding").expect_code(0).stdout;
    workspace.write("q.jsonl", format!("{queries}nonsense\n{FREE}\n"));
    let ask = |options: &str| {
        let line = format!("query small.model --input q.jsonl --json {options}");
        let mut answers = workspace.run(&line).expect_code(1).json();
        answers.iter_mut().filter(|a| a.get("error").is_none()).for_each(|a| a["seconds"] = Value::Null);
        answers
    };
    let one = ask("");
    assert_eq!((one.len(), one[30]["line"].as_u64()), (32, Some(31)));
    assert_eq!(one, ask("--threads 3"));
    let several = ask("--exits 3 --segment");
    for (one, answer) in one.iter().zip(&several).take(30) {
        let exits = answer["exits"].as_array().unwrap();
        assert!(!exits.is_empty() && exits.len() <= 3);
        exits.iter().for_each(|exit| assert_keys(exit, &["depth", "witness", "touching"]));
        assert_eq!((&exits[0]["depth"], &exits[0]["witness"]), (&answer["depth"], &answer["witness"]));
        assert_keys(&answer["segment"], &["colliding_until", "free_from"]);
        assert_keys(&answer["contacts"][0], &["pair", "distance", "point_first", "point_second", "normal"]);
        assert!((one["depth"].as_f64().unwrap() - answer["depth"].as_f64().unwrap()).abs() < 1e-3);
    }
    assert!(several.iter().take(30).any(|a| a["exits"].as_array().unwrap().len() > 1));
    for (full, cut) in one.iter().zip(ask("--max-checks 3")).take(30) {
        assert!(cut["checks"].as_u64().unwrap() <= 6 && cut["verified"] == true);
        assert!(cut["depth"].as_f64().unwrap() >= full["depth"].as_f64().unwrap());
        assert_eq!((&full["cut_short"], &cut["cut_short"]), (&false.into(), &true.into()));
    }
    let doubts = |options: &str| {
        let text = workspace.run(&format!("query small.model --input q.jsonl {options}")).expect_code(1).stdout;
        text.matches("a limit ended the search, and a nearer exit is not ruled out").count()
    };
    assert_eq!(doubts(""), 0);
    assert!(doubts("--max-checks 3") > 0);
    // Early proofs save checks in any case, so they are switched off.
    let checks =
        |rows: &[serde_json::Value]| rows.iter().take(30).map(|row| row["checks"].as_u64().unwrap()).sum::<u64>();
    assert!(checks(&ask("--starts 1 --gap 0")) < checks(&ask("--gap 0")));
    assert!(checks(&one) < checks(&ask("--gap 0")));
    let text = workspace.run("query small.model --input q.jsonl --exits 2 --segment").expect_code(1).stdout;
    assert!(text.contains("another exit") && text.contains("of the segment"), "{text}");
}

#[test]
fn frames_of_a_motion_are_answered_from_the_last_answer() {
    let workspace = Workspace::learned();
    let frames: String = (0..40).map(|i| format!("[{}, 0.3]\n", -0.05 + 0.005 * f64::from(i))).collect();
    workspace.write("q.jsonl", frames);
    let ask = |options: &str| {
        workspace.run(&format!("query small.model --input q.jsonl --json {options}")).expect_code(0).json()
    };
    let checks = |answers: &[Value]| answers.iter().map(|a| a["checks"].as_u64().unwrap()).sum::<u64>();
    // Early proofs save checks in any case, so they are switched off.
    let (single, stream) = (ask("--gap 0"), ask("--gap 0 --stream"));
    assert!(stream.iter().all(|a| a["verified"] == true));
    assert!(checks(&stream) < checks(&single), "{} {}", checks(&stream), checks(&single));
    ask("--stream --hysteresis 0.2");
    let [none, many] = ["0", "100"].map(|looks| ask(&format!("--gap 0 --stream --starts-per-frame {looks}")));
    assert!(checks(&none) < checks(&many), "{} {}", checks(&none), checks(&many));
    let default = ask("--gap 0 --stream --starts-per-frame 2");
    assert!(default.iter().zip(&stream).all(|(a, b)| a["checks"] == b["checks"] && a["witness"] == b["witness"]));
    for bad in ["many", "-1", "1.5"] {
        let refused = workspace
            .run(&format!("query small.model --input q.jsonl --stream --starts-per-frame {bad}"))
            .expect_code(2);
        let told = [format!("'{bad}'"), "--starts-per-frame".into(), "expected a whole number from 0".into()];
        assert!(told.iter().all(|part| refused.stderr.contains(part)), "{}", refused.stderr);
    }
    workspace.run("query small.model --input q.jsonl --starts-per-frame 2").expect_code(2);
    workspace.run("query small.model --input q.jsonl --hysteresis 0.2").expect_code(2);
    workspace.run("query small.model --input q.jsonl --stream --threads 2").expect_code(2);
}

#[test]
fn a_model_is_asked_in_a_changed_scene() {
    let workspace = Workspace::learned();
    let scene = std::fs::read_to_string(workspace.path("scene.toml")).unwrap();
    workspace.write("moved.toml", scene.replace("xyz = [0.6, 0.1, 0]", "xyz = [0.55, -0.25, 0]"));
    let queries = workspace.run("sample moved.toml -n 20 --seed 3 --colliding").expect_code(0).stdout;
    workspace.write("q.jsonl", queries);
    for threads in [1, 2] {
        let line = format!("query small.model --scene moved.toml --input q.jsonl --json --threads {threads}");
        let answers = workspace.run(&line).expect_code(0).json();
        let witnesses: String = answers.iter().map(|a| format!("{}\n", a["witness"])).collect();
        let verdicts = workspace.run_with_input("check moved.toml --input - --json", &witnesses).expect_code(0).json();
        assert!(answers.iter().all(|a| a["verified"] == true) && verdicts.iter().all(|v| v["free"] == true));
    }
    workspace
        .write("other.toml", scene.replace("metric = { kind = \"joint\" }", "metric = { kind = \"object-norm\" }"));
    let refused = workspace.run("query small.model --scene other.toml --input q.jsonl").expect_code(1);
    assert!(refused.stderr.contains("other.toml") && refused.stderr.contains("metric"), "{}", refused.stderr);
}

fn difference(a: &Value, b: &Value) -> f64 {
    a.as_f64().unwrap() - b.as_f64().unwrap()
}

#[test]
fn a_free_query_is_its_own_answer() {
    let workspace = Workspace::learned();
    let answer = &workspace.run_with_input("query small.model --input - --json", FREE).expect_code(0).json()[0];
    assert_eq!(answer["depth"], 0.0);
    assert_eq!(answer["witness"], json!([-2.0, 0.0]));
    assert_eq!(answer["colliding"], json!([]));
}

#[test]
fn the_model_does_not_depend_on_the_number_of_threads() {
    let workspace = Workspace::new();
    let queries = workspace.run("sample scene.toml -n 10 --seed 2 --colliding").expect_code(0).stdout;
    let answers = |threads: usize| {
        let line = format!("learn scene.toml -o {threads}.model --labels 3000 --seed 5 --threads {threads}");
        workspace.run(&line).expect_code(0);
        let line = format!("query {threads}.model --input - --json");
        let mut answers = workspace.run_with_input(&line, &queries).expect_code(0).json();
        answers.iter_mut().for_each(|a| a["seconds"] = Value::Null);
        answers
    };
    assert_eq!(answers(1), answers(2));
}

#[test]
fn learn_reports_statistics_and_info_repeats_them() {
    let workspace = Workspace::new();
    let report = workspace.run("learn scene.toml -o a.model --labels 3000 --seed 7 --json").expect_code(0);
    let report = &report.json()[0];
    assert_keys(report, &["model", "interrupted", "seconds", "memory", "statistics"]);
    assert_eq!(report["interrupted"], json!(false));
    assert!(!cfg!(target_os = "linux") || report["memory"].as_u64().unwrap() > 1 << 20);
    assert_eq!(report["statistics"]["seed"], 7);
    assert_eq!(report["statistics"]["ended_by"], "labels");
    let info = &workspace.run("info a.model --json").expect_code(0).json()[0];
    assert_eq!(info["kind"], "model");
    assert_eq!(info["statistics"], report["statistics"]);
    assert_eq!(info["joints"][0]["name"], "shoulder");
    assert!(workspace.run("info a.model").expect_code(0).stdout.contains("held-out accuracy"));
}

#[test]
fn text_output_has_a_row_a_query_and_a_summary() {
    let workspace = Workspace::learned();
    let text = workspace.run_with_input("query small.model --input -", &format!("\n{COLLIDING}\n{FREE}\n"));
    let text = text.expect_code(0).stdout;
    assert!(text.lines().any(|l| l.trim_start().starts_with("2 ") && l.contains("post")), "{text}");
    assert!(text.contains("2 (1 of them free already)"), "{text}");
}

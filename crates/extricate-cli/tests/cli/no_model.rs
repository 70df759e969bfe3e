//! Queries of a scene without a model.

use crate::process::{COLLIDING, FREE, Workspace};

#[test]
fn a_scene_is_asked_at_once() {
    let workspace = Workspace::new();
    let samples = workspace.run("sample scene.toml -n 20 --colliding --seed 4").expect_code(0).stdout;
    let answers = workspace.run_with_input("query scene.toml --input - --json", &samples).expect_code(0).json();
    assert_eq!(answers.len(), 20);
    let mut witnesses = String::new();
    for answer in &answers {
        assert_eq!(answer["verified"], true);
        assert!(answer["lower_bound"].as_f64() <= answer["depth"].as_f64());
        witnesses += &format!("{}\n", answer["witness"]);
    }
    let checked = workspace.run_with_input("check scene.toml --input - --json", &witnesses).expect_code(0).json();
    assert!(checked.iter().all(|verdict| verdict["free"] == true));
    let on_threads = workspace.run_with_input("query scene.toml --input - --json --threads 2", &samples);
    let witness_of = |answer: &serde_json::Value| answer["witness"].clone();
    let again: Vec<_> = on_threads.expect_code(0).json().iter().map(witness_of).collect();
    assert_eq!(again, answers.iter().map(witness_of).collect::<Vec<_>>());
    let frames = workspace.run_with_input("query scene.toml --input - --json --stream", &samples);
    assert_eq!(frames.expect_code(0).json().len(), 20);
}

#[test]
fn one_configuration_needs_no_file_and_its_witness_is_free_as_printed() {
    let workspace = Workspace::new();
    let inside = COLLIDING.trim_matches(['[', ']']).replace(' ', "");
    let text = workspace.run(&format!("query scene.toml --q {inside}")).expect_code(0).stdout;
    let printed = text.lines().find_map(|line| line.trim().strip_prefix("at  ")).expect("a witness");
    let verdict = &workspace.run_with_input("check scene.toml --input - --json", printed).expect_code(0).json()[0];
    assert_eq!(verdict["free"], true, "{text}");
    let free = FREE.trim_matches(['[', ']']).replace(' ', "");
    let two = workspace.run(&format!("query scene.toml --q {inside} --q {free} --json")).expect_code(0).json();
    assert!(two[0]["depth"].as_f64().unwrap() > 0.0 && two[1]["depth"] == 0.0);
    workspace.run("query scene.toml --q 0.1").expect_failure(&["--q", "1 of 1"]);
    workspace.run("query scene.toml --q a,b").expect_failure(&["--q", "1 of 1"]);
    let both = workspace.run(&format!("query scene.toml --q {inside} --input q.jsonl"));
    both.expect_code(2);
}

#[test]
fn beyond_the_limits_is_a_query_that_names_the_joint() {
    let workspace = Workspace::new();
    let answer = &workspace.run("query scene.toml --q -2.0,2.6 --json").expect_code(0).json()[0];
    assert_eq!(answer["outside"], serde_json::json!(["elbow"]));
    assert!((answer["depth"].as_f64().unwrap() - 0.1).abs() < 1e-9 && answer["verified"] == true, "{answer}");
    assert_eq!((&answer["colliding"], &answer["lower_bound"]), (&serde_json::json!([]), &answer["depth"]));
    let text = workspace.run("query scene.toml --q -2.0,2.6").expect_code(0).stdout;
    assert!(text.contains("beyond limits: elbow"), "{text}");
    workspace.run("query scene.toml --q -2.0,2.6 --limits refuse").expect_failure(&["1 of 1"]);
    workspace.run("query scene.toml --q -2.0,1e999").expect_failure(&["1 of 1"]);
}

#[test]
fn a_urdf_is_a_scene_of_one_robot() {
    let workspace = Workspace::new();
    let arm = r#"<robot name="arm"><link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
      <link name="a"><collision><origin xyz="0.3 0 0"/><geometry><box size="0.5 0.02 0.02"/></geometry></collision></link>
      <link name="b"><collision><origin xyz="0.3 0 0"/><geometry><box size="0.5 0.02 0.02"/></geometry></collision></link>
      <joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
      <joint name="k" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><origin xyz="0.6 0 0"/>
        <limit lower="-3.1" upper="3.1" effort="1" velocity="1"/></joint></robot>"#;
    workspace.write("arm.urdf", arm);
    let answer = &workspace.run("query arm.urdf --q 0,3.1 --json").expect_code(0).json()[0];
    assert_eq!(answer["colliding"][0], serde_json::json!(["base", "b"]));
    assert_eq!(answer["verified"], true);
    workspace.run("info arm.urdf").expect_code(0);
}

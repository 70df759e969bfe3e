//! Pages: what is in them, what is refused, and that a served one is given to this computer alone.
//! How they look is checked in a browser, by scripts/check-view.py.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;

use serde_json::{Value, json};

use crate::process::{COLLIDING, FREE, Workspace, assert_keys, exists};

/// What the page is given.
fn data_of(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").expect("a place for data");
    serde_json::from_str(rest.split_once("</script>").expect("an end").0).expect("JSON")
}

#[test]
fn a_page_holds_the_numbers_of_query() {
    let workspace = Workspace::new();
    workspace.write("q.jsonl", format!("{COLLIDING}\n{FREE}\n"));
    let made = workspace.run("view scene.toml --input q.jsonl --exits 2 -o page.html --json").expect_code(0).json();
    assert_keys(&made[0], &["page", "bytes"]);
    let page = std::fs::read_to_string(workspace.path("page.html")).unwrap();
    assert_eq!(made[0]["bytes"], page.len());
    let data = data_of(&page);
    let rows = workspace.run("query scene.toml --input q.jsonl --exits 2 --json").expect_code(0).json();
    for (shown, row) in data["answers"].as_array().unwrap().iter().zip(&rows) {
        for key in ["depth", "lower_bound", "gap", "witness", "max_displacement", "clearance", "verified", "gradient"] {
            assert_eq!(shown["answer"][key], row[key], "{key}");
        }
        let pairs: Vec<Value> = shown["answer"]["colliding"]
            .as_array()
            .unwrap()
            .iter()
            .map(Value::to_string)
            .map(|pair| {
                let name = |k: usize| {
                    data["scene"]["bodies"][shown["pairs"][&pair][k].as_u64().unwrap() as usize]["name"].clone()
                };
                json!([name(0), name(1)])
            })
            .collect();
        assert_eq!(json!(pairs), row["colliding"]);
        let depths: Vec<&Value> = shown["exits"].as_array().unwrap().iter().map(|exit| &exit["depth"]).collect();
        let listed = row["exits"].as_array().map_or(vec![], |exits| exits.iter().map(|exit| &exit["depth"]).collect());
        assert_eq!(depths, listed);
    }
    assert_eq!(data["answers"].as_array().unwrap().len(), 2);
    assert!(data["answers"][1]["exits"].as_array().unwrap().is_empty(), "a free query has no exit");
    // The same call gives the same page, but for the times.
    workspace.run("view scene.toml --input q.jsonl --exits 2 -o again.html").expect_code(0);
    let mut again = data_of(&std::fs::read_to_string(workspace.path("again.html")).unwrap());
    let mut first = data;
    for page in [&mut first, &mut again] {
        page["answers"].as_array_mut().unwrap().iter_mut().for_each(|answer| answer["seconds"] = Value::Null);
    }
    assert_eq!(first, again);
}

#[test]
fn without_configurations_random_ones_in_collision_are_shown() {
    let workspace = Workspace::learned();
    let said = workspace.run("view small.model").expect_code(0).stdout;
    assert!(said.contains("wrote extricate-view.html"), "{said}");
    let data = data_of(&std::fs::read_to_string(workspace.path("extricate-view.html")).unwrap());
    let answers = data["answers"].as_array().unwrap();
    assert!(answers.len() == 5 && answers.iter().all(|shown| shown["answer"]["depth"].as_f64() > Some(0.0)));
    // Pages are replaced, other files are not.
    workspace.run("view small.model -n 1").expect_code(0);
    workspace.run("view small.model -n 1 -o scene.toml").expect_failure(&["scene.toml", "no page of this program"]);
}

#[test]
fn answers_of_a_file_are_shown_as_they_are() {
    let workspace = Workspace::new();
    workspace.write("q.jsonl", format!("{COLLIDING}\n[9]\n{FREE}\n"));
    let answers =
        workspace.run("query scene.toml --input q.jsonl --exits 2 --free-radius --json").expect_code(1).stdout;
    workspace.write("a.jsonl", answers.replacen("\"checks\":", "\"checks\":1000000", 1));
    let line = "view scene.toml --input q.jsonl --answers a.jsonl -o page.html";
    let failed = workspace.run(line).expect_code(1);
    assert!(failed.stderr.contains("line 2"), "{}", failed.stderr);
    let data = data_of(&std::fs::read_to_string(workspace.path("page.html")).unwrap());
    let shown = &data["answers"][0];
    assert!(shown["answer"]["checks"].as_u64().unwrap() >= 1_000_000 && !shown["answer"]["free_radius"].is_null());
    assert_eq!(shown["exits"].as_array().unwrap().len(), shown["answer"]["exits"].as_array().unwrap().len());

    workspace.write("q.jsonl", COLLIDING);
    workspace.run(line).expect_failure(&["a.jsonl", "got 2 answers, expected 1"]);
    for (from, to, parts) in [
        ("\"fore\"", "\"wrist\"", ["a.jsonl: line 1: pair", "wrist"]),
        ("\"witness\":[", "\"witness\":[0.5,", ["a.jsonl: line 1: witness", "expected 2"]),
        ("\"refined\"", "\"lucky\"", ["a.jsonl: line 1: effort", "lucky"]),
        ("\"depth\"", "\"width\"", ["a.jsonl: line 1", "expected an answer"]),
    ] {
        workspace.write("a.jsonl", answers.lines().next().unwrap().replace(from, to));
        workspace.run(line).expect_failure(&parts);
    }
}

#[test]
fn a_served_page_is_given_to_this_computer_alone() {
    let workspace = Workspace::new();
    let mut serving = workspace.command("view scene.toml --q 0.1,0 --serve --json").spawn().unwrap();
    let mut line = String::new();
    BufReader::new(serving.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let address: Value = serde_json::from_str(&line).unwrap();
    let address = address["address"].as_str().unwrap().trim_start_matches("http://").trim_end_matches('/').to_string();
    assert!(address.starts_with("127.0.0.1:"), "{address}");
    let ask = |host: &str| {
        let mut stream = TcpStream::connect(&address).unwrap();
        write!(stream, "GET / HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut reply = String::new();
        stream.read_to_string(&mut reply).unwrap();
        reply
    };
    let (own, other) = (ask(&address), ask("elsewhere.example"));
    serving.kill().unwrap();
    serving.wait().unwrap();
    assert!(own.starts_with("HTTP/1.1 200 OK") && own.ends_with("</html>\n"), "{}", &own[..200.min(own.len())]);
    assert!(other.starts_with("HTTP/1.1 403"), "{other}");
    assert!(!exists(&workspace.path("extricate-view.html")), "a served page is no file");
}

#[test]
fn a_report_measures_a_model() {
    let workspace = Workspace::learned();
    let line = "report small.model -n 20 -o report.html --json";
    let measured = &workspace.run(line).expect_code(0).json()[0]["measured"];
    assert_eq!(measured["queries"], 20);
    let shares: Vec<f64> =
        measured["budgets"].as_array().unwrap().iter().map(|b| b["within_5pct"].as_f64().unwrap()).collect();
    assert!(
        shares.iter().all(|share| (0.0..=1.0).contains(share))
            && measured["refined"]["within_5pct"].as_f64() >= Some(0.9)
    );
    assert_eq!(measured["depths"].as_array().unwrap().len(), 20);
    assert_eq!(measured["touching"][0][0][1], "post");
    let page = std::fs::read_to_string(workspace.path("report.html")).unwrap();
    assert!(
        page.contains("random collisions are within 5 %")
            && page.contains("fore &ndash; post")
            && page.matches("<svg").count() == 4
    );
    assert!(!page.contains("NaN"));
    let text = workspace.run("report small.model -n 5 -o report.html").expect_code(0).stdout;
    assert!(text.contains("of 5 random collisions within 5 % of the best found"), "{text}");
    workspace.run("report scene.toml").expect_code(1);
}

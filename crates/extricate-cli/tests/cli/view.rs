//! Pages: their contents, what is refused, and that a page is served to this computer alone.
//! scripts/check-view.py checks their look in a browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::process::{COLLIDING, FREE, Workspace, assert_keys, exists};

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
    // The same call gives the same page, except for the times.
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
fn frames_of_a_motion_are_answered_as_query_stream_does() {
    let workspace = Workspace::new();
    let frames: String =
        (0..12).map(|k| format!("[{}, {}]\n", 0.1 + 0.01 * f64::from(k), 0.02 * f64::from(k))).collect();
    workspace.write("q.jsonl", &frames);
    workspace.run("view scene.toml --input q.jsonl --stream -o page.html").expect_code(0);
    let answers = workspace.run("query scene.toml --input q.jsonl --stream --json").expect_code(0).stdout;
    workspace.write("a.jsonl", answers);
    workspace.run("view scene.toml --input q.jsonl --stream --answers a.jsonl -o given.html").expect_code(0);
    let page = |name: &str| data_of(&std::fs::read_to_string(workspace.path(name)).unwrap());
    let [asked, given] = ["page.html", "given.html"].map(page);
    assert!(asked["stream"] == true && given["stream"] == true);
    let depths = |page: &Value| -> Vec<Value> {
        page["answers"].as_array().unwrap().iter().map(|shown| shown["answer"]["depth"].clone()).collect()
    };
    assert_eq!(depths(&asked).len(), 12);
    assert_eq!(depths(&asked), depths(&given));
    workspace.run("view scene.toml --q 0,0 --stream").expect_code(2);
}

#[test]
fn paths_are_judged_along_the_way() {
    let workspace = Workspace::new();
    workspace.write(
        "paths.jsonl",
        format!("[{FREE}, {COLLIDING}, {FREE}]\n{{\"path\": [{FREE}, [-2.0, 0.1]]}}\n[{FREE}]\n"),
    );
    let failed = workspace.run("view scene.toml --paths paths.jsonl -o page.html").expect_code(1);
    assert!(failed.stderr.contains("line 3: got 1 waypoint,"), "{}", failed.stderr);
    let data = data_of(&std::fs::read_to_string(workspace.path("page.html")).unwrap());
    let played: Vec<&Value> =
        data["answers"].as_array().unwrap().iter().map(|shown| &shown["played"]["path"]).collect();
    assert_eq!(played.len(), 2);
    assert_eq!((&played[0]["waypoints"], &played[0]["colliding_segments"]), (&json!(3), &json!(2)));
    assert!(played[0]["first_collision"].as_f64().unwrap() < 0.5);
    assert_eq!((&played[1]["free_segments"], &played[1]["first_collision"]), (&json!(1), &Value::Null));
    // `check --segments` gives the same verdict.
    workspace.write("s.jsonl", format!("[{FREE}, [-2.0, 0.1]]\n"));
    let verdict = workspace.run("check scene.toml --segments --input s.jsonl --json").expect_code(0).json();
    assert_eq!(verdict[0]["outcome"], "free");
    workspace.run("view scene.toml --paths paths.jsonl --q 0,0").expect_code(2);
}

#[test]
fn grasps_are_shown_from_the_query_to_the_release() {
    let workspace = crate::grasps::workspace();
    workspace.write("g.jsonl", "[0.08, 0.065]\n[0.07, 0.07]\n");
    let answers = workspace.run("grasp grip.toml --input g.jsonl --object ball --json").expect_code(0);
    let rows = answers.json();
    workspace.run("grasp grip.toml --input g.jsonl --object ball -o a.jsonl").expect_code(0);
    workspace.run("view grip.toml --input g.jsonl --answers a.jsonl -o page.html").expect_code(0);
    let data = data_of(&std::fs::read_to_string(workspace.path("page.html")).unwrap());
    for (shown, row) in data["answers"].as_array().unwrap().iter().zip(&rows) {
        let grasp = &shown["played"]["grasp"];
        for key in ["config", "moved", "verified", "touched", "kept", "fingers", "depth_before", "quality"] {
            assert_eq!(grasp[key], row[key], "{key}");
        }
        assert_eq!(shown["exits"][0]["witness"], row["config"]);
        assert!(shown["exits"][0]["contacts"].as_array().unwrap().len() >= 2);
    }
    workspace.write(
        "a.jsonl",
        std::fs::read_to_string(workspace.path("a.jsonl")).unwrap().replace("\"config\":[", "\"config\":[1,"),
    );
    let line = "view grip.toml --input g.jsonl --answers a.jsonl -o page.html";
    workspace.run(line).expect_failure(&["a.jsonl: line 1", "expected 2"]);
}

#[test]
fn objects_that_grasps_name_are_shown() {
    let workspace = crate::grasps::workspace();
    workspace.write("g.jsonl", crate::grasps::grasps_of_a_mesh(3));
    workspace.run("grasp hand.toml --input g.jsonl --objects meshes -o a.jsonl").expect_code(0);
    let line = "view hand.toml --input g.jsonl --answers a.jsonl -o page.html";
    workspace.run(&format!("{line} --objects meshes")).expect_code(0);
    let page = || data_of(&std::fs::read_to_string(workspace.path("page.html")).unwrap());
    let data = page();
    let bodies = data["scene"]["bodies"].as_array().unwrap().len();
    for shown in data["answers"].as_array().unwrap() {
        assert_eq!(shown["object"]["name"], "object");
        assert!(shown["object"]["surface"].is_object());
        // Fingers are inside the object, which is the body after those of the scene.
        let of_object = shown["pairs"].as_object().unwrap().values().filter(|pair| pair[1] == bodies);
        assert!(of_object.count() >= 1 && !shown["contacts"].as_array().unwrap().is_empty());
    }
    workspace.run(line).expect_code(0);
    assert!(page()["answers"][0]["object"].is_null());
    workspace.run(&format!("{line} --objects nowhere")).expect_failure(&["nowhere/cup.obj"]);
}

#[test]
fn a_live_page_in_another_world_keeps_the_model() {
    let workspace = Workspace::learned();
    let world = "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.1 }\npose = { xyz = [0.8, 0.3, 0] }\n";
    workspace.write("world.toml", world);
    workspace.write("lib.wasm", b"\0asm of a test");
    let live = |line: &str| {
        workspace.run(&format!("{line} -n 1 --live --wasm lib.wasm -o page.html")).expect_code(0);
        data_of(&std::fs::read_to_string(workspace.path("page.html")).unwrap())["live"].clone()
    };
    let (alone, moved) = (live("view small.model"), live("view small.model --world world.toml"));
    assert!(alone["world"].is_null() && moved["world"].is_string());
    assert_eq!(alone["scene"], moved["scene"], "the model is the same");
    let scene = live("view scene.toml --world world.toml");
    assert!(scene["world"].is_null() && scene["scene"] != moved["scene"]);
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
    // Browsers that send nothing yet, or only a part, do not block others.
    let mut slow: Vec<TcpStream> = (0..8).map(|_| TcpStream::connect(&address).unwrap()).collect();
    slow.iter_mut().skip(1).for_each(|stream| write!(stream, "GET / HT").unwrap());
    let asked = Instant::now();
    let (own, other) = (ask(&address), ask("elsewhere.example"));
    let took = asked.elapsed();
    let twice = ask(&format!("{address}\r\nHost: {address}"));
    drop(slow);
    serving.kill().unwrap();
    serving.wait().unwrap();
    assert!(own.starts_with("HTTP/1.1 200 OK") && own.ends_with("</html>\n"), "{}", &own[..200.min(own.len())]);
    assert!(other.starts_with("HTTP/1.1 403"), "{other}");
    assert!(twice.starts_with("HTTP/1.1 400"), "{twice}");
    assert!(took < Duration::from_secs(4), "{took:?}");
    for field in ["Content-Security-Policy: frame-ancestors 'none'", "X-Frame-Options: DENY"] {
        assert!(own[..600].contains(field), "{}", &own[..600]);
    }
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
            && page.matches("<svg").count() == 3
    );
    assert!(!page.contains("NaN"));
    let text = workspace.run("report small.model -n 5 -o report.html").expect_code(0).stdout;
    assert!(text.contains("of 5 random collisions within 5 % of the best found"), "{text}");
    workspace.run("report scene.toml").expect_code(1);
}

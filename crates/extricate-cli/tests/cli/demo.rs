//! Tests the demo, shortened, and the files that it exports.

use crate::process::{Workspace, assert_keys, exists};

#[test]
fn the_demo_learns_answers_and_shows() {
    let workspace = Workspace::new();
    let line = "demo --seconds 2 --queries 20 --out way-out.html --json";
    let report = &workspace.run(line).expect_code(0).json()[0];
    assert_keys(report, &["scene", "at_once", "as_near", "learned", "learning_seconds", "queries", "page"]);
    assert_eq!((&report["at_once"]["queries"], &report["at_once"]["verified"]), (&20.into(), &1.0.into()));
    assert!(report["as_near"].as_f64().unwrap() >= 0.9);
    assert_eq!(report["queries"]["queries"], 20);
    assert_eq!(report["queries"]["verified"], 1.0);
    assert!(report["queries"]["depth_median"].as_f64().unwrap() > 0.0);
    assert_eq!(report["page"], "way-out.html");
    let page = std::fs::read_to_string(workspace.path("way-out.html")).unwrap();
    assert!(page.ends_with("</html>\n") && page.len() < 4_000_000, "{} bytes", page.len());
    // The first query of the page is in collision.
    let (_, rest) = page.split_once("\"depth\":").unwrap();
    let depth: f64 = rest.split(',').next().unwrap().parse().unwrap();
    assert!(depth > 0.0);
    // Pages are replaced, other files are not.
    workspace.write("notes.html", "my own");
    workspace.run("demo --out notes.html").expect_failure(&["notes.html", "no page of this program"]);
}

#[test]
#[cfg(unix)]
fn a_browser_draws_the_page_of_the_demo() {
    use std::os::unix::fs::PermissionsExt;
    let workspace = Workspace::new();
    // In place of a browser: it writes its last argument, the page, where the picture belongs.
    let script = "#!/bin/sh\nfor word; do case $word in --screenshot=*) out=${word#*=} ;; esac; done\n\
                  printf '\\211PNG\\r\\n\\032\\n%s' \"$word\" > \"$out\"\n";
    workspace.write("browser", script);
    std::fs::set_permissions(workspace.path("browser"), PermissionsExt::from_mode(0o755)).unwrap();
    let line = "demo --scene planar-arm --seconds 0.1 --queries 2 --png a.png";
    let demo = |line: &str, browser: &str| {
        let done = workspace.command(line).env("EXTRICATE_CHROMIUM", workspace.path(browser)).output().unwrap();
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    assert_eq!(demo(line, "browser").0, Some(0));
    let picture = std::fs::read(workspace.path("a.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.ends_with(b"extricate-demo.html#t=0"));
    let (code, said) = demo(line, "none");
    assert!(code == Some(1) && said.contains("EXTRICATE_CHROMIUM") && said.contains("expected a browser"), "{said}");
    workspace.write("notes.png", "my own");
    let (code, said) = demo(&line.replace("a.png", "notes.png"), "browser");
    assert!(code == Some(1) && said.contains("notes.png"), "{said}");
    workspace.write("browser", "#!/bin/sh\n");
    let (code, said) = demo(line, "browser");
    assert!(code == Some(1) && said.contains("drew no picture"), "{said}");
}

#[test]
fn the_exported_scene_is_whole_and_nothing_is_overwritten() {
    let workspace = Workspace::new();
    workspace.run("demo --export mine").expect_code(0);
    let again = workspace.run("demo --export mine");
    again.expect_failure(&["exists", "nothing was written"]);
    // An export completes what a killed run left, unless another file is in the way.
    let mesh = workspace.path("mine/robot/meshes/link_3.stl");
    std::fs::remove_file(&mesh).unwrap();
    workspace.run("demo --export mine").expect_code(0);
    std::fs::remove_file(&mesh).unwrap();
    workspace.write("mine/shelf-arm.toml", "other");
    workspace.run("demo --export mine").expect_failure(&["shelf-arm.toml exists", "nothing was written"]);
    assert!(!exists(&mesh));
    let report = &workspace.run("demo --export other --json").expect_code(0).json()[0];
    let scene = report["scene"].as_str().unwrap();
    assert!(report["files"].as_array().unwrap().iter().all(|f| exists(&workspace.path(f.as_str().unwrap()))));
    let info = &workspace.run(&format!("info {scene} --json")).expect_code(0).json()[0];
    assert_eq!(info["degrees_of_freedom"], 7);
    assert_eq!(info["always_colliding"]["pairs"].as_array().unwrap().len(), 0);
    let samples = workspace.run(&format!("sample {scene} -n 5 --colliding --seed 1")).expect_code(0).stdout;
    let verdicts = workspace.run_with_input(&format!("check {scene} --input - --json"), &samples).expect_code(0).json();
    assert!(verdicts.len() == 5 && verdicts.iter().all(|v| v["free"] == false));
}

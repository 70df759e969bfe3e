//! Writers that are killed: no file is lost or half written, and the next run removes what was left
//! unfinished.
//!
//! `EXTRICATE_KILLS=2500 cargo test --release -p extricate-cli killed -- --nocapture` kills each
//! writer 2,500 times.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::process::{Workspace, exists, kill};

/// Kills of each test, unless the environment sets their number.
const KILLS: usize = 50;
/// A seeded generator that needs no crate (G. Marsaglia, "Xorshift RNGs", 2003,
/// doi:10.18637/jss.v008.i14).
struct Random(u64);

impl Random {
    /// Uniform in `[0, 1)`.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn kills() -> usize {
    std::env::var("EXTRICATE_KILLS").map_or(KILLS, |n| n.parse().expect("EXTRICATE_KILLS is a number"))
}

#[test]
fn a_model_that_is_killed_at_any_moment_is_whole() {
    let workspace = Workspace::new();
    let line = |seed: usize| format!("learn scene.toml -o a.model --labels 20000 --seed {seed}");
    assert_replaces(&workspace, [&line(1), &line(2)]);
}

/// Asserts that later runs removed what killed runs left.
fn assert_no_unfinished(workspace: &Workspace) {
    let is_hidden = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(".extricate-");
    let unfinished: Vec<PathBuf> = workspace.files().into_keys().filter(is_hidden).collect();
    assert!(unfinished.is_empty(), "killed runs left {unfinished:?}, and the next ones let them lie");
}

/// A message with tetrahedra as meshes, each with many more triangles than it needs.
fn world(meshes: usize, size: f64) -> String {
    let vertices = |size: f64| {
        let vertex = |[x, y, z]: [f64; 3]| format!(r#"{{"x": {x}, "y": {y}, "z": {z}}}"#);
        [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]].map(vertex).join(", ")
    };
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|t| format!(r#"{{"vertex_indices": {t:?}}}"#));
    let triangles = vec![triangles.join(", "); 500].join(", ");
    let object = |k: usize| {
        let vertices = vertices(size * (k + 1) as f64);
        format!(
            r#"{{"header": {{"frame_id": "w"}}, "id": "o{k}", "meshes": [{{"vertices": [{vertices}], "triangles": [{triangles}]}}],
            "mesh_poses": [{{"position": {{"x": 0, "y": 0, "z": 0}}, "orientation": {{"x": 0, "y": 0, "z": 0, "w": 1}}}}]}}"#
        )
    };
    let objects: Vec<String> = (0..meshes).map(object).collect();
    format!(r#"{{"world": {{"collision_objects": [{}]}}}}"#, objects.join(", "))
}

/// Runs two lines alternately, each of which replaces the other's files, and kills them: every file
/// has to be that of one of them.
fn assert_replaces(workspace: &Workspace, lines: [&str; 2]) {
    let mut wholes: Vec<BTreeMap<PathBuf, Vec<u8>>> = Vec::new();
    let mut duration = Duration::ZERO;
    for line in lines {
        let started = Instant::now();
        workspace.run(line).expect_code(0);
        duration = started.elapsed();
        wholes.push(workspace.files());
    }
    assert!(wholes[0] != wholes[1], "both write the same");
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut replaced = 0;
    for round in 0..kills() {
        let child = workspace.command(lines[round % 2]).spawn().unwrap();
        sleep(duration.mul_f64(1.1 * random.next()));
        kill(child);
        let found = workspace.files();
        let whole = |path: &PathBuf| found.get(path).is_some_and(|bytes| wholes.iter().any(|all| all[path] == *bytes));
        let lost: Vec<&PathBuf> = wholes[0].keys().filter(|path| !whole(path)).collect();
        assert!(lost.is_empty(), "after {round} kills {lost:?} are those of neither run");
        replaced += usize::from(wholes[round % 2].iter().all(|(path, bytes)| found[path] == *bytes));
    }
    workspace.run(lines[0]).expect_code(0);
    assert_no_unfinished(workspace);
    assert!(workspace.files() == wholes[0]);
    println!("{} kills of {:?}, {replaced} after all was written", kills(), lines[0]);
}

#[test]
fn an_import_that_is_killed_at_any_moment_leaves_whole_files() {
    let workspace = Workspace::new();
    workspace.write("old.json", world(12, 1.0));
    workspace.write("new.json", world(12, 2.0));
    assert_replaces(&workspace, ["import old.json -o world.toml", "import new.json -o world.toml"]);
}

/// Runs a line to its end, then repeatedly, and kills it about when it writes. `is_whole` checks
/// the files, and the last run removes what was left unfinished.
fn assert_stays_whole(workspace: &Workspace, line: &str, is_whole: impl Fn(&BTreeMap<PathBuf, Vec<u8>>) -> bool) {
    let started = Instant::now();
    workspace.run(line).expect_code(0);
    let duration = started.elapsed();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for round in 0..kills() {
        let child = workspace.command(line).spawn().unwrap();
        sleep(duration.mul_f64(0.5 + 0.6 * random.next()));
        kill(child);
        assert!(is_whole(&workspace.files()), "{line}: after {round} kills a file is not whole");
    }
    workspace.run(line).expect_code(0);
    assert!(is_whole(&workspace.files()));
    assert_no_unfinished(workspace);
    println!("{} kills of {line:?}", kills());
}

/// Pages contain times, which differ from run to run, so their form is checked, not their bytes.
fn is_page(bytes: &[u8]) -> bool {
    bytes.starts_with(b"<!doctype html>") && bytes.ends_with(b"</html>\n")
}

#[test]
fn pages_that_are_killed_at_any_moment_are_whole() {
    let workspace = Workspace::learned();
    for line in [
        "view scene.toml --q 0.1,0 -o a.html",
        "report small.model -n 2 -o b.html",
        "demo --scene planar-arm --queries 1 --seconds 0.05 --out c.html",
    ] {
        let page = workspace.path(line.rsplit(' ').next().unwrap());
        assert_stays_whole(&workspace, line, |files| is_page(&files[&page]));
    }
}

#[test]
fn a_roadmap_that_is_killed_at_any_moment_is_whole() {
    let workspace = Workspace::new();
    let kept = workspace.path("kept");
    // A file in safetensors states its length.
    let is_whole = |bytes: &[u8]| {
        let head = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        let head_text: serde_json::Value = serde_json::from_slice(&bytes[8..8 + head]).unwrap();
        let ends = head_text.as_object().unwrap().values().filter_map(|entry| entry["data_offsets"][1].as_u64());
        bytes.len() == 8 + head + ends.max().unwrap() as usize
    };
    let line = "plan scene.toml --from 2.5,0 --to -2.5,0 --roadmap kept";
    assert_stays_whole(&workspace, line, |files| is_whole(&files[&kept]));
}

#[test]
fn manual_pages_and_exports_that_are_killed_at_any_moment_are_whole() {
    for (line, is_replaced) in [("man there", true), ("demo --scene planar-arm --export there", false)] {
        let workspace = Workspace::new();
        workspace.run(line).expect_code(0);
        let whole = workspace.files();
        let is_whole = |files: &BTreeMap<PathBuf, Vec<u8>>| {
            let known = files.iter().filter_map(|(path, bytes)| Some((whole.get(path)?, bytes)));
            known.into_iter().all(|(whole, bytes)| whole == bytes)
        };
        if is_replaced {
            assert_stays_whole(&workspace, line, is_whole);
            continue;
        }
        // Exports replace nothing, and the next run completes what a killed one left.
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for _ in 0..kills() {
            std::fs::remove_dir_all(workspace.path("there")).unwrap();
            let child = workspace.command(line).spawn().unwrap();
            sleep(Duration::from_micros((30_000.0 * random.next()) as u64));
            kill(child);
            assert!(is_whole(&workspace.files()));
            if workspace.run(line).code != Some(0) {
                assert!(whole.keys().all(|path| exists(path)), "it was not completed");
            }
            assert_no_unfinished(&workspace);
            assert!(workspace.files() == whole);
        }
    }
}

#[test]
fn grasps_that_are_killed_at_any_moment_keep_the_old_file_and_resume() {
    let workspace = crate::grasps::workspace();
    let line = "grasp hand.toml --input g.jsonl --objects meshes -o o.jsonl";
    let output = || std::fs::read(workspace.path("o.jsonl")).unwrap();
    workspace.write("g.jsonl", crate::grasps::grasps_of_a_mesh(3));
    workspace.run(line).expect_code(0);
    let old = output();
    workspace.write("g.jsonl", crate::grasps::grasps_of_meshes(100));
    let started = Instant::now();
    workspace.run(line).expect_code(0);
    let (whole, duration) = (output(), started.elapsed());
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut parts = 0;
    for _ in 0..kills() {
        workspace.write("o.jsonl", &old);
        let child = workspace.command(line).spawn().unwrap();
        sleep(duration.mul_f64(0.2 + 0.8 * random.next()));
        kill(child);
        let found = output();
        if found != whole {
            assert!(found == old, "the old file is gone before the new one is whole");
            let part = exists(&workspace.path("o.jsonl.part"));
            parts += usize::from(part);
            // Without a part, only the old file is there, and nothing can be resumed.
            workspace.run(&format!("{line}{}", if part { " --resume" } else { "" })).expect_code(0);
        }
        assert!(output() == whole && !exists(&workspace.path("o.jsonl.part")));
    }
    assert!(parts * 10 > kills(), "only {parts} of {} kills left a part: the test tests little", kills());
    workspace.run(line).expect_code(0);
    assert_no_unfinished(&workspace);
    println!("{} kills of {line:?}, {parts} left a part", kills());
}

/// Whenever a run was killed, each writer removes what it left there, and nothing else.
#[test]
fn every_writer_removes_what_was_left() {
    let workspace = Workspace::learned();
    crate::grasps::add_files(&workspace);
    workspace.write("g.jsonl", crate::grasps::grasps_of_a_mesh(1));
    workspace.write("w.json", world(1, 1.0));
    for (line, written) in [
        ("learn scene.toml -o a.model --labels 3000", &["a.model"][..]),
        ("import w.json -o w.toml", &["w.toml", "w-meshes/o0.obj"]),
        ("demo --scene planar-arm --queries 1 --seconds 0.05 --out d.html", &["d.html"]),
        ("demo --scene planar-arm --export there", &["there/planar-arm.toml"]),
        ("plan scene.toml --from 2.5,0 --to -2.5,0 --roadmap kept", &["kept"]),
        ("view scene.toml --q 0.1,0 -o v.html", &["v.html"]),
        ("report small.model -n 2 -o r.html", &["r.html"]),
        ("grasp hand.toml --input g.jsonl --objects meshes -o o.jsonl", &["o.jsonl", "o.jsonl.part"]),
        ("man pages", &["pages/extricate.1", "pages/extricate-learn.1"]),
    ] {
        let left = |suffix: &str| -> Vec<PathBuf> {
            let hidden = |path: &&str| {
                let path = workspace.path(path);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                path.with_file_name(format!(".extricate-{name}{suffix}"))
            };
            written.iter().map(hidden).collect()
        };
        let unfinished = left("-Ab3xYz");
        let of_others = [workspace.path(".extricate-other-Ab3xYz"), workspace.path("notes-Ab3xYz")];
        unfinished.iter().chain(&of_others).for_each(|path| std::fs::write(path, "half").unwrap());
        workspace.run(line).expect_code(0);
        let stays: Vec<&PathBuf> = unfinished.iter().filter(|path| exists(path)).collect();
        assert!(stays.is_empty(), "{line}: {stays:?}");
        assert!(of_others.iter().all(|path| exists(path)), "{line}");
        std::fs::remove_file(&of_others[0]).unwrap();
        assert_no_unfinished(&workspace);
    }
}

//! Writers that are killed: no file is lost or half written, runs resume to the same bytes, and the
//! next run removes what was left unfinished.
//!
//! `EXTRICATE_KILLS=2500 cargo test --release -p extricate-cli killed -- --nocapture` kills each of
//! the four writers 2,500 times.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::checkpoints::with_an_old_model;
use crate::process::{Workspace, exists, kill};

/// Kills of each test, where the environment does not say how many.
const KILLS: usize = 50;
/// Three runs of the first kind for one of the second, which is long enough to solve configurations
/// too.
const LABELS: [usize; 2] = [30_000, 110_000];

fn learning(labels: usize) -> String {
    format!("learn scene.toml -o a.model --labels {labels} --seed 5 --checkpoint-every 0")
}

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

/// Learns without interruption; returns the model's bytes and the time it took.
fn whole_run(workspace: &Workspace, line: &str) -> (Vec<u8>, Duration) {
    let started = Instant::now();
    workspace.run(line).expect_code(0);
    let bytes = std::fs::read(workspace.path("a.model")).unwrap();
    assert!(!exists(&workspace.path("a.model.checkpoint")), "a run that is over leaves no checkpoint");
    std::fs::remove_file(workspace.path("a.model")).unwrap();
    (bytes, started.elapsed())
}

fn kills() -> usize {
    std::env::var("EXTRICATE_KILLS").map_or(KILLS, |n| n.parse().expect("EXTRICATE_KILLS is a number"))
}

#[test]
fn killed_at_any_moment_it_resumes_to_the_same_bytes() {
    assert_resumes(&Workspace::new(), &LABELS.map(learning));
}

/// Three runs in which little is solved for one in which much is.
#[test]
fn adapting_that_is_killed_at_any_moment_resumes_to_the_same_bytes() {
    let workspace = with_an_old_model();
    let adapting =
        |labels| format!("adapt old.model moved.toml -o a.model --labels {labels} --seed 5 --checkpoint-every 0");
    assert_resumes(&workspace, &[30_000, 110_000].map(adapting));
}

/// Kills runs of two kinds, which write `a.model`, again and again.
fn assert_resumes(workspace: &Workspace, lines: &[String; 2]) {
    let kills = kills();
    let wholes = [0, 1].map(|kind| whole_run(workspace, &lines[kind]));
    let (model, checkpoint) = (workspace.path("a.model"), workspace.path("a.model.checkpoint"));
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut left_behind, mut done) = (0, 0);
    for round in 0.. {
        if done >= kills {
            break;
        }
        let kind = usize::from(round % 4 == 3);
        let (line, (whole, duration)) = (&lines[kind], &wholes[kind]);
        // One to three kills a run: what was resumed is killed too.
        for _ in 0..1 + (3.0 * random.next()) as usize {
            let resume = exists(&checkpoint);
            let child = workspace.command(&format!("{line}{}", if resume { " --resume" } else { "" })).spawn().unwrap();
            sleep(duration.mul_f64(1.1 * random.next()));
            kill(child);
            done += 1;
            left_behind += usize::from(exists(&checkpoint));
            if exists(&model) {
                // It was over before it was killed, or as good as: the model is never half written.
                assert!(std::fs::read(&model).unwrap() == *whole);
            }
        }
        let resume = if exists(&checkpoint) { " --resume" } else { "" };
        workspace.run(&format!("{line}{resume}")).expect_code(0);
        assert!(std::fs::read(&model).unwrap() == *whole, "other bytes after {done} kills");
        assert!(!exists(&checkpoint));
        std::fs::remove_file(&model).unwrap();
        println!("{done} kills, {left_behind} left a checkpoint");
    }
    assert_no_unfinished(workspace);
    assert!(left_behind * 4 > kills, "only {left_behind} of {kills} kills left a checkpoint: the test tests little");
}

/// What killed runs leave, the next ones remove.
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

/// Runs lines in turn, each of which replaces what the other one wrote, and kills them: every file
/// is that of one of them.
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

#[test]
fn a_demo_that_is_killed_at_any_moment_leaves_a_whole_picture() {
    let workspace = Workspace::new();
    // How much is learned in so little time differs from run to run, and the picture with it.
    let line = "demo --scene planar-arm --queries 1 --seconds 0.05 --out demo.svg";
    let picture = || std::fs::read_to_string(workspace.path("demo.svg")).unwrap();
    let started = Instant::now();
    workspace.run(line).expect_code(0);
    let duration = started.elapsed();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for round in 0..kills() {
        let child = workspace.command(line).spawn().unwrap();
        // The picture is written at the end.
        sleep(duration.mul_f64(0.8 + 0.3 * random.next()));
        kill(child);
        let found = picture();
        assert!(found.starts_with("<svg") && found.trim_end().ends_with("</svg>"), "after {round} kills: {found}");
    }
    workspace.run(line).expect_code(0);
    assert_no_unfinished(&workspace);
}

//! Tests that drawn scenes depend on the seed alone, load from their files, and have free and
//! colliding configurations.

use std::path::PathBuf;

use extricate::internals::io;
use extricate::{CheckScratch, Checker, Label};
use serde_json::Value;

use crate::drawn::*;

fn folder(test: &str) -> PathBuf {
    std::env::temp_dir().join(format!("extricate-bench-{test}-{}", std::process::id()))
}

#[test]
fn scenes_are_those_of_their_seed() {
    for robot in robots::built_in() {
        for (kind, _) in KINDS {
            let [one, again, other] = [7, 7, 8].map(|seed| among(kind, &robot, seed).unwrap());
            assert_eq!(one, again);
            assert_ne!(one.text.replace("-7", "-8"), other.text);
        }
    }
    let voxels = |name: &str| told::voxels(&mut random(name), "voxels");
    assert_eq!(voxels("a"), voxels("a"));
    assert_ne!(voxels("a"), voxels("b"));
}

#[test]
fn every_scene_loads_from_its_file_and_has_free_and_colliding_places() {
    let folder = folder("drawn");
    let mut lines = Vec::new();
    draw(&folder, 3, None, &mut lines).unwrap();
    let lines: Vec<Value> =
        String::from_utf8(lines).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3 * KINDS.len() + 2 + 3 + 4 * 3 + 1);
    for line in lines {
        let name = line["scene"].as_str().unwrap();
        let scene = io::load_scene(folder.join(name)).unwrap();
        assert_eq!(scene.warnings(), [""; 0], "{name}");
        assert_eq!(line["coordinates"], scene.space().nq());
        let share = line["colliding"].as_f64().unwrap();
        // Carts are tested at known configurations; voxels may have any share of collisions.
        if name.starts_with("carts") {
            let checker = Checker::new(scene.into());
            let mut scratch = CheckScratch::default();
            let mut q = vec![0.6002; checker.scene().space().nq()];
            assert_eq!(checker.label(&q, &mut scratch), Label::Free, "{name}");
            q[1] = -0.6;
            assert_eq!(checker.label(&q, &mut scratch), Label::Colliding, "{name}");
        } else if name.starts_with("voxels") {
            assert!(0.0 < share && share < 1.0, "{name}: {share}");
        } else {
            assert!((0.1..=0.9).contains(&share), "{name}: {share}");
            assert!(line["with_obstacles"].as_f64() >= Some(0.1), "{name}: {line}");
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn robots_that_were_not_fetched_are_missed() {
    let error = draw(&folder("missing"), 1, Some(Path::new("nowhere")), Vec::new()).unwrap_err();
    assert!(error.to_string().contains("nowhere"), "{error}");
    std::fs::remove_dir_all(folder("missing")).unwrap();
}

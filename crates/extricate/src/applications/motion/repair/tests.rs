//! Tests repairs against samples along them.

use std::path::Path;

use super::*;
use crate::applications::motion::EscapeOptions;
use crate::applications::motion::testing::{along, labelled};
use crate::collision::CheckScratch;
use crate::cspace::Label;
use crate::query::Termination;
use crate::query::keep::{KeptLink, Projection};
use crate::scene::assemble::assemble;
use crate::scene::builtin;
use crate::solver::Solver;

#[test]
fn repaired_paths_are_free_and_keep_what_was_free() {
    for name in ["planar-arm", "shelf-arm", "free-box"] {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let (free, mut scratch) = (labelled(solver.checker(), Label::Free, 12, 7), CheckScratch::default());
        let mut found = 0;
        for rows in free.chunks_exact(3) {
            let flat: Vec<f64> = rows.iter().flat_map(|q| q.iter().copied()).collect();
            let rows = Rows::new(&flat, solver.scene().space.nq()).unwrap();
            let repaired = solver.repair(rows, &RepairOptions::default()).unwrap();
            assert_eq!(repaired, solver.repair(rows, &RepairOptions::default()).unwrap());
            if !repaired.is_found() {
                continue;
            }
            found += 1;
            along(solver.checker(), &repaired.points, |p| {
                assert_eq!(solver.checker().label(p, &mut scratch), Label::Free);
            });
            assert!(repaired.places.is_sorted() && repaired.places.len() == repaired.points.len());
            for (place, q) in repaired.places.iter().zip(&repaired.points) {
                // The rows are free, so they stay.
                if *place == 0.0 || *place == 2.0 {
                    assert_eq!(q, rows.row(*place as usize));
                }
            }
        }
        assert!(found >= 3, "{name}: {found}");
    }
}

#[test]
fn ends_that_collide_are_moved() {
    let solver = Solver::new(builtin::scene("shelf-arm").unwrap());
    let nq = solver.scene().space.nq();
    let colliding = labelled(solver.checker(), Label::Colliding, 2, 3);
    // Half a hundredth of the way to another one.
    let mut near = colliding[0].to_vec();
    solver.scene().space.interpolate(&colliding[0], &colliding[1], 0.005, &mut near);
    let flat = [&colliding[0][..], &near].concat();
    let repaired = solver.repair(Rows::new(&flat, nq).unwrap(), &RepairOptions::default()).unwrap();
    assert!(repaired.is_found() && repaired.deviation > 0.0);
    let one = solver.repair(Rows::new(&colliding[0], nq).unwrap(), &RepairOptions::default()).unwrap();
    assert_eq!((one.points.len(), &one.places[..]), (1, &[0.0][..]));
    let wrong = vec![f64::NAN; nq];
    let message = solver.repair(Rows::new(&wrong, nq).unwrap(), &RepairOptions::default());
    assert!(message.unwrap_err().to_string().contains("path: row 0"));
}

/// Equal rows are a pause, of which nothing is cut off.
#[test]
fn a_free_path_with_equal_rows_stays_as_it_is() {
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    let free = labelled(solver.checker(), Label::Free, 1, 3).remove(0);
    let mut near = free.to_vec();
    near[0] += 1e-3;
    let rows = [&free[..], &free, &near].concat();
    let options = RepairOptions { max_deviation: Some(1e-9), ..RepairOptions::default() };
    let repaired = solver.repair(Rows::new(&rows, free.len()).unwrap(), &options).unwrap();
    assert_eq!((repaired.points.len(), repaired.deviation), (3, 0.0));
}

/// A motion through collisions: every frame stays a frame, is free, and is joined to the next by a
/// proved edge no longer than the limit.
#[test]
fn frames_stay_frames_and_steps_are_bounded() {
    for name in ["planar-arm", "shelf-arm", "dual-arm"] {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let (space, metric) = (&solver.scene().space, solver.metric());
        let (mut scratch, nq) = (CheckScratch::default(), space.nq());
        let (free, colliding) =
            (labelled(solver.checker(), Label::Free, 2, 3), labelled(solver.checker(), Label::Colliding, 1, 3));
        let mut rows = Vec::new();
        for (from, to) in [(&free[0], &colliding[0]), (&colliding[0], &free[1])] {
            let frames = (metric.distance(from, to) / 0.01).ceil() as usize;
            for frame in 0..frames {
                let mut q = vec![0.0; nq];
                space.interpolate(from, to, frame as f64 / frames as f64, &mut q);
                rows.extend(q);
            }
        }
        let options = RepairOptions::default().frames(true).max_step(0.05).termination(Termination::default());
        let repaired = solver.repair(Rows::new(&rows, nq).unwrap(), &options).unwrap();
        assert_eq!((repaired.points.len() * nq, repaired.stretches > 0), (rows.len(), true), "{name}");
        assert!(repaired.places.iter().enumerate().all(|(row, place)| *place == row as f64));
        along(solver.checker(), &repaired.points, |p| {
            assert_eq!(solver.checker().label(p, &mut scratch), Label::Free, "{name}");
        });
        let steps = repaired.points.windows(2).map(|edge| metric.distance(&edge[0], &edge[1]));
        assert!(steps.fold(0.0, f64::max) <= 0.05 + 1e-9, "{name}");
    }
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    let message = solver.repair(Rows::new(&[0.0; 3], 3).unwrap(), &RepairOptions::default().max_step(0.1)).unwrap_err();
    assert!(message.to_string().contains("max_step"), "{message}");
}

/// A ball that is carried along the floor has to pass a mound: the nearest way leads over it, the
/// way that keeps the contact with the floor leads around.
#[test]
fn pairs_that_touch_stay_in_touch() {
    let axis = |name: &str, [parent, child]: [&str; 2], xyz: &str| {
        format!(
            "<joint name='{name}' type='prismatic'><parent link='{parent}'/><child link='{child}'/><axis xyz='{xyz}'/>\
             <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        )
    };
    let axes = axis("x", ["rail", "cross"], "1 0 0")
        + &axis("y", ["cross", "lift"], "0 1 0")
        + &axis("z", ["lift", "ball"], "0 0 1");
    let urdf = format!(
        "<robot name='carried'><link name='rail'/><link name='cross'/><link name='lift'/><link name='ball'>\
         <collision><geometry><sphere radius='0.05'/></geometry></collision></link>{axes}</robot>"
    );
    let scene = "[[robot]]\nurdf = \"carried.urdf\"\n\
                 [[obstacle]]\nname = \"floor\"\nshape = { box = [2.0, 2.0, 0.1] }\npose = { xyz = [0.0, 0.0, -0.05] }\n\
                 [[obstacle]]\nname = \"mound\"\nshape = { sphere = 0.1 }\npose = { xyz = [0.0, 0.0, -0.03] }\n";
    let scene = assemble(Path::new("carried.toml"), scene, &mut |_| Ok(urdf.as_bytes().to_vec())).unwrap();
    let solver = Solver::new(scene);
    let rows: Vec<f64> = (0..=200).flat_map(|k| [-0.4 + 0.004 * f64::from(k), 0.03, 0.051]).collect();
    let rows = Rows::new(&rows, 3).unwrap();
    let options = RepairOptions::default().frames(true);
    let free = solver.repair(rows, &options.clone()).unwrap();
    assert!(free.is_found() && free.points.iter().any(|q| q[2] > 0.06), "the nearest way leads over the mound");
    let held = solver.repair(rows, &options.clone().touch(2e-3)).unwrap();
    assert!(held.is_found() && held.points.iter().all(|q| q[2] < 0.0521), "{:?}", held.points);
    // The floor in every row, and the mound in those that collide.
    assert!(held.touched > 201 && held.kept == held.touched, "{} of {}", held.kept, held.touched);
    along(solver.checker(), &held.points, |p| {
        assert_eq!(solver.checker().label(p, &mut CheckScratch::default()), Label::Free);
    });
    let message = solver.repair(rows, &options.touch(2e-3).aim(5e-3)).unwrap_err().to_string();
    assert!(message.contains("touch") && message.contains("0.005"), "{message}");
}

/// Escapes that hold the gripper lead out and back, so that the rows in the middle collide. Their
/// repairs hold it too: all along, or at each row if the rows are frames.
#[test]
fn repairs_keep_links() {
    let solver = Solver::new(builtin::scene("shelf-arm").unwrap());
    let scene = solver.scene();
    for text in [r#"{"link": "gripper", "rotation": null, "position": 1e-3}"#, r#"{"link": "gripper"}"#] {
        let keep = KeptLink::from_text(scene, text).unwrap();
        let mut paths = 0;
        for q in labelled(solver.checker(), Label::Colliding, 20, 3) {
            let escape = solver.escape(&q, &EscapeOptions::default().keep(keep.clone())).unwrap();
            if !escape.is_found() {
                continue;
            }
            let back: Vec<f64> = escape.points.iter().rev().chain(&escape.points[1..]).flatten().copied().collect();
            let old = Rows::new(&back, scene.space.nq()).unwrap();
            for frames in [false, true] {
                let options = RepairOptions::default().keep(keep.clone()).frames(frames);
                let repaired = solver.repair(old, &options).unwrap();
                assert!(repaired.is_found() && repaired.deviation > 0.0, "{text}, frames {frames}");
                let kept = LinkConstraint::all(scene, &keep, old.row(0));
                let (mut projection, mut scratch) = (Projection::default(), CheckScratch::default());
                along(solver.checker(), &repaired.points, |p| {
                    assert_eq!(solver.checker().label(p, &mut scratch), Label::Free);
                    assert!(frames || projection.keeps(scene, &kept, p));
                });
                for (row, q) in repaired.points.iter().enumerate().filter(|_| frames) {
                    assert!(projection.keeps(scene, &LinkConstraint::all(scene, &keep, old.row(row)), q));
                }
                paths += 1;
            }
        }
        assert!(paths >= 4, "{text}: {paths}");
    }
}

//! Tests repairs against samples along them.

use super::*;
use crate::applications::motion::testing::{along, labelled};
use crate::collision::CheckScratch;
use crate::cspace::Label;
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

//! Tests escapes against samples along them.

use super::*;
use crate::applications::motion::testing::{along, labelled};
use crate::collision::{Checker, signed_distances_of};
use crate::cspace::Label;
use crate::query::Termination;
use crate::scene::{PairId, builtin};
use crate::solver::Solver;

/// Asserts by samples what is guaranteed of a path.
fn assert_nothing_gets_worse(checker: &Checker, escape: &Escape, options: &EscapeOptions) {
    let mut scratch = CheckScratch::default();
    let pairs: Vec<PairId> = escape.colliding.iter().map(|(pair, _)| *pair).collect();
    along(checker, &escape.points[..=escape.free_from], |p| {
        let mut now = Vec::new();
        checker.colliding_pairs(p, &mut scratch, &mut now);
        assert!(now.iter().all(|pair| pairs.contains(pair)), "{now:?} {pairs:?}");
        let distances = signed_distances_of(checker, p, &pairs, &mut scratch);
        for ((_, before), now) in escape.colliding.iter().zip(distances) {
            assert!(now >= before - options.tolerance - 1e-9, "{now} {before}");
        }
    });
    along(checker, &escape.points[escape.free_from..], |p| {
        assert_eq!(checker.label(p, &mut scratch), Label::Free);
    });
    assert_eq!(checker.label(&escape.points[escape.points.len() - 1], &mut scratch), Label::Free);
    assert!(escape.deepening <= options.tolerance + 1e-9);
}

#[test]
fn nothing_gets_worse_on_the_way() {
    let (options, mut all_bent) = (EscapeOptions::default(), 0);
    for name in builtin::NAMES {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let (mut found, mut bent) = (0, 0);
        for q in labelled(solver.checker(), Label::Colliding, 40, 5) {
            let options = EscapeOptions { tree_checks: 3_000, ..options.clone() };
            let escape = solver.escape(&q, &options).unwrap();
            assert_eq!(escape, solver.escape(&q, &options).unwrap());
            if escape.is_found() {
                found += 1;
                bent += usize::from(escape.points.len() > 2 + usize::from(escape.free_from > 0));
                assert_eq!(escape.points[0], q.to_vec());
                assert_nothing_gets_worse(solver.checker(), &escape, &options);
            }
        }
        // Links that go through a shelf or through each other may have no way to part.
        let least = if ["shelf-arm", "dual-arm"].contains(name) { 15 } else { 36 };
        assert!(found >= least, "{name}: {found}");
        all_bent += bent;
    }
    assert!(all_bent >= 5, "{all_bent}");
}

#[test]
fn what_cannot_be_asked_is_told() {
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    let space = &solver.scene().space;
    let free = &labelled(solver.checker(), Label::Free, 1, 3)[0];
    let escape = solver.escape(free, &EscapeOptions::default()).unwrap();
    assert_eq!((escape.method, &escape.points[..]), (Some(EscapeMethod::Free), &[free.to_vec()][..]));
    let outside = space.config_anywhere(&vec![9.0; space.nq()]).unwrap();
    let message = |q: &Config, options: &EscapeOptions| solver.escape(q, options).unwrap_err().to_string();
    assert!(message(&outside, &EscapeOptions::default()).contains("a path cannot begin"));
    let options = EscapeOptions { exits: 1_000_000_000_000, ..EscapeOptions::default() };
    assert!(message(free, &options).contains("option exits: got 1000000000000, expected at most 100000"));
    let options = EscapeOptions { tolerance: f64::NAN, ..EscapeOptions::default() };
    assert!(message(free, &options).contains("tolerance"));
    let colliding = &labelled(solver.checker(), Label::Colliding, 1, 3)[0];
    let options = EscapeOptions { termination: Termination::after_checks(0), ..EscapeOptions::default() };
    assert!(solver.escape(colliding, &options).unwrap().checks < 200);
}

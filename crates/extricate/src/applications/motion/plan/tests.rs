//! Tests plans against samples along them, and in a passage that trees do not find.

use super::*;
use crate::applications::motion::testing::{along, labelled, peg};
use crate::collision::{CheckScratch, signed_distances_of};
use crate::cspace::Label;
use crate::query::Termination;
use crate::scene::builtin;
use crate::solver::Solver;

/// Asserts that a path leads from one end to the other and that samples of it are free.
fn assert_path(solver: &Solver, [from, to]: [&Config; 2], plan: &Plan) {
    assert_eq!((&plan.points[0], &plan.points[plan.points.len() - 1]), (&from.to_vec(), &to.to_vec()));
    let mut scratch = CheckScratch::default();
    along(solver.checker(), &plan.points, |p| assert_eq!(solver.checker().label(p, &mut scratch), Label::Free));
}

#[test]
fn paths_are_free_and_do_not_depend_on_threads() {
    for name in builtin::NAMES {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let free = labelled(solver.checker(), Label::Free, 6, 3);
        for (seed, ends) in free.chunks_exact(2).enumerate() {
            let termination = Termination::after_checks(20_000);
            let options = PlanOptions { seed: seed as u64, threads: 1, termination, ..PlanOptions::default() };
            let plan = solver.plan(&ends[0], &ends[1], &options).unwrap();
            let again = solver.plan(&ends[0], &ends[1], &PlanOptions { threads: 2, ..options }).unwrap();
            assert_eq!(plan, again, "{name}");
            if plan.is_found() {
                assert_path(&solver, [&ends[0], &ends[1]], &plan);
            }
        }
    }
}

#[test]
fn a_roadmap_leads_through_a_hole_and_is_kept() {
    let (solver, ends) = peg(2.0);
    let options = PlanOptions { resolution: 1e-3, ..PlanOptions::default() };
    let mut roadmap = Roadmap::new(&solver.scene().space, 0);
    let plan = solver.plan_with(&ends[0], &ends[1], &options, &mut roadmap).unwrap();
    assert!(plan.is_found());
    assert_path(&solver, [&ends[0], &ends[1]], &plan);
    let again = solver.plan_with(&ends[1], &ends[0], &options, &mut roadmap).unwrap();
    assert!(again.method == Some(PlanMethod::Roadmap) && again.checks < plan.checks / 4, "{}", again.checks);
    assert_path(&solver, [&ends[1], &ends[0]], &again);
}

#[test]
fn colliding_ends_are_led_out_and_get_no_deeper() {
    let mut plans = 0;
    for name in ["planar-arm", "dual-arm", "free-box"] {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let colliding = labelled(solver.checker(), Label::Colliding, 6, 3);
        let free = &labelled(solver.checker(), Label::Free, 1, 3)[0];
        for pair in colliding.chunks_exact(2) {
            for [from, to] in [[&pair[0], free], [free, &pair[1]], [&pair[0], &pair[1]]] {
                let options = PlanOptions::default().termination(Termination::after_checks(30_000)).threads(1);
                let plan = solver.plan(from, to, &options).unwrap();
                assert_eq!(plan.start_escape.is_some(), from != free);
                assert_eq!(plan.goal_escape.is_some(), to != free && plan.start_escape.iter().all(Escape::is_found));
                if plan.is_found() {
                    assert_eq!((&plan.points[0], &plan.points[plan.points.len() - 1]), (&from.to_vec(), &to.to_vec()));
                    assert_parts(&solver, [from, to], &plan, options.tolerance);
                    plans += 1;
                }
            }
        }
    }
    assert!(plans > 15, "{plans}");
}

/// Asserts by samples that the free part is free, and that on the parts before and after it no pair
/// gets deeper than at the end of the path, by more than the tolerance.
fn assert_parts(solver: &Solver, ends: [&Config; 2], plan: &Plan, tolerance: f64) {
    let (checker, mut scratch) = (solver.checker(), CheckScratch::default());
    assert!(plan.free_from <= plan.free_to);
    along(checker, &plan.points[plan.free_from..=plan.free_to], |p| {
        assert_eq!(checker.label(p, &mut scratch), Label::Free);
    });
    let parts = [&plan.points[..=plan.free_from], &plan.points[plan.free_to..]];
    for (end, part) in ends.into_iter().zip(parts) {
        let mut pairs = Vec::new();
        checker.colliding_pairs(end, &mut scratch, &mut pairs);
        let before = signed_distances_of(checker, end, &pairs, &mut scratch);
        along(checker, part, |p| {
            let mut now = Vec::new();
            checker.colliding_pairs(p, &mut scratch, &mut now);
            assert!(now.iter().all(|pair| pairs.contains(pair)), "a new pair collides");
            let distances = signed_distances_of(checker, p, &pairs, &mut scratch);
            assert!(distances.iter().zip(&before).all(|(now, before)| now >= &(before - tolerance - 1e-9)));
        });
    }
}

#[test]
fn ends_beyond_limits_are_named() {
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    let free = &labelled(solver.checker(), Label::Free, 1, 3)[0];
    let mut values = free.to_vec();
    values[1] = 100.0;
    let beyond = &solver.scene().space.config_anywhere(&values).unwrap();
    let message = |from, to| solver.plan(from, to, &PlanOptions::default()).unwrap_err().to_string();
    assert!(message(free, beyond).contains("to: coordinate 1: got 100"), "{}", message(free, beyond));
    assert!(message(beyond, free).contains("from: coordinate 1: got 100"));
    let options = PlanOptions { resolution: f64::NAN, ..PlanOptions::default() };
    assert!(solver.plan(free, free, &options).unwrap_err().to_string().contains("resolution"));
}

/// Trees, roadmaps, proofs inside batches, and shortcuts keep to the budget together.
#[test]
fn plans_keep_to_their_budget() {
    let (solver, ends) = peg(1.05);
    for checks in [100, 3_000, 12_000] {
        let options = PlanOptions { termination: Termination::after_checks(checks), ..PlanOptions::default() };
        let plan = solver.plan(&ends[0], &ends[1], &options).unwrap();
        let most = checks + checks / 10;
        assert!(plan.is_found() || (checks..=most).contains(&plan.checks), "{} of {checks}", plan.checks);
        assert!(plan.checks <= most, "{} of {checks}", plan.checks);
    }
}

/// However few checks are left, they are spent, and then growing ends.
#[test]
fn roadmaps_grow_by_the_last_check_too() {
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    for checks in 1..=12 {
        let mut roadmap = Roadmap::new(&solver.scene().space, 0);
        solver.grow_roadmap(&mut roadmap, checks, &PlanOptions::default()).unwrap();
        assert!(roadmap.checks() >= checks, "{} of {checks}", roadmap.checks());
    }
}

/// Points between the ends keep more than before if they can.
#[test]
fn paths_are_pushed_off() {
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    let (checker, mut scratch) = (solver.checker(), CheckScratch::default());
    let free = labelled(checker, Label::Free, 8, 3);
    let mut kept = [0, 0];
    for ends in free.chunks_exact(2) {
        for (at, clearance) in [None, Some(0.02)].into_iter().enumerate() {
            let options = PlanOptions { clearance, ..PlanOptions::default() };
            let plan = solver.plan(&ends[0], &ends[1], &options).unwrap();
            assert_path(&solver, [&ends[0], &ends[1]], &plan);
            let wide = checker.with_clearance(0.02);
            let inner = &plan.points[1..plan.points.len() - 1];
            kept[at] += inner.iter().filter(|q| wide.label(q, &mut scratch) == Label::Free).count();
        }
    }
    assert!(kept[1] > 10 + 2 * kept[0], "{kept:?}");
}

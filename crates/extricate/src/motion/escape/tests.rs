//! Escapes against samples along them.

use super::*;
use crate::collision::{Checker, signed_distances_of};
use crate::cspace::Label;
use crate::motion::testing::{along, labelled};
use crate::query::World;
use crate::scene::{PairId, builtin};

/// Asserts what is promised of a path, by samples.
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
    let options = EscapeOptions::default();
    for name in builtin::NAMES {
        let world = World::new(builtin::scene(name).unwrap());
        let (mut methods, mut checks, mut queries) = (Vec::new(), Vec::new(), Vec::new());
        for q in labelled(world.checker(), Label::Colliding, 40, 5) {
            let escape = world.view().escape(&q, &options).unwrap();
            checks.push(escape.checks);
            queries.push(world.query(&q).unwrap().checks);
            methods.push(escape.method.map_or("none", EscapeMethod::name));
            if escape.is_found() {
                assert_eq!(escape.points[0], q.to_vec());
                assert_nothing_gets_worse(world.checker(), &escape, &options);
            }
        }
        let count = |method: &str| methods.iter().filter(|m| **m == method).count();
        let median = |values: &mut Vec<usize>| {
            values.sort_unstable();
            values[values.len() / 2]
        };
        let mean = checks.iter().sum::<usize>() / checks.len();
        eprintln!(
            "{name}: nearest {} exit {} pushed {} grown {} none {}; checks median {} mean {mean}, queries {}",
            count("nearest"), count("exit"), count("pushed"), count("grown"), count("none"), median(&mut checks), median(&mut queries)
        );
        assert!(count("none") <= 4, "{name}: {methods:?}");
    }
}

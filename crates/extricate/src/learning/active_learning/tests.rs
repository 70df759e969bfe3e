//! Active training on a union of balls, where every label and every decision is known.

use crate::learning::LearnOptions;
use std::ops::ControlFlow;
use std::sync::Mutex;

use crate::cspace::Manifold;
use crate::cspace::sampling::Halton;
use crate::learning::active_learning::*;

/// Balls in a cube of side 4: centre and radius.
const BALLS: [[f64; 4]; 3] = [[-0.6, 0.0, 0.2, 1.2], [0.9, 0.3, -0.3, 0.9], [1.4, -1.4, 1.2, 0.4]];
const NQ: usize = 3;

fn offset(q: &[f64], part: u32) -> [f64; NQ] {
    std::array::from_fn(|k| q[k] - BALLS[part as usize][k])
}

fn offsets(configs: &[f64], parts: &[u32]) -> Vec<f64> {
    configs.chunks_exact(NQ).flat_map(|q| parts.iter().flat_map(move |part| offset(q, *part))).collect()
}

fn containing(configs: &[f64]) -> Vec<Vec<u32>> {
    let is_inside =
        |q: &[f64], part: u32| offset(q, part).iter().map(|x| x * x).sum::<f64>().sqrt() < BALLS[part as usize][NQ];
    configs.chunks_exact(NQ).map(|q| (0..3).filter(|part| is_inside(q, *part)).collect()).collect()
}

const PARTS: Parts = Parts { count: 3, nq: NQ, containing: &containing, features: &offsets, width: NQ };

fn labels(configs: &[f64]) -> Vec<Label> {
    let of = |inside: Vec<u32>| if inside.is_empty() { Label::Free } else { Label::Colliding };
    containing(configs).into_iter().map(of).collect()
}

fn cube() -> ConfigSpace {
    let mut space = ConfigSpace::default();
    for k in 0..NQ {
        space.push(format!("x{k}"), Manifold::Interval { lower: -2.0, upper: 2.0 }, 1.0);
    }
    space
}

/// The free and the colliding ones of the first `count` configurations of a seed, row major.
fn explored(count: u64, seed: u64) -> [Vec<f64>; 2] {
    let (space, halton, mut q) = (cube(), Halton::new(NQ, seed), [0.0; NQ]);
    let mut lists = [Vec::new(), Vec::new()];
    for i in 0..count {
        halton.config(&space, i, &mut q);
        lists[usize::from(labels(&q)[0] == Label::Colliding)].extend_from_slice(&q);
    }
    lists
}

fn fitted(configs: &[f64]) -> ObstacleClassifier {
    ObstacleClassifier::fit(&PARTS, configs, &containing(configs), &FitOptions::default(), None)
}

fn rows(configs: &[f64]) -> Vec<&[f64]> {
    configs.chunks_exact(NQ).collect()
}

/// Decisions of free configurations and negated ones of colliding ones: the lower, the worse.
fn sureness(classifier: &ObstacleClassifier, lists: &[Vec<f64>; 2]) -> Vec<f64> {
    let of = |side: usize| classifier.decisions(NQ, &offsets, &lists[side]);
    of(0).into_iter().chain(of(1).into_iter().map(|decision| -decision)).collect()
}

#[test]
fn the_wrong_and_the_least_sure_are_taken() {
    let classifier = fitted(&explored(400, 1).concat());
    let count = 300;
    // At most this many of each label are evaluated.
    let candidates = CANDIDATES_PER_ADDED * count / 2;
    let before = explored(6000, 2);
    let mut pool = before.clone();
    let taken = take_doubtful(&classifier, &PARTS, &mut pool, count);
    assert_eq!((taken[0].len() + taken[1].len()) / NQ, count);
    let mut seen_and_left = [Vec::new(), Vec::new()];
    for side in [0, 1] {
        let (all, seen) = (rows(&before[side]), candidates.min(before[side].len() / NQ));
        let is_taken = |q: &&[f64]| rows(&taken[side]).contains(q);
        assert!(rows(&taken[side]).iter().all(|q| all[..seen].contains(q)), "only what was looked at is taken");
        let left: Vec<&[f64]> = all[..seen].iter().filter(|q| !is_taken(q)).chain(&all[seen..]).copied().collect();
        assert_eq!(rows(&pool[side]), left, "the others stay, in their order");
        seen_and_left[side] = left[..seen - taken[side].len() / NQ].concat();
    }
    let most = |values: Vec<f64>| values.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let least = |values: Vec<f64>| values.into_iter().fold(f64::INFINITY, f64::min);
    let (taken, left) = (sureness(&classifier, &taken), sureness(&classifier, &seen_and_left));
    assert!(most(taken.clone()) <= least(left.clone()), "{} {}", most(taken), least(left));
}

#[test]
fn of_new_ones_those_nearest_to_the_predicted_boundary_are_taken() {
    let classifier = fitted(&explored(600, 1).concat());
    let (count, seed) = (500, 7);
    let taken = most_doubtful_of_new(&classifier, &cube(), &PARTS, count, &mut ChaCha8Rng::seed_from_u64(seed));
    assert_eq!(taken.len(), count * NQ);
    // Draws the same configurations again: none that was left is nearer.
    let (space, mut rng) = (cube(), ChaCha8Rng::seed_from_u64(seed));
    let mut all = vec![0.0; CANDIDATES_PER_ADDED * count * NQ];
    all.chunks_exact_mut(NQ).for_each(|q| uniform(&space, &mut rng, q));
    let doubts = |configs: &[f64]| -> Vec<f64> {
        let mut doubts: Vec<f64> = classifier.decisions(NQ, &offsets, configs).into_iter().map(f64::abs).collect();
        doubts.sort_by(f64::total_cmp);
        doubts
    };
    assert_eq!(doubts(&taken), doubts(&all)[..count]);
}

/// Choosing pays off: the same number of labels leaves fewer mistakes.
#[test]
fn chosen_configurations_teach_more_than_as_many_uniform_ones() {
    let [mut mistakes_chosen, mut mistakes_uniform] = [0.0; 2];
    for seed in [1, 2, 3] {
        let [first, all] = [600, 3000].map(|count| explored(count, seed));
        let mut pool = [0, 1].map(|side| all[side][first[side].len()..].to_vec());
        let uniform = explored(1000, seed).concat();
        let classifier = fitted(&first.concat());
        let chosen = take_doubtful(&classifier, &PARTS, &mut pool, 400).concat();
        let held = explored(8000, 10 + seed).concat();
        let mistakes = |configs: &[f64]| {
            let shares = fitted(configs).accuracy(NQ, &offsets, &held, &labels(&held));
            1.0 - 0.5 * shares.into_iter().flatten().sum::<f64>()
        };
        mistakes_chosen += mistakes(&[first.concat(), chosen].concat());
        mistakes_uniform += mistakes(&uniform);
    }
    println!("balanced mistakes, summed over three seeds: chosen {mistakes_chosen:.4}, uniform {mistakes_uniform:.4}");
    assert!(mistakes_chosen < 0.75 * mistakes_uniform, "{mistakes_chosen} {mistakes_uniform}");
}

#[test]
fn surprises_come_first_and_nothing_is_lost() {
    // The training set is so small that the classifier is often wrong.
    let classifier = fitted(&explored(60, 1).concat());
    let [_, before] = explored(3000, 2);
    let count = before.len() / NQ - 100;
    let mut after = before.clone();
    surprising_first(&classifier, &offsets, NQ, count, &mut after);
    let predictions = classifier.predictions(NQ, &offsets, &before);
    let predicted = |label: Label| {
        let all = before.chunks_exact(NQ).zip(&predictions).take(count);
        all.filter(move |(_, predicted)| **predicted == label).map(|(q, _)| q)
    };
    assert!(predicted(Label::Free).count() > 20, "{}", predicted(Label::Free).count());
    let rest = before.chunks_exact(NQ).skip(count);
    let expected: Vec<&[f64]> = predicted(Label::Free).chain(predicted(Label::Colliding)).chain(rest).collect();
    assert_eq!(rows(&after), expected);
    // A count above the number of rows means all rows.
    surprising_first(&classifier, &offsets, NQ, usize::MAX, &mut after);
    let predictions = classifier.predictions(NQ, &offsets, &after);
    assert!(predictions.is_sorted_by_key(|label| *label == Label::Colliding));
}

#[test]
fn training_counts_what_it_asks_and_never_sees_what_it_is_judged_by() {
    // Rounds draw on known configurations if there are many, and on new ones if there are few.
    for (count, draws) in [(20_000, false), (3000, true)] {
        let [free, colliding] = explored(count, 3);
        let mut known = Exploration { free: free.clone(), colliding: colliding.clone(), next: count };
        let asked = Mutex::new(Vec::new());
        let containing = |configs: &[f64]| {
            asked.lock().unwrap().extend_from_slice(configs);
            containing(configs)
        };
        let parts = Parts { containing: &containing, ..PARTS };
        let options = LearnOptions { labels: 1_000_000, seconds: None, ..LearnOptions::default() };
        let mut report = |_: &_| ControlFlow::Continue(());
        let mut budget = Budget::new(&options, &mut report);
        let outcome = classify(&cube(), &parts, &mut known, options.seed, &mut budget);
        let asked = asked.into_inner().unwrap();
        assert_eq!(budget.spent(), asked.len() / NQ);
        assert!(known.free.starts_with(&free) && known.colliding.starts_with(&colliding));
        let drawn = (known.free.len() + known.colliding.len() - free.len() - colliding.len()) / NQ;
        assert_eq!(drawn, if draws { (TRAINING_ROUNDS - 1) * ADDED_PER_ROUND } else { 0 });
        let svms = outcome.classifier.as_ref().unwrap().svms();
        for (side, list) in [&free, &colliding].into_iter().enumerate() {
            let held = &rows(list)[list.len() / NQ - outcome.held_out[side]..];
            assert!(held.len() == (list.len() / NQ / 5).min(MAX_HELD_OUT));
            let trained_on = |svm: &crate::learning::obstacle_classifier::PairSvm| {
                rows(&svm.support).iter().any(|q| held.contains(q))
            };
            assert!(!svms.iter().any(trained_on) && !rows(&asked).iter().any(|q| held.contains(q)));
        }
        let accuracy = outcome.balanced_accuracy().unwrap();
        println!("balanced accuracy {accuracy:.4} after {} labels", budget.spent());
        assert!(accuracy > 0.98, "{accuracy}");
    }
}

//! Results of queries besides the nearest exit: several exits, a termination, the gradient, the
//! segment there, and batches.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::query::answer::RIVAL;
use extricate::{
    Answer, CheckScratch, Config, Effort, Label, MetricKind, QueryOptions, SegmentOptions, SegmentOutcome, Solver,
    Stop, Termination, builtin,
};

use crate::baselines::{
    BUDGET_FOUND_EXITS, GRADIENT_KINKS_SLOPES, GRADIENT_OF_DEPTH_QUERIES, SEGMENT_COLLIDING_SHARE,
    SEVERAL_EXITS_FOUND_EXITS, SEVERAL_PAIRS_QUERIES, STOPPED_CHECKS_SHARE,
};
use crate::memory::learned;

fn model(name: &str, metric: MetricKind) -> Solver {
    learned(builtin::scene(name).unwrap().with_metric(metric), 6_000, 7)
}

pub fn colliding(solver: &Solver, count: usize) -> Vec<Config> {
    let space = solver.scene().space();
    let halton = Halton::new(space.nv(), 5);
    let mut check = CheckScratch::default();
    let mut q = vec![0.0; space.nq()];
    let all = (0..).map(|i| {
        halton.config(space, i, &mut q);
        space.config(&q).unwrap()
    });
    all.filter(|q| solver.checker().label(q, &mut check) == Label::Colliding).take(count).collect()
}

/// Returns the answer with these options instead of those of the solver.
pub fn ask(solver: &Solver, q: &Config, options: &QueryOptions) -> Answer {
    solver.clone().options(options.clone()).unwrap().query(q).expect("something is free")
}

#[test]
fn a_query_that_was_warmed_up_says_what_a_first_one_says() {
    for (name, effort) in [("shelf-arm", Effort::Nearest), ("planar-arm", Effort::Refined), ("hand", Effort::Nearest)] {
        let model = model(name, MetricKind::Joint);
        let options = QueryOptions::default().effort(effort);
        let warm = model.clone().options(options.clone()).unwrap();
        warm.warm_up(Duration::from_millis(5));
        for q in colliding(&model, 20) {
            // The fresh solver shares the model, but no memory.
            let fresh = Solver::of_model(Arc::clone(model.model().unwrap()));
            let (first, warmed) = (ask(&fresh, &q, &options), warm.query(&q).unwrap());
            assert_eq!(format!("{first:?}"), format!("{warmed:?}"), "{name}");
        }
    }
}

#[test]
fn several_exits_are_free_distinct_sorted_and_begin_with_the_witness() {
    let mut found = 0;
    for (name, metric) in [
        ("shelf-arm", MetricKind::Joint),
        ("planar-arm", MetricKind::Joint),
        ("free-box", MetricKind::ObjectNorm),
        ("planar-arm", MetricKind::MaxDisplacement),
    ] {
        let model = model(name, metric);
        let mut check = CheckScratch::default();
        for q in colliding(&model, 6) {
            let one = ask(&model, &q, &QueryOptions::default());
            let answer = ask(&model, &q, &QueryOptions::default().exits(4));
            assert!(one.exits.is_empty());
            assert!((1..=4).contains(&answer.exits.len()), "{name}: {}", answer.exits.len());
            assert!(answer.depth <= one.depth * 1.001, "{name}: {} {}", answer.depth, one.depth);
            assert_eq!((answer.exits[0].depth, &answer.exits[0].witness), (answer.depth, &answer.witness));
            assert!(answer.exits.is_sorted_by(|a, b| a.depth <= b.depth));
            for (i, exit) in answer.exits.iter().enumerate() {
                assert_eq!(model.checker().label(&exit.witness, &mut check), Label::Free);
                let distance = model.metric().distance(&q, &exit.witness);
                assert!((distance - exit.depth).abs() < 1e-9 + 1e-6 * distance, "{name}: {distance} {}", exit.depth);
                let apart = |other: &extricate::Exit| model.metric().distance(&exit.witness, &other.witness);
                assert!(answer.exits[..i].iter().all(|other| apart(other) > 0.01 * exit.depth), "{name}: {i}");
            }
            let rivals = answer.exits.iter().skip(1).any(|exit| exit.depth <= RIVAL * answer.depth);
            assert_eq!(answer.unique, !rivals, "{name}");
            found += answer.exits.len();
        }
    }
    assert!(found > SEVERAL_EXITS_FOUND_EXITS, "{found} exits of 24 queries");
}

#[test]
fn an_exit_is_a_local_minimum() {
    let model = model("planar-arm", MetricKind::Joint);
    let space = model.scene().space();
    let (mut check, halton) = (CheckScratch::default(), Halton::new(space.nv(), 3));
    let (mut a, mut b) = (vec![0.0; space.nq()], vec![0.0; space.nq()]);
    let (mut step, mut near) = (vec![0.0; space.nv()], vec![0.0; space.nq()]);
    for q in colliding(&model, 10) {
        for exit in ask(&model, &q, &QueryOptions::default().exits(3)).exits {
            for k in 0..300 {
                halton.config(space, 2 * k, &mut a);
                halton.config(space, 2 * k + 1, &mut b);
                space.difference(&a, &b, &mut step);
                let length = space.distance(&a, &b);
                step.iter_mut().for_each(|s| *s *= 0.02 * exit.depth / length);
                space.integrate(&exit.witness, &step, &mut near);
                let nearer = model.metric().distance(&q, &near) < 0.999 * exit.depth;
                assert!(!nearer || model.checker().label(&near, &mut check) == Label::Colliding, "{exit:?}");
            }
        }
    }
}

#[test]
fn a_larger_budget_is_never_worse_and_checks_are_kept() {
    for (name, metric) in [("shelf-arm", MetricKind::Joint), ("free-box", MetricKind::MaxDisplacement)] {
        let model = model(name, metric);
        for effort in [Effort::Refined, Effort::Exhaustive] {
            for q in colliding(&model, 4) {
                let with =
                    |termination| ask(&model, &q, &QueryOptions::default().effort(effort).termination(termination));
                let full = with(Termination::default());
                let mut last = f64::INFINITY;
                for checks in [0, 1, 3, 10, 30, 60, 100, 300] {
                    let answer = with(Termination::after_checks(checks));
                    assert!(answer.verified && answer.depth <= last, "{name}: {} after {last}", answer.depth);
                    assert!(answer.checks <= checks.max(1) + 3, "{name}: {} of {checks}", answer.checks);
                    last = answer.depth;
                }
                assert!(full.depth <= last);
                let none = with(Termination::after_seconds(f64::MIN_POSITIVE));
                assert!(none.verified && none.checks <= 4, "{}", none.checks);
                assert_eq!(with(Termination::after_seconds(f64::MAX)), full);
            }
        }
    }
}

/// Exits that were met before the termination was spent are checked within it.
#[test]
fn several_exits_keep_to_a_budget() {
    let model = model("shelf-arm", MetricKind::Joint);
    let mut told = 0;
    for q in colliding(&model, 200) {
        let termination = Termination::after_checks(40);
        let answer = ask(&model, &q, &QueryOptions::default().exits(6).termination(termination).segment(true));
        assert!(answer.checks <= 40 + 3 + answer.exits.len() + 1, "{} of 40, {}", answer.checks, answer.exits.len());
        assert!(answer.cut_short || answer.checks < 40);
        assert_eq!(answer.is_doubtful(), answer.cut_short && answer.gap > 0.5);
        told += answer.exits.len();
    }
    assert!(told > BUDGET_FOUND_EXITS, "{told}");
}

#[test]
fn a_query_ends_when_its_caller_says_so() {
    for (name, metric) in [("planar-arm", MetricKind::Joint), ("free-box", MetricKind::MaxDisplacement)] {
        let model = model(name, metric);
        for q in colliding(&model, 2) {
            let options = QueryOptions::default().effort(Effort::Exhaustive).exits(3);
            let full = ask(&model, &q, &options);
            let mut last = f64::INFINITY;
            for questions in [0, 1, 30, 300] {
                let asked = Arc::new(AtomicUsize::new(0));
                let counted = asked.clone();
                let stop = Stop::when(move || counted.fetch_add(1, Ordering::Relaxed) >= questions);
                let answer = ask(&model, &q, &options.clone().termination(Termination::default().stop(stop.clone())));
                assert!(answer.verified && answer.lower_bound <= answer.depth && full.depth <= answer.depth, "{name}");
                let is_stopped = (answer.checks as f64) < STOPPED_CHECKS_SHARE * full.checks as f64;
                assert!(answer.depth <= last && is_stopped, "{} of {}", answer.checks, full.checks);
                assert!(stop.is_asked() && stop == stop.clone() && stop != Stop::when(|| true));
                last = answer.depth;
            }
            let never = options.termination(Termination::default().stop(Stop::when(|| false)));
            assert_eq!(ask(&model, &q, &never), full);
        }
    }
}

#[test]
fn the_gradient_is_that_of_the_distance_and_of_the_depth_where_it_is_smooth() {
    for (name, metric) in [
        ("shelf-arm", MetricKind::Joint),
        ("free-box", MetricKind::Joint),
        ("free-box", MetricKind::ObjectNorm),
        ("shelf-arm", MetricKind::MaxDisplacement),
    ] {
        let model = model(name, metric);
        let space = model.scene().space();
        let (mut off, mut of_depth) = (0, 0);
        let mut moved = vec![0.0; space.nq()];
        for q in colliding(&model, 8) {
            let answer = ask(&model, &q, &QueryOptions::default());
            for k in 0..space.nv() {
                let mut slope = |h: f64, of: &dyn Fn(&[f64]) -> f64| {
                    let mut step = vec![0.0; space.nv()];
                    step[k] = h;
                    space.integrate(&q, &step, &mut moved);
                    (of(&moved) - answer.depth) / h
                };
                let distance = |p: &[f64]| model.metric().distance(p, &answer.witness);
                // The largest displacement has a kink where several points move equally far, as at
                // the nearest exit; elsewhere both slopes agree. The step is no shorter than the
                // length over which the gradient is a mean.
                let least = if metric == MetricKind::MaxDisplacement { 2e-5 } else { 0.0 };
                let h = f64::max(3e-4 * answer.depth, least);
                let (ahead, behind) = (slope(h, &distance), slope(-h, &distance));
                let slack = 2e-3 * (1.0 + ahead.abs());
                assert!(metric == MetricKind::MaxDisplacement || (ahead - behind).abs() < slack);
                let between = ahead.min(behind) - slack..=ahead.max(behind) + slack;
                off += usize::from(!between.contains(&answer.gradient[k]));
                // Only a query that follows the same exit has the slope of the depth.
                let depth =
                    |p: &[f64]| space.config(p).map_or(f64::NAN, |p| ask(&model, &p, &QueryOptions::default()).depth);
                if metric == MetricKind::Joint && k == 0 && answer.unique {
                    let slope = slope(1e-4 * answer.depth, &depth);
                    of_depth += usize::from((slope - answer.gradient[k]).abs() < 0.02);
                }
            }
        }
        let kinks = if metric == MetricKind::MaxDisplacement { GRADIENT_KINKS_SLOPES } else { 0 };
        assert!(off <= kinks, "{name} {metric:?}: {off}");
        let is_smooth = metric != MetricKind::Joint || of_depth >= GRADIENT_OF_DEPTH_QUERIES;
        assert!(is_smooth, "{name}: {of_depth} of 8");
    }
}

#[test]
fn the_way_ends_in_a_stretch_that_is_proved_free() {
    let model = model("shelf-arm", MetricKind::Joint);
    let mut check = CheckScratch::default();
    for q in colliding(&model, 10) {
        let answer = ask(&model, &q, &QueryOptions::default().segment(true));
        let segment = answer.segment.expect("asked for");
        let collides = segment.colliding_until > SEGMENT_COLLIDING_SHARE;
        assert!(segment.colliding_until <= segment.free_from && collides, "{segment:?}");
        let mut from = q.to_vec();
        model.scene().space().interpolate(&q, &answer.witness, segment.free_from, &mut from);
        let outcome = model.checker().segment(&answer.witness, &from, &SegmentOptions::default(), &mut check);
        assert!(matches!(outcome, SegmentOutcome::Free) || segment.free_from > 0.999, "{segment:?} {outcome:?}");
        assert_eq!(answer.touching.is_empty(), answer.contacts.is_empty());
        assert!(answer.contacts.iter().all(|c| (c.normal.norm() - 1.0).abs() < 1e-9));
    }
}

#[test]
fn a_batch_answers_as_one_by_one_in_order_and_can_be_ended() {
    let model = model("planar-arm", MetricKind::Joint);
    let queries = colliding(&model, 40);
    let several = model.clone().options(QueryOptions::default().exits(2)).unwrap();
    let single: Vec<Answer> = queries.iter().map(|q| several.query(q).unwrap()).collect();
    for threads in [0, 1, 3] {
        let mut answers = Vec::new();
        let done = several.batch_each(queries.iter().cloned(), threads, &mut |answered| {
            assert_eq!(answered.index, answers.len());
            assert!(answered.seconds > 0.0);
            answers.push(answered.answer);
            ControlFlow::Continue(())
        });
        assert!(done == 40 && answers == single.iter().cloned().map(Some).collect::<Vec<_>>(), "{threads} threads");
    }
    let mut seen = 0;
    let ended = model.batch_each(std::iter::repeat(queries[0].clone()), 2, &mut |_| {
        seen += 1;
        if seen == 17 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!((ended, seen), (17, 17));
    assert_eq!(several.batch_each(Vec::new(), 2, &mut |_| ControlFlow::Continue(())), 0);
}

#[test]
fn the_nearest_sample_comes_with_its_contacts_where_they_are_asked_for() {
    for (name, metric) in [("shelf-arm", MetricKind::Joint), ("planar-arm", MetricKind::MaxDisplacement)] {
        let model = model(name, metric);
        let mut several = 0;
        for q in colliding(&model, 40) {
            let bare = QueryOptions::default().effort(Effort::Nearest);
            let told = ask(&model, &q, &bare.clone().contacts(true));
            let bare = ask(&model, &q, &bare);
            assert_eq!((bare.depth, &bare.witness), (told.depth, &told.witness));
            assert_eq!((bare.max_displacement, &bare.gradient), (told.max_displacement, &told.gradient));
            assert!(bare.contacts.is_empty() && bare.touching.is_empty());
            assert!(bare.colliding.len() == 1 && told.colliding.contains(&bare.colliding[0]), "{name}: {told:?}");
            // The bound of one pair is at most that of all pairs.
            assert!((0.0..=told.lower_bound).contains(&bare.lower_bound), "{name}: {bare:?} {told:?}");
            assert_eq!(told.colliding, ask(&model, &q, &QueryOptions::default()).colliding);
            several += usize::from(told.colliding.len() > 1);
            assert_eq!(told.touching.is_empty(), told.contacts.is_empty());
        }
        assert!(several > SEVERAL_PAIRS_QUERIES, "{name}: {several} of 40 with several pairs");
    }
}

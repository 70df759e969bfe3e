//! Queries in scenes of which nothing was learned.

use std::ops::ControlFlow;

use extricate::internals::cspace::sampling::Halton;
use extricate::{
    Answer, CheckScratch, Config, Effort, Label, MetricKind, QueryOptions, Solver, StreamOptions, Termination, builtin,
};

use crate::baselines::{NO_MODEL_MISSED_SHARE, NO_MODEL_SEVERAL_EXITS_QUERIES, NO_MODEL_STREAM_AS_NEAR_FRAMES};
use crate::memory::learned;
use crate::query::ask;

fn world(name: &str, metric: MetricKind) -> Solver {
    Solver::new(builtin::scene(name).unwrap().with_metric(metric))
}

fn colliding(world: &Solver, count: usize) -> Vec<Config> {
    let space = world.scene().space();
    let (halton, mut check, mut q) = (Halton::new(space.nv(), 5), CheckScratch::default(), vec![0.0; space.nq()]);
    let all = (0..).map(|i| {
        halton.config(space, i, &mut q);
        space.config(&q).unwrap()
    });
    all.filter(|q| world.checker().label(q, &mut check) == Label::Colliding).take(count).collect()
}

fn with(effort: Effort) -> QueryOptions {
    QueryOptions::default().effort(effort)
}

#[test]
fn answers_are_verified_bounded_and_nearly_those_of_a_long_search() {
    let mut missed = 0;
    for name in builtin::NAMES {
        for metric in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
            let world = world(name, metric);
            let mut check = CheckScratch::default();
            for q in colliding(&world, 5) {
                let [nearest, refined, exhaustive] = [Effort::Nearest, Effort::Refined, Effort::Exhaustive]
                    .map(|effort| world.clone().options(with(effort)).unwrap().query(&q).expect("something is free"));
                for answer in [&nearest, &refined, &exhaustive] {
                    assert!(answer.verified);
                    assert_eq!(world.checker().label(&answer.witness, &mut check), Label::Free);
                    assert!((world.metric().distance(&q, &answer.witness) - answer.depth).abs() < 1e-9);
                    assert!(answer.lower_bound <= answer.depth);
                }
                let depths = [nearest.depth, refined.depth, exhaustive.depth];
                // Without a model, `nearest` gets one pair only, and may group joints differently.
                let [a, b, c] = depths;
                assert!(a >= (1.0 - 1e-4) * b && b >= c, "{name} {metric:?}: {depths:?} at {q:?}");
                assert!(refined.lower_bound <= exhaustive.depth && refined.unseen.is_some());
                missed += usize::from(refined.depth > 1.05 * exhaustive.depth);
            }
        }
    }
    let all = 15 * builtin::NAMES.len();
    println!("{missed} of {all} missed by more than 5 %");
    assert!(missed as f64 <= NO_MODEL_MISSED_SHARE * all as f64, "{missed} of {all}");
}

#[test]
fn batches_and_threads_change_nothing_and_more_checks_never_lead_farther() {
    let world = world("shelf-arm", MetricKind::Joint);
    let queries = colliding(&world, 20);
    let single: Vec<Option<Answer>> = queries.iter().map(|q| world.query(q)).collect();
    for threads in [1, 3] {
        let mut batch = Vec::new();
        world.batch_each(queries.clone(), threads, &mut |answered| {
            batch.push(answered.answer);
            ControlFlow::Continue(())
        });
        assert_eq!(batch, single);
    }
    for (q, full) in queries.iter().zip(&single) {
        let mut last = f64::INFINITY;
        for checks in [0, 1, 5, 20, 60, 200, 100_000] {
            let termination = Termination::after_checks(checks);
            let answer = ask(&world, q, &QueryOptions::default().termination(termination));
            assert!(answer.verified && answer.depth <= last);
            last = answer.depth;
        }
        assert_eq!(full.as_ref().map(|answer| answer.depth), Some(last));
    }
}

#[test]
fn several_exits_and_streams_need_no_model() {
    let world = world("planar-arm", MetricKind::Joint);
    let (queries, mut several) = (colliding(&world, 40), 0);
    for q in &queries {
        let answer = ask(&world, q, &QueryOptions::default().exits(3));
        assert!(answer.exits.is_sorted_by(|a, b| a.depth <= b.depth) && answer.exits[0].witness == answer.witness);
        several += usize::from(answer.exits.len() > 1);
    }
    assert!(several > NO_MODEL_SEVERAL_EXITS_QUERIES, "{several} of 40");
    let (mut stream, mut near) = (world.stream(StreamOptions::default()).unwrap(), 0);
    for step in 0..100 {
        let mut q = vec![0.0; world.scene().space().nq()];
        world.scene().space().interpolate(&queries[0], &queries[1], f64::from(step) / 100.0, &mut q);
        let q = world.scene().space().config(&q).unwrap();
        let frame = stream.query(&q).unwrap();
        let alone = world.query(&q).unwrap();
        near += usize::from(frame.depth <= 1.05 * alone.depth);
    }
    assert!(near >= NO_MODEL_STREAM_AS_NEAR_FRAMES, "{near} of 100");
}

#[test]
fn where_nothing_is_free_there_is_no_answer() {
    let scene = builtin::scene("planar-arm").unwrap().with_clearance(50.0).unwrap();
    let world = Solver::new(scene);
    let q = world.scene().space().config(&[0.0; 3]).unwrap();
    for effort in [Effort::Nearest, Effort::Refined, Effort::Exhaustive] {
        assert_eq!(world.clone().options(with(effort)).unwrap().query(&q), None);
    }
}

/// Metrics of displacement measure nothing here: everything is as near as everything else.
#[test]
fn a_robot_without_geometry_is_free_everywhere() {
    let urdf = crate::memory::chain(&[("revolute", [0.0; 3], [0.0, 0.0, 1.0], -1.0, 1.0, "")]);
    let toml = "[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"ball\"\nshape = { sphere = 1 }\n";
    for metric in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
        let scene = crate::memory::scene(toml, &[("r.urdf", urdf.clone())]).with_metric(metric);
        let q = scene.config(&[0.5]).unwrap();
        assert!(Solver::new(scene.clone()).query(&q).unwrap().is_free());
        let model = learned(scene, 2000, 1);
        assert!(model.query(&q).unwrap().is_free());
    }
}

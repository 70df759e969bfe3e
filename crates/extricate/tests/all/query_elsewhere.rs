//! Queries from frame to frame, and in scenes other than the learned one.

use std::ops::ControlFlow;

use extricate::geometry::Pose;
use extricate::internals::math::Vec3;
use extricate::internals::query::prepared::Prepared;
use extricate::internals::query::{QueryScratch, Stored, query};
use extricate::{
    Answer, CheckScratch, Config, Effort, Label, MetricKind, QueryOptions, Scene, Solver, Stop, StreamOptions,
    Termination, builtin,
};

use crate::baselines::{
    ALONE_TO_STREAM_CHECKS_RATIO, CHANGED_SCENE_AS_NEAR_ANSWERS, EXITS_STREAM_FARTHER_SHARE,
    EXITS_STREAM_SOLVED_SAMPLES, FIRST_FREE_SAMPLE_RANK, FIRST_WITNESS_CHECKS, FREE_BOX_STREAM_AS_NEAR_PERCENT,
    HAND_EXITS_STREAM_CHECKS_PERCENT, HYSTERESIS_DEPTH_RATIO, HYSTERESIS_QUERIES, HYSTERESIS_TURNS_RATIO,
    MOVING_OBSTACLE_AS_NEAR_SHARE, PLANAR_ARM_STREAM_AS_NEAR_PERCENT, SHELF_ARM_EXITS_STREAM_CHECKS_PERCENT,
    STREAM_COLLIDING_FRAMES, STREAM_SETTLED_PLACES,
};
use crate::memory::{chain, collision, learned, scene};
use crate::query::{ask, colliding};
use crate::query_changed::{obstacle, with_another};

/// Returns frames along the way from each colliding configuration to the next.
fn frames(model: &Solver, targets: usize, between: usize) -> Vec<Config> {
    let space = model.scene().space();
    let targets = colliding(model, targets);
    let mut q = vec![0.0; space.nq()];
    let pairs = targets.windows(2);
    let all = pairs.flat_map(|pair| (0..between).map(move |i| (pair, i as f64 / between as f64)));
    all.map(|(pair, t)| {
        space.interpolate(&pair[0], &pair[1], t, &mut q);
        space.config(&q).unwrap()
    })
    .collect()
}

#[test]
fn a_stream_is_cheaper_and_notices_nearer_ways_out() {
    for (name, metric, share) in [
        ("planar-arm", MetricKind::Joint, PLANAR_ARM_STREAM_AS_NEAR_PERCENT),
        ("free-box", MetricKind::ObjectNorm, FREE_BOX_STREAM_AS_NEAR_PERCENT),
    ] {
        let scene = builtin::scene(name).unwrap().with_metric(metric);
        // A gap of 0 lets no proved bound end either search.
        let model = learned(scene, 6_000, 7).options(QueryOptions::default().gap(0.0)).unwrap();
        let mut stream = model.stream(StreamOptions::default()).unwrap();
        let mut check = CheckScratch::default();
        let (mut spent, mut alone, mut asked, mut as_near, mut settled) = (0, 0, 0, 0, 0);
        for (i, q) in frames(&model, 4, 60).iter().enumerate() {
            let answer = stream.query(q).unwrap();
            let single = model.query(q).unwrap();
            assert_eq!(answer.depth == 0.0, single.depth == 0.0);
            assert_eq!(model.checker().label(&answer.witness, &mut check), Label::Free, "{name}, frame {i}");
            assert!(answer.verified && answer.lower_bound <= answer.depth);
            if single.depth == 0.0 {
                continue;
            }
            asked += 1;
            (spent, alone) = (spent + answer.checks, alone + single.checks);
            as_near += usize::from(answer.depth <= 1.01 * single.depth);
            if i % 30 == 29 {
                // While the query stands still, every start is tried within four frames.
                let last = (0..4).map(|_| stream.query(q).unwrap()).last().unwrap();
                settled += usize::from(last.depth <= 1.01 * single.depth);
            }
        }
        let is_cheaper = alone as f64 > ALONE_TO_STREAM_CHECKS_RATIO * spent as f64;
        assert!(
            asked > STREAM_COLLIDING_FRAMES && is_cheaper,
            "{name}: {spent} checks in a stream, {alone} alone, {asked} frames"
        );
        assert!(as_near * 100 >= asked * share, "{name}: {as_near} of {asked} frames");
        assert!(settled >= STREAM_SETTLED_PLACES, "{name}: {settled} of up to 6");
    }
}

/// Once the exit of the last frame is known, the contact planes of most solved samples prune them;
/// single queries in narrow places are about as cheap. (Since single queries of the arm begin with
/// separating directions, they take two thirds of the checks, and frames as many as before: hence
/// 40, not 30.)
#[test]
fn a_stream_of_a_model_with_exits_is_cheaper_and_as_near() {
    for (name, labels, share) in [
        ("shelf-arm", 250_000, SHELF_ARM_EXITS_STREAM_CHECKS_PERCENT),
        ("hand", 200_000, HAND_EXITS_STREAM_CHECKS_PERCENT),
    ] {
        let model = learned(builtin::scene(name).unwrap(), labels, 7);
        let solved = model.model().unwrap().boundary().solved();
        assert!(solved > EXITS_STREAM_SOLVED_SAMPLES, "{name}: {solved}");
        let mut stream = model.stream(StreamOptions::default()).unwrap();
        let (mut spent, mut alone, mut asked, mut farther) = (0, 0, 0, 0);
        for q in frames(&model, 6, 100) {
            let (answer, single) = (stream.query(&q).unwrap(), model.query(&q).unwrap());
            assert!(answer.verified && answer.lower_bound <= answer.depth);
            asked += usize::from(single.depth > 0.0);
            farther += usize::from(answer.depth > 1.01 * single.depth);
            (spent, alone) = (spent + answer.checks, alone + single.checks);
        }
        println!("{name}: {spent} checks in a stream, {alone} alone, {farther} of {asked} frames farther");
        let are_near = farther as f64 <= EXITS_STREAM_FARTHER_SHARE * asked as f64;
        assert!(100 * spent < share * alone && are_near, "{name}: {spent} {alone}, {farther} of {asked}");
    }
}

/// An obstacle moves from frame to frame while the configuration stands still.
#[test]
fn a_stream_goes_on_while_obstacles_move() {
    let model = learned(builtin::scene("planar-arm").unwrap(), 6_000, 7);
    let mut check = CheckScratch::default();
    let (mut as_near, mut asked) = (0, 0);
    for q in colliding(&model, 6) {
        let mut stream = model.stream(StreamOptions::default()).unwrap();
        for frame in 0..12 {
            let scene = moved("planar-arm", [0.0, 0.004 * f64::from(frame), 0.0]);
            let changed = model.with_scene(scene).unwrap();
            let answer = stream.query_in(&changed, &q).unwrap().expect("something is free");
            assert!(answer.verified && answer.lower_bound <= answer.depth);
            assert_eq!(changed.checker().label(&answer.witness, &mut check), Label::Free);
            let single = changed.query(&q).expect("something is free");
            asked += 1;
            as_near += usize::from(answer.depth <= 1.05 * single.depth);
        }
    }
    assert!(as_near as f64 >= MOVING_OBSTACLE_AS_NEAR_SHARE * f64::from(asked), "{as_near} of {asked}");
}

#[test]
fn hysteresis_keeps_to_a_way_out_within_its_share() {
    let model = learned(builtin::scene("planar-arm").unwrap(), 6_000, 7);
    let space = model.scene().space();
    let (mut free, mut held, mut asked) = (0, 0, 0);
    for q in colliding(&model, 60) {
        let two = ask(&model, &q, &QueryOptions::default().exits(2));
        if two.exits.len() < 2 || two.exits[1].depth > 1.1 * two.depth {
            continue;
        }
        asked += 1;
        // Frames alternate between two exits that are about as near.
        let frame = |i: usize| {
            let mut at = q.to_vec();
            space.interpolate(&q, &two.exits[i % 2].witness, 0.15, &mut at);
            space.config(&at).unwrap()
        };
        let turns = |hysteresis: f64| {
            let mut stream = model.stream(StreamOptions::default().hysteresis(hysteresis)).unwrap();
            let answers: Vec<Answer> = (0..12).map(|i| stream.query(&frame(i)).unwrap()).collect();
            let turned = |pair: &[Answer]| {
                let cosine: f64 = pair[0].gradient.iter().zip(&pair[1].gradient).map(|(a, b)| a * b).sum();
                pair.iter().all(|a| a.depth > 0.0) && cosine < 0.5
            };
            (answers.windows(2).filter(|pair| turned(pair)).count(), answers)
        };
        let (turned, nearest) = turns(0.0);
        free += turned;
        let (turned, kept) = turns(0.4);
        held += turned;
        for (kept, nearest) in kept.iter().zip(&nearest) {
            let most = HYSTERESIS_DEPTH_RATIO * nearest.depth / 0.6;
            assert!(kept.verified && kept.depth <= most, "{} {}", kept.depth, nearest.depth);
        }
    }
    let are_fewer = HYSTERESIS_TURNS_RATIO * held < free;
    assert!(asked >= HYSTERESIS_QUERIES && are_fewer, "{held} turns with hysteresis, {free} without, {asked} places");
}

/// Returns the built-in scene with its last obstacle shifted by `by`.
fn moved(name: &str, by: [f64; 3]) -> Scene {
    let scene = builtin::scene(name).unwrap();
    let obstacle = obstacle(&scene);
    let pose = Pose::translation(Vec3::from(by)).then(&obstacle.parts[0].pose_frame_part);
    scene.moved([(obstacle.name.as_str(), pose)]).unwrap()
}

#[test]
fn answers_in_a_changed_scene_are_verified_there() {
    for (name, by) in [("planar-arm", [0.05, 0.1, 0.0]), ("shelf-arm", [0.0, 0.05, 0.1])] {
        let model = learned(builtin::scene(name).unwrap(), 6_000, 7);
        let changed = model.with_scene(moved(name, by)).unwrap();
        let anew = learned(moved(name, by), 6_000, 7);
        let queries = colliding(&anew, 25);
        let mut check = CheckScratch::default();
        let mut as_near = 0;
        let mut single = Vec::new();
        for q in &queries {
            let answer = changed.query(q).expect("something is free");
            assert!(answer.verified && answer.depth > 0.0 && answer.lower_bound <= answer.depth);
            assert_eq!(changed.checker().label(&answer.witness, &mut check), Label::Free);
            let best = anew.query(q).unwrap().depth;
            as_near += usize::from(answer.depth <= 1.05 * best);
            let nearest = ask(&changed, q, &QueryOptions::default().effort(Effort::Nearest));
            assert!(nearest.verified && changed.checker().label(&nearest.witness, &mut check) == Label::Free);
            // Both end in the same exit, to the digits that last descents reach.
            assert!(nearest.depth >= (1.0 - 1e-4) * answer.depth, "{} {}", nearest.depth, answer.depth);
            single.push(Some(answer));
        }
        assert!(as_near >= CHANGED_SCENE_AS_NEAR_ANSWERS, "{name}: {as_near} of 25 as near as in a model learned anew");
        let mut batch = Vec::new();
        changed.batch_each(queries, 2, &mut |answered| {
            batch.push(answered.answer);
            ControlFlow::Continue(())
        });
        assert!(batch == single, "{name}");
    }
}

/// The next scene may use the number of a pair for another one, with bodies of more pieces.
#[test]
fn one_scratch_serves_scene_after_scene() {
    let model = learned(builtin::scene("shelf-arm").unwrap(), 6_000, 7);
    let more = with_another(builtin::scene("shelf-arm").unwrap(), [0.0, 0.3, 0.0]);
    let prepared = Prepared::new(builtin::scene("shelf-arm").unwrap());
    let scenes = [moved("shelf-arm", [0.0, 0.05, 0.1]), more].map(|scene| prepared.with_scene(scene));
    let samples = model.model().unwrap().boundary();
    let mut scratch = QueryScratch::default();
    for q in colliding(&model, 20) {
        for scene in &scenes {
            let context = scene.with(Some(Stored { samples, holding: Some(&[]) }));
            let options = QueryOptions::default().exits(2);
            let used = query(&context, &q, &options, &mut scratch);
            assert_eq!(used, query(&context, &q, &options, &mut QueryScratch::default()));
        }
    }
}

/// Returns how many of the stored samples have to be checked in order of distance until one is
/// free, and the distance to that one.
fn nearest_free_sample(model: &Solver, changed: &Solver, q: &Config) -> (usize, f64) {
    let samples = model.model().unwrap().boundary().configs().chunks_exact(model.scene().space().nq());
    let mut ranked: Vec<_> = samples.map(|sample| (model.metric().distance(q, sample), sample)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut check = CheckScratch::default();
    let rank = ranked.iter().position(|(_, sample)| changed.checker().label(sample, &mut check) == Label::Free);
    let rank = rank.expect("a free sample");
    (rank + 1, ranked[rank].0)
}

#[test]
fn a_budget_in_a_changed_scene_ends_all_but_the_search_for_a_first_witness() {
    let model = learned(builtin::scene("planar-arm").unwrap(), 6_000, 7);
    // Most samples are nearer than this clearance to something.
    let wider = builtin::scene("planar-arm").unwrap().with_clearance(1e-3).unwrap();
    let changed = model.with_scene(wider).unwrap();
    // This many samples are checked in order of distance; the first exit takes the other checks of
    // a first witness.
    let in_order = 16;
    let (mut longest, mut nearer) = (0, 0);
    for q in colliding(&model, 40) {
        let full = changed.query(&q).expect("something is free");
        let (rank, distance) = nearest_free_sample(&model, &changed, &q);
        longest = longest.max(rank);
        let first = FIRST_WITNESS_CHECKS;
        let nothing = [Termination::after_checks(0), Termination::after_seconds(f64::MIN_POSITIVE)];
        for (termination, effort) in nothing.into_iter().zip([Effort::Refined, Effort::Exhaustive]) {
            let answer = ask(&changed, &q, &QueryOptions::default().termination(termination).effort(effort));
            assert!(answer.verified);
            if rank <= in_order {
                assert!(answer.depth < distance + 1e-9, "{} {distance}", answer.depth);
            } else {
                nearer += usize::from(answer.depth < distance);
            }
            assert!(answer.lower_bound > 0.0 && answer.lower_bound <= full.depth);
            // These are the query itself, the samples or descents, and contacts at the witness.
            assert!(answer.checks <= first + 1, "{} checks, {rank} samples", answer.checks);
        }
        let mut last = f64::INFINITY;
        for checks in [0, 3, 10, 30, 100, 300] {
            let termination = Termination::after_checks(checks);
            let answer = ask(&changed, &q, &QueryOptions::default().termination(termination));
            let depths = [last, answer.depth, full.depth];
            assert!(answer.verified && depths.is_sorted_by(|a, b| a >= b), "{checks} checks: {depths:?} at {q:?}");
            assert!(answer.checks <= checks.max(first) + 3, "{} of {checks}, {rank} samples", answer.checks);
            last = answer.depth;
        }
        let stopped = QueryOptions::default().termination(Termination::default().stop(Stop::when(|| true)));
        let stopped = changed.clone().options(stopped).unwrap();
        assert!(stopped.query(&q).is_none(), "only a stop ends the search");
    }
    let are_taken = longest >= FIRST_FREE_SAMPLE_RANK && nearer > 0;
    assert!(are_taken, "at most {longest} samples until one is free, {nearer} times one was nearer");
}

#[test]
fn a_scene_in_which_nothing_is_free_has_no_answer_and_one_of_other_joints_is_refused() {
    let model = learned(builtin::scene("planar-arm").unwrap(), 4_000, 7);
    let walled = builtin::scene("planar-arm").unwrap().with_clearance(100.0).unwrap();
    let changed = model.with_scene(walled).unwrap();
    assert!(changed.query(&colliding(&model, 1)[0]).is_none());

    let refused = |model: &Solver, scene: Scene| model.with_scene(scene).unwrap_err().to_string();
    assert!(refused(&model, builtin::scene("shelf-arm").unwrap()).contains("joint"));
    let other = builtin::scene("planar-arm").unwrap().with_metric(MetricKind::ObjectNorm);
    assert!(refused(&model, other).contains("metric"));
    // A link is mounted elsewhere on its joint.
    let arm = |x: f64| {
        let link = collision([x, 0.0, 0.0], [0.0; 3], "<box size=\"0.4 0.1 0.1\"/>");
        let urdf = chain(&[("revolute", [0.0; 3], [0.0, 0.0, 1.0], -3.0, 3.0, &link)]);
        let toml = "metric = { kind = \"object-norm\" }\n[[robot]]\nurdf = \"r.urdf\"\n\
                    [[obstacle]]\nname = \"wall\"\nshape = { box = [0.2, 2, 2] }\npose = { xyz = [0.4, 0, 0] }\n";
        scene(toml, &[("r.urdf", urdf)])
    };
    let message = refused(&learned(arm(0.2), 2_000, 7), arm(0.21));
    assert!(message.contains("moving bodies"), "{message}");
}

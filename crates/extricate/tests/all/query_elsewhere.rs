//! Queries from frame to frame, and in scenes that are not the one that was learned.

use std::ops::ControlFlow;

use extricate::internals::scene::BodyPair;
use extricate::{
    Answer, ChangedScene, CheckScratch, Config, Effort, Label, MetricKind, Model, QueryOptions, QueryScratch, Scene,
    Stop, Stream, StreamOptions, Termination, builtin,
};

use crate::memory::learn;
use crate::query::colliding;

/// Frames along the way from each colliding configuration to the next.
fn frames(model: &Model, targets: usize, between: usize) -> Vec<Config> {
    let space = &model.scene().space;
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
    for (name, metric, share) in [("planar-arm", MetricKind::Joint, 85), ("free-box", MetricKind::ObjectNorm, 70)] {
        let mut scene = builtin::scene(name).unwrap();
        scene.metric = metric;
        let model = learn(scene, 6_000, 7);
        // Nothing but what is found ends either.
        let options = QueryOptions { gap: Some(0.0), ..QueryOptions::default() };
        let mut stream = Stream::new(StreamOptions { query: options.clone(), ..StreamOptions::default() });
        let (mut scratch, mut check) = (QueryScratch::default(), CheckScratch::default());
        let (mut spent, mut alone, mut asked, mut as_near, mut settled) = (0, 0, 0, 0, 0);
        for (i, q) in frames(&model, 4, 60).iter().enumerate() {
            let answer = model.view().query_next(q, &mut stream).unwrap();
            let single = model.view().query_with(q, &options, &mut scratch).unwrap();
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
                // Standing still: every start is looked at within four frames.
                let last = (0..4).map(|_| model.view().query_next(q, &mut stream).unwrap()).last().unwrap();
                settled += usize::from(last.depth <= 1.01 * single.depth);
            }
        }
        assert!(
            asked > 60 && 19 * spent < 10 * alone,
            "{name}: {spent} checks in a stream, {alone} alone, {asked} frames"
        );
        assert!(as_near * 100 >= asked * share, "{name}: {as_near} of {asked} frames");
        assert!(settled >= 2, "{name}: {settled} of up to 6");
    }
}

/// With exits, of which most are given up by their planes once the exit of the last frame is known;
/// narrow queries are about as cheap by themselves. (Queries of the arm alone take two thirds of
/// the checks that they took before they began with separating directions, frames as many: hence
/// 40, not 30.)
#[test]
fn a_stream_of_a_model_with_exits_is_cheaper_and_as_near() {
    for (name, labels, share) in [("shelf-arm", 250_000, 40), ("hand", 200_000, 110)] {
        let model = learn(builtin::scene(name).unwrap(), labels, 7);
        // As many as queries start from alone.
        assert!(model.boundary().solved() > 1600, "{name}: {}", model.boundary().solved());
        let (mut stream, mut scratch) = (Stream::new(StreamOptions::default()), QueryScratch::default());
        let (mut spent, mut alone, mut asked, mut farther) = (0, 0, 0, 0);
        for q in frames(&model, 6, 100) {
            let (answer, single) = (
                model.view().query_next(&q, &mut stream).unwrap(),
                model.view().query_with(&q, &QueryOptions::default(), &mut scratch).unwrap(),
            );
            assert!(answer.verified && answer.lower_bound <= answer.depth);
            asked += usize::from(single.depth > 0.0);
            farther += usize::from(answer.depth > 1.01 * single.depth);
            (spent, alone) = (spent + answer.checks, alone + single.checks);
        }
        println!("{name}: {spent} checks in a stream, {alone} alone, {farther} of {asked} frames farther");
        assert!(100 * spent < share * alone && 20 * farther <= asked, "{name}: {spent} {alone}, {farther} of {asked}");
    }
}

/// An obstacle that moves from frame to frame, while the configuration stands still.
#[test]
fn a_stream_goes_on_while_obstacles_move() {
    let model = learn(builtin::scene("planar-arm").unwrap(), 6_000, 7);
    let (mut scratch, mut check) = (QueryScratch::default(), CheckScratch::default());
    let (mut as_near, mut asked) = (0, 0);
    for q in colliding(&model, 6) {
        let mut stream = Stream::new(StreamOptions::default());
        for frame in 0..12 {
            let scene = moved("planar-arm", [0.0, 0.004 * f64::from(frame), 0.0]);
            let scene = ChangedScene::new(model.world(), scene).unwrap();
            let answer = model.in_scene(&scene).query_next(&q, &mut stream).expect("something is free");
            assert!(answer.verified && answer.lower_bound <= answer.depth);
            assert_eq!(scene.checker().label(&answer.witness, &mut check), Label::Free);
            let single = model
                .in_scene(&scene)
                .query_with(&q, &QueryOptions::default(), &mut scratch)
                .expect("something is free");
            asked += 1;
            as_near += usize::from(answer.depth <= 1.05 * single.depth);
        }
    }
    assert!(as_near * 10 >= asked * 9, "{as_near} of {asked}");
}

#[test]
fn hysteresis_keeps_to_a_way_out_within_its_share() {
    let model = learn(builtin::scene("planar-arm").unwrap(), 6_000, 7);
    let space = &model.scene().space;
    let mut scratch = QueryScratch::default();
    let (mut free, mut held, mut asked) = (0, 0, 0);
    for q in colliding(&model, 60) {
        let two =
            model.view().query_with(&q, &QueryOptions { exits: 2, ..QueryOptions::default() }, &mut scratch).unwrap();
        if two.exits.len() < 2 || two.exits[1].depth > 1.1 * two.depth {
            continue;
        }
        asked += 1;
        // To and fro between two exits that are about as near.
        let frame = |i: usize| {
            let mut at = q.to_vec();
            space.interpolate(&q, &two.exits[i % 2].witness, 0.15, &mut at);
            space.config(&at).unwrap()
        };
        let turns = |hysteresis: f64| {
            let mut stream = Stream::new(StreamOptions { hysteresis, ..StreamOptions::default() });
            let answers: Vec<Answer> =
                (0..12).map(|i| model.view().query_next(&frame(i), &mut stream).unwrap()).collect();
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
            assert!(kept.verified && kept.depth <= 1.02 * nearest.depth / 0.6, "{} {}", kept.depth, nearest.depth);
        }
    }
    assert!(asked >= 2 && 3 * held < free, "{held} turns with hysteresis, {free} without, {asked} places");
}

/// The built-in scene with its last obstacle elsewhere.
fn moved(name: &str, by: [f64; 3]) -> Scene {
    let mut scene = builtin::scene(name).unwrap();
    let obstacle = scene.bodies.iter_mut().rev().find(|body| body.robot.is_none()).expect("an obstacle");
    obstacle.parts.iter_mut().for_each(|part| part.pose_frame_part.translation += extricate::geometry::Vec3::from(by));
    scene
}

#[test]
fn answers_in_a_changed_scene_are_verified_there() {
    for (name, by) in [("planar-arm", [0.05, 0.1, 0.0]), ("shelf-arm", [0.0, 0.05, 0.1])] {
        let model = learn(builtin::scene(name).unwrap(), 6_000, 7);
        let changed = ChangedScene::new(model.world(), moved(name, by)).unwrap();
        let anew = learn(moved(name, by), 6_000, 7);
        let queries = colliding(&anew, 25);
        let (mut scratch, mut check) = (QueryScratch::default(), CheckScratch::default());
        let options = QueryOptions::default();
        let mut as_near = 0;
        let mut single = Vec::new();
        for q in &queries {
            let answer = model.in_scene(&changed).query_with(q, &options, &mut scratch).expect("something is free");
            assert!(answer.verified && answer.depth > 0.0 && answer.lower_bound <= answer.depth);
            assert_eq!(changed.checker().label(&answer.witness, &mut check), Label::Free);
            let best = anew.view().query_with(q, &options, &mut scratch).unwrap().depth;
            as_near += usize::from(answer.depth <= 1.05 * best);
            let nearest = QueryOptions { effort: Effort::Nearest, ..QueryOptions::default() };
            let nearest = model.in_scene(&changed).query_with(q, &nearest, &mut scratch).expect("something is free");
            assert!(nearest.verified && changed.checker().label(&nearest.witness, &mut check) == Label::Free);
            // Both end in the same exit, to the digits that last descents go to.
            assert!(nearest.depth >= (1.0 - 1e-4) * answer.depth, "{} {}", nearest.depth, answer.depth);
            single.push(Some(answer));
        }
        assert!(as_near >= 22, "{name}: {as_near} of 25 as near as in a model learned anew");
        let mut batch = Vec::new();
        model.in_scene(&changed).query_batch(queries, &options, 2, &mut |answered| {
            batch.push(answered.answer);
            ControlFlow::Continue(())
        });
        assert!(batch == single, "{name}");
    }
}

/// A pair of one scene may have the number of another one in the next, of bodies of more pieces.
#[test]
fn one_scratch_serves_scene_after_scene() {
    let model = learn(builtin::scene("shelf-arm").unwrap(), 6_000, 7);
    let mut more = moved("shelf-arm", [0.0; 3]);
    let (added, obstacle) = (more.bodies.len(), more.bodies.len() - 1);
    more.bodies.push(more.bodies[obstacle].clone());
    more.bodies[added].parts.iter_mut().for_each(|part| part.pose_frame_part.translation.y += 0.3);
    let beside = more.pairs.iter().filter(|pair| pair.second == obstacle);
    let pairs: Vec<_> = beside.map(|pair| BodyPair { second: added, ..*pair }).collect();
    more.pairs.extend(pairs);
    more.pairs.sort();
    let scenes = [moved("shelf-arm", [0.0, 0.05, 0.1]), more].map(|s| ChangedScene::new(model.world(), s).unwrap());
    let mut scratch = QueryScratch::default();
    for q in colliding(&model, 20) {
        for scene in &scenes {
            let options = QueryOptions { exits: 2, ..QueryOptions::default() };
            let used = model.in_scene(scene).query_with(&q, &options, &mut scratch);
            assert_eq!(used, model.in_scene(scene).query_with(&q, &options, &mut QueryScratch::default()));
        }
    }
}

/// How many of the stored samples have to be checked in order of distance until one is free, and
/// the distance to that one.
fn nearest_free_sample(model: &Model, changed: &ChangedScene, q: &Config) -> (usize, f64) {
    let samples = model.boundary().configs().chunks_exact(model.scene().space.nq());
    let mut ranked: Vec<_> = samples.map(|sample| (model.metric().distance(q, sample), sample)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut check = CheckScratch::default();
    let rank = ranked.iter().position(|(_, sample)| changed.checker().label(sample, &mut check) == Label::Free);
    let rank = rank.expect("a free sample");
    (rank + 1, ranked[rank].0)
}

#[test]
fn a_budget_in_a_changed_scene_ends_all_but_the_search_for_a_first_witness() {
    let model = learn(builtin::scene("planar-arm").unwrap(), 6_000, 7);
    // Most samples lie nearer than that to something.
    let mut wider = builtin::scene("planar-arm").unwrap();
    wider.clearance = 1e-3;
    let changed = ChangedScene::new(model.world(), wider).unwrap();
    let mut scratch = QueryScratch::default();
    // So many are looked at in order of distance; the first exit takes the rest.
    let (in_order, most) = (16, 120);
    let (mut longest, mut nearer) = (0, 0);
    for q in colliding(&model, 40) {
        let mut ask = |options: &QueryOptions| model.in_scene(&changed).query_with(&q, options, &mut scratch);
        let full = ask(&QueryOptions::default()).expect("something is free");
        let (rank, distance) = nearest_free_sample(&model, &changed, &q);
        longest = longest.max(rank);
        let first = most;
        let nothing = [(Some(0), None), (None, Some(0.0))].map(|(checks, seconds)| Termination {
            max_checks: checks,
            max_seconds: seconds,
            stop: None,
        });
        for (termination, effort) in nothing.into_iter().zip([Effort::Refined, Effort::Exhaustive]) {
            let answer =
                ask(&QueryOptions { termination, effort, ..QueryOptions::default() }).expect("something is free");
            assert!(answer.verified);
            if rank <= in_order {
                assert!(answer.depth < distance + 1e-9, "{} {distance}", answer.depth);
            } else {
                nearer += usize::from(answer.depth < distance);
            }
            assert!(answer.lower_bound > 0.0 && answer.lower_bound <= full.depth);
            // The query itself, the samples or descents, and contacts at the witness.
            assert!(answer.checks <= first + 1, "{} checks, {rank} samples", answer.checks);
        }
        let mut last = f64::INFINITY;
        for checks in [0, 3, 10, 30, 100, 300] {
            let termination = Termination::after_checks(checks);
            let answer = ask(&QueryOptions { termination, ..QueryOptions::default() }).expect("something is free");
            let depths = [last, answer.depth, full.depth];
            assert!(answer.verified && depths.is_sorted_by(|a, b| a >= b), "{checks} checks: {depths:?} at {q:?}");
            assert!(answer.checks <= checks.max(first) + 3, "{} of {checks}, {rank} samples", answer.checks);
            last = answer.depth;
        }
        let stopped = QueryOptions {
            termination: Termination { stop: Some(Stop::when(|| true)), ..Termination::default() },
            ..QueryOptions::default()
        };
        assert!(ask(&stopped).is_none(), "only a stop ends the search");
    }
    assert!(longest >= 50 && nearer > 0, "at most {longest} samples until one is free, {nearer} times one was nearer");
}

#[test]
fn a_scene_in_which_nothing_is_free_has_no_answer_and_one_of_other_joints_is_refused() {
    let model = learn(builtin::scene("planar-arm").unwrap(), 4_000, 7);
    let mut walled = builtin::scene("planar-arm").unwrap();
    walled.clearance = 100.0;
    let changed = ChangedScene::new(model.world(), walled).unwrap();
    let q = &colliding(&model, 1)[0];
    assert!(model.in_scene(&changed).query_with(q, &QueryOptions::default(), &mut QueryScratch::default()).is_none());

    let refused = |scene: Scene| ChangedScene::new(model.world(), scene).err().map(|e| e.to_string());
    assert!(refused(builtin::scene("shelf-arm").unwrap()).unwrap().contains("joint"));
    let mut other = builtin::scene("planar-arm").unwrap();
    other.metric = MetricKind::ObjectNorm;
    assert!(refused(other.clone()).unwrap().contains("metric"));
    let under = learn(other.clone(), 2_000, 7);
    let link = other.bodies.iter_mut().find(|body| body.frame != 0).expect("a link");
    link.parts[0].pose_frame_part.translation.x += 0.01;
    let message = ChangedScene::new(under.world(), other).err().map(|e| e.to_string()).unwrap();
    assert!(message.contains("moving bodies"), "{message}");
}

//! Queries with a clearance of their own, with locked joints, and toward a goal.

use extricate::internals::cspace::sampling::Halton;
use extricate::{
    Answer, CheckScratch, Config, Effort, Label, MetricKind, QueryOptions, Scene, Solver, StreamOptions, Toward,
    builtin,
};

use crate::baselines::{
    CLEARANCE_AS_NEAR_SHARE, FREE_RADIUS_COLLIDING_CONFIGS, GOAL_OTHER_EXIT_SHARE, LOCKED_FOUND_ANSWERS,
    LOCKED_NONE_ANSWERS, LOCKED_STREAM_COLLIDING_FRAMES, WEIGHTED_DEPTH_RATIO, WEIGHTED_TURNED_LESS_EXITS,
    WEIGHTED_TURNED_MORE_EXITS,
};
use crate::memory;
use crate::query::ask;

fn colliding(world: &Solver, count: usize) -> Vec<Config> {
    let (space, mut scratch) = (world.scene().space(), CheckScratch::default());
    let (halton, mut q) = (Halton::new(space.nv(), 5), vec![0.0; space.nq()]);
    let config = |index| {
        halton.config(space, index, &mut q);
        space.config(&q).unwrap()
    };
    let collides = |q: &Config| world.checker().label(q, &mut scratch) == Label::Colliding;
    (0..).map(config).filter(collides).take(count).collect()
}

fn learned(scene: &Scene) -> Solver {
    memory::learned(scene.clone(), 20_000, 0)
}

#[test]
fn a_clearance_of_a_query_is_that_of_a_scene() {
    for name in ["planar-arm", "shelf-arm"] {
        let scene = builtin::scene(name).unwrap();
        let (world, model) = (Solver::new(scene.clone()), learned(&scene));
        let wider = Solver::new(scene.with_clearance(0.02).unwrap());
        let options = QueryOptions::default().clearance(0.02);
        let (mut near, all) = ([0; 2], 150);
        for q in colliding(&wider, all) {
            let expected = wider.query(&q).unwrap();
            let of_world = ask(&world, &q, &options);
            assert_eq!(of_world, expected);
            let of_model = ask(&model, &q, &options);
            let mut check = CheckScratch::default();
            for answer in [&of_world, &of_model] {
                assert_eq!((answer.clearance, answer.verified), (0.02, true));
                assert_eq!(wider.checker().label(&answer.witness, &mut check), Label::Free);
                assert!(answer.lower_bound <= answer.depth);
            }
            near[0] += usize::from(of_model.depth <= 1.01 * expected.depth);
            near[1] += usize::from(expected.depth <= 1.01 * of_model.depth);
        }
        println!("{name}: {near:?} of {all}");
        let least = CLEARANCE_AS_NEAR_SHARE * all as f64;
        assert!(near.iter().all(|near| *near as f64 >= least), "{name}: {near:?}");
    }
}

#[test]
fn a_clearance_that_nothing_keeps_is_given_up() {
    let world = Solver::new(builtin::scene("shelf-arm").unwrap());
    // This is wider than links that are side by side, so no configuration keeps it.
    let options = QueryOptions::default().clearance(5.0);
    for q in colliding(&world, 3) {
        let answer = ask(&world, &q, &options);
        let plain = world.query(&q).unwrap();
        assert_eq!((answer.clearance, answer.depth), (world.scene().clearance(), plain.depth));
    }
}

/// Returns the distance of the nearest free configuration on a grid over unlocked joints.
fn on_a_grid(world: &Solver, q: &Config, locked: &[usize]) -> f64 {
    let (space, cells) = (world.scene().space(), 300);
    let free: Vec<usize> = (0..3).filter(|joint| !locked.contains(joint)).collect();
    let (mut scratch, mut best) = (CheckScratch::default(), f64::INFINITY);
    let place = |k: usize| -std::f64::consts::PI + (k as f64 + 0.5) * std::f64::consts::TAU / cells as f64;
    for at in 0..cells * cells {
        let mut config = q.to_vec();
        config[free[0]] = place(at / cells);
        free.iter().skip(1).for_each(|joint| config[*joint] = place(at % cells));
        space.clamp(&mut config);
        let distance = world.metric().distance(q, &config);
        if distance < best && world.checker().label(&config, &mut scratch) == Label::Free {
            best = distance;
        }
    }
    best
}

#[test]
fn locked_joints_stay_and_the_others_find_the_nearest() {
    let scene = builtin::scene("planar-arm").unwrap();
    let (world, model) = (Solver::new(scene.clone()), learned(&scene));
    let (mut found, mut none) = (0, 0);
    for (k, q) in colliding(&world, 45).iter().enumerate() {
        let locked = [&[0][..], &[1], &[2], &[0, 1], &[0, 2]][k % 5];
        let options = QueryOptions::default().locked(locked.to_vec());
        let answers = [&world, &model].map(|solver| solver.clone().options(options.clone()).unwrap().query(q));
        let best = on_a_grid(&world, q, locked);
        for answer in answers {
            let Some(Answer { depth, witness, verified, lower_bound, .. }) = answer else {
                assert!(best.is_infinite(), "{q:?} {locked:?}: there is one at {best}");
                none += 1;
                continue;
            };
            assert!(verified && locked.iter().all(|joint| witness[*joint] == q[*joint]) && lower_bound <= depth);
            assert_eq!(world.checker().label(&witness, &mut CheckScratch::default()), Label::Free);
            assert!(depth <= best + 1e-9, "{q:?} {locked:?}: {depth}, and one at {best}");
            found += 1;
        }
    }
    println!("{found} found, {none} without any");
    assert!(found > LOCKED_FOUND_ANSWERS && none > LOCKED_NONE_ANSWERS, "{found} {none}");
}

#[test]
fn streams_keep_joints_locked_too() {
    let query = QueryOptions::default().locked(vec![0, 3]);
    let world = Solver::new(builtin::scene("shelf-arm").unwrap()).options(query).unwrap();
    let mut stream = world.stream(StreamOptions::default()).unwrap();
    let mut seen = 0;
    for corner in colliding(&world, 6).windows(2) {
        for k in 0..10 {
            let mut q = corner[0].to_vec();
            world.scene().space().interpolate(&corner[0], &corner[1], f64::from(k) / 200.0, &mut q);
            let q = world.scene().space().config(&q).unwrap();
            let single = world.query(&q);
            let Some(answer) = stream.query(&q) else {
                assert!(single.is_none());
                continue;
            };
            assert!(answer.witness[0] == q[0] && answer.witness[3] == q[3] && answer.verified);
            seen += usize::from(!answer.is_free());
        }
    }
    assert!(seen > LOCKED_STREAM_COLLIDING_FRAMES, "{seen}");
}

#[test]
fn of_exits_that_are_about_as_near_the_one_toward_the_goal_is_taken() {
    let world = Solver::new(builtin::scene("planar-arm").unwrap());
    let (mut other, mut all) = (0, 0);
    let configs = colliding(&world, 120);
    for (q, goal) in configs.iter().zip(configs.iter().rev()) {
        let several = QueryOptions::default().exits(8);
        let exits = ask(&world, q, &several).exits;
        let toward = Toward::new(goal.clone(), 0.5);
        let answer = ask(&world, q, &several.toward(toward));
        let from_goal = |witness: &[f64]| world.metric().distance(goal, witness);
        let near = exits.iter().filter(|exit| exit.depth <= 1.5 * exits[0].depth);
        let best = near.map(|exit| from_goal(&exit.witness)).fold(f64::INFINITY, f64::min);
        assert!(answer.verified && answer.depth <= 1.5 * exits[0].depth + 1e-12);
        assert!(from_goal(&answer.witness) <= best + 1e-12);
        other += usize::from(answer.witness != exits[0].witness);
        all += 1;
    }
    assert!(other as f64 > GOAL_OTHER_EXIT_SHARE * f64::from(all), "{other} of {all}");
    let refused = QueryOptions::default().effort(Effort::Nearest);
    assert_eq!(ask(&world, &configs[0], &refused).exits, []);
}

#[test]
fn nothing_touches_within_the_free_radius() {
    for (name, metric) in [
        ("planar-arm", MetricKind::Joint),
        ("shelf-arm", MetricKind::Joint),
        ("hand", MetricKind::MaxDisplacement),
        ("dual-arm", MetricKind::ObjectNorm),
        ("free-box", MetricKind::ObjectNorm),
    ] {
        let world = Solver::new(builtin::scene(name).unwrap().with_metric(metric));
        // Only touching counts here, without clearance.
        let judge = Solver::new(world.scene().with_clearance(0.0).unwrap());
        let space = world.scene().space();
        let mut check = CheckScratch::default();
        let options = QueryOptions::default().free_radius(true).clearance(5e-3).exits(1);
        let (halton, mut touched_beyond) = (Halton::new(space.nv(), 3), 0);
        for q in colliding(&world, 12) {
            let answer = ask(&world, &q, &options);
            let radius = answer.free_radius.unwrap();
            assert!(radius > 0.0, "{name}: {answer:?}");
            let mut far = vec![0.0; space.nq()];
            for index in 0..200 {
                halton.config(space, index, &mut far);
                let reached = world.metric().distance(&answer.witness, &far);
                let mut at = |share: f64| {
                    let mut config = far.clone();
                    space.interpolate(&answer.witness, &far, share.min(1.0), &mut config);
                    (world.metric().distance(&answer.witness, &config), judge.checker().label(&config, &mut check))
                };
                // Distances by bodies are not proportional along a geodesic of the joints.
                let mut share = 0.999 * radius / reached;
                let (distance, label) = loop {
                    let (distance, label) = at(share);
                    if distance <= radius {
                        break (distance, label);
                    }
                    share *= 0.9;
                };
                assert_eq!(label, Label::Free, "{name}: at {distance} of {radius}");
                touched_beyond += usize::from(at(30.0 * share).1 == Label::Colliding);
            }
        }
        let tells = touched_beyond > FREE_RADIUS_COLLIDING_CONFIGS;
        assert!(tells, "{name}: the radius tells nothing: {touched_beyond}");
    }
}

#[test]
fn weights_change_what_is_nearest() {
    let scene = builtin::scene("planar-arm").unwrap();
    let world = Solver::new(scene.clone());
    let name = scene.joints()[0].name.as_str();
    let weighted = world.weighted([(name, [100.0, 100.0])]).unwrap();
    let (mut moved, mut as_before) = (0, 0);
    for q in colliding(&world, 60) {
        let plain = world.query(&q).unwrap();
        let heavy = weighted.query(&q).unwrap();
        // The exit that was nearest is still an exit, at another distance.
        let most = weighted.metric().distance(&q, &plain.witness) * WEIGHTED_DEPTH_RATIO;
        assert!(heavy.verified && heavy.depth <= most);
        let turn = |answer: &Answer| (answer.witness[0] - q[0]).abs();
        moved += usize::from(turn(&heavy) < 0.5 * turn(&plain));
        as_before += usize::from(turn(&heavy) > 2.0 * turn(&plain) + 1e-3);
    }
    let is_weighted = moved > WEIGHTED_TURNED_LESS_EXITS && as_before < WEIGHTED_TURNED_MORE_EXITS;
    assert!(is_weighted, "{moved} {as_before}");
    let refused = scene.weighted([("elbo", [1.0; 2])]).unwrap_err().to_string();
    assert!(refused.contains("metric: weights: got `elbo`, expected one of"), "{refused}");
    let metric = MetricKind::ObjectNorm;
    let refused = scene.with_metric(metric).weighted([(name, [1.0; 2])]).unwrap_err().to_string();
    assert!(refused.contains("only that of the joints"), "{refused}");
}

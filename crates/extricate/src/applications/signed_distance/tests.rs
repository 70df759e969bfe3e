//! Tests signed distances against closed forms, samples within proved balls, and rays.

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::applications::stream::StreamOptions;
use crate::cspace::sampling::uniform;
use crate::scene::assemble::assemble;
use crate::scene::builtin;
use crate::scene::{MetricKind, PairId};

/// A ball of radius 0.1 that moves along three axes within 1 m, among these obstacles.
fn carried_ball(obstacles: &str) -> Solver {
    let axis = |name: &str, [parent, child]: [&str; 2], xyz: &str| {
        format!(
            "<joint name='{name}' type='prismatic'><parent link='{parent}'/><child link='{child}'/><axis xyz='{xyz}'/>\
             <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        )
    };
    let axes = axis("x", ["rail", "cross"], "1 0 0")
        + &axis("y", ["cross", "lift"], "0 1 0")
        + &axis("z", ["lift", "ball"], "0 0 1");
    let urdf = format!(
        "<robot name='carried'><link name='rail'/><link name='cross'/><link name='lift'/><link name='ball'>\
         <collision><geometry><sphere radius='0.1'/></geometry></collision></link>{axes}</robot>"
    );
    let scene = format!("clearance = 0.0001\n[[robot]]\nurdf = \"carried.urdf\"\n{obstacles}");
    Solver::new(assemble(Path::new("carried.toml"), &scene, &mut |_| Ok(urdf.as_bytes().to_vec())).unwrap())
}

fn distance(solver: &Solver, q: &[f64]) -> SignedDistance {
    let q = solver.scene().space.config(q).unwrap();
    solver.signed_distance(&q, None).unwrap().expect("something is free")
}

#[test]
fn closed_forms_hold_on_both_sides() {
    // One ball is all that moves, so it moves as far in every metric.
    for kind in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
        closed_forms_hold(kind);
    }
}

fn closed_forms_hold(kind: MetricKind) {
    let ball = carried_ball("[[obstacle]]\nname = \"round\"\nshape = { sphere = 0.3 }\npose = { xyz = [0, 0, 0] }\n");
    let block =
        carried_ball("[[obstacle]]\nname = \"box\"\nshape = { box = [0.6, 0.8, 0.4] }\npose = { xyz = [0, 0, 0] }\n");
    let [ball, block] = [ball, block].map(|solver| Solver::new(solver.scene().with_metric(kind)));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut inside, reach) = (0, 0.1 + 1e-4);
    for _ in 0..100 {
        let q: [f64; 3] = std::array::from_fn(|_| rng.random::<f64>() * 1.6 - 0.8);
        let to_ball = q.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.3 - reach;
        let over: Vec<f64> = q.iter().zip([0.3, 0.4, 0.2]).map(|(x, half)| x.abs() - half).collect();
        let outer = over.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt();
        let to_box = outer + over.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0) - reach;
        for (solver, expected) in [(&ball, to_ball), (&block, to_box)] {
            let found = distance(solver, &q);
            assert!((found.distance - expected).abs() < 1e-3, "{q:?}: {found:?}, expected {expected}");
            assert!(found.bound.abs() <= found.distance.abs() && found.bound * found.distance >= 0.0, "{found:?}");
            inside += usize::from(expected < 0.0);
            if found.distance.abs() > 0.01 {
                let slope = found.gradient.iter().map(|x| x * x).sum::<f64>().sqrt();
                assert!((slope - 1.0).abs() < 1e-5, "{kind:?} {found:?}");
            }
        }
    }
    assert!(inside > 10 && inside < 100, "{inside}");
}

/// Within the proved bound nothing changes sides, rays meet nothing much nearer than the distance,
/// and the gradient points away from what is near.
#[test]
fn bounds_hold_and_little_is_nearer() {
    let (mut rays, mut nearer, mut compared) = (0, 0, 0);
    for (name, kind) in [
        ("planar-arm", MetricKind::Joint),
        ("shelf-arm", MetricKind::Joint),
        ("dual-arm", MetricKind::Joint),
        ("free-box", MetricKind::ObjectNorm),
        ("hand", MetricKind::MaxDisplacement),
    ] {
        let scene = builtin::scene(name).unwrap();
        let solver = Solver::new(scene.with_metric(kind));
        let (space, metric) = (&solver.scene().space, solver.metric());
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut q, mut other, mut at) = (vec![0.0; space.nq()], vec![0.0; space.nq()], vec![0.0; space.nq()]);
        let mut count = 0;
        while count < 20 {
            uniform(space, &mut rng, &mut q);
            if !solver.check(&q) {
                continue;
            }
            count += 1;
            let found = distance(&solver, &q);
            assert!(found.bound > 0.0 && found.bound <= found.distance, "{name}: {found:?}");
            if let Some(witness) = &found.witness {
                assert!(solver.check(witness), "{name}: {found:?}");
                let beyond = metric.distance(&q, witness);
                assert!((beyond - found.distance).abs() <= 1e-9 * (1.0 + beyond), "{name}");
            }
            let mut least = f64::INFINITY;
            for _ in 0..60 {
                uniform(space, &mut rng, &mut other);
                let far = metric.distance(&q, &other);
                let share = (found.bound / far).min(1.0) * rng.random::<f64>();
                space.interpolate(&q, &other, share, &mut at);
                if metric.distance(&q, &at) < found.bound {
                    assert!(solver.check(&at), "{name}: {q:?} {at:?} {found:?}");
                }
                // The first of fifty samples of the ray that collides.
                for sample in 1..=50 {
                    space.interpolate(&q, &other, f64::from(sample) / 50.0, &mut at);
                    let distance = metric.distance(&q, &at);
                    if distance >= least.min(found.distance) {
                        break;
                    }
                    if !solver.check(&at) {
                        least = distance;
                    }
                }
                rays += 1;
            }
            compared += 1;
            nearer += usize::from(least < 0.95 * found.distance);
        }
    }
    assert!(rays == 6000 && nearer * 50 <= compared, "{nearer} of {compared}");
}

#[test]
fn the_search_ends_at_within_and_limits() {
    let solver = carried_ball("[[obstacle]]\nname = \"round\"\nshape = { sphere = 0.3 }\npose = { xyz = [0, 0, 0] }\n");
    let q = solver.scene().space.config(&[0.9, 0.0, 0.0]).unwrap();
    let near = solver.signed_distance(&q, Some(0.2)).unwrap().unwrap();
    assert!(near.distance.is_infinite() && near.bound >= 0.2 && near.witness.is_none(), "{near:?}");
    let wide = solver.signed_distance(&q, Some(0.6)).unwrap().unwrap();
    assert!((wide.distance - 0.4999).abs() < 1e-3, "{wide:?}");
    let message = solver.signed_distance(&q, Some(-1.0)).unwrap_err();
    assert!(message.to_string().contains("within"), "{message}");
}

/// Configurations of a test: as many as the variable says, or a few.
fn count(usual: usize) -> usize {
    std::env::var("EXTRICATE_DISTANCES").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// Draws configurations next to each other.
fn neighbours(solver: &Solver, rng: &mut ChaCha8Rng, reach: f64) -> [Vec<f64>; 2] {
    let space = &solver.scene().space;
    let mut q = vec![0.0; space.nq()];
    uniform(space, rng, &mut q);
    let step: Vec<f64> = (0..space.nv()).map(|_| reach * (2.0 * rng.random::<f64>() - 1.0)).collect();
    let mut other = q.clone();
    space.integrate(&q, &step, &mut other);
    space.clamp(&mut other);
    [q, other]
}

#[test]
fn distances_change_by_no_more_than_the_configuration() {
    let (mut pairs, mut missed) = (0, 0);
    for name in ["planar-arm", "hand"] {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for _ in 0..count(150) {
            let [a, b] = neighbours(&solver, &mut rng, 0.1);
            let moved = solver.metric().distance(&a, &b);
            let changed = (distance(&solver, &a).distance - distance(&solver, &b).distance).abs();
            pairs += 1;
            // A query may stop at an exit that is 15 % farther than the nearest.
            missed += usize::from(changed > moved + 1e-4);
        }
    }
    assert!(missed * 50 <= pairs, "{missed} of {pairs}");
}

#[test]
fn gradients_are_derivatives() {
    let (mut agree, mut all) = (0, 0);
    for (name, kind) in
        [("planar-arm", MetricKind::Joint), ("planar-arm", MetricKind::ObjectNorm), ("free-box", MetricKind::Joint)]
    {
        let solver = Solver::new(builtin::scene(name).unwrap().with_metric(kind));
        let space = &solver.scene().space;
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        for _ in 0..12 {
            let [q, _] = neighbours(&solver, &mut rng, 0.0);
            let found = distance(&solver, &q);
            if found.distance < 0.02 || found.distance.is_infinite() {
                continue;
            }
            for v in 0..space.nv() {
                let side = |sign: f64| {
                    let (mut step, mut moved) = (vec![0.0; space.nv()], q.clone());
                    step[v] = sign * 1e-3;
                    space.integrate(&q, &step, &mut moved);
                    space.clamp(&mut moved);
                    distance(&solver, &moved).distance
                };
                all += 1;
                agree += usize::from(((side(1.0) - side(-1.0)) / 2e-3 - found.gradient[v]).abs() < 0.02);
            }
        }
    }
    assert!(all > 30 && agree * 10 >= all * 9, "{agree} of {all}");
}

#[test]
fn balls_are_free_and_about_as_large_as_the_bound() {
    for name in ["planar-arm", "shelf-arm", "four-legs", "free-box"] {
        let solver = Solver::new(builtin::scene(name).unwrap());
        let space = &solver.scene().space;
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut drawn = 0;
        while drawn < 6 {
            let [q, mut near] = neighbours(&solver, &mut rng, 0.0);
            let config = space.config(&q).unwrap();
            let radius = solver.free_radius(&config);
            if !solver.check(&q) {
                assert_eq!(radius, 0.0);
                continue;
            }
            drawn += 1;
            let found = distance(&solver, &q);
            assert!(radius <= found.distance && radius > 0.8 * found.bound, "{name} {q:?}: {radius}, {found:?}");
            for _ in 0..count(500) {
                let step: Vec<f64> = (0..space.nv()).map(|_| 2.0 * rng.random::<f64>() - 1.0).collect();
                let length = step.iter().map(|x| x * x).sum::<f64>().sqrt();
                let step: Vec<f64> = step.iter().map(|x| x * radius / length).collect();
                space.integrate(&q, &step, &mut near);
                space.clamp(&mut near);
                let is_within = solver.metric().distance(&q, &near) < radius;
                assert!(!is_within || solver.check(&near), "{name} {q:?} {near:?}");
            }
        }
    }
}

#[test]
fn many_are_measured_as_one_and_locked_joints_stay() {
    let solver = Solver::new(builtin::scene("planar-arm").unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let all: Vec<Config> =
        (0..30).map(|_| solver.scene().space.config(&neighbours(&solver, &mut rng, 0.0)[0]).unwrap()).collect();
    let mut found = Vec::new();
    let mut each = |answered: Answered<Option<SignedDistance>>| {
        found.push(answered.answer);
        ControlFlow::Continue(())
    };
    assert_eq!(solver.signed_distances(all.clone(), None, 2, &mut each).unwrap(), 30);
    let locked = solver.clone().options(QueryOptions::default().locked(vec![1])).unwrap();
    for (q, found) in all.iter().zip(found) {
        assert_eq!(solver.signed_distance(q, None).unwrap(), found);
        let Some(own) = locked.signed_distance(q, None).unwrap() else { continue };
        assert!(own.witness.is_none_or(|witness| witness[1] == q[1]), "{q:?}");
        let whole = found.unwrap().distance.abs();
        assert!(own.distance.abs() > 0.85 * whole, "{q:?}: {} {whole}", own.distance);
    }
}

/// The nearest configuration that touches an obstacle is on its boundary, whether the query
/// collides or not; another obstacle in the way is gone around.
#[test]
fn pairs_that_have_to_touch_do() {
    let round = "[[obstacle]]\nname = \"round\"\nshape = { sphere = 0.3 }\npose = { xyz = [0, 0, 0] }\n";
    let block = "[[obstacle]]\nname = \"block\"\nshape = { box = [0.2, 2, 2] }\npose = { xyz = [0.7, 0, 0] }\n";
    let one = carried_ball(round);
    let both = carried_ball(&format!("{round}{block}"));
    let touching = |solver: &Solver, names: [&str; 2]| {
        let pair = solver.scene().pair_named("touch", names).unwrap();
        solver.clone().options(QueryOptions::default().touch(vec![pair])).unwrap()
    };
    let (one, both) = (touching(&one, ["round", "ball"]), touching(&both, ["ball", "block"]));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..60 {
        let q: [f64; 3] = std::array::from_fn(|_| rng.random::<f64>() * 1.2 - 0.6);
        let config = one.scene().space.config(&q).unwrap();
        let expected = (q.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.4).abs();
        let answer = one.query(&config).unwrap_or_else(|| panic!("{q:?} cannot touch"));
        assert!((answer.depth - expected).abs() < 1e-3, "{q:?} {answer:?}");
        let far = one.distance(&answer.witness);
        assert!(one.check(&answer.witness) && far <= 1e-4 + 5e-4, "{q:?}: {far}");
        assert!(answer.lower_bound <= answer.depth);
        let answer = both.query(&config).unwrap_or_else(|| panic!("{q:?} cannot touch both"));
        // The ball touches the block with its centre at x = 0.5, and is free of the other there.
        let from_block = (0.5 - q[0]).abs();
        assert!((answer.witness[0] - 0.4995).abs() < 1e-3, "{q:?} {answer:?}");
        assert!(both.check(&answer.witness) && answer.depth < from_block + 1e-3, "{q:?} {answer:?}");
    }
    let unknown = one.scene().pair_named("touch", ["ball", "sky"]).unwrap_err().to_string();
    assert!(unknown.contains("sky") && unknown.contains("round"), "{unknown}");
}

#[test]
fn a_continuous_stream_takes_no_pairs_that_touch() {
    let solver = Solver::new(builtin::scene("free-box").unwrap());
    let options = QueryOptions::default().touch(vec![PairId::new(0)]);
    let continuous = StreamOptions::default().continuous(true);
    let Err(refused) = solver.options(options).unwrap().stream(continuous) else { panic!("touch is ignored") };
    assert!(refused.to_string().contains("touch"), "{refused}");
}

//! Claims of answers of every effort and mode: how far anything moves, that depths are distances,
//! and what is prepared before the first answer.

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::metric::{Anchor, MetricScratch};
use extricate::{
    CheckScratch, Checker, Config, Effort, MetricKind, QueryOptions, Solver, StreamOptions, Termination, builtin,
};

use crate::baselines::{DEPTH_JUMPS_SHARE, MOVED_ANSWERS};

/// Returns a drawn motion: configurations from one random one toward another, each `step` (metric
/// units) after the last.
fn motion(world: &Solver, seed: u64, step: f64, frames: usize) -> Vec<Config> {
    let (space, metric) = (world.scene().space(), world.metric());
    let (halton, mut ends) = (Halton::new(space.nv(), seed), [(); 2].map(|()| vec![0.0; space.nq()]));
    ends.iter_mut().enumerate().for_each(|(at, q)| halton.config(space, at as u64, q));
    let (share, mut q) = (step / metric.distance(&ends[0], &ends[1]), vec![0.0; space.nq()]);
    let frames = (0..frames).map(|frame| {
        space.interpolate(&ends[0], &ends[1], (share * frame as f64).min(1.0), &mut q);
        space.config(&q).unwrap()
    });
    frames.collect()
}

/// The reported displacement is that of the witness, whatever the search evaluated last.
#[test]
fn displacements_are_those_of_the_witness() {
    let mut moved = 0;
    for name in builtin::NAMES {
        for metric in [MetricKind::Joint, MetricKind::MaxDisplacement] {
            let world = Solver::new(builtin::scene(name).unwrap().with_metric(metric));
            let (mut anchor, mut memory) = (Anchor::default(), MetricScratch::default());
            let mut judge = |q: &Config, answer: &extricate::Answer, how: &str| {
                world.metric().anchor(q, &mut anchor);
                let expected = world.metric().max_displacement_from(&anchor, &answer.witness, &mut memory);
                let told = answer.max_displacement;
                assert!((told - expected).abs() < 1e-12, "{name}, {how}: {told}, expected {expected}");
                let is_depth = metric != MetricKind::MaxDisplacement || (told - answer.depth).abs() < 1e-9;
                assert!(is_depth, "{name}, {how}: {told} of {}", answer.depth);
                moved += usize::from(told > 0.0);
            };
            let frames = motion(&world, 3, 0.03, 12);
            for effort in [Effort::Refined, Effort::Proved, Effort::Exhaustive] {
                let termination = Termination::after_checks(150);
                let options = QueryOptions::default().effort(effort).termination(termination).segment(true);
                let solver = world.clone().options(options).unwrap();
                for q in &frames {
                    let answer = solver.query(q).unwrap();
                    judge(q, &answer, &format!("{effort:?}"));
                }
            }
            for continuous in [false, true] {
                let mut stream = world.stream(StreamOptions::default().continuous(continuous)).unwrap();
                for q in &frames {
                    let answer = stream.query(q).unwrap();
                    judge(q, &answer, if continuous { "a continuous stream" } else { "a stream" });
                }
            }
        }
    }
    assert!(moved > MOVED_ANSWERS, "{moved}");
}

/// A depth is a distance to a set: between two configurations it changes by no more than their
/// distance. If it changes by more, one of them missed the nearer exit. `EXTRICATE_FRAMES` sets the
/// number of frames of each scene.
#[test]
fn depths_change_no_faster_than_configurations() {
    let count = std::env::var("EXTRICATE_FRAMES").map_or(300, |text| text.parse().expect("a number of frames"));
    const STEP_LENGTH: f64 = 4e-3;
    let (mut missed, mut all) = (0, 0);
    for name in builtin::NAMES {
        let world = Solver::new(builtin::scene(name).unwrap());
        let (mut own, mut most) = (0, 0.0_f64);
        for seed in 0..(count as u64).div_ceil(100) {
            let frames = motion(&world, seed, STEP_LENGTH, 100);
            let depths: Vec<f64> = frames.iter().map(|q| world.query(q).unwrap().depth).collect();
            for (pair, depths) in frames.windows(2).zip(depths.windows(2)) {
                let beyond = (depths[0] - depths[1]).abs() - world.metric().distance(&pair[0], &pair[1]);
                own += usize::from(beyond > 1e-5);
                most = most.max(beyond);
                all += 1;
            }
        }
        println!("{name}: {own} jumps, the largest by {most:.1e}");
        missed += own;
    }
    println!("{missed} jumps in {all} frames");
    let most = DEPTH_JUMPS_SHARE * all as f64;
    assert!(missed as f64 <= most, "{missed} of {all} frames jump, expected at most {most}");
}

/// A solver prepares all that queries need of meshes, and labels alone need none of it.
#[test]
fn the_first_query_finds_its_meshes_prepared() {
    let scene = crate::repeatable::gripper();
    let q = scene.config(&[0.0, 0.0, 0.0, 0.0]).unwrap();
    let checker = Checker::new(scene.clone().into());
    checker.label(&q, &mut CheckScratch::default());
    assert!(!checker.has_pieces());
    let world = Solver::new(scene);
    world.prepare();
    assert!(world.checker().has_pieces());
}

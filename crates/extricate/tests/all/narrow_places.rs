//! Places narrower than the clearance that is aimed at, and deviations in closed form: near exits
//! are preferred to farther ones with more clearance.

use extricate::{
    Answer, CheckScratch, Escape, EscapeOptions, Label, QueryOptions, RepairOptions, Repaired, Rows, SegmentOptions,
    SegmentOutcome, Solver, StreamOptions, Termination, builtin,
};

use crate::baselines::{
    ARM_STREAM_CLEARANCE_METRES, BOX_REPAIR_DEVIATION_METRES, GIVEN_UP_CLEARANCE_OVERDRAWN_CHECKS,
    NARROW_ESCAPE_CHECKS, NARROW_REPAIR_CHECKS, SPIKE_REPAIR_DEVIATION_METRES,
};
use crate::memory::{chain, collision, learned, scene};
use crate::query::ask;

/// Makes a block of side 0.2 that slides along some axes among boxes of these widths \[m\] along x,
/// at these places. Along y and z the boxes are much larger.
fn sliding(axes: &[[f64; 3]], clearance: f64, boxes: &[(f64, f64)]) -> Solver {
    let shape = collision([0.0; 3], [0.0; 3], "<box size=\"0.2 0.2 0.2\"/>");
    let last = axes.len() - 1;
    let joint = |(k, axis): (usize, &[f64; 3])| {
        ("prismatic", [0.0; 3], *axis, -2.0, 2.0, if k == last { shape.as_str() } else { "" })
    };
    let joints: Vec<_> = axes.iter().enumerate().map(joint).collect();
    let mut toml = format!("clearance = {clearance:?}\n[[robot]]\nurdf = \"r.urdf\"\n");
    for (k, (width, x)) in boxes.iter().enumerate() {
        toml += &format!("[[obstacle]]\nname = \"box{k}\"\n");
        toml += &format!("shape = {{ box = [{width:?}, 2.0, 2.0] }}\npose = {{ xyz = [{x:?}, 0, 0] }}\n");
    }
    Solver::new(scene(&toml, &[("r.urdf", chain(&joints))]))
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// Makes a gap of 205 mm whose middle keeps 2.5 mm; the scene's clearance is 2 mm.
fn gap() -> Solver {
    sliding(&[X], 2e-3, &[(0.5, -0.25), (0.5, 0.455)])
}

/// Makes a slot with 0.9 mm of play on both sides of the origin; the scene's clearance is 0.1 mm.
fn slot(axes: &[[f64; 3]]) -> Solver {
    sliding(axes, 1e-4, &[(0.4, 0.3009), (0.4, -0.3009)])
}

fn escape(world: &Solver, q: &[f64]) -> Escape {
    world.escape(&world.scene().config(q).unwrap(), &EscapeOptions::default()).unwrap()
}

fn query(world: &Solver, q: &[f64], clearance: f64) -> Answer {
    let options = QueryOptions::default().clearance(clearance);
    let q = world.scene().config(q).unwrap();
    ask(world, &q, &options)
}

#[test]
fn an_escape_takes_the_near_exit_of_a_narrow_place() {
    // The scene's clearance begins 5 mm away in the gap, and the middle is another 0.5 mm away.
    let found = escape(&gap(), &[0.097]);
    assert!((0.005..0.0056).contains(&found.length) && found.checks < NARROW_ESCAPE_CHECKS, "{found:?}");
    for axes in [&[X][..], &[X, Y, Z]] {
        let mut q = vec![0.0; axes.len()];
        q[0] = 0.00117;
        let found = escape(&slot(axes), &q);
        assert!((3.7e-4..1.2e-3).contains(&found.length) && found.checks < NARROW_ESCAPE_CHECKS, "{found:?}");
    }
    // Pegs in these fits overlap one side by half the play.
    for play in [1e-3, 2e-4, 5e-5] {
        let world = sliding(&[X, Y, Z], play / 10.0, &[(0.4, 0.3 + play), (0.4, -0.3 - play)]);
        let found = escape(&world, &[1.5 * play, 0.0, 0.0]);
        assert!((0.5 * play..2.5 * play).contains(&found.length), "{play}: {found:?}");
    }
}

#[test]
fn a_repair_takes_the_near_exit_of_a_narrow_place() {
    for last in [0.1025, 0.103] {
        let rows = [0.097, last];
        let repaired = gap().repair(Rows::new(&rows, 1).unwrap(), &RepairOptions::default()).unwrap();
        assert!(repaired.is_found() && repaired.deviation < 0.0056, "{repaired:?}");
        assert!(repaired.checks < NARROW_REPAIR_CHECKS, "{repaired:?}");
    }
}

#[test]
fn a_query_gives_up_clearance_rather_than_go_far() {
    let world = slot(&[X, Y, Z]);
    let answer = query(&world, &[0.00117, 0.0, 0.0], 1e-3);
    assert!(answer.depth < 1e-3 && answer.clearance > 1e-4 && answer.clearance < 9e-4, "{answer:?}");
    assert!(answer.verified && answer.lower_bound > 0.0 && answer.lower_bound <= answer.depth, "{answer:?}");
    // A scene of that clearance has the same answer.
    let wider = Solver::new(world.scene().with_clearance(answer.clearance).unwrap());
    let expected = wider.query(&world.scene().config(&[0.00117, 0.0, 0.0]).unwrap()).unwrap();
    // The query begins with the pushed exit and comes to the same end but for rounding.
    let is_near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(is_near(answer.depth, expected.depth) && is_near(answer.lower_bound, expected.lower_bound), "{answer:?}");
    assert!(answer.witness.iter().zip(&expected.witness[..]).all(|(a, b)| is_near(*a, *b)), "{answer:?} {expected:?}");
    assert_eq!((&answer.colliding, &answer.touching), (&expected.colliding, &expected.touching));
    // A configuration that is free already does not jump through a wall either.
    let answer = query(&world, &[0.0003, 0.0, 0.0], 1e-3);
    assert!(answer.depth < 1e-3, "{answer:?}");
    // Beside one wall there is enough space to keep the whole clearance.
    let answer = query(&sliding(&[X], 1e-4, &[(0.5, -0.25)]), &[0.09], 5e-3);
    assert!((answer.depth - 0.015).abs() < 1e-6 && answer.clearance == 5e-3, "{answer:?}");
}

#[test]
fn what_is_asked_again_keeps_the_budget() {
    let (world, q) = (slot(&[X, Y, Z]), [0.00117, 0.0, 0.0]);
    let q = world.scene().config(&q).unwrap();
    for budget in [0, 1, 5, 20, 50, 100, 200] {
        let options = QueryOptions::default().clearance(1e-3).termination(Termination::after_checks(budget));
        let answer = ask(&world, &q, &options);
        // Each of the three queries may overdraw by the checks that end it.
        assert!(answer.checks <= budget + GIVEN_UP_CLEARANCE_OVERDRAWN_CHECKS, "{budget}: {answer:?}");
    }
}

/// Follows a straight motion by a continuous stream; the last 10 frames stand still.
fn follow(solver: &Solver, options: QueryOptions, ends: [&[f64]; 2], frames: usize) -> Vec<Answer> {
    let space = solver.scene().space();
    let mut stream =
        solver.clone().options(options).unwrap().stream(StreamOptions::default().continuous(true)).unwrap();
    let frame = |k: usize| {
        let mut q = vec![0.0; space.nq()];
        space.interpolate(ends[0], ends[1], (k as f64 / (frames - 10) as f64).min(1.0), &mut q);
        stream.query(&space.config(&q).unwrap()).unwrap()
    };
    (0..frames).map(frame).collect()
}

#[test]
fn a_continuous_stream_that_begins_in_collision_follows() {
    let world = sliding(&[X], 1e-4, &[(0.5, -0.25)]);
    for (options, aim) in [(QueryOptions::default(), 6e-4), (QueryOptions::default().clearance(5e-3), 5e-3)] {
        let answers = follow(&world, options, [&[0.09], &[0.5]], 42);
        assert!((answers[0].witness[0] - 0.1 - aim).abs() < 1e-6, "{:?}", answers[0]);
        assert!((answers[0].clearance - aim).abs() < 1e-6, "{:?}", answers[0]);
        let last = &answers[41];
        assert_eq!((&last.witness[..], last.depth), (&[0.5][..], 0.0));
        assert!((last.clearance - aim).abs() < 1e-12, "{last:?}");
    }
    // In a slot too narrow for the aim, the stream keeps less clearance, and still moves.
    let world = slot(&[X]);
    let options = QueryOptions::default().clearance(5e-3);
    let answers = follow(&world, options, [&[0.00117], &[-0.0005]], 40);
    let kept = 1e-4 + 4.9e-3 / 8.0;
    assert!((answers[0].witness[0] - (9e-4 - kept)).abs() < 1e-6, "{:?}", answers[0]);
    assert!((answers[39].witness[0] + (9e-4 - kept)).abs() < 1e-6, "{:?}", answers[39]);
    assert!((answers[39].clearance - kept).abs() < 1e-6, "{:?}", answers[39]);
}

#[test]
fn continuous_streams_of_arms_that_begin_in_collision_follow() {
    for name in ["planar-arm", "shelf-arm"] {
        let (world, mut scratch) = (Solver::new(builtin::scene(name).unwrap()), CheckScratch::default());
        let aimed = Solver::new(builtin::scene(name).unwrap().with_clearance(6e-4).unwrap());
        let model = learned(builtin::scene(name).unwrap(), 4_000, 0);
        for solver in [&world, &model] {
            let (mut moved, mut reached) = (0, 0);
            let (colliding, free) = (labelled(&world, Label::Colliding, 6), labelled(&world, Label::Free, 6));
            for (first, last) in colliding.iter().zip(&free) {
                let answers = follow(solver, QueryOptions::default(), [first, last], 60);
                let far = |answer: &Answer| world.metric().distance(&answer.witness, &answers[0].witness);
                moved += usize::from(answers.iter().map(far).fold(0.0, f64::max) > 0.05);
                assert!(answers[0].clearance > ARM_STREAM_CLEARANCE_METRES, "{}", answers[0].clearance);
                let end = &answers[59];
                reached += usize::from(end.depth == 0.0);
                // Otherwise something holds it, or the last query violates the aimed clearance.
                let way = world.checker().segment(&end.witness, last, &SegmentOptions::default(), &mut scratch);
                let is_held = !matches!(way, SegmentOutcome::Free)
                    || aimed.checker().label(last, &mut scratch) == Label::Colliding;
                assert!(end.depth == 0.0 || is_held, "{name}: {end:?}");
            }
            println!("{name}: {moved} of 6 moved, {reached} reached");
            assert!(moved == 6 && reached >= 1, "{name}: {moved} of 6 moved, {reached} reached");
        }
    }
}

#[test]
fn a_continuous_stream_that_something_moved_onto_follows_on() {
    let near = sliding(&[X], 1e-4, &[(0.5, -0.25)]);
    let moved = sliding(&[X], 1e-4, &[(0.5, -0.1)]);
    let mut stream = near.stream(StreamOptions::default().continuous(true)).unwrap();
    let mut at =
        |world: &Solver, x: f64| stream.query_in(world, &world.scene().config(&[x]).unwrap()).unwrap().unwrap();
    at(&near, 0.15);
    let answer = at(&moved, 0.2);
    assert!((answer.witness[0] - 0.2506).abs() < 1e-6, "{answer:?}");
    assert_eq!(at(&moved, 0.4).witness[..], [0.4]);
}

fn labelled(world: &Solver, label: Label, count: usize) -> Vec<Vec<f64>> {
    let (space, mut scratch) = (world.scene().space(), CheckScratch::default());
    let halton = extricate::internals::cspace::sampling::Halton::new(space.nv(), 5);
    let mut q = vec![0.0; space.nq()];
    let config = |index| {
        halton.config(space, index, &mut q);
        q.clone()
    };
    let has_label = |q: &Vec<f64>| world.checker().label(q, &mut scratch) == label;
    (0..).map(config).filter(has_label).take(count).collect()
}

/// A disc of radius 0.1 in the plane over a box of half side 0.3; its centre is free beyond 0.4.
fn disc() -> Solver {
    let shape = collision([0.0; 3], [0.0; 3], "<sphere radius=\"0.1\"/>");
    let joints = [("prismatic", [0.0; 3], X, -3.0, 3.0, ""), ("prismatic", [0.0; 3], Y, -3.0, 3.0, shape.as_str())];
    let toml = "clearance = 0.0\n[[robot]]\nurdf = \"r.urdf\"\n[[obstacle]]\nname = \"box\"\nshape = { box = [0.6, 0.6, 0.6] }\n";
    Solver::new(scene(toml, &[("r.urdf", chain(&joints))]))
}

fn repair(rows: &[f64], max_deviation: Option<f64>, seed: u64) -> Repaired {
    let mut options = RepairOptions::default().seed(seed);
    options.max_deviation = max_deviation;
    disc().repair(Rows::new(rows, 2).unwrap(), &options).unwrap()
}

/// Returns the largest distance between two paths at equal places, by samples.
fn sampled_deviation(rows: &[f64], repaired: &Repaired) -> f64 {
    let at = |places: &[f64], points: &[Vec<f64>], place: f64| -> [f64; 2] {
        let k = places.partition_point(|p| *p <= place).clamp(1, places.len() - 1);
        let share = (place - places[k - 1]) / (places[k] - places[k - 1]).max(1e-12);
        [0, 1].map(|c| points[k - 1][c] + share.min(1.0) * (points[k][c] - points[k - 1][c]))
    };
    let old: Vec<Vec<f64>> = rows.chunks_exact(2).map(<[f64]>::to_vec).collect();
    let old_places: Vec<f64> = (0..old.len()).map(|k| k as f64).collect();
    let end = (old.len() - 1) as f64;
    let far = |k: usize| {
        let place = end * k as f64 / 5000.0;
        let (a, b) = (at(&old_places, &old, place), at(&repaired.places, &repaired.points, place));
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    (0..=5000).map(far).fold(0.0, f64::max)
}

#[test]
fn the_deviation_counts_rows_that_are_cut_off() {
    let spike = [-1.0, 1.0, 0.0, 0.2, 1.0, 1.0];
    let repaired = repair(&spike, None, 0);
    assert!((0.2..SPIKE_REPAIR_DEVIATION_METRES).contains(&repaired.deviation), "{repaired:?}");
    assert!(sampled_deviation(&spike, &repaired) <= repaired.deviation + 1e-12);
    for most in [0.01, 0.1, 0.19] {
        assert!(!repair(&spike, Some(most), 0).is_found(), "{most}");
    }
}

#[test]
fn a_repair_over_a_box_is_about_as_near_as_can_be() {
    let straight: Vec<f64> = (0..=20).flat_map(|k| [-1.0 + 0.1 * f64::from(k), 0.05]).collect();
    for seed in 0..4 {
        let most = BOX_REPAIR_DEVIATION_METRES;
        let repaired = repair(&straight, Some(most), seed);
        println!("seed {seed}: {:.3} in {} checks", repaired.deviation, repaired.checks);
        assert!(repaired.is_found() && repaired.deviation <= most, "seed {seed}: {:?}", repair(&straight, None, seed));
        assert!(sampled_deviation(&straight, &repaired) <= repaired.deviation + 1e-12);
        assert!(repaired.places.is_sorted());
    }
}

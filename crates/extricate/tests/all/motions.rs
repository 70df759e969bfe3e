//! Paths of every kind, judged with another library: samples along their edges keep the clearance.
//!
//! `EXTRICATE_EDGES=100000 cargo test --release -p extricate --test all motions` judges as many
//! edges.

use extricate::{Config, EscapeOptions, Label, PlanOptions, RepairOptions, Rows, Solver, Termination};

use crate::recheck::{Recheck, SLACK};

/// Scenes that plan in few checks, with clearances that another library does not take for contact.
const SCENES: [&str; 4] = ["planar-arm", "shelf-arm", "free-box", "hand"];
/// Equal parts of an edge, whose ends are judged.
const EDGE_PARTS: usize = 16;

/// Returns the number of edges to judge.
fn wanted() -> usize {
    std::env::var("EXTRICATE_EDGES").map_or(400, |text| text.parse().expect("EXTRICATE_EDGES is a number"))
}

struct Judge<'a> {
    world: &'a Solver,
    recheck: Recheck<'a>,
    edges: usize,
}

impl Judge<'_> {
    /// Asserts that another library finds every sample free on the edges from point `first` on.
    fn judge(&mut self, points: &[Vec<f64>], first: usize) {
        let (scene, mut q) = (self.world.scene(), points[0].clone());
        for (a, b) in points.iter().zip(points.iter().skip(1)).skip(first) {
            self.edges += 1;
            for sample in 0..=EDGE_PARTS {
                scene.space().interpolate(a, b, sample as f64 / EDGE_PARTS as f64, &mut q);
                let distances = self.recheck.distances(&q, 0.01);
                let nearest = distances.into_iter().fold(f64::INFINITY, f64::min);
                assert!(nearest >= scene.clearance() - SLACK, "{nearest} at {q:?}, between {a:?} and {b:?}");
            }
        }
    }

    /// Judges one path of each kind between three configurations.
    fn paths_of(&mut self, rows: &[Config; 3], seed: u64) {
        let termination = Termination::after_checks(20_000);
        let [colliding, from, to] = rows;
        let options = EscapeOptions::default().tree_checks(2_000).seed(seed);
        let escape = self.world.escape(colliding, &options).unwrap();
        if escape.is_found() {
            self.judge(&escape.points, escape.free_from);
        }
        let options = PlanOptions::default().seed(seed).termination(termination.clone()).threads(1);
        let plan = self.world.plan(from, to, &options).unwrap();
        if plan.is_found() {
            assert_eq!([&plan.points[0][..], &plan.points[plan.points.len() - 1]], [&from[..], &to[..]]);
            self.judge(&plan.points, 0);
        }
        let old = [&from[..], colliding, to].concat();
        let rows = Rows::new(&old, from.len()).unwrap();
        let options = RepairOptions::default().seed(seed).termination(termination);
        let repaired = self.world.repair(rows, &options).unwrap();
        if repaired.is_found() {
            assert_eq!([&repaired.points[0][..], &repaired.points[repaired.points.len() - 1]], [&from[..], &to[..]]);
            self.judge(&repaired.points, 0);
        }
    }
}

#[test]
fn another_library_finds_every_edge_free() {
    let (wanted, mut edges) = (wanted(), 0);
    for name in SCENES {
        let world = Solver::new(extricate::builtin::scene(name).unwrap());
        let mut judge = Judge { world: &world, recheck: Recheck::new(world.scene()), edges: 0 };
        let mut seed = 0;
        while judge.edges < wanted.div_ceil(SCENES.len()) {
            let [from, to] = [2 * seed, 2 * seed + 1].map(|number| nth(&world, Label::Free, number));
            judge.paths_of(&[nth(&world, Label::Colliding, seed), from, to], seed);
            seed += 1;
        }
        edges += judge.edges;
    }
    assert!(edges >= wanted, "{edges}");
}

/// Returns the first configuration with this label in the random sequence of this seed.
fn nth(world: &Solver, label: Label, number: u64) -> Config {
    use rand::SeedableRng;
    let space = world.scene().space();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(number);
    let (mut scratch, mut q) = (Default::default(), vec![0.0; space.nq()]);
    loop {
        extricate::internals::cspace::sampling::uniform(space, &mut rng, &mut q);
        if world.checker().label(&q, &mut scratch) == label {
            return space.config(&q).unwrap();
        }
    }
}

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
        let options = PlanOptions::default().seed(seed).termination(termination.clone()).threads(1);
        let plan = self.world.plan(colliding, to, &options).unwrap();
        if plan.is_found() {
            self.judge(&plan.points, plan.free_from);
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

/// A square peg goes into a blind hole of 1.3 times its width, three peg widths deep: straight
/// edges hardly ever come out there, slides along its walls do.
#[test]
fn a_peg_slides_into_a_hole() {
    const RATIO: f64 = 1.3;
    let (width, depth, size) = (0.04, 0.12, 0.5);
    let (hole, wall) = (width * RATIO, 0.5 * (size - width * RATIO));
    let (off, middle) = (0.5 * (hole + wall), -0.5 * depth);
    let walls = [
        ([wall, size, depth], [-off, 0.0, middle]),
        ([wall, size, depth], [off, 0.0, middle]),
        ([hole, wall, depth], [0.0, -off, middle]),
        ([hole, wall, depth], [0.0, off, middle]),
        ([size, size, 0.02], [0.0, 0.0, -depth - 0.01]),
    ];
    let mut toml = String::from(
        "clearance = 1e-4\nmetric = { kind = \"object-norm\" }\n[[robot]]\nurdf = \"peg.urdf\"\nbase = \"floating\"\n\
         bounds = { min = [-0.25, -0.25, -0.15], max = [0.25, 0.25, 0.35] }\n",
    );
    for (number, (size, place)) in walls.iter().enumerate() {
        toml += &format!(
            "[[obstacle]]\nname = \"wall_{number}\"\nshape = {{ box = {size:?} }}\npose = {{ xyz = {place:?} }}\n"
        );
    }
    let peg = crate::memory::collision([0.0; 3], [0.0; 3], &format!("<box size=\"{width} {width} 0.16\"/>"));
    let urdf = format!("<robot name=\"peg\"><link name=\"peg\">{peg}</link></robot>");
    let world = Solver::new(crate::memory::scene(&toml, &[("peg.urdf", urdf)]));
    let space = world.scene().space();
    let from = [0.1, 0.08, 0.2, 0.25801448, 0.23094654, 0.08186639, 0.93455343];
    let to = [0.0, 0.0, -0.036, 0.0, 0.0, 0.0, 1.0];
    let [from, to] = [from, to].map(|q| space.config(&q).unwrap());
    let mut judge = Judge { world: &world, recheck: Recheck::new(world.scene()), edges: 0 };
    for seed in 0..3 {
        let termination = Termination::after_checks(60_000);
        let options = PlanOptions::default().seed(seed).termination(termination).threads(1);
        let plan = world.plan(&from, &to, &options).unwrap();
        assert!(plan.is_found(), "seed {seed}: {} checks", plan.checks);
        judge.judge(&plan.points, 0);
    }
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

//! The target of roadmap files: a roadmap that can be read serves plans, and grows.

use std::path::Path;
use std::sync::OnceLock;

use extricate::internals::io::roadmap_file::{decode, encode};
use extricate::{Config, PlanOptions, Roadmap, Solver, Termination};

use crate::container::Container;
use crate::scenes;

const PLAN_CHECKS: usize = 300;
/// Equal parts of an edge, whose ends are checked.
const EDGE_PARTS: usize = 8;

/// Reads a roadmap and plans with it; panics if a path is not free.
pub fn run(bytes: &[u8]) {
    let sealed = Container::open(bytes).map(|file| file.sealed());
    let _ = read(sealed.as_deref().unwrap_or(bytes));
}

/// Does the same with a roadmap whose checksum is right.
///
/// # Errors
/// Returns the message of a roadmap that is refused.
pub fn read(bytes: &[u8]) -> Result<(), String> {
    let (solver, [from, to]) = world();
    let space = solver.scene().space();
    let mut roadmap = decode(Path::new("f"), bytes, space).map_err(|error| error.to_string())?;
    let options = options();
    let plan = solver.plan_with(from, to, &options, &mut roadmap).map_err(|error| error.to_string())?;
    let mut q = from.to_vec();
    for (a, b) in plan.points.iter().zip(plan.points.iter().skip(1)) {
        for sample in 0..=EDGE_PARTS {
            space.interpolate(a, b, sample as f64 / EDGE_PARTS as f64, &mut q);
            assert!(solver.check(&q), "{q:?}");
        }
    }
    // A roadmap that was read can be written and read again.
    let again = decode(Path::new("f"), &encode(&roadmap), space);
    assert_eq!(again.map_err(|error| error.to_string()).as_ref(), Ok(&roadmap));
    Ok(())
}

fn options() -> PlanOptions {
    PlanOptions::default().threads(1).termination(Termination::after_checks(PLAN_CHECKS))
}

/// Returns a solver of a small scene, and two free configurations of it.
fn world() -> &'static (Solver, [Config; 2]) {
    static WORLD: OnceLock<(Solver, [Config; 2])> = OnceLock::new();
    WORLD.get_or_init(|| {
        let solver = Solver::new(scenes::scene("few"));
        let space = solver.scene().space();
        let halton = extricate::internals::cspace::sampling::Halton::new(space.nv(), 3);
        let (mut q, mut free) = (vec![0.0; space.nq()], Vec::new());
        for index in 0..1_000 {
            halton.config(space, index, &mut q);
            if solver.check(&q) {
                free.push(space.config(&q).expect("a configuration that was drawn"));
            }
        }
        let ends = [free[0].clone(), free[free.len() / 2].clone()];
        (solver, ends)
    })
}

/// Returns roadmaps of some sizes.
pub fn corpus() -> Vec<(String, Vec<u8>)> {
    let (solver, [from, to]) = world();
    let mut all = Vec::new();
    for checks in [0, 100, 3_000] {
        let mut roadmap = Roadmap::new(solver.scene().space(), checks as u64);
        solver.grow_roadmap(&mut roadmap, checks, &options()).expect("sound options");
        all.push((format!("grown-{checks}"), encode(&roadmap)));
    }
    let mut roadmap = Roadmap::new(solver.scene().space(), 1);
    solver.plan_with(from, to, &options(), &mut roadmap).expect("free ends");
    all.push(("planned".into(), encode(&roadmap)));
    all
}

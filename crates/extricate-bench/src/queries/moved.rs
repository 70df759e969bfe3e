//! Times a scene in which obstacles moved until it can be queried, against a solver built from
//! scratch.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, ensure};
use extricate::geometry::{Body, Pose};
use extricate::internals::cspace::sampling::Halton;
use extricate::internals::io;
use extricate::internals::math::Vec3;
use extricate::{Answer, Config, Scene, Solver};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

const MOVE_ROUNDS: usize = 40;
/// First rounds, in which a solver is also built from scratch and compared.
const COMPARED_ROUNDS: usize = 5;
/// Largest move of an obstacle along each axis \[m\].
const MAX_MOVE_M: f64 = 0.05;

/// Moves `count` obstacles of the scene at `path` per round, and writes a JSON line of medians
/// \[s\] and agreement. `moved` is the time to change the scene and prepare its solver, `first` the
/// extra time of its first query, and `anew` the time to prepare a solver from scratch. `agree`
/// says whether both solvers give the same answers.
///
/// # Errors
/// Fails if the scene cannot be read or has fewer obstacles.
pub fn measure(path: &str, count: usize, mut output: impl Write) -> Result<()> {
    let mut scene = Arc::new(io::load_scene(Path::new(path))?);
    let obstacles: Vec<String> = scene.bodies().iter().filter(|b| b.is_obstacle()).map(|b| b.name.clone()).collect();
    ensure!(obstacles.len() >= count, "{path}: got {} obstacles, expected {count} or more", obstacles.len());
    let mut solver = Solver::new(scene.clone());
    solver.prepare();
    let (queries, mut rng) = (configs(&scene), ChaCha8Rng::seed_from_u64(1));
    let (mut moved, mut first, mut anew, mut agree) = (Vec::new(), Vec::new(), Vec::new(), true);
    for (round, q) in queries.iter().cycle().take(MOVE_ROUNDS).enumerate() {
        let poses: Vec<(&str, Pose)> =
            obstacles.sample(&mut rng, count).map(|name| (name.as_str(), pose_of(&scene, name))).collect();
        let poses: Vec<_> = poses.into_iter().map(|(name, pose)| (name, shifted(pose, &mut rng))).collect();
        let began = Instant::now();
        scene = Arc::new(scene.moved(poses)?);
        solver = solver.with_scene(scene.clone())?;
        solver.prepare();
        moved.push(began.elapsed().as_secs_f64());
        let (answer, cold) = timed(&solver, q);
        let (_, warm) = timed(&solver, q);
        first.push((cold - warm).max(0.0));
        if round < COMPARED_ROUNDS {
            let began = Instant::now();
            let made = Solver::new(scene.clone());
            made.prepare();
            anew.push(began.elapsed().as_secs_f64());
            agree &= made.query(q) == answer;
        }
    }
    let [moved, first, anew] = [moved, first, anew].map(median);
    let (bodies, pairs) = (scene.bodies().len(), scene.pairs().len());
    let line =
        json!({ "moved": moved, "first": first, "anew": anew, "agree": agree, "bodies": bodies, "pairs": pairs });
    Ok(writeln!(output, "{line}")?)
}

fn timed(solver: &Solver, q: &Config) -> (Option<Answer>, f64) {
    let began = Instant::now();
    let answer = solver.query(q);
    (answer, began.elapsed().as_secs_f64())
}

fn configs(scene: &Scene) -> Vec<Config> {
    let (halton, mut q) = (Halton::new(scene.space().nv(), 2), vec![0.0; scene.space().nq()]);
    let config = |index| {
        halton.config(scene.space(), index, &mut q);
        scene.space().config(&q).expect("within the limits")
    };
    (0..MOVE_ROUNDS as u64).map(config).collect()
}

fn pose_of(scene: &Scene, name: &str) -> Pose {
    let body: &Body = scene.bodies().iter().find(|body| body.name == name).expect("one of its obstacles");
    body.parts[0].pose_frame_part
}

fn shifted(pose: Pose, rng: &mut ChaCha8Rng) -> Pose {
    let by = Vec3::from_fn(|_, _| MAX_MOVE_M * (2.0 * rng.random::<f64>() - 1.0));
    Pose { translation: pose.translation + by, ..pose }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

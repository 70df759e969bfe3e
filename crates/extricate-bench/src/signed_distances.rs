//! Measures signed distances of free configurations: what they miss beside contacts that many draws
//! find, and what they cost beside queries.

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use extricate::internals::cspace::sampling::uniform;
use extricate::internals::io;
use extricate::internals::metric::Metric;
use extricate::{CheckScratch, Config, Label, MetricKind, Scene, Solver, builtin};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::clock::ThreadTime;

/// Uniform draws within which a configuration of either kind has to be found.
const MAX_DRAWS: usize = 10_000;
/// A distance misses if something in contact is nearer by more than this share.
const MISS_SHARE: f64 = 0.05;
/// A draw near the nearest contact turns from its direction by up to this angle \[rad\], or by as
/// little as its thousandth.
const MAX_TURN: f64 = 1.0;
/// Halvings that move a contact back along its ray.
const HALVINGS: usize = 20;

/// Measures `count` free configurations of a scene file or a built-in scene under every metric, and
/// as many queries. For each free configuration, `draws` rays look for contacts that are nearer.
/// Writes a JSON line for each metric; times are processor seconds.
///
/// # Errors
/// Fails if `source` cannot be read.
pub fn measure(source: &str, count: usize, seed: u64, draws: usize, mut output: impl Write) -> Result<()> {
    let scene =
        if builtin::NAMES.contains(&source) { builtin::scene(source)? } else { io::load_scene(Path::new(source))? };
    for metric in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
        let line = of_scene(&scene.with_metric(metric), count, seed, draws)?;
        let named = json!({ "scene": source, "metric": metric });
        writeln!(output, "{}", merged(named, line))?;
    }
    Ok(())
}

fn merged(mut a: Value, b: Value) -> Value {
    if let (Value::Object(a), Value::Object(b)) = (&mut a, b) {
        a.extend(b);
    }
    a
}

fn of_scene(scene: &Scene, count: usize, seed: u64, draws: usize) -> Result<Value> {
    let solver = Solver::new(scene.clone());
    let metric = Metric::new(solver.scene().clone());
    let (mut rng, mut check) = (ChaCha8Rng::seed_from_u64(seed), CheckScratch::default());
    let (free, colliding) = drawn(&solver, count, &mut rng, &mut check);
    let (mut queries, mut query_seconds) = (Vec::new(), Vec::new());
    for q in &colliding {
        let started = ThreadTime::now();
        let answer = solver.query(q);
        query_seconds.push(started.elapsed());
        queries.extend(answer.map(|answer| answer.checks as f64));
    }
    let (mut distances, mut nearest, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
    let (mut checks, mut seconds) = (Vec::new(), Vec::new());
    for q in &free {
        let started = ThreadTime::now();
        let Some(found) = solver.signed_distance(q, None)? else { continue };
        seconds.push(started.elapsed());
        checks.push(found.checks as f64);
        bounds.push(found.bound / found.distance);
        let start = found.witness.as_ref().map(|witness| (found.distance, witness.to_vec()));
        nearest.push(nearest_by_draws((&solver, &metric), q, start, draws, (&mut rng, &mut check)));
        distances.push(found.distance);
    }
    let missed = distances.iter().zip(&nearest).filter(|(d, n)| **n < (1.0 - MISS_SHARE) * **d).count();
    Ok(json!({
        "configurations": distances.len(),
        "missed": missed,
        "checks": median(checks), "query_checks": median(queries),
        "seconds": median(seconds), "query_seconds": median(query_seconds),
        "bound_over_distance": median(bounds),
        "distances": distances, "nearest": nearest,
    }))
}

/// Draws `count` free and `count` colliding configurations, or as many as there are.
fn drawn(solver: &Solver, count: usize, rng: &mut ChaCha8Rng, check: &mut CheckScratch) -> (Vec<Config>, Vec<Config>) {
    let space = solver.scene().space();
    let (mut free, mut colliding, mut q) = (Vec::new(), Vec::new(), vec![0.0; space.nq()]);
    for _ in 0..MAX_DRAWS {
        uniform(space, rng, &mut q);
        let Ok(config) = space.config(&q) else { continue };
        let kind = if solver.checker().label(&config, check) == Label::Free { &mut free } else { &mut colliding };
        if kind.len() < count {
            kind.push(config);
        }
        if free.len() == count && colliding.len() == count {
            break;
        }
    }
    (free, colliding)
}

/// Returns the distance of the nearest collision that is known or that draws find: rays in random
/// directions, and every second time in directions near that of the nearest.
fn nearest_by_draws(
    (solver, metric): (&Solver, &Metric),
    q: &Config,
    start: Option<(f64, Vec<f64>)>,
    draws: usize,
    (rng, check): (&mut ChaCha8Rng, &mut CheckScratch),
) -> f64 {
    let space = solver.scene().space();
    let mut least = start.as_ref().map_or(f64::INFINITY, |(distance, _)| *distance);
    let mut best = vec![0.0; space.nv()];
    if let Some((_, witness)) = &start {
        space.difference(q, witness, &mut best);
    }
    let (mut at, mut step) = (q.to_vec(), vec![0.0; space.nv()]);
    for draw in 0..draws {
        if draw % 3 == 0 || least.is_infinite() {
            uniform(space, rng, &mut at);
            space.difference(q, &at, &mut step);
        } else {
            let near = draw % 3 == 1;
            let size = best.iter().map(|x| x * x).sum::<f64>().sqrt();
            let turn = if near { MAX_TURN * 10f64.powf(-3.0 * rng.random::<f64>()) } else { 1e6 } * size
                / (space.nv() as f64).sqrt();
            step.iter_mut().zip(&best).for_each(|(step, best)| *step = best + turn * normal(rng));
        }
        // The farthest point of the ray that is nearer than what is known.
        let reach = |share: f64, at: &mut Vec<f64>| {
            let scaled: Vec<f64> = step.iter().map(|x| share * x).collect();
            space.integrate(q, &scaled, at);
            space.clamp(at);
            metric.distance(q, at)
        };
        let (mut low, mut high) = (0.0, 1.0);
        if least.is_finite() {
            let length = reach(1e-3, &mut at).max(1e-12);
            high = 1e-3 * least / length * if rng.random_bool(0.5) { 0.99 } else { rng.random::<f64>() };
            if reach(high, &mut at) >= least {
                continue;
            }
        } else {
            reach(high, &mut at);
        }
        if solver.checker().label(&at, check) == Label::Free {
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            reach(middle, &mut at);
            if solver.checker().label(&at, check) == Label::Free { low = middle } else { high = middle }
        }
        let distance = reach(high, &mut at);
        if distance < least {
            least = distance;
            space.difference(q, &at, &mut best);
        }
    }
    least
}

/// Draws a nearly normal number.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

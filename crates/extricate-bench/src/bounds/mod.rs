//! Compares lower bounds with every free configuration that is found near the query: by searches,
//! and by draws within the bound.

mod chains;

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use extricate::internals::cspace::sampling::uniform;
use extricate::internals::io;
use extricate::internals::metric::Metric;
use extricate::{CheckScratch, Config, Effort, Label, MetricKind, QueryOptions, Scene, Solver, Termination};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::{Value, json};

use chains::chain;

/// Clearances \[m\]; successive queries of a scene use them one after another.
const CLEARANCES_M: [f64; 3] = [0.0, 1e-4, 0.02];
/// Configurations drawn within the bound of each query.
const DRAWS_WITHIN_BOUND: usize = 16;
/// Uniform draws within which a free and a colliding configuration have to be found.
const MAX_DRAWS: usize = 400;
/// Relative rounding error by which a bound may exceed a depth.
const ROUNDING_SHARE: f64 = 1e-9;
/// Every query in so many is also searched from more starts, by branch and bound, or exhaustively,
/// or is drawn 1e-9 from contact.
const MORE_STARTS_PERIOD: usize = 6;
const PROVED_PERIOD: usize = 50;
const EXHAUSTIVE_PERIOD: usize = 200;
const NEAR_CONTACT_PERIOD: usize = 5;
/// Checks after which every search but the one by branch and bound stops.
const MAX_CHECKS: usize = 2000;

/// Queries a scene file `count` times, or each of the random chains `chains:FROM-TO`, under every
/// metric. Writes a JSON line for each, and returns whether all bounds held.
///
/// # Errors
/// Fails if `source` cannot be read.
pub fn measure(source: &str, count: usize, seed: u64, mut output: impl Write) -> Result<bool> {
    let scenes: Vec<(String, Scene)> = match source.strip_prefix("chains:") {
        Some(range) => {
            let (from, to) = range.split_once('-').context("expected chains:FROM-TO")?;
            (from.parse()?..to.parse()?).map(|n: u64| (format!("chain {n}"), chain(n))).collect()
        }
        None => vec![(source.to_string(), io::load_scene(Path::new(source))?)],
    };
    let mut holds = true;
    for (name, scene) in scenes {
        for metric in [MetricKind::Joint, MetricKind::ObjectNorm, MetricKind::MaxDisplacement] {
            let found = of_scene(&scene.with_metric(metric), count, seed)?;
            holds &= found.broken.is_empty();
            writeln!(output, "{}", found.line(&name, metric))?;
        }
    }
    Ok(holds)
}

#[derive(Default)]
struct BoundTally {
    queries: usize,
    within: usize,
    shares: Vec<f64>,
    /// Queries with a free configuration nearer than the bound.
    broken: Vec<Value>,
}

impl BoundTally {
    fn line(mut self, name: &str, metric: MetricKind) -> Value {
        self.shares.sort_by(f64::total_cmp);
        let at = |share: f64| self.shares.get((share * self.shares.len() as f64) as usize).copied();
        json!({
            "scene": name,
            "metric": metric,
            "queries": self.queries,
            "drawn_within": self.within,
            "bound_over_best": { "p10": at(0.1), "median": at(0.5) },
            "broken": self.broken,
        })
    }

    fn and(mut self, other: Self) -> Self {
        self.queries += other.queries;
        self.within += other.within;
        self.shares.extend(other.shares);
        self.broken.extend(other.broken);
        self
    }
}

fn of_scene(scene: &Scene, count: usize, seed: u64) -> Result<BoundTally> {
    let with = |clearance: &f64| Ok(Solver::new(scene.with_clearance(*clearance)?));
    let all = CLEARANCES_M.iter().map(with).collect::<Result<Vec<Solver>>>()?;
    let metrics: Vec<Metric> = all.iter().map(|world| Metric::new(world.scene().clone())).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    if !all.iter().any(|world| has_both(world, &mut rng)) {
        return Ok(BoundTally::default());
    }
    Ok((0..count)
        .into_par_iter()
        .with_min_len(16)
        .map_init(CheckScratch::default, |check, number| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1_000_003).wrapping_add(number as u64));
            let at = number % all.len();
            one(&all[at], &metrics[at], number / all.len(), &mut rng, check).unwrap_or_default()
        })
        .reduce(BoundTally::default, BoundTally::and))
}

/// Compares the bound of one colliding configuration. Returns `None` if none was drawn, or if
/// nothing free is known.
fn one(
    world: &Solver,
    metric: &Metric,
    number: usize,
    rng: &mut ChaCha8Rng,
    check: &mut CheckScratch,
) -> Option<BoundTally> {
    let q = colliding(world, number.is_multiple_of(NEAR_CONTACT_PERIOD), rng, check)?;
    let mut answers = Vec::new();
    let termination = Termination::after_checks(MAX_CHECKS);
    let refined = QueryOptions::default().termination(termination);
    let mut kinds = vec![refined.clone()];
    if number.is_multiple_of(MORE_STARTS_PERIOD) {
        kinds.push(refined.clone().starts(24));
    }
    if number.is_multiple_of(PROVED_PERIOD) {
        let termination = Termination::after_checks(200);
        kinds.push(refined.clone().effort(Effort::Proved).termination(termination));
    }
    if number.is_multiple_of(EXHAUSTIVE_PERIOD) {
        kinds.push(refined.effort(Effort::Exhaustive));
    }
    for options in kinds {
        let solver = world.clone().options(options).expect("these options go together");
        answers.push(solver.query(&q)?);
    }
    let bound = answers.iter().map(|answer| answer.lower_bound).fold(0.0, f64::max);
    let mut best = answers.iter().map(|answer| answer.depth).fold(f64::INFINITY, f64::min);
    let (space, mut other) = (world.scene().space(), vec![0.0; q.len()]);
    let mut tangent = vec![0.0; space.nv()];
    let mut within = 0;
    for _ in 0..DRAWS_WITHIN_BOUND {
        tangent.iter_mut().for_each(|step| *step = rng.random_range(-1.0..1.0));
        // The length need only be near the bound, because distances are measured below.
        space.integrate(&q, &tangent, &mut other);
        let unit = metric.distance(&q, &other).max(1e-300);
        let factor = bound * rng.random_range(0.5..1.02) / unit;
        tangent.iter_mut().for_each(|step| *step *= factor);
        space.integrate(&q, &tangent, &mut other);
        space.clamp(&mut other);
        let Ok(there) = space.config(&other) else { continue };
        let distance = metric.distance(&q, &there);
        within += usize::from(distance < bound);
        if distance < best && world.checker().label(&there, check) == Label::Free {
            best = distance;
        }
    }
    let mut found = BoundTally { queries: 1, within, ..BoundTally::default() };
    if bound > best * (1.0 + ROUNDING_SHARE) {
        let clearance = world.scene().clearance();
        let answers: Vec<Value> = answers
            .iter()
            .map(|a| json!({ "effort": a.effort, "depth": a.depth, "lower_bound": a.lower_bound, "at": a.witness }))
            .collect();
        found.broken.push(json!({
            "q": q.to_vec(), "clearance": clearance, "bound": bound, "best": best, "answers": answers,
        }));
    }
    found.shares.push(bound / best);
    Some(found)
}

/// Whether both labels occur. Without either, searches would take long and find nothing.
fn has_both(world: &Solver, rng: &mut ChaCha8Rng) -> bool {
    let (space, mut check) = (world.scene().space(), CheckScratch::default());
    let mut q = vec![0.0; space.nq()];
    let labels = (0..MAX_DRAWS).filter_map(|_| {
        uniform(space, rng, &mut q);
        Some(world.checker().label(&space.config(&q).ok()?, &mut check))
    });
    let found: Vec<Label> = labels.collect();
    found.contains(&Label::Free) && found.contains(&Label::Colliding)
}

/// Draws a colliding configuration: uniformly, or next to contact by bisection to a free one.
fn colliding(world: &Solver, near_contact: bool, rng: &mut ChaCha8Rng, check: &mut CheckScratch) -> Option<Config> {
    let space = world.scene().space();
    let draw = |rng: &mut ChaCha8Rng| {
        let mut q = vec![0.0; space.nq()];
        uniform(space, rng, &mut q);
        space.config(&q).ok()
    };
    let (mut inside, mut outside) = (None, None);
    for _ in 0..MAX_DRAWS {
        let q = draw(rng)?;
        match world.checker().label(&q, check) {
            Label::Colliding => inside = Some(q),
            Label::Free => outside = Some(q),
        }
        if inside.is_some() && (outside.is_some() || !near_contact) {
            break;
        }
    }
    let mut inside = inside?;
    let Some(mut outside) = outside.filter(|_| near_contact) else { return Some(inside) };
    let mut middle = vec![0.0; space.nq()];
    while space.distance(&inside, &outside) > 1e-9 {
        space.interpolate(&inside, &outside, 0.5, &mut middle);
        let Ok(q) = space.config(&middle) else { break };
        match world.checker().label(&q, check) {
            Label::Colliding => inside = q,
            Label::Free => outside = q,
        }
    }
    Some(inside)
}

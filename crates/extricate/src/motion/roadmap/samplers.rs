//! Where the configurations of a roadmap come from, and what each source has yielded.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::{MOST_COUNTED, Roadmap, RoadmapContext};
use crate::cspace::Label;
use crate::cspace::sampling::{Halton, uniform};
use crate::query::{Effort, QueryOptions, QueryScratch, Termination, nearest_exit_under};

/// A source of configurations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// A low-discrepancy sequence; those that collide are dropped.
    Uniform,
    /// The same; those that collide are brought to the nearest exit that one start finds, at one of
    /// the [`AIMS`].
    Retracted(usize),
    /// The same at the widest aim, by the nearest stored sample of a model.
    Stored,
    /// The middle between two near configurations that collide.
    Bridge,
    /// Near a node that was useful, brought to the nearest exit where it collides.
    Around,
}

/// All, in the order of their yields in a roadmap.
pub const SAMPLERS: [Sampler; 7] = [
    Sampler::Uniform,
    Sampler::Retracted(0),
    Sampler::Retracted(1),
    Sampler::Retracted(2),
    Sampler::Stored,
    Sampler::Bridge,
    Sampler::Around,
];

/// What retracted configurations keep beyond the clearance, as shares of the radius of the smallest
/// moving body: nobody says how wide a passage is, so three sizes are tried, each a third of the
/// last.
pub const AIMS: [f64; 3] = [0.03, 0.01, 0.003];

/// Checks after which a retraction ends; the first exit is found whatever it takes.
const RETRACTION_CHECKS: usize = 1;

/// Checks that drawing and joining a configuration takes, until it was measured.
const FIRST_COST: f64 = 20.0;

/// How far the ends of a bridge are from each other at most, as a share of the distance between two
/// random configurations; most passages are far narrower, so shorter ones are more likely.
const BRIDGE: f64 = 0.2;
/// The same of configurations around a node.
const AROUND: f64 = 0.1;

/// What a sampler has yielded.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Yield {
    /// Configurations that were drawn.
    pub drawn: u64,
    /// Useful nodes, see [`super`].
    pub useful: u64,
    /// Configurations that were evaluated to draw and to join them.
    pub checks: u64,
}

impl Yield {
    /// Useful nodes for each check. The prior is one in a thousand: a sampler that was hardly tried
    /// is neither dropped nor taken for the best.
    fn rate(&self) -> f64 {
        (self.useful as f64 + 1.0) / (self.checks as f64 + 1000.0)
    }

    /// Checks that one more takes, about.
    pub fn cost(&self) -> f64 {
        /// As if so many had been drawn before.
        const PRIOR: f64 = 10.0;
        (self.checks as f64 + PRIOR * FIRST_COST) / (self.drawn as f64 + PRIOR)
    }
}

/// Whether yields are those of all samplers, or of none yet.
pub fn check(yields: &[Yield]) -> Result<(), String> {
    let most = yields.iter().flat_map(|of| [of.drawn, of.useful, of.checks]).fold(0, u64::max);
    if most > MOST_COUNTED {
        return Err(format!("yields: got {most}, expected at most {MOST_COUNTED}"));
    }
    if yields.is_empty() || yields.len() == SAMPLERS.len() {
        return Ok(());
    }
    Err(format!("yields: got {}, expected {}", yields.len(), SAMPLERS.len()))
}

/// Checks of a batch that each sampler gets, of so many: in proportion to its rate, at least a
/// twentieth of the best one's.
pub fn shares(yields: &[Yield], is_of_use: impl Fn(Sampler) -> bool) -> Vec<f64> {
    /// Least share, of the best sampler's.
    const LEAST: f64 = 0.05;
    let rates: Vec<f64> = SAMPLERS
        .into_iter()
        .zip(yields)
        .map(|(sampler, of)| if is_of_use(sampler) { of.rate() } else { 0.0 })
        .collect();
    let best = rates.iter().copied().fold(0.0, f64::max);
    let floored: Vec<f64> = rates.iter().map(|rate| if *rate > 0.0 { rate.max(LEAST * best) } else { 0.0 }).collect();
    let sum: f64 = floored.iter().sum();
    floored.iter().map(|rate| rate / sum).collect()
}

/// A configuration that was drawn.
pub struct Drawn {
    /// Verified free; `None` where nothing came of it.
    pub config: Option<Vec<f64>>,
    /// Configurations that were evaluated.
    pub checks: usize,
}

/// Draws the configuration of an index, on any thread.
pub fn draw(
    sampler: Sampler,
    index: u64,
    roadmap: &Roadmap,
    context: &RoadmapContext,
    memory: &mut QueryScratch,
) -> Drawn {
    let space = &context.query.checker.scene().space;
    let mut rng = ChaCha8Rng::seed_from_u64(roadmap.seed);
    rng.set_stream(index);
    let mut q = vec![0.0; space.nq()];
    match sampler {
        Sampler::Uniform => {
            Halton::new(space.nv(), roadmap.seed).config(space, index, &mut q);
            let label = context.query.checker.label(&q, &mut memory.evaluator.check);
            Drawn { config: (label == Label::Free).then_some(q), checks: 1 }
        }
        Sampler::Retracted(aim) => {
            Halton::new(space.nv(), roadmap.seed).config(space, index, &mut q);
            retracted(&q, (AIMS[aim], Effort::Refined), context, memory)
        }
        Sampler::Stored => {
            Halton::new(space.nv(), roadmap.seed).config(space, index, &mut q);
            retracted(&q, (AIMS[0], Effort::Nearest), context, memory)
        }
        Sampler::Bridge => bridge(q, &mut rng, context, memory),
        Sampler::Around => {
            let node = roadmap.narrow[rng.random_range(0..roadmap.narrow.len())] as usize;
            uniform(space, &mut rng, &mut q);
            let (far, reach) = (q.clone(), AROUND * rng.random::<f64>().powi(2));
            space.interpolate(roadmap.config(node), &far, reach, &mut q);
            retracted(&q, (AIMS[rng.random_range(0..AIMS.len())], Effort::Refined), context, memory)
        }
    }
}

/// The configuration itself where it is free, else the nearest exit that one start finds.
fn retracted(q: &[f64], (aim, effort): (f64, Effort), context: &RoadmapContext, memory: &mut QueryScratch) -> Drawn {
    let Ok(q) = context.query.checker.scene().space.config(q) else { return Drawn { config: None, checks: 0 } };
    let aim = context.query.clearance + aim * context.radius;
    let starts = (effort != Effort::Nearest).then_some(1);
    // The first exit that is found will do: that it is the nearest is not worth its checks.
    let termination = Termination::after_checks(RETRACTION_CHECKS);
    let options = QueryOptions { effort, starts, clearance: Some(aim), termination, ..QueryOptions::default() };
    let answer = nearest_exit_under(&context.query, &q, &options, memory);
    let mut checks = memory.checks();
    let config = answer.and_then(|answer| {
        let is_free = answer.verified || {
            checks += 1;
            context.query.checker.label(&answer.witness, &mut memory.evaluator.check) == Label::Free
        };
        is_free.then_some(answer.witness)
    });
    Drawn { config, checks }
}

fn bridge(mut q: Vec<f64>, rng: &mut ChaCha8Rng, context: &RoadmapContext, memory: &mut QueryScratch) -> Drawn {
    let (checker, space) = (context.query.checker, &context.query.checker.scene().space);
    uniform(space, rng, &mut q);
    if checker.label(&q, &mut memory.evaluator.check) == Label::Free {
        return Drawn { config: None, checks: 1 };
    }
    let (mut far, mut end, mut middle) = (q.clone(), q.clone(), q.clone());
    uniform(space, rng, &mut far);
    space.interpolate(&q, &far, BRIDGE * rng.random::<f64>().powi(2), &mut end);
    if checker.label(&end, &mut memory.evaluator.check) == Label::Free {
        return Drawn { config: None, checks: 2 };
    }
    space.interpolate(&q, &end, 0.5, &mut middle);
    let label = checker.label(&middle, &mut memory.evaluator.check);
    Drawn { config: (label == Label::Free).then_some(middle), checks: 3 }
}

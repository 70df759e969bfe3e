//! Draws the configurations of a roadmap.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::context::RoadmapContext;
use super::kept::Roadmap;
use super::yields::Sampler;
use crate::cspace::Label;
use crate::cspace::sampling::{Halton, uniform};
use crate::query::{Effort, QueryOptions, QueryScratch, Termination, nearest_exit_under};

/// Margins of retracted configurations beyond the clearance, as shares of the radius of the
/// smallest moving body. Widths of passages are unknown, so three are tried, each a third of the
/// last.
pub const AIM_SHARES: [f64; 3] = [0.03, 0.01, 0.003];

/// Checks after which a retraction ends; the first exit is found whatever it takes.
const RETRACTION_CHECKS: usize = 1;

/// Largest distance between the ends of a bridge, as a share of that of two random configurations.
/// Most passages are far narrower, so shorter bridges are more likely.
const BRIDGE_SHARE: f64 = 0.2;
/// Largest distance of configurations drawn around a node, as the same share.
const AROUND_SHARE: f64 = 0.1;

/// Result of drawing a configuration.
pub struct Drawn {
    /// Configuration that was verified free; `None` if none was found.
    pub config: Option<Vec<f64>>,
    /// Number of configurations evaluated.
    pub checks: usize,
}

/// Draws the configuration of an index; it is the same on any thread.
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
            retracted(&q, (AIM_SHARES[aim], Effort::Refined), context, memory)
        }
        Sampler::Stored => {
            Halton::new(space.nv(), roadmap.seed).config(space, index, &mut q);
            retracted(&q, (AIM_SHARES[0], Effort::Nearest), context, memory)
        }
        Sampler::Bridge => bridge(q, &mut rng, context, memory),
        // Trees draw no single configuration, see `islands`.
        Sampler::Trees => Drawn { config: None, checks: 0 },
        Sampler::Around => {
            let node = roadmap.narrow[rng.random_range(0..roadmap.narrow.len())] as usize;
            uniform(space, &mut rng, &mut q);
            let (far, reach) = (q.clone(), AROUND_SHARE * rng.random::<f64>().powi(2));
            space.interpolate(roadmap.config(node), &far, reach, &mut q);
            retracted(&q, (AIM_SHARES[rng.random_range(0..AIM_SHARES.len())], Effort::Refined), context, memory)
        }
    }
}

/// Returns the configuration itself if it is free, else the nearest exit that one start finds.
fn retracted(q: &[f64], (aim, effort): (f64, Effort), context: &RoadmapContext, memory: &mut QueryScratch) -> Drawn {
    let Ok(q) = context.query.checker.scene().space.config(q) else { return Drawn { config: None, checks: 0 } };
    let aim = context.query.clearance + aim * context.radius;
    let starts = (effort != Effort::Nearest).then_some(1);
    // The first exit will do: a search for the nearest is not worth its checks.
    let termination = Termination::after_checks(RETRACTION_CHECKS);
    let options = QueryOptions { effort, starts, clearance: Some(aim), termination, ..QueryOptions::default() };
    let answer = nearest_exit_under(&context.query, &q, &options, true, memory);
    let mut checks = memory.checks();
    let config = answer.and_then(|answer| {
        let is_free = answer.verified || {
            checks += 1;
            context.query.checker.label(&answer.witness, &mut memory.evaluator.check) == Label::Free
        };
        is_free.then(|| answer.witness.into())
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
    space.interpolate(&q, &far, BRIDGE_SHARE * rng.random::<f64>().powi(2), &mut end);
    if checker.label(&end, &mut memory.evaluator.check) == Label::Free {
        return Drawn { config: None, checks: 2 };
    }
    space.interpolate(&q, &end, 0.5, &mut middle);
    let label = checker.label(&middle, &mut memory.evaluator.check);
    Drawn { config: (label == Label::Free).then_some(middle), checks: 3 }
}

//! A short random descent from a free configuration: exact labels only, no gradients.
//!
//! Where near contacts mislead (non-convex meshes, features that come and go), a linearised descent can end beside a corner that
//! a few random steps find the way around.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Ground;
use super::local_metric::LocalMetric;
use super::refine::RefineScratch;
use super::scatter::normal;
use crate::cspace::Label;
use crate::metric::Anchor;

/// First length of a step, as a share of the depth.
const FIRST_STEP: f64 = 0.05;
/// A step that is neither too long nor too short succeeds in about one of five trials: growth is four shrinkages, so the length
/// stands still there. Source: I. Rechenberg, *Evolutionsstrategie*, 1973 (the 1/5 success rule).
const GROW: f64 = 1.5;
const SHRINK: f64 = 0.9036; // 1.5^(-1/4)

/// Memory that wandering reuses.
#[derive(Default)]
pub struct WanderScratch {
    step: Vec<f64>,
    home: Vec<f64>,
    trial: Vec<f64>,
}

/// Replaces the free configuration `best`, at distance `depth` from the anchor, by nearer free ones among `trials` random steps;
/// returns the new depth. Steps lean toward the anchor.
pub fn wander(
    ground: &Ground,
    anchor: &Anchor,
    (best, mut depth): (&mut [f64], f64),
    trials: usize,
    local: &LocalMetric,
    scratch: &mut WanderScratch,
    refine: &mut RefineScratch,
) -> f64 {
    let space = &ground.checker.scene().space;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let WanderScratch { step, home, trial } = scratch;
    step.resize(space.nv(), 0.0);
    home.resize(space.nv(), 0.0);
    trial.resize(space.nq(), 0.0);
    let mut length = FIRST_STEP * depth;
    for _ in 0..trials {
        if refine.is_spent() {
            break;
        }
        step.iter_mut().for_each(|s| *s = normal(&mut rng));
        local.spread(step);
        let scale = length / (space.nv() as f64).sqrt();
        space.difference(best, &anchor.q, home);
        let lean = 0.5 * length / depth.max(f64::MIN_POSITIVE);
        step.iter_mut().zip(home.iter()).for_each(|(s, h)| *s = *s * scale + lean * h);
        space.integrate(best, step, trial);
        let distance = refine.distance(ground, anchor, trial);
        if distance < depth && refine.label(ground, trial) == Label::Free {
            best.copy_from_slice(trial);
            depth = distance;
            length *= GROW;
        } else {
            length *= SHRINK;
        }
    }
    depth
}

//! Starts close to the query: free configurations on shells around it, for ways out too short for any stored sample to be near.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Ground;
use super::local_metric::LocalMetric;
use super::refine::RefineScratch;
use crate::cspace::Label;
use crate::metric::Anchor;

/// Shells are at the best known depth divided by powers of two, this many of them.
///
/// Past a plane at distance `s`, a random direction in 7 dimensions leads at radius `2 s` with probability 0.1, at `4 s` with
/// 0.25; so shells a factor of two apart and a dozen directions each seldom miss a flat exit twice.
const SHELLS: i32 = 7;

/// How many starts to look for, and how hard.
#[derive(Debug, Clone, Copy)]
pub struct ScatterOptions {
    /// Directions tried on each shell.
    pub directions: usize,
    /// Starts after which the search ends.
    pub wanted: usize,
}

/// Memory that scattering reuses.
#[derive(Default)]
pub struct ScatterScratch {
    /// The starts found, row major.
    pub starts: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
}

/// Fills `scratch.starts` with up to `wanted` free configurations from the innermost shells that have some, all nearer than
/// `depth`. The directions are the same in every call.
pub fn scatter(
    ground: &Ground,
    anchor: &Anchor,
    depth: f64,
    options: &ScatterOptions,
    local: &LocalMetric,
    scratch: &mut ScatterScratch,
    refine: &mut RefineScratch,
) {
    let space = &ground.checker.scene().space;
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let ScatterScratch { starts, step, trial } = scratch;
    starts.clear();
    trial.resize(space.nq(), 0.0);
    step.resize(space.nv(), 0.0);
    let mut found = 0;
    for shell in (0..SHELLS).rev() {
        let radius = 0.8 * depth * 0.5_f64.powi(shell);
        for _ in 0..options.directions {
            if refine.is_spent() {
                return;
            }
            step.iter_mut().for_each(|s| *s = normal(&mut rng));
            local.spread(step);
            // Twice: the first step measures how long it is in the metric.
            for _ in 0..2 {
                space.integrate(&anchor.q, step, trial);
                let length = refine.distance(ground, anchor, trial);
                if length > 0.0 {
                    step.iter_mut().for_each(|s| *s *= radius / length);
                }
            }
            space.integrate(&anchor.q, step, trial);
            if refine.label(ground, trial) == Label::Free {
                starts.extend_from_slice(trial);
                found += 1;
                if found == options.wanted {
                    return;
                }
            }
        }
    }
}

/// A standard normal number (Box and Muller).
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

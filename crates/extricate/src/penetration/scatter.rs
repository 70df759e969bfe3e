//! Starts close to the query: free configurations on shells around it, for ways out too short for any stored sample to be near.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Ground;
use super::refine::RefineScratch;
use crate::cspace::Label;
use crate::metric::Anchor;

/// Shells are at the best known depth divided by powers of two, this many of them.
///
/// Past a plane at distance `s`, a random direction in 7 dimensions leads at radius `2 s` with probability 0.1, at `4 s` with
/// 0.25; so shells a factor of two apart and a dozen directions each seldom miss a flat exit twice.
const SHELLS: i32 = 7;

/// Memory that scattering reuses.
#[derive(Default)]
pub struct ScatterScratch {
    step: Vec<f64>,
    trial: Vec<f64>,
}

/// Appends to `starts` (row major) up to `wanted` free configurations from the innermost shells that have some, `directions` tried
/// on each. The directions are the same in every call.
pub fn scatter(
    ground: &Ground,
    anchor: &Anchor,
    depth: f64,
    directions: usize,
    wanted: usize,
    starts: &mut Vec<f64>,
    scratch: &mut ScatterScratch,
    refine: &mut RefineScratch,
) {
    let space = &ground.checker.scene().space;
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let ScatterScratch { step, trial } = scratch;
    trial.resize(space.nq(), 0.0);
    step.resize(space.nv(), 0.0);
    let mut found = 0;
    for shell in (1..=SHELLS).rev() {
        let radius = depth * 0.5_f64.powi(shell);
        for _ in 0..directions {
            step.iter_mut().for_each(|s| *s = normal(&mut rng));
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
                if found == wanted {
                    return;
                }
            }
        }
    }
}

/// A standard normal number (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

//! Sources of configurations, and what each has yielded for its checks.

use serde::{Deserialize, Serialize};

/// A source of configurations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// A low-discrepancy sequence; colliding configurations are dropped.
    Uniform,
    /// The same; colliding configurations are brought to the nearest exit that one start finds, at
    /// one of the [`super::samplers::AIM_SHARES`].
    Retracted(usize),
    /// The same at the widest aim, but from the nearest stored sample of a model.
    Stored,
    /// A free middle between two near configurations that collide.
    Bridge,
    /// A configuration near a useful node, brought to the nearest exit if it collides.
    Around,
    /// Trees between a component and its surroundings.
    Trees,
}

/// All samplers, in the order of their yields in a roadmap.
pub const SAMPLERS: [Sampler; 8] = [
    Sampler::Uniform,
    Sampler::Retracted(0),
    Sampler::Retracted(1),
    Sampler::Retracted(2),
    Sampler::Stored,
    Sampler::Bridge,
    Sampler::Around,
    Sampler::Trees,
];

/// Checks that drawing and joining a configuration is expected to take before any is measured.
const PRIOR_COST_CHECKS: f64 = 20.0;

/// Maximum of a stored count: more takes longer than anyone has, and sums would overflow.
pub const MAX_COUNT: u64 = 1 << 48;

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Yield {
    /// Number of configurations drawn.
    pub drawn: u64,
    /// Number of useful nodes, see [`super`].
    pub useful: u64,
    /// Number of configurations evaluated to draw and to join them.
    pub checks: u64,
}

impl Yield {
    /// Returns useful nodes for each check. The prior is one in a thousand, so that a sampler that
    /// was hardly tried is neither dropped nor taken for the best.
    fn rate(&self) -> f64 {
        (self.useful as f64 + 1.0) / (self.checks as f64 + 1000.0)
    }

    /// Estimates the checks that one more draw takes.
    pub fn cost(&self) -> f64 {
        /// Weight of the prior, in draws.
        const PRIOR_DRAWS: f64 = 10.0;
        (self.checks as f64 + PRIOR_DRAWS * PRIOR_COST_CHECKS) / (self.drawn as f64 + PRIOR_DRAWS)
    }
}

/// Checks that there are yields of all samplers, or of none.
pub fn check(yields: &[Yield]) -> Result<(), String> {
    let most = yields.iter().flat_map(|of| [of.drawn, of.useful, of.checks]).fold(0, u64::max);
    if most > MAX_COUNT {
        return Err(format!("yields: got {most}, expected at most {MAX_COUNT}"));
    }
    if yields.is_empty() || yields.len() == SAMPLERS.len() {
        return Ok(());
    }
    Err(format!("yields: got {}, expected {}", yields.len(), SAMPLERS.len()))
}

/// Returns each sampler's share of a batch's checks: in proportion to its rate, and at least a
/// twentieth of the best one's.
pub fn shares(yields: &[Yield], is_of_use: impl Fn(Sampler) -> bool) -> Vec<f64> {
    /// Least rate, as a share of the best sampler's.
    const MIN_RATE_SHARE: f64 = 0.05;
    let rates: Vec<f64> = SAMPLERS
        .into_iter()
        .zip(yields)
        .map(|(sampler, of)| if is_of_use(sampler) { of.rate() } else { 0.0 })
        .collect();
    let best = rates.iter().copied().fold(0.0, f64::max);
    let floored: Vec<f64> =
        rates.iter().map(|rate| if *rate > 0.0 { rate.max(MIN_RATE_SHARE * best) } else { 0.0 }).collect();
    let sum: f64 = floored.iter().sum();
    floored.iter().map(|rate| rate / sum).collect()
}

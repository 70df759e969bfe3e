//! The sources of configurations, and what each has yielded for its checks.

use serde::{Deserialize, Serialize};

/// A source of configurations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// A low-discrepancy sequence; those that collide are dropped.
    Uniform,
    /// The same; those that collide are brought to the nearest exit that one start finds, at one of
    /// the [`super::samplers::AIMS`].
    Retracted(usize),
    /// The same at the widest aim, by the nearest stored sample of a model.
    Stored,
    /// The middle between two near configurations that collide.
    Bridge,
    /// Near a node that was useful, brought to the nearest exit where it collides.
    Around,
    /// Trees between a component and what is around it.
    Trees,
}

/// All, in the order of their yields in a roadmap.
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

/// Checks that drawing and joining a configuration takes, until it was measured.
const FIRST_COST: f64 = 20.0;

/// Most that a count may say \[1\]: more takes longer than anyone has, and sums would overflow.
pub const MOST_COUNTED: u64 = 1 << 48;

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

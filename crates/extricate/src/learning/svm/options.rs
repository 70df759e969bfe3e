//! How a classifier is fitted: what is given, and what validation chooses of the rest. It chooses
//! nothing itself.

use serde::{Deserialize, Serialize};

use super::scaling::Scaling;
use super::smo::SvmOptions;

/// How to fit a [`Classifier`](super::Classifier).
#[derive(Debug, Clone)]
pub struct FitOptions {
    /// Weights of free and of colliding points in the penalty; as if there were as many of each
    /// where not given.
    pub weights: Option<[f64; 2]>,
    /// How features are brought to a common scale.
    pub scaling: Scaling,
    /// Width of the kernel: `gamma = gamma_factor / median squared distance`; searched where not
    /// given.
    pub gamma_factor: Option<f64>,
    /// Soft-margin penalty `C`; searched where not given.
    pub penalty: Option<f64>,
    /// Points that the search for the two trains with, about; it validates with as many others.
    pub search_points: usize,
    /// Tolerance of training, in units of the decision value.
    pub tolerance: f64,
    /// Memory for kernel rows in bytes, of all machines that are trained at once; two rows of each
    /// are always kept. What is fitted does not depend on it.
    pub cache_bytes: usize,
    /// Seed of the search's split and of the median.
    pub seed: u64,
}

impl FitOptions {
    /// For one of many that the threads share out: each trains one at a time, and none waits for
    /// another while it holds rows.
    pub fn shared_out(&self) -> Self {
        Self { cache_bytes: self.cache_bytes / rayon::current_num_threads(), ..self.clone() }
    }
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            weights: None,
            scaling: Scaling::Global,
            gamma_factor: None,
            penalty: None,
            search_points: 2_000,
            tolerance: 1e-2,
            cache_bytes: 256 << 20,
            seed: 0,
        }
    }
}

/// What validation chooses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// `gamma` times the median squared distance between points.
    pub gamma_factor: f64,
    /// Soft-margin penalty `C`.
    pub penalty: f64,
}

/// Options of training for one choice of parameters.
pub fn svm_options(free: &[bool], spread: f64, choice: Choice, options: &FitOptions) -> SvmOptions {
    let count = free.iter().filter(|free| **free).count();
    let balance = |count: usize| free.len() as f64 / (2.0 * count.max(1) as f64);
    let weights = options.weights.unwrap_or([balance(count), balance(free.len() - count)]);
    SvmOptions {
        c_positive: choice.penalty * weights[0],
        c_negative: choice.penalty * weights[1],
        gamma: choice.gamma_factor / spread,
        tolerance: options.tolerance,
        cache_bytes: options.cache_bytes,
    }
}

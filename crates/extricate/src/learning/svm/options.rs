//! Options of fitting a classifier, and the parameters that validation chooses.

use serde::{Deserialize, Serialize};

use super::scaling::Scaling;
use super::smo::SvmOptions;

/// How to fit a [`Classifier`](super::Classifier).
#[derive(Debug, Clone)]
pub struct FitOptions {
    /// Weights of free and of colliding points in the penalty; balanced if not given.
    pub weights: Option<[f64; 2]>,
    /// How features are brought to a common scale.
    pub scaling: Scaling,
    /// Kernel width: `gamma = gamma_factor / median squared distance`; searched if not given.
    pub gamma_factor: Option<f64>,
    /// Soft-margin penalty `C`; searched if not given.
    pub penalty: Option<f64>,
    /// About this many points train each candidate of the search, and as many others validate it.
    pub search_points: usize,
    /// Tolerance of training, in units of the decision value.
    pub tolerance: f64,
    /// Memory for kernel rows of all classifiers trained at once \[bytes\]; each keeps at least two
    /// rows. The fit does not depend on it.
    pub cache_bytes: usize,
    /// Seed of the search's split and of the median.
    pub seed: u64,
}

impl FitOptions {
    /// Returns options for one of many fits that run in parallel: each thread trains one at a time,
    /// with an equal share of the memory.
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

/// Kernel width and penalty, given or chosen by validation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hyperparameters {
    /// `gamma` times the median squared distance between points.
    pub gamma_factor: f64,
    /// Penalty `C` of the soft margin.
    pub penalty: f64,
}

/// Returns the options of training for one choice of parameters.
pub fn svm_options(free: &[bool], spread: f64, choice: Hyperparameters, options: &FitOptions) -> SvmOptions {
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

//! From labels to a classifier of the obstacle region. Sees `label` and features of configurations, never a mesh.

pub mod active;
pub mod active_set;
pub mod budget;
pub mod classifier;
pub mod explore;
pub mod kernel;
pub mod row_cache;
pub mod selection;
pub mod smo;
pub mod standardize;

use crate::cspace::Label;

pub use budget::Budget;

/// Exact labels of many configurations (row major) at once; may use many threads, answers in order.
pub type LabelBatch<'a> = dyn Fn(&[f64]) -> Vec<Label> + Sync + 'a;

/// How much to learn.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnOptions {
    /// Most labels (exact checks) to spend.
    pub labels: usize,
    /// Most seconds to spend; a model that ran out of time depends on the speed of the machine.
    pub seconds: Option<f64>,
    /// Seed of every sampler.
    pub seed: u64,
    /// Threads; 0 for one per core. The model does not depend on it.
    pub threads: usize,
    /// Most memory for what is found \[bytes\], counted; learning ends where it is reached.
    pub memory: usize,
}

impl Default for LearnOptions {
    fn default() -> Self {
        Self { labels: 600_000, seconds: Some(90.0), seed: 0, threads: 0, memory: 4 << 30 }
    }
}

/// Where a learning run stands, for a progress bar.
#[derive(Debug, Clone)]
pub struct LearnProgress {
    /// What is being done: `exploring`, `training`, `tracing the boundary`, ...
    pub stage: &'static str,
    /// Share of the budget spent, in `[0, 1]`.
    pub fraction: f64,
    /// Labels spent.
    pub labels: usize,
    /// Boundary samples found.
    pub boundary_samples: usize,
    /// Held-out balanced accuracy of the last classifier.
    pub accuracy: Option<f64>,
}

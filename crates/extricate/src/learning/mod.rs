//! Learns a classifier of the obstacle region from exact labels. This module sees labels and
//! features of configurations, never a mesh.

pub mod active_learning;
pub mod budget;
pub mod exploration;
pub mod obstacle_classifier;
pub mod svm;

use crate::cspace::Label;
use crate::error::{Error, Result};

use crate::interface::setters;
pub use budget::Budget;

/// Returns the exact labels of many configurations (row major) in order; may use many threads.
pub type LabelBatch<'a> = dyn Fn(&[f64]) -> Vec<Label> + Sync + 'a;

/// Limits, seed and threads of a learning run.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LearnOptions {
    /// Most labels to spend; each exact check and each evaluation of contacts is one.
    pub labels: usize,
    /// Most seconds to spend; a model that ran out of time depends on the speed of the machine.
    pub seconds: Option<f64>,
    /// Seed of every sampler.
    pub seed: u64,
    /// Number of threads; 0 means one per core. The model does not depend on it.
    pub threads: usize,
}

setters! {
    LearnOptions {
        labels: usize,
        seconds: f64 = Some,
        seed: u64,
        threads: usize,
    }
}

impl LearnOptions {
    /// Builds the thread pool of a run with these options.
    ///
    /// # Errors
    /// [`Error::Option`] if an option has an invalid value.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool> {
        self.check()?;
        rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(|e| Error::Option {
            name: "threads",
            value: format!("{} ({e})", self.threads),
            expected: "a number of threads that the system can start".into(),
        })
    }

    /// # Errors
    /// [`Error::Option`] if an option has an invalid value.
    pub(crate) fn check(&self) -> Result<()> {
        if self.labels == 0 {
            return Err(Error::Option { name: "labels", value: "0".into(), expected: "at least 1".into() });
        }
        if let Some(seconds) = self.seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
            return Err(Error::Option { name: "seconds", value: seconds.to_string(), expected: "more than 0".into() });
        }
        Ok(())
    }
}

impl Default for LearnOptions {
    fn default() -> Self {
        Self { labels: 160_000, seconds: Some(5.0), seed: 0, threads: 0 }
    }
}

/// State of a learning run, for a progress bar.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LearnProgress {
    /// Name of the stage: `exploring`, `training`, `tracing the boundary`, `solving` or
    /// `measuring`.
    pub stage: &'static str,
    /// Share of the budget spent, in `[0, 1]`.
    pub fraction: f64,
    /// Number of labels spent so far.
    pub labels: usize,
    /// Number of boundary samples found so far.
    pub boundary_samples: usize,
    /// Balanced held-out accuracy of the last classifier; `None` before one was measured.
    pub accuracy: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_that_are_no_time_are_refused() {
        let checked = |seconds| LearnOptions { seconds, ..LearnOptions::default() }.check();
        for bad in [f64::NAN, -1.0, -0.0, 0.0, f64::NEG_INFINITY] {
            let message = checked(Some(bad)).unwrap_err().to_string();
            assert_eq!(message, format!("option seconds: got {bad}, expected more than 0"));
        }
        for good in [None, Some(1e-9), Some(f64::INFINITY)] {
            assert!(checked(good).is_ok(), "{good:?}");
        }
    }
}

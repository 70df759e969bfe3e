//! From labels to a classifier of the obstacle region. Sees `label` and features of configurations,
//! never a mesh.

pub mod active_learning;
pub mod budget;
pub mod exploration;
pub mod obstacle_classifier;
pub mod svm;

use crate::cspace::Label;
use crate::error::{Error, Result};

pub use budget::Budget;

/// Exact labels of many configurations (row major) at once; may use many threads, answers in order.
pub type LabelBatch<'a> = dyn Fn(&[f64]) -> Vec<Label> + Sync + 'a;

/// How much to learn.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnOptions {
    /// Most labels (exact checks, and evaluations of contacts while solving) to spend.
    pub labels: usize,
    /// Most seconds to spend; a model that ran out of time depends on the speed of the machine.
    pub seconds: Option<f64>,
    /// Seed of every sampler.
    pub seed: u64,
    /// Threads; 0 for one per core. The model does not depend on it.
    pub threads: usize,
    /// Most memory for what is found \[bytes\], as [`crate::Learner::bytes`] counts it; learning
    /// ends where it is reached. Kernel rows of training take half of what is left of it.
    pub memory: usize,
    /// Ends learning where at least 95 % of the queries of 64 held-out colliding configurations
    /// have at most this excess (0.05: 5 % farther than a search about ten times as long finds) and
    /// [`LearnOptions::target_disagreement`] holds, where given.
    pub target_excess: Option<f64>,
    /// Ends learning where classifier and labels disagree on at most this share of held-out
    /// configurations, free and colliding ones counting half each, and
    /// [`LearnOptions::target_excess`] holds, where given. Training goes on longer for it.
    pub target_disagreement: Option<f64>,
}

impl LearnOptions {
    /// The part of the limit in seconds that learning itself may take: the rest is for indexing and
    /// measuring what it made.
    pub(crate) fn seconds_for_learning(&self) -> Option<f64> {
        self.seconds.map(|seconds| LEARNING_SHARE * seconds)
    }

    /// The threads of a run with these options.
    ///
    /// # Errors
    /// [`Error::Option`] for an option that makes no sense.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool> {
        self.check()?;
        rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(|e| Error::Option {
            name: "threads",
            value: format!("{} ({e})", self.threads),
            expected: "a number of threads that the system can start",
        })
    }

    /// # Errors
    /// [`Error::Option`] for one that makes no sense.
    pub(crate) fn check(&self) -> Result<()> {
        if self.labels == 0 {
            return Err(Error::Option { name: "labels", value: "0".into(), expected: "at least 1" });
        }
        if let Some(seconds) = self.seconds.filter(|seconds| seconds.is_nan() || *seconds <= 0.0) {
            return Err(Error::Option { name: "seconds", value: seconds.to_string(), expected: "more than 0" });
        }
        let targets = [("target_excess", self.target_excess), ("target_disagreement", self.target_disagreement)];
        match targets.into_iter().find_map(|(name, target)| Some((name, target.filter(|t| !(0.0..1e9).contains(t))?))) {
            Some((name, value)) => Err(Error::Option { name, value: value.to_string(), expected: "0 or more" }),
            None => Ok(()),
        }
    }
}

/// Of a limit in seconds.
const LEARNING_SHARE: f64 = 0.9;

impl Default for LearnOptions {
    fn default() -> Self {
        Self {
            labels: 500_000,
            seconds: Some(90.0),
            seed: 0,
            threads: 0,
            memory: 4 << 30,
            target_excess: None,
            target_disagreement: None,
        }
    }
}

/// Where a learning run stands, for a progress bar.
#[derive(Debug, Clone)]
pub struct LearnProgress {
    /// What is being done: `exploring`, `training`, `tracing the boundary`, `solving`, ...
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

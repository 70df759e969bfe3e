//! The budget of a learning run, in labels and seconds, and the caller's request to stop.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::{LabelBatch, LearnOptions, LearnProgress};
use crate::cspace::Label;

/// Share of the limit in seconds that learning may take; indexing and measuring get the rest.
const LEARNING_SHARE: f64 = 0.9;

/// Counts labels and seconds, and reports progress after every batch.
pub struct Budget<'a> {
    labels: usize,
    seconds: Option<f64>,
    started: Instant,
    progress: LearnProgress,
    report: &'a mut dyn FnMut(&LearnProgress) -> ControlFlow<()>,
    end: Option<BudgetEnd>,
}

/// Why a budget ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BudgetEnd {
    /// All labels are spent.
    Labels,
    /// The time for learning is spent.
    Seconds,
    /// The caller requested a stop.
    Interrupted,
}

impl<'a> Budget<'a> {
    /// Creates an unspent budget and starts its clock.
    pub fn new(options: &LearnOptions, report: &'a mut dyn FnMut(&LearnProgress) -> ControlFlow<()>) -> Self {
        let progress =
            LearnProgress { stage: "exploring", fraction: 0.0, labels: 0, boundary_samples: 0, accuracy: None };
        let (labels, seconds) = (options.labels, options.seconds);
        Self { labels, seconds, started: Instant::now(), progress, report, end: None }
    }

    /// Names the stage that begins, and reports it.
    pub fn stage(&mut self, stage: &'static str) {
        self.progress.stage = stage;
        self.tell();
    }

    /// Stores figures for the next reports.
    pub fn note(&mut self, boundary_samples: usize, accuracy: Option<f64>) {
        self.progress.boundary_samples = boundary_samples;
        self.progress.accuracy = accuracy.or(self.progress.accuracy);
    }

    /// Labels `configs`, counts them and reports.
    pub fn label(&mut self, label: &LabelBatch, configs: &[f64]) -> Vec<Label> {
        let labels = label(configs);
        self.spend(labels.len());
        labels
    }

    /// Counts `labels` that were spent without [`Budget::label`], and reports.
    pub fn spend(&mut self, labels: usize) {
        self.progress.labels += labels;
        self.tell();
    }

    fn tell(&mut self) {
        let [by_labels, by_time] = self.shares();
        self.progress.fraction = by_labels.max(by_time).min(1.0);
        if (self.report)(&self.progress).is_break() {
            self.end = Some(BudgetEnd::Interrupted);
        } else if self.end.is_none() && by_labels >= 1.0 {
            self.end = Some(BudgetEnd::Labels);
        } else if self.end.is_none() && by_time >= 1.0 {
            self.end = Some(BudgetEnd::Seconds);
        }
    }

    /// Returns why the budget ended; `None` while it has not.
    pub fn end(&self) -> Option<BudgetEnd> {
        self.end
    }

    /// Larger of the spent shares of labels and of seconds, in `[0, 1]`.
    pub fn fraction(&self) -> f64 {
        let [by_labels, by_time] = self.shares();
        by_labels.max(by_time).min(1.0)
    }

    /// Spent shares of the labels and of the seconds for learning.
    fn shares(&self) -> [f64; 2] {
        let by_labels = self.progress.labels as f64 / self.labels.max(1) as f64;
        let limit = self.seconds.map(|limit| LEARNING_SHARE * limit);
        let by_time = limit.map_or(0.0, |limit| self.started.elapsed().as_secs_f64() / limit.max(1e-9));
        [by_labels, by_time]
    }

    /// Limit in seconds, indexing and measuring included.
    pub fn seconds(&self) -> Option<f64> {
        self.seconds
    }

    /// Time at which the seconds for learning end; `None` without a limit that a clock can
    /// represent.
    pub fn until(&self) -> Option<Instant> {
        self.after(LEARNING_SHARE * self.seconds?)
    }

    /// Time at which all seconds end, those for indexing and measuring included.
    pub fn until_measured(&self) -> Option<Instant> {
        self.after(self.seconds?)
    }

    fn after(&self, seconds: f64) -> Option<Instant> {
        self.started.checked_add(Duration::try_from_secs_f64(seconds).ok()?)
    }

    /// Number of labels spent.
    pub fn spent(&self) -> usize {
        self.progress.labels
    }

    /// Number of labels left.
    pub fn left(&self) -> usize {
        self.labels.saturating_sub(self.progress.labels)
    }
}

//! What a learning run may still spend, and the caller's wish to stop.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::{LabelBatch, LearnOptions, LearnProgress};
use crate::cspace::Label;

/// The part of the limit in seconds that learning itself may take: the rest is for indexing and
/// measuring what it made.
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

/// Why no more labels are to be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BudgetEnd {
    /// The labels are spent.
    Labels,
    /// The seconds are spent.
    Seconds,
    /// The caller asked to stop.
    Interrupted,
}

impl<'a> Budget<'a> {
    /// Starts the clock.
    pub fn new(options: &LearnOptions, report: &'a mut dyn FnMut(&LearnProgress) -> ControlFlow<()>) -> Self {
        let progress =
            LearnProgress { stage: "exploring", fraction: 0.0, labels: 0, boundary_samples: 0, accuracy: None };
        let (labels, seconds) = (options.labels, options.seconds);
        Self { labels, seconds, started: Instant::now(), progress, report, end: None }
    }

    /// Names the stage that follows.
    pub fn stage(&mut self, stage: &'static str) {
        self.progress.stage = stage;
        self.tell();
    }

    /// Notes results for the reports.
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

    /// Counts `labels` that were asked otherwise and reports.
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

    /// Why nothing more may be spent; `None` while something may.
    pub fn end(&self) -> Option<BudgetEnd> {
        self.end
    }

    /// Share of the budget spent, of labels or of seconds, whichever is more, in `[0, 1]`.
    pub fn fraction(&self) -> f64 {
        let [by_labels, by_time] = self.shares();
        by_labels.max(by_time).min(1.0)
    }

    /// Shares of the labels and of the seconds that are spent.
    fn shares(&self) -> [f64; 2] {
        let by_labels = self.progress.labels as f64 / self.labels.max(1) as f64;
        let limit = self.seconds.map(|limit| LEARNING_SHARE * limit);
        let by_time = limit.map_or(0.0, |limit| self.started.elapsed().as_secs_f64() / limit.max(1e-9));
        [by_labels, by_time]
    }

    /// The limit in seconds.
    pub fn seconds(&self) -> Option<f64> {
        self.seconds
    }

    /// When the seconds for learning are spent; `None` without a limit, or with one that no clock
    /// can hold.
    pub fn until(&self) -> Option<Instant> {
        self.after(LEARNING_SHARE * self.seconds?)
    }

    /// When all seconds are spent, those for indexing and measuring included.
    pub fn until_measured(&self) -> Option<Instant> {
        self.after(self.seconds?)
    }

    fn after(&self, seconds: f64) -> Option<Instant> {
        self.started.checked_add(Duration::try_from_secs_f64(seconds).ok()?)
    }

    /// Labels spent.
    pub fn spent(&self) -> usize {
        self.progress.labels
    }

    /// Labels left.
    pub fn left(&self) -> usize {
        self.labels.saturating_sub(self.progress.labels)
    }
}

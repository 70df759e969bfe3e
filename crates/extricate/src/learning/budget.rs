//! What a learning run may still spend, and the caller's wish to stop.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::{LabelBatch, LearnOptions, LearnProgress};
use crate::cspace::Label;

/// What a run has spent and found; a checkpoint keeps it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// Labels.
    pub labels: usize,
    /// Wall time \[s\].
    pub seconds: f64,
}

/// Counts labels and seconds, and reports progress after every batch.
pub struct Budget<'a> {
    labels: usize,
    seconds: Option<f64>,
    before: f64,
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
        Self::resumed(options, &Spent::default(), report)
    }

    /// Starts the clock for the rest of a run that has spent something before.
    pub fn resumed(
        options: &LearnOptions,
        spent: &Spent,
        report: &'a mut dyn FnMut(&LearnProgress) -> ControlFlow<()>,
    ) -> Self {
        let (labels, before) = (options.labels, spent.seconds);
        let progress = LearnProgress {
            stage: "exploring",
            fraction: 0.0,
            labels: spent.labels,
            boundary_samples: 0,
            accuracy: None,
        };
        Self {
            labels,
            seconds: options.seconds_for_learning(),
            before,
            started: Instant::now(),
            progress,
            report,
            end: None,
        }
    }

    /// What was spent, earlier parts of the run included.
    pub fn spent_so_far(&self) -> Spent {
        Spent { labels: self.progress.labels, seconds: self.seconds_spent() }
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
        let by_labels = self.progress.labels as f64 / self.labels.max(1) as f64;
        let by_time = self.seconds.map_or(0.0, |limit| self.seconds_spent() / limit.max(1e-9));
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
        let by_labels = self.progress.labels as f64 / self.labels.max(1) as f64;
        let by_time = self.seconds.map_or(0.0, |limit| self.seconds_spent() / limit.max(1e-9));
        by_labels.max(by_time).min(1.0)
    }

    /// The limit in seconds.
    pub fn seconds(&self) -> Option<f64> {
        self.seconds
    }

    /// When the seconds are spent; `None` without a limit, or with one that no clock can hold.
    pub fn until(&self) -> Option<Instant> {
        let left = Duration::try_from_secs_f64((self.seconds? - self.before).max(0.0)).ok()?;
        self.started.checked_add(left)
    }

    /// Labels spent.
    pub fn spent(&self) -> usize {
        self.progress.labels
    }

    /// Labels left.
    pub fn left(&self) -> usize {
        self.labels.saturating_sub(self.progress.labels)
    }

    /// Wall time \[s\], earlier parts of the run included.
    pub fn seconds_spent(&self) -> f64 {
        self.before + self.started.elapsed().as_secs_f64()
    }
}

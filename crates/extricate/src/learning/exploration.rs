//! Exploration: labels of low-discrepancy configurations, before anything is known.

use rayon::prelude::*;

use super::{Budget, LabelBatch};
use crate::cspace::sampling::Halton;
use crate::cspace::{ConfigSpace, Label};

/// Labelled configurations, in two lists.
#[derive(Debug, Clone, Default)]
pub struct Exploration {
    /// Free ones, row major.
    pub free: Vec<f64>,
    /// Colliding ones, row major.
    pub colliding: Vec<f64>,
    /// Index of the next low-discrepancy point.
    pub next: u64,
}

/// Configurations labelled in one batch.
pub const BATCH: usize = 2048;
/// Rows below which sharing out work that takes less than a label costs more than it saves.
pub const ROWS_A_TASK: usize = 64;

impl Exploration {
    /// Labels `count` further points of the sequence; fewer where the budget ends, never more than
    /// it has left.
    pub fn extend(
        &mut self,
        space: &ConfigSpace,
        halton: &Halton,
        count: usize,
        label: &LabelBatch,
        budget: &mut Budget,
    ) {
        let nq = space.nq();
        let mut done = 0;
        while done < count && budget.end().is_none() {
            let batch = BATCH.min(count - done).min(budget.left());
            if batch == 0 {
                return;
            }
            let mut configs = vec![0.0; batch * nq];
            let rows = configs.par_chunks_exact_mut(nq).enumerate().with_min_len(ROWS_A_TASK);
            rows.for_each(|(i, q)| halton.config(space, self.next + i as u64, q));
            for (q, label) in configs.chunks_exact(nq).zip(budget.label(label, &configs)) {
                match label {
                    Label::Free => self.free.extend_from_slice(q),
                    Label::Colliding => self.colliding.extend_from_slice(q),
                }
            }
            self.next += batch as u64;
            done += batch;
        }
    }
}

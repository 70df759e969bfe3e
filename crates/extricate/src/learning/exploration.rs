//! Exploration, the first step of learning: labels evenly spread (low-discrepancy) configurations.

use rayon::prelude::*;

use super::{Budget, LabelBatch};
use crate::cspace::sampling::Halton;
use crate::cspace::{ConfigSpace, Label};

/// Labelled configurations, in two lists.
#[derive(Debug, Clone, Default)]
pub struct Exploration {
    /// Free configurations, row major.
    pub free: Vec<f64>,
    /// Colliding configurations, row major.
    pub colliding: Vec<f64>,
    /// Index of the next low-discrepancy point.
    pub next: u64,
}

/// Most configurations labelled in one batch.
pub const BATCH: usize = 2048;
/// Fewest rows of a parallel task, for work cheaper than a label: smaller tasks cost more to share
/// out than they save.
pub const ROWS_A_TASK: usize = 64;

impl Exploration {
    /// Labels the next `count` points of the sequence, or as many as the budget still allows.
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

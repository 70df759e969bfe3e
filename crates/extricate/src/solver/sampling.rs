//! Samples uniformly random configurations: all of them, only free ones, or only colliding ones.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Solver;
use crate::cspace::Label;
use crate::cspace::sampling::uniform;
use crate::error::{Error, Result};

/// Configurations labelled at once: enough for all threads, few enough that a rare label is not
/// drawn far beyond need.
const BATCH_CONFIGS: usize = 4096;
/// Drawing ends after this many configurations in a row without the wanted label.
const MAX_CONFIGS_IN_VAIN: usize = 1_000_000;

/// Draws uniformly random configurations; the same scene, seed and wanted label give the same ones.
#[derive(Debug)]
pub struct Sampler {
    solver: Solver,
    wanted: Option<Label>,
    rng: ChaCha8Rng,
    /// Configurations found and not yet given out.
    ready: VecDeque<Vec<f64>>,
    tried: usize,
    given: usize,
}

impl Sampler {
    /// Makes a sampler of configurations with one label, or with any (`None`).
    pub fn new(solver: &Solver, wanted: Option<Label>, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { solver: solver.clone(), wanted, rng, ready: VecDeque::new(), tried: 0, given: 0 }
    }

    /// Draws the next `count` configurations. `progress` receives the numbers tried and found so
    /// far, and may stop the drawing. All threads of the current rayon pool check labels.
    ///
    /// # Errors
    /// [`Error::Unlikely`] if a million tries in a row found nothing; [`Error::Interrupted`] if
    /// `progress` stopped it.
    pub fn draw(
        &mut self,
        count: usize,
        progress: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<Vec<Vec<f64>>> {
        let mut in_vain = 0;
        while self.ready.len() < count {
            if progress(self.tried, self.given + self.ready.len()).is_break() {
                return Err(Error::Interrupted);
            }
            let found = self.ready.len();
            let tried = self.try_batch(count - found);
            in_vain = if self.ready.len() > found { 0 } else { in_vain + tried };
            if in_vain >= MAX_CONFIGS_IN_VAIN {
                return Err(self.unlikely(in_vain));
            }
        }
        self.given += count;
        Ok(self.ready.drain(..count).collect())
    }

    fn try_batch(&mut self, missing: usize) -> usize {
        let space = &self.solver.scene().space;
        let rows = if self.wanted.is_some() { BATCH_CONFIGS } else { BATCH_CONFIGS.min(missing) };
        let mut batch = vec![0.0; rows * space.nq()];
        batch.chunks_exact_mut(space.nq()).for_each(|q| uniform(space, &mut self.rng, q));
        self.tried += rows;
        let drawn = batch.chunks_exact(space.nq()).map(<[f64]>::to_vec);
        match self.wanted {
            None => self.ready.extend(drawn),
            Some(wanted) => {
                let mut labels = vec![Label::Free; rows];
                self.solver.checker().label_batch(&batch, &mut labels);
                self.ready.extend(drawn.zip(labels).filter(|(_, label)| *label == wanted).map(|(q, _)| q));
            }
        }
        rows
    }

    fn unlikely(&self, in_vain: usize) -> Error {
        let (kind, other) = match self.wanted {
            Some(Label::Free) => ("free", "in collision"),
            _ => ("colliding", "free"),
        };
        let found = self.given + self.ready.len();
        Error::Unlikely(format!(
            "no {kind} configuration among {in_vain} uniform ones ({found} found before): the scene is nearly always {other}"
        ))
    }
}

//! Labels of many configurations at once, on one thread or on all of them. What a label means: [`Checker::label`].

use rayon::prelude::*;

use super::{CheckScratch, Checker};
use crate::cspace::Label;

/// Configurations that a thread labels before it looks for more: enough to make handing out work cheap, few enough that no
/// thread ends long after the others.
const CHUNK: usize = 64;

impl Checker {
    /// Labels `n` configurations (row major, `n x nq`, each within limits) on all threads of the current rayon pool.
    ///
    /// `labels[i]` is what [`Checker::label`] says of configuration `i`, whatever the number of threads.
    ///
    /// # Panics
    /// Where `configs` is not `labels.len() * nq` long.
    ///
    /// ```
    /// use extricate::{Checker, Label, scene::builtin};
    /// let scene = builtin::scene("planar-arm").unwrap();
    /// let checker = Checker::new(scene.into());
    /// let mut labels = [Label::Free; 2];
    /// checker.label_batch(&[0.0, 0.0, 0.0, 0.3, -0.2, 0.1], &mut labels);
    /// ```
    pub fn label_batch(&self, configs: &[f64], labels: &mut [Label]) {
        self.assert_rows(configs, labels);
        let width = CHUNK * self.scene.space.nq();
        configs
            .par_chunks(width)
            .zip(labels.par_chunks_mut(CHUNK))
            .for_each_init(CheckScratch::default, |scratch, (configs, labels)| self.label_rows(configs, labels, scratch));
    }

    /// As [`Checker::label_batch`] on the calling thread, without allocating once `scratch` has served this checker.
    ///
    /// # Panics
    /// Where `configs` is not `labels.len() * nq` long.
    pub fn label_batch_serial(&self, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
        self.assert_rows(configs, labels);
        self.label_rows(configs, labels, scratch);
    }

    fn label_rows(&self, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
        for (q, label) in configs.chunks_exact(self.scene.space.nq()).zip(labels) {
            *label = self.label(q, scratch);
        }
    }

    fn assert_rows(&self, configs: &[f64], labels: &[Label]) {
        let (rows, nq) = (labels.len(), self.scene.space.nq());
        assert_eq!(configs.len(), rows * nq, "{rows} labels of configurations of {nq} coordinates");
    }
}

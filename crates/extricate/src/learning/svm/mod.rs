//! A support vector classifier that predicts from features whether a configuration collides. It is
//! an approximation: only an exact check says "free".

pub mod kernel;
pub mod kernel_cache;
pub mod kernel_tile;
pub mod model_selection;
pub mod options;
pub mod scaling;
pub mod smo;
pub mod working_set;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cspace::Label;
use kernel::{PointSet, WeightedPoints};
pub use options::FitOptions;
use options::{Hyperparameters, svm_options};
use scaling::Standardization;
use smo::train;

/// Features up to this many kept dimensions are classified without allocation.
const STACK_DIMENSIONS: usize = 256;

/// A support vector machine with a Gaussian kernel on standardised features.
///
/// ```
/// use extricate::Label;
/// use extricate::internals::learning::svm::{Classifier, FitOptions};
/// let features: Vec<f64> = (0..200).map(|i| f64::from(i) / 100.0 - 1.0).collect();
/// let label = |x: &f64| if x.abs() < 0.3 { Label::Colliding } else { Label::Free };
/// let labels: Vec<Label> = features.iter().map(label).collect();
/// let classifier = Classifier::fit(&features, 1, &labels, &FitOptions::default());
/// assert!(classifier.decision(&[0.0]) < 0.0 && classifier.decision(&[0.8]) > 0.0);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Classifier {
    standardization: Standardization,
    support: WeightedPoints,
    bias: f64,
    gamma: f64,
    choice: Hyperparameters,
}

/// Final state of training, from which it can continue after points are appended.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trained {
    /// Dual variables of all points.
    pub duals: Vec<f64>,
    /// Number of steps that training took.
    pub steps: u64,
    /// Most memory that the kernel rows took \[bytes\].
    pub cached: usize,
}

impl Classifier {
    /// Fits a classifier to `features` (`n x dimensions`, row major) and one label a row. If all
    /// labels are equal, it predicts that label.
    ///
    /// # Cost
    /// About 0.1 s for 5,000 points of 14 dimensions, plus 0.2 to 1 s for the search of gamma and
    /// penalty. The search does not grow with the set beyond `search_points`. Hard sets with a
    /// large penalty take longest.
    pub fn fit(features: &[f64], dimensions: usize, labels: &[Label], options: &FitOptions) -> Self {
        Self::fit_from(features, dimensions, labels, options, &[]).0
    }

    /// Does the same as [`Classifier::fit`], starting from the dual variables `warm` of the first
    /// points. Also returns the final state; pass on its dual variables after appending points.
    pub fn fit_from(
        features: &[f64],
        dimensions: usize,
        labels: &[Label],
        options: &FitOptions,
        warm: &[f64],
    ) -> (Self, Trained) {
        assert_eq!(features.len(), dimensions * labels.len(), "one row of {dimensions} features a label");
        let standardization = Standardization::fit(features, dimensions, options.scaling);
        let points = PointSet::from_rows(&standardization.apply_all(features), standardization.kept());
        let free: Vec<bool> = labels.iter().map(|label| *label == Label::Free).collect();
        let spread = model_selection::median_squared_distance(&points, options.seed);
        let choice = model_selection::choose(&points, &free, spread, options);
        let solved = svm_options(&free, spread, choice, options);
        let solution = train(&points, &free, &solved, Some(warm).filter(|warm| !warm.is_empty()));
        let support: Vec<u32> = (0..free.len() as u32).filter(|i| solution.alphas[*i as usize] > 0.0).collect();
        let signed = |i: &u32| if free[*i as usize] { 1.0 } else { -1.0 } * solution.alphas[*i as usize];
        let weights: Vec<f64> = support.iter().map(signed).collect();
        let classifier = Self {
            standardization,
            support: WeightedPoints::new(points.gather(&support), &weights),
            bias: solution.bias,
            gamma: solved.gamma,
            choice,
        };
        (classifier, Trained { duals: solution.alphas, steps: solution.iterations, cached: solution.cached })
    }

    /// Whether a classifier read from bytes is consistent and takes `dimensions` features.
    pub(super) fn is_sound(&self, dimensions: usize) -> bool {
        let Self { standardization, support, bias, gamma, choice } = self;
        let numbers = [*bias, *gamma, choice.gamma_factor, choice.penalty];
        standardization.is_sound(dimensions)
            && support.is_sound()
            && support.points().dimensions() == standardization.kept()
            && numbers.iter().all(|x| x.is_finite())
            && *gamma >= 0.0
    }

    /// Returns the decision value: positive if predicted free, 0 at the predicted boundary, about
    /// +1 and -1 at the margins.
    pub fn decision(&self, features: &[f64]) -> f64 {
        let (mut stack, mut heap) = ([0.0; STACK_DIMENSIONS], Vec::new());
        let kept = self.standardization.kept();
        let query = if kept <= STACK_DIMENSIONS {
            &mut stack[..kept]
        } else {
            heap.resize(kept, 0.0);
            &mut heap[..]
        };
        self.standardization.apply(features, query);
        self.support.kernel_sum(query, self.gamma) + self.bias
    }

    /// The label that [`Classifier::decision`] predicts.
    pub fn predict(&self, features: &[f64]) -> Label {
        if self.decision(features) > 0.0 { Label::Free } else { Label::Colliding }
    }

    /// Returns shares of free and of colliding rows predicted correctly; 1 for a label without
    /// rows.
    pub fn balanced_accuracy(&self, features: &[f64], labels: &[Label]) -> (f64, f64) {
        let rows = features.par_chunks_exact(self.standardization.dimensions()).zip(labels);
        let counts = rows
            .map(|(row, label)| {
                let right = usize::from(self.predict(row) == *label);
                if *label == Label::Free { [right, 1, 0, 0] } else { [0, 0, right, 1] }
            })
            .reduce(|| [0; 4], |a, b| std::array::from_fn(|i| a[i] + b[i]));
        let share = |right: usize, all: usize| if all == 0 { 1.0 } else { right as f64 / all as f64 };
        (share(counts[0], counts[1]), share(counts[2], counts[3]))
    }

    /// Number of support vectors; the cost of a decision is proportional to it.
    pub fn support_vectors(&self) -> usize {
        self.support.points().len()
    }

    /// The kernel width and penalty that were used; pass them in [`FitOptions`] to fit again
    /// without a search.
    pub fn choice(&self) -> Hyperparameters {
        self.choice
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn annulus(n: usize, seed: u64) -> (Vec<f64>, Vec<Label>) {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let (mut features, mut labels) = (Vec::new(), Vec::new());
        for _ in 0..n {
            let (x, y) = (4.0 * rng.random::<f64>() - 2.0, 4.0 * rng.random::<f64>() - 2.0);
            features.extend([x, 7.0, y]); // the constant must not matter
            let inside = (0.7..1.4).contains(&f64::hypot(x, y));
            labels.push(if inside { Label::Colliding } else { Label::Free });
        }
        (features, labels)
    }

    #[test]
    fn learns_an_annulus() {
        let (features, labels) = annulus(1500, 1);
        let classifier = Classifier::fit(&features, 3, &labels, &FitOptions::default());
        let (held_out, truth) = annulus(4000, 2);
        let (free, colliding) = classifier.balanced_accuracy(&held_out, &truth);
        assert!(free > 0.97 && colliding > 0.97, "{free} {colliding}");
        assert!(classifier.support_vectors() < 500);
    }

    #[test]
    fn does_not_depend_on_the_number_of_threads() {
        let (features, labels) = annulus(600, 3);
        let fit = || Classifier::fit(&features, 3, &labels, &FitOptions::default());
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        assert_eq!(pool(1).install(fit), pool(4).install(fit));
    }

    #[test]
    fn warm_start_reaches_the_same_classifier() {
        let (features, labels) = annulus(800, 4);
        let options =
            FitOptions { gamma_factor: Some(4.0), penalty: Some(100.0), tolerance: 1e-4, ..FitOptions::default() };
        let (_, before) = Classifier::fit_from(&features[..3 * 700], 3, &labels[..700], &options, &[]);
        let (warm, trained) = Classifier::fit_from(&features, 3, &labels, &options, &before.duals);
        let cold = Classifier::fit(&features, 3, &labels, &options);
        let (_, again) = Classifier::fit_from(&features, 3, &labels, &options, &trained.duals);
        assert!(10 * again.steps <= trained.steps, "{} steps from the solution, {} before", again.steps, trained.steps);
        for row in annulus(200, 5).0.chunks_exact(3) {
            let (a, b) = (warm.decision(row), cold.decision(row));
            assert!((a - b).abs() < 0.01 * (1.0 + b.abs()), "{a} {b}");
        }
    }

    #[test]
    fn one_class_or_no_point_is_no_failure() {
        let options = FitOptions::default();
        assert!(Classifier::fit(&[0.0, 1.0, 2.0], 1, &[Label::Free; 3], &options).decision(&[5.0]) > 0.0);
        assert!(Classifier::fit(&[0.0, 1.0, 2.0], 1, &[Label::Colliding; 3], &options).decision(&[5.0]) < 0.0);
        assert_eq!(Classifier::fit(&[], 1, &[], &options).decision(&[5.0]), 0.0);
        let contradiction = Classifier::fit(&[1.0, 1.0], 1, &[Label::Free, Label::Colliding], &options);
        assert!(contradiction.decision(&[1.0]).abs() < 1e-6);
    }

    #[test]
    fn survives_serialisation() {
        let (features, labels) = annulus(300, 6);
        let classifier = Classifier::fit(&features, 3, &labels, &FitOptions::default());
        let bytes = postcard::to_stdvec(&classifier).unwrap();
        assert_eq!(postcard::from_bytes::<Classifier>(&bytes).unwrap(), classifier);
    }
}

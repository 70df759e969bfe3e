//! A classifier of the obstacle region as a union of parts, with one SVM per part. A configuration
//! is predicted to collide if any SVM predicts so.
//!
//! A part is the set of configurations at which one pair of bodies collides. It depends on their
//! relative pose alone: fewer numbers, fewer joints and a smoother boundary than the whole region,
//! whose creases are where parts meet.

use std::collections::HashSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::svm::{Classifier, FitOptions, Trained};
use crate::cspace::{ConfigSpace, Label};

/// The obstacle region as a union of parts; learning sees nothing else of the bodies.
pub struct Parts<'a> {
    /// Number of parts of the region.
    pub count: usize,
    /// Number of coordinates of a configuration.
    pub nq: usize,
    /// Returns the parts that each configuration (row major) lies in, ascending; none for a free
    /// one. Each configuration costs an exact check.
    pub containing: &'a (dyn Fn(&[f64]) -> Vec<Vec<u32>> + Sync),
    /// Returns the [`Parts::width`] features of each given part at each configuration (row major),
    /// configuration after configuration.
    pub features: &'a Features<'a>,
    /// Number of features of one part.
    pub width: usize,
}

/// Maps configurations (row major) and parts to the features that the kernels see.
pub type Features<'a> = dyn Fn(&[f64], &[u32]) -> Vec<f64> + Sync + 'a;

/// One SVM for each part that some training configuration lies in.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleClassifier {
    /// Sorted by how often the parts were seen, most often first.
    svms: Vec<PairSvm>,
}

/// The support vector machine of one part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairSvm {
    /// Index of the part.
    pub part: u32,
    /// Classifies features of the part.
    pub classifier: Classifier,
    /// Configurations of the support vectors, row major, in the same order.
    pub support: Vec<f64>,
    /// Start of further training, if configurations are appended.
    #[serde(skip)]
    trained: Trained,
}

/// Configurations whose features are computed together.
const CONFIGS_PER_CHUNK: usize = 64;
/// Soft-margin penalty `C`, large because exact labels have no noise. For seven joints before a
/// box, 100 to 10,000 learn equally well; smaller values train faster.
const PENALTY: f64 = 300.0;
/// Kernel widths that are tried: three joints need a narrow kernel, seven a wide one.
const GAMMA_FACTORS: [f64; 3] = [1.0, 3.0, 10.0];

impl ObstacleClassifier {
    /// Fits one SVM for every part that some configuration lies in; `inside[i]` holds the parts of
    /// row `i` of `configs`.
    ///
    /// Each SVM separates its part from the free configurations. It ignores configurations in other
    /// parts alone, since it may call them either. Labels are weighted inversely to their shares in
    /// the whole set. All SVMs share one kernel width, relative to the spread of their features. If
    /// `options` give none, several are fitted to one half of the configurations and judged by the
    /// other.
    ///
    /// `last` may be a classifier fitted to the first of these configurations: its kernel width is
    /// kept, and training continues from its solution.
    ///
    /// # Guarantee
    /// The result depends on the arguments alone, not on the number of threads.
    pub fn fit(parts: &Parts, configs: &[f64], inside: &[Vec<u32>], options: &FitOptions, last: Option<&Self>) -> Self {
        assert_eq!(configs.len(), inside.len() * parts.nq, "one list of parts a configuration");
        let kept = last.and_then(|last| last.svms.first()).map(|svm| svm.classifier.choice().gamma_factor);
        let gamma_factor = kept.or(options.gamma_factor).unwrap_or_else(|| choose(parts, configs, inside, options));
        Self::fit_width(parts, configs, inside, options, last, gamma_factor)
    }

    fn fit_width(
        parts: &Parts,
        configs: &[f64],
        inside: &[Vec<u32>],
        options: &FitOptions,
        last: Option<&Self>,
        gamma_factor: f64,
    ) -> Self {
        let mut counts = vec![0usize; parts.count];
        inside.iter().flatten().for_each(|part| counts[*part as usize] += 1);
        let mut order: Vec<u32> = (0..parts.count as u32).filter(|part| counts[*part as usize] > 0).collect();
        order.sort_by_key(|part| (std::cmp::Reverse(counts[*part as usize]), *part));
        let free = inside.iter().filter(|parts| parts.is_empty()).count();
        let weight = |count: usize| inside.len() as f64 / (2.0 * count.max(1) as f64);
        let options = FitOptions {
            gamma_factor: Some(gamma_factor),
            penalty: options.penalty.or(Some(PENALTY)),
            weights: Some([weight(free), weight(inside.len() - free)]),
            ..options.shared_out()
        };
        let fit = |part: &u32| {
            let rows = configs.chunks_exact(parts.nq).zip(inside);
            let (mut configs, mut labels) = (Vec::new(), Vec::new());
            for (q, inside) in rows.filter(|(_, inside)| inside.is_empty() || inside.contains(part)) {
                configs.extend_from_slice(q);
                labels.push(if inside.is_empty() { Label::Free } else { Label::Colliding });
            }
            let features: Vec<f64> = configs
                .chunks(CONFIGS_PER_CHUNK * parts.nq)
                .flat_map(|rows| (parts.features)(rows, &[*part]))
                .collect();
            let before = last.and_then(|last| last.svms.iter().find(|svm| svm.part == *part));
            let warm = before.map_or(&[][..], |before| &before.trained.duals);
            let (classifier, trained) = Classifier::fit_from(&features, parts.width, &labels, &options, warm);
            let supports = configs.chunks_exact(parts.nq).zip(&trained.duals).filter(|(_, dual)| **dual > 0.0);
            let support = supports.flat_map(|(q, _)| q.iter().copied()).collect();
            PairSvm { part: *part, classifier, support, trained }
        };
        // One SVM per task: the largest come first, so tasks of equal numbers would be unbalanced.
        Self { svms: order.par_iter().with_max_len(1).map(fit).collect() }
    }

    /// Checks that a classifier read from bytes fits `space` and `parts` parts of `width` features.
    ///
    /// # Errors
    /// The SVM at fault, its value, and what was expected.
    pub fn check(&self, space: &ConfigSpace, parts: usize, width: usize) -> Result<(), String> {
        let mut seen = HashSet::new();
        for (number, svm) in self.svms.iter().enumerate() {
            let fault = |problem: String| Err(format!("svm {number}: {problem}"));
            if svm.part as usize >= parts || !seen.insert(svm.part) {
                return fault(format!("got the part {}, expected one of {parts}, each once", svm.part));
            }
            if !svm.classifier.is_sound(width) {
                return fault(format!(
                    "got lengths or numbers that do not fit, expected finite ones of {width} features"
                ));
            }
            let (found, expected) = (svm.support.len() / space.nq(), svm.classifier.support_vectors());
            if found != expected {
                return fault(format!(
                    "got {found} configurations, expected one of each of {expected} support vectors"
                ));
            }
            space.check_rows(&svm.support).or_else(fault)?;
        }
        Ok(())
    }

    /// Drops what only further training needs.
    pub fn without_duals(mut self) -> Self {
        self.svms.iter_mut().for_each(|svm| svm.trained = Trained::default());
        self
    }

    /// The SVMs, that of the most frequent part first.
    pub fn svms(&self) -> &[PairSvm] {
        &self.svms
    }

    /// Number of support vectors of all SVMs; the cost of a decision is proportional to it.
    pub fn support_vectors(&self) -> usize {
        self.svms.iter().map(|svm| svm.classifier.support_vectors()).sum()
    }

    /// Returns the least decision of any SVM at each configuration (row major). It is positive if
    /// predicted free, about 0 at the predicted boundary, and infinite if there is no SVM.
    pub fn decisions(&self, nq: usize, features: &Features, configs: &[f64]) -> Vec<f64> {
        self.least(nq, features, configs, f64::NEG_INFINITY)
    }

    /// Returns the predicted label of each configuration (row major).
    pub fn predictions(&self, nq: usize, features: &Features, configs: &[f64]) -> Vec<Label> {
        let of = |least: f64| if least > 0.0 { Label::Free } else { Label::Colliding };
        self.least(nq, features, configs, 0.0).into_iter().map(of).collect()
    }

    /// Returns the least decision of each configuration, or the first that is at most `enough`.
    fn least(&self, nq: usize, features: &Features, configs: &[f64], enough: f64) -> Vec<f64> {
        let parts: Vec<u32> = self.svms.iter().map(|svm| svm.part).collect();
        if parts.is_empty() {
            return vec![f64::INFINITY; configs.len() / nq];
        }
        let of_row = |row: &[f64]| {
            let mut least = f64::INFINITY;
            for (svm, features) in self.svms.iter().zip(row.chunks_exact(row.len() / parts.len())) {
                least = least.min(svm.classifier.decision(features));
                if least <= enough {
                    break;
                }
            }
            least
        };
        let of_chunk = |configs: &[f64]| {
            let features = features(configs, &parts);
            features.chunks_exact(features.len() / (configs.len() / nq)).map(of_row).collect::<Vec<f64>>()
        };
        configs.par_chunks(CONFIGS_PER_CHUNK * nq).map(of_chunk).collect::<Vec<_>>().concat()
    }

    /// Returns the shares of the free and of the colliding configurations (row major) that are
    /// predicted correctly; `None` for a label that does not occur.
    pub fn accuracy(&self, nq: usize, features: &Features, configs: &[f64], labels: &[Label]) -> [Option<f64>; 2] {
        let (mut right, mut all) = ([0usize; 2], [0usize; 2]);
        for (predicted, label) in self.predictions(nq, features, configs).into_iter().zip(labels) {
            let side = usize::from(*label == Label::Colliding);
            all[side] += 1;
            right[side] += usize::from(predicted == *label);
        }
        std::array::from_fn(|side| (all[side] > 0).then(|| right[side] as f64 / all[side] as f64))
    }
}

/// Chooses the kernel width. SVMs are fitted to every other configuration and judged by those
/// between, both labels counting equally; ties go to the widest kernel. Large sets are thinned to
/// about `search_points` for training.
fn choose(parts: &Parts, configs: &[f64], inside: &[Vec<u32>], options: &FitOptions) -> f64 {
    let step = inside.len().div_ceil(2 * options.search_points.max(1)).max(1);
    let every_other = |offset: usize| {
        let rows = configs.chunks_exact(parts.nq).zip(inside).skip(offset).step_by(2 * step);
        let (configs, inside): (Vec<&[f64]>, Vec<Vec<u32>>) = rows.map(|(q, inside)| (q, inside.clone())).unzip();
        (configs.concat(), inside)
    };
    let ((seen, seen_inside), (held, held_inside)) = (every_other(0), every_other(step));
    let side = |inside: &Vec<u32>| if inside.is_empty() { Label::Free } else { Label::Colliding };
    let labels: Vec<Label> = held_inside.iter().map(side).collect();
    let right = |gamma_factor: &f64| -> f64 {
        let union = ObstacleClassifier::fit_width(parts, &seen, &seen_inside, options, None, *gamma_factor);
        union.accuracy(parts.nq, parts.features, &held, &labels).into_iter().flatten().sum()
    };
    // All widths run at once, because the last SVMs of a single width would leave threads idle.
    let of_each: Vec<f64> = GAMMA_FACTORS.par_iter().with_max_len(1).map(right).collect();
    let best = (1..GAMMA_FACTORS.len()).fold(0, |best, i| if of_each[i] > of_each[best] { i } else { best });
    GAMMA_FACTORS[best]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Discs in a square; the last one lies outside of it.
    const DISCS: [[f64; 3]; 4] = [[-0.5, 0.0, 0.7], [0.5, 0.2, 0.6], [1.5, -1.5, 0.15], [9.0, 9.0, 1.0]];

    fn offsets(configs: &[f64], parts: &[u32]) -> Vec<f64> {
        let of = |q: &[f64], part: &u32| [q[0] - DISCS[*part as usize][0], q[1] - DISCS[*part as usize][1]];
        configs
            .chunks_exact(2)
            .flat_map(|q| parts.iter().flat_map(move |part| of(q, part)).collect::<Vec<_>>())
            .collect()
    }

    fn containing(configs: &[f64]) -> Vec<Vec<u32>> {
        let inside = |q: &[f64], part: &u32| {
            let [x, y, radius] = DISCS[*part as usize];
            f64::hypot(q[0] - x, q[1] - y) < radius
        };
        configs.chunks_exact(2).map(|q| (0..4).filter(|part| inside(q, part)).collect()).collect()
    }

    const PARTS: Parts = Parts { count: 4, nq: 2, containing: &containing, features: &offsets, width: 2 };

    fn points(n: usize, seed: u64) -> Vec<f64> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..2 * n).map(|_| 4.0 * rng.random::<f64>() - 2.0).collect()
    }

    fn fitted(n: usize) -> ObstacleClassifier {
        let configs = points(n, 1);
        ObstacleClassifier::fit(&PARTS, &configs, &containing(&configs), &FitOptions::default(), None)
    }

    #[test]
    fn learns_discs_that_overlap_and_a_rare_one() {
        let classifier = fitted(2000);
        let parts: Vec<u32> = classifier.svms().iter().map(|svm| svm.part).collect();
        assert_eq!(parts, [0, 1, 2], "most frequent first, none for what was never seen");
        let held = points(5000, 2);
        let inside = containing(&held);
        let labels: Vec<Label> =
            inside.iter().map(|parts| if parts.is_empty() { Label::Free } else { Label::Colliding }).collect();
        let [free, colliding] = classifier.accuracy(2, &offsets, &held, &labels).map(Option::unwrap);
        assert!(free > 0.97 && colliding > 0.97, "{free} {colliding}");
        let in_rare = held.chunks_exact(2).zip(&inside).filter(|(_, inside)| inside.contains(&2)).flat_map(|(q, _)| q);
        let rare = classifier.predictions(2, &offsets, &in_rare.copied().collect::<Vec<f64>>());
        let found = rare.iter().filter(|label| **label == Label::Colliding).count();
        assert!(found * 10 > rare.len() * 8 && rare.len() > 10, "{found} of {}", rare.len());
        let decisions = classifier.decisions(2, &offsets, &held);
        let predictions = classifier.predictions(2, &offsets, &held);
        assert!(decisions.iter().zip(&predictions).all(|(d, label)| (*d > 0.0) == (*label == Label::Free)));
    }

    #[test]
    fn support_vectors_are_kept_as_configurations_too() {
        let classifier = fitted(600);
        let all = points(600, 1);
        for svm in classifier.svms() {
            assert_eq!(svm.support.len(), 2 * svm.classifier.support_vectors());
            let known = |q: &[f64]| all.chunks_exact(2).any(|other| other == q);
            assert!(svm.support.chunks_exact(2).all(known));
        }
        let sum: usize = classifier.svms().iter().map(|svm| svm.support.len() / 2).sum();
        assert_eq!(classifier.support_vectors(), sum);
    }

    #[test]
    fn neither_threads_nor_a_warm_start_decide() {
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let cold = pool(1).install(|| fitted(900));
        assert_eq!(cold, pool(4).install(|| fitted(900)));
        let configs = points(900, 1);
        let options = FitOptions { tolerance: 1e-4, ..FitOptions::default() };
        let fit = |rows: usize, last: Option<&ObstacleClassifier>| {
            ObstacleClassifier::fit(&PARTS, &configs[..2 * rows], &containing(&configs[..2 * rows]), &options, last)
        };
        let warm = fit(900, Some(&fit(800, None)));
        let steps = |fitted: &ObstacleClassifier| fitted.svms.iter().map(|svm| svm.trained.steps).sum::<u64>();
        let again = fit(900, Some(&warm));
        assert!(
            10 * steps(&again) <= steps(&warm),
            "{} steps from the solution, {} before",
            steps(&again),
            steps(&warm)
        );
        let held = points(500, 5);
        let (a, b) = (cold.predictions(2, &offsets, &held), warm.predictions(2, &offsets, &held));
        let same = a.iter().zip(&b).filter(|(a, b)| a == b).count();
        assert!(same > 490, "{same} of 500");
    }

    #[test]
    fn kernel_rows_of_all_threads_keep_to_their_memory_and_change_nothing() {
        let (configs, threads) = (points(2000, 1), 4);
        let inside = containing(&configs);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let fit = |cache_bytes: usize| {
            let options = FitOptions { cache_bytes, ..FitOptions::default() };
            pool.install(|| ObstacleClassifier::fit(&PARTS, &configs, &inside, &options, None))
        };
        // A thread trains one SVM at a time, so it holds at most the rows of the largest.
        let held = |fitted: &ObstacleClassifier| fitted.svms.iter().map(|svm| svm.trained.cached).max().unwrap();
        let (roomy, limit) = (fit(1 << 30), 256 << 10);
        let tight = fit(limit);
        assert!(held(&roomy) > limit / threads, "{} bytes are not enough to tell", held(&roomy));
        assert!(threads * held(&tight) <= limit, "{} of {limit}", threads * held(&tight));
        assert_eq!(roomy.without_duals(), tight.without_duals());
    }

    #[test]
    fn a_classifier_survives_serialisation() {
        let classifier = fitted(600).without_duals();
        let bytes = postcard::to_stdvec(&classifier).unwrap();
        assert_eq!(postcard::from_bytes::<ObstacleClassifier>(&bytes).unwrap(), classifier);
    }
}

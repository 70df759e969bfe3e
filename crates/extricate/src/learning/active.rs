//! Active learning of the classifier: which labelled configurations it is trained on, and which are labelled for it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::classifier::{Classifier, FitOptions};
use super::explore::Exploration;
use super::{Budget, LabelBatch, LearnOptions};
use crate::cspace::{ConfigSpace, Label};

/// Maps a configuration to the features that the kernel sees.
pub type Features<'a> = dyn Fn(&[f64]) -> Vec<f64> + Sync + 'a;

/// The classifier and how good it is on configurations it was not trained on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Classified {
    /// The classifier; `None` where only one label was ever seen.
    pub classifier: Option<Classifier>,
    /// Held-out accuracy on free configurations, in `[0, 1]`; `None` where none was held out.
    pub accuracy_free: Option<f64>,
    /// Held-out accuracy on colliding configurations.
    pub accuracy_colliding: Option<f64>,
    /// Free and colliding configurations that were held out.
    pub held_out: [usize; 2],
}

impl Classified {
    /// Mean of both accuracies; `None` where one was not measured.
    pub fn balanced_accuracy(&self) -> Option<f64> {
        Some(0.5 * (self.accuracy_free? + self.accuracy_colliding?))
    }

    /// Whether classifier and labels disagree on at most the share `target` of what was held out, each side counting half.
    pub fn is_within(&self, target: f64) -> bool {
        self.balanced_accuracy().is_some_and(|accuracy| 1.0 - accuracy <= target)
    }
}

/// Rounds of training.
const ROUNDS: usize = 3;
/// The same where a disagreement is asked for that takes more.
const MOST_ROUNDS: usize = 8;
/// Configurations of the first round, half of each label where there are so many.
const FIRST: usize = 2000;
/// With less time than this \[s\] the first round is smaller, in proportion: nothing stops a fit that has begun.
const TIME_FOR_FIRST: f64 = 10.0;
/// Share of the budget after which no round begins, so that most of it is left for the boundary.
const TRAINED_BY: f64 = 0.4;
/// Configurations that each later round adds.
const ADDED: usize = 1000;
/// Held out of every training set, of each label.
const HELD_OUT: usize = 1000;
/// Configurations looked at for the most doubtful ones.
const POOL: usize = 8000;

struct Set {
    features: Vec<f64>,
    labels: Vec<Label>,
}

/// Trains on the exploration's configurations: a balanced start, then rounds that add those which the classifier gets wrong or is
/// least sure of (exploration), and new ones between nearby training points of opposite label (exploitation).
///
/// New labels are added to `known`. The held-out configurations are uniform in space and never trained on.
pub fn classify(
    space: &ConfigSpace,
    features: &Features,
    known: &mut Exploration,
    label: &LabelBatch,
    options: &LearnOptions,
    budget: &mut Budget,
) -> Classified {
    let nq = space.nq();
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let (free, colliding) = (rows(&known.free, nq), rows(&known.colliding, nq));
    let mut outcome = Classified::default();
    if free.is_empty() || colliding.is_empty() || budget.end().is_some() {
        return outcome;
    }
    // The last fifth of each list, at most HELD_OUT, is held out.
    let split = |n: usize| n - (n / 5).min(HELD_OUT);
    let (held_free, held_colliding) = (&free[split(free.len())..], &colliding[split(colliding.len())..]);
    let held = gather(held_free.iter().map(|q| (*q, Label::Free)), features)
        .join(gather(held_colliding.iter().map(|q| (*q, Label::Colliding)), features));
    let (free, colliding) = (&free[..split(free.len())], &colliding[..split(colliding.len())]);
    let share_of_first = budget.seconds().map_or(1.0, |limit| (limit / TIME_FOR_FIRST).clamp(0.1, 1.0));
    let first = (FIRST as f64 * share_of_first) as usize / 2;
    let mut configs: Vec<(Vec<f64>, Label)> = Vec::new();
    configs.extend(free.iter().take(first).map(|q| (q.to_vec(), Label::Free)));
    configs.extend(colliding.iter().take(first).map(|q| (q.to_vec(), Label::Colliding)));
    let mut pool: Vec<(&[f64], Label)> = Vec::new();
    pool.extend(free.iter().skip(first).take(POOL / 2).map(|q| (*q, Label::Free)));
    pool.extend(colliding.iter().skip(first).take(POOL / 2).map(|q| (*q, Label::Colliding)));
    let mut pool_set = gather(pool.iter().copied(), features);
    let mut fresh: Vec<(Vec<f64>, Label)> = Vec::new();
    for round in 0..MOST_ROUNDS {
        let set = gather(configs.iter().map(|(q, l)| (q.as_slice(), *l)), features);
        let dimensions = set.features.len() / set.labels.len();
        // Only the first round searches the kernel's parameters; the later ones keep them.
        let fit = match &outcome.classifier {
            None => FitOptions::default(),
            Some(last) => FitOptions {
                gamma_factor: Some(last.choice().gamma_factor),
                penalty: Some(last.choice().penalty),
                ..FitOptions::default()
            },
        };
        let classifier = Classifier::fit(&set.features, dimensions, &set.labels, &fit);
        let (free, colliding) = classifier.balanced_accuracy(&held.features, &held.labels);
        outcome.held_out = [held_free.len(), held_colliding.len()];
        outcome.accuracy_free = (!held_free.is_empty()).then_some(free);
        outcome.accuracy_colliding = (!held_colliding.is_empty()).then_some(colliding);
        budget.note(0, Some(0.5 * (free + colliding)));
        // Asks for the time too, which a long fit may have used up.
        budget.stage("training");
        let enough = match options.target_disagreement {
            Some(target) => outcome.is_within(target) || round + 1 == MOST_ROUNDS,
            None => round + 1 == ROUNDS,
        };
        if enough || budget.end().is_some() || budget.fraction() > TRAINED_BY {
            outcome.classifier = Some(classifier);
            break;
        }
        let doubtful = most_doubtful(&classifier, &pool_set, ADDED / 2);
        configs.extend(doubtful.iter().map(|i| (pool[*i].0.to_vec(), pool[*i].1)));
        remove(&mut pool, &mut pool_set, &doubtful);
        let between = between_opposites(space, &configs, (ADDED / 2).min(budget.left() / 4), &mut rng);
        let labels = budget.label(label, &between);
        let new = || between.chunks_exact(nq).map(<[f64]>::to_vec).zip(labels.iter().copied());
        configs.extend(new());
        fresh.extend(new());
        outcome.classifier = Some(classifier);
    }
    for (q, label) in fresh {
        match label {
            Label::Free => known.free.extend(q),
            Label::Colliding => known.colliding.extend(q),
        }
    }
    outcome
}

/// Moves those of the first `count` colliding configurations that the classifier calls free to the front: small components
/// hide among them.
pub fn surprising_first(classifier: &Classifier, features: &Features, nq: usize, count: usize, colliding: &mut [f64]) {
    let count = count.min(colliding.len() / nq);
    let colliding = &mut colliding[..count * nq];
    let decisions: Vec<f64> = colliding.par_chunks_exact(nq).map(|q| classifier.decision(&features(q))).collect();
    let (mut front, mut back) = (Vec::new(), Vec::with_capacity(colliding.len()));
    for (q, decision) in colliding.chunks_exact(nq).zip(decisions) {
        if decision > 0.0 { front.extend_from_slice(q) } else { back.extend_from_slice(q) }
    }
    front.extend(back);
    colliding.copy_from_slice(&front);
}

impl Set {
    fn join(mut self, other: Set) -> Set {
        self.features.extend(other.features);
        self.labels.extend(other.labels);
        self
    }
}

fn rows(configs: &[f64], nq: usize) -> Vec<&[f64]> {
    configs.chunks_exact(nq).collect()
}

fn gather<'a>(rows: impl Iterator<Item = (&'a [f64], Label)>, features: &Features) -> Set {
    let rows: Vec<(&[f64], Label)> = rows.collect();
    let all: Vec<Vec<f64>> = rows.par_iter().map(|(q, _)| features(q)).collect();
    Set { features: all.concat(), labels: rows.iter().map(|(_, l)| *l).collect() }
}

/// Indices of the configurations that are misclassified or nearest to the decision boundary.
fn most_doubtful(classifier: &Classifier, set: &Set, count: usize) -> Vec<usize> {
    if set.labels.is_empty() {
        return Vec::new();
    }
    let dimensions = set.features.len() / set.labels.len();
    let mut order: Vec<(f64, usize)> = set
        .features
        .par_chunks_exact(dimensions)
        .zip(&set.labels)
        .map(|(x, label)| classifier.decision(x) * if *label == Label::Free { 1.0 } else { -1.0 })
        .collect::<Vec<f64>>()
        .into_iter()
        .enumerate()
        .map(|(i, margin)| (margin, i))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.truncate(count);
    order.into_iter().map(|(_, i)| i).collect()
}

fn remove(pool: &mut Vec<(&[f64], Label)>, set: &mut Set, taken: &[usize]) {
    let dimensions = set.features.len() / set.labels.len().max(1);
    let mut keep = vec![true; pool.len()];
    taken.iter().for_each(|i| keep[*i] = false);
    let mut at = keep.iter();
    pool.retain(|_| *at.next().unwrap_or(&true));
    let mut at = keep.iter();
    set.labels.retain(|_| *at.next().unwrap_or(&true));
    let kept = set.features.chunks_exact(dimensions.max(1)).zip(&keep).filter(|(_, k)| **k);
    set.features = kept.flat_map(|(x, _)| x.iter().copied()).collect();
}

/// Midpoints of random training points and the nearest one of opposite label, row major.
fn between_opposites(
    space: &ConfigSpace,
    configs: &[(Vec<f64>, Label)],
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let picks: Vec<usize> = (0..count).map(|_| rng.random_range(0..configs.len())).collect();
    let middle = |&pick: &usize| {
        let (q, label) = &configs[pick];
        let opposite = configs
            .iter()
            .filter(|(_, other)| other != label)
            .map(|(other, _)| (space.distance_squared(q, other), other))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let mut out = q.clone();
        if let Some((_, other)) = opposite {
            space.interpolate(q, other, 0.5, &mut out);
        }
        out
    };
    picks.par_iter().map(middle).collect::<Vec<_>>().concat()
}

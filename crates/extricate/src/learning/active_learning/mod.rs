//! Active learning: chooses known configurations to train the classifier on, and new ones to label.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Budget;
use super::exploration::Exploration;
use super::obstacle_classifier::{Features, ObstacleClassifier, Parts};
use super::svm::FitOptions;
use crate::cspace::sampling::uniform;
use crate::cspace::{ConfigSpace, Label};

/// A classifier, with its accuracy on configurations that it was not trained on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Classified {
    /// `None` if only one label was seen, or if the budget had ended before training.
    pub classifier: Option<ObstacleClassifier>,
    /// Held-out accuracy on free configurations, in `[0, 1]`; `None` if none was held out.
    pub accuracy_free: Option<f64>,
    /// Held-out accuracy on colliding configurations, in `[0, 1]`.
    pub accuracy_colliding: Option<f64>,
    /// Numbers of free and of colliding configurations that were held out.
    pub held_out: [usize; 2],
}

impl Classified {
    /// Mean of both accuracies; `None` unless both were measured.
    pub fn balanced_accuracy(&self) -> Option<f64> {
        Some(0.5 * (self.accuracy_free? + self.accuracy_colliding?))
    }
}

const TRAINING_ROUNDS: usize = 3;
/// Configurations of the first round, half of each label if there are that many.
const FIRST_ROUND_CONFIGS: usize = 4000;
/// With a smaller limit \[s\] the first round shrinks in proportion: a fit cannot be interrupted.
const FULL_FIRST_ROUND_S: f64 = 10.0;
/// Share of the budget after which no round begins, so that most is left for the boundary.
const MAX_TRAINING_SHARE: f64 = 0.4;
/// Most configurations that a later round adds.
const ADDED_PER_ROUND: usize = 2000;
/// Most configurations of each label that are held out of training.
const MAX_HELD_OUT: usize = 1000;
/// Candidates evaluated for each configuration that is added.
const CANDIDATES_PER_ADDED: usize = 4;

/// Trains on explored configurations, then in rounds also on those that the classifier gets wrong
/// or is least sure of. They come from the known configurations, or are drawn anew if few are left.
///
/// New labels are added to `known`. Finding the parts that a colliding configuration lies in costs
/// a check, which is counted. The held-out configurations are never trained on.
pub fn classify(
    space: &ConfigSpace,
    parts: &Parts,
    known: &mut Exploration,
    seed: u64,
    budget: &mut Budget,
) -> Classified {
    let nq = space.nq();
    let mut outcome = Classified::default();
    if known.free.is_empty() || known.colliding.is_empty() || budget.end().is_some() {
        return outcome;
    }
    // Holds out the last fifth of each list, at most MAX_HELD_OUT rows.
    let split = |list: &[f64]| (list.len() / nq - (list.len() / nq / 5).min(MAX_HELD_OUT)) * nq;
    let ((free, held_free), (colliding, held_colliding)) =
        (known.free.split_at(split(&known.free)), known.colliding.split_at(split(&known.colliding)));
    let held = [held_free, held_colliding].concat();
    outcome.held_out = [held_free.len() / nq, held_colliding.len() / nq];
    let held_labels = [vec![Label::Free; outcome.held_out[0]], vec![Label::Colliding; outcome.held_out[1]]].concat();
    let share_of_first = budget.seconds().map_or(1.0, |limit| (limit / FULL_FIRST_ROUND_S).clamp(0.1, 1.0));
    let first = (FIRST_ROUND_CONFIGS as f64 * share_of_first) as usize;
    let of_colliding = (colliding.len() / nq).min((first / 2).max(first.saturating_sub(free.len() / nq)));
    let of_free = (free.len() / nq).min(first - of_colliding.min(first));
    let mut set = Set::default();
    set.add_known(&free[..of_free * nq], &colliding[..of_colliding * nq], parts, budget);
    let mut pool = [&free[of_free * nq..], &colliding[of_colliding * nq..]].map(<[f64]>::to_vec);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut fresh = Set::default();
    let fit_options = FitOptions::default();
    for round in 1..=TRAINING_ROUNDS {
        let classifier =
            ObstacleClassifier::fit(parts, &set.configs, &set.inside, &fit_options, outcome.classifier.as_ref());
        if classifier.svms().is_empty() {
            return Classified::default();
        }
        [outcome.accuracy_free, outcome.accuracy_colliding] =
            classifier.accuracy(nq, parts.features, &held, &held_labels);
        budget.note(0, outcome.balanced_accuracy());
        // Also reads the clock, since a long fit may have used up the time.
        budget.stage("training");
        let wanted = ADDED_PER_ROUND.min(budget.left() / 4);
        if round == TRAINING_ROUNDS || wanted == 0 || budget.end().is_some() || budget.fraction() > MAX_TRAINING_SHARE {
            outcome.classifier = Some(classifier.without_duals());
            break;
        }
        let pooled = pool.iter().map(Vec::len).sum::<usize>() / nq;
        if pooled >= CANDIDATES_PER_ADDED * wanted {
            let [free, colliding] = take_doubtful(&classifier, parts, &mut pool, wanted);
            set.add_known(&free, &colliding, parts, budget);
        } else {
            let configs = most_doubtful_of_new(&classifier, space, parts, wanted, &mut rng);
            let inside = (parts.containing)(&configs);
            budget.spend(inside.len());
            fresh.add(&configs, &inside);
            set.add(&configs, &inside);
        }
        outcome.classifier = Some(classifier);
    }
    for (q, inside) in fresh.configs.chunks_exact(nq).zip(&fresh.inside) {
        if inside.is_empty() { &mut known.free } else { &mut known.colliding }.extend_from_slice(q);
    }
    outcome
}

/// Moves colliding configurations that the classifier calls free to the front, among the first
/// `count`: small components of the obstacle region hide there.
pub fn surprising_first(
    classifier: &ObstacleClassifier,
    features: &Features,
    nq: usize,
    count: usize,
    colliding: &mut [f64],
) {
    let count = count.min(colliding.len() / nq);
    let colliding = &mut colliding[..count * nq];
    let predicted = classifier.predictions(nq, features, colliding);
    let (mut front, mut back) = (Vec::new(), Vec::with_capacity(colliding.len()));
    for (q, predicted) in colliding.chunks_exact(nq).zip(predicted) {
        if predicted == Label::Free { &mut front } else { &mut back }.extend_from_slice(q);
    }
    front.extend(back);
    colliding.copy_from_slice(&front);
}

/// Training configurations and the parts that each lies in.
#[derive(Default)]
struct Set {
    /// Row major, `nq` coordinates each.
    configs: Vec<f64>,
    inside: Vec<Vec<u32>>,
}

impl Set {
    fn add(&mut self, configs: &[f64], inside: &[Vec<u32>]) {
        self.configs.extend_from_slice(configs);
        self.inside.extend_from_slice(inside);
    }

    /// Adds configurations of known labels. Only colliding ones cost a check, to find their parts.
    fn add_known(&mut self, free: &[f64], colliding: &[f64], parts: &Parts, budget: &mut Budget) {
        self.add(free, &vec![Vec::new(); free.len() / parts.nq]);
        let colliding = &colliding[..colliding.len().min(budget.left() / 4 * parts.nq)];
        let inside = (parts.containing)(colliding);
        budget.spend(inside.len());
        self.add(colliding, &inside);
    }
}

/// Removes the `count` configurations that the classifier gets wrong or is least sure of from the
/// `pool` of free and colliding ones, and returns them.
fn take_doubtful(
    classifier: &ObstacleClassifier,
    parts: &Parts,
    pool: &mut [Vec<f64>; 2],
    count: usize,
) -> [Vec<f64>; 2] {
    let nq = parts.nq;
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (side, list) in pool.iter().enumerate() {
        let candidates = &list[..list.len().min(CANDIDATES_PER_ADDED * count * nq / 2)];
        let decisions = classifier.decisions(nq, parts.features, candidates).into_iter().enumerate();
        order.extend(decisions.map(|(i, decision)| (if side == 0 { decision } else { -decision }, side, i)));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    order.truncate(count);
    let mut taken = [Vec::new(), Vec::new()];
    let mut left = [0, 1].map(|side| vec![true; pool[side].len() / nq]);
    for (_, side, i) in order {
        taken[side].extend_from_slice(&pool[side][i * nq..(i + 1) * nq]);
        left[side][i] = false;
    }
    for (list, left) in pool.iter_mut().zip(left) {
        let rows = list.chunks_exact(nq).zip(left).filter(|(_, left)| *left);
        *list = rows.flat_map(|(q, _)| q.iter().copied()).collect();
    }
    taken
}

/// Draws [`CANDIDATES_PER_ADDED`] times `count` configurations and returns the `count` nearest to
/// the predicted boundary, row major.
fn most_doubtful_of_new(
    classifier: &ObstacleClassifier,
    space: &ConfigSpace,
    parts: &Parts,
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let nq = parts.nq;
    let mut configs = vec![0.0; CANDIDATES_PER_ADDED * count * nq];
    configs.chunks_exact_mut(nq).for_each(|q| uniform(space, rng, q));
    let decisions = classifier.decisions(nq, parts.features, &configs).into_iter().map(f64::abs);
    let mut order: Vec<(f64, usize)> = decisions.enumerate().map(|(i, doubt)| (doubt, i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.truncate(count);
    order.iter().flat_map(|(_, i)| configs[i * nq..(i + 1) * nq].iter().copied()).collect()
}

#[cfg(test)]
mod tests;

//! Active learning of the classifier: which labelled configurations it is trained on, and which are
//! labelled for it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::Budget;
use super::exploration::Exploration;
use super::obstacle_classifier::{Features, ObstacleClassifier, Parts};
use super::svm::FitOptions;
use crate::cspace::sampling::uniform;
use crate::cspace::{ConfigSpace, Label};

/// The classifier and how good it is on configurations it was not trained on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Classified {
    /// The classifier; `None` where only one label was ever seen.
    pub classifier: Option<ObstacleClassifier>,
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
}

/// Rounds of training.
const ROUNDS: usize = 3;
/// Configurations of the first round, half of each label where there are so many.
const FIRST: usize = 4000;
/// With less time than this \[s\] the first round is smaller, in proportion: nothing stops a fit
/// that has begun.
const TIME_FOR_FIRST: f64 = 10.0;
/// Share of the budget after which no round begins, so that most of it is left for the boundary.
const TRAINED_BY: f64 = 0.4;
/// Configurations that each later round adds.
const ADDED: usize = 2000;
/// Held out of every training set, of each label.
const HELD_OUT: usize = 1000;
/// Configurations looked at for the most doubtful ones, for each that is added.
const LOOKED_AT: usize = 4;

/// Trains on the exploration's configurations, then in rounds on those as well that the classifier
/// gets wrong or is least sure of: among what is known, or among new configurations where little
/// else is.
///
/// What is labelled anew is added to `known`. Which parts a colliding configuration lies in takes a
/// check, which is counted. The held-out configurations are uniform in space and never trained on.
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
    // The last fifth of each list, at most HELD_OUT, is held out.
    let split = |list: &[f64]| (list.len() / nq - (list.len() / nq / 5).min(HELD_OUT)) * nq;
    let ((free, held_free), (colliding, held_colliding)) =
        (known.free.split_at(split(&known.free)), known.colliding.split_at(split(&known.colliding)));
    let held = [held_free, held_colliding].concat();
    outcome.held_out = [held_free.len() / nq, held_colliding.len() / nq];
    let held_labels = [vec![Label::Free; outcome.held_out[0]], vec![Label::Colliding; outcome.held_out[1]]].concat();
    let share_of_first = budget.seconds().map_or(1.0, |limit| (limit / TIME_FOR_FIRST).clamp(0.1, 1.0));
    let first = (FIRST as f64 * share_of_first) as usize;
    let of_colliding = (colliding.len() / nq).min((first / 2).max(first.saturating_sub(free.len() / nq)));
    let of_free = (free.len() / nq).min(first - of_colliding.min(first));
    let mut set = Set::default();
    set.add_known(&free[..of_free * nq], &colliding[..of_colliding * nq], parts, budget);
    let mut pool = [&free[of_free * nq..], &colliding[of_colliding * nq..]].map(<[f64]>::to_vec);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut fresh = Set::default();
    let fit_options = FitOptions::default();
    for round in 1..=ROUNDS {
        let classifier =
            ObstacleClassifier::fit(parts, &set.configs, &set.inside, &fit_options, outcome.classifier.as_ref());
        if classifier.svms().is_empty() {
            return Classified::default();
        }
        [outcome.accuracy_free, outcome.accuracy_colliding] =
            classifier.accuracy(nq, parts.features, &held, &held_labels);
        budget.note(0, outcome.balanced_accuracy());
        // Asks for the time too, which a long fit may have used up.
        budget.stage("training");
        let wanted = ADDED.min(budget.left() / 4);
        if round == ROUNDS || wanted == 0 || budget.end().is_some() || budget.fraction() > TRAINED_BY {
            outcome.classifier = Some(classifier.without_duals());
            break;
        }
        let pooled = pool.iter().map(Vec::len).sum::<usize>() / nq;
        if pooled >= LOOKED_AT * wanted {
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

/// Moves those of the first `count` colliding configurations that the classifier calls free to the
/// front: small components hide among them.
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
    /// Row major.
    configs: Vec<f64>,
    inside: Vec<Vec<u32>>,
}

impl Set {
    fn add(&mut self, configs: &[f64], inside: &[Vec<u32>]) {
        self.configs.extend_from_slice(configs);
        self.inside.extend_from_slice(inside);
    }

    /// Adds configurations of known labels; only of the colliding ones it has to be asked which
    /// parts they lie in.
    fn add_known(&mut self, free: &[f64], colliding: &[f64], parts: &Parts, budget: &mut Budget) {
        self.add(free, &vec![Vec::new(); free.len() / parts.nq]);
        let colliding = &colliding[..colliding.len().min(budget.left() / 4 * parts.nq)];
        let inside = (parts.containing)(colliding);
        budget.spend(inside.len());
        self.add(colliding, &inside);
    }
}

/// Takes those `count` of the `pool` of free and colliding configurations out that the classifier
/// gets wrong, or is least sure of.
fn take_doubtful(
    classifier: &ObstacleClassifier,
    parts: &Parts,
    pool: &mut [Vec<f64>; 2],
    count: usize,
) -> [Vec<f64>; 2] {
    let nq = parts.nq;
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (side, list) in pool.iter().enumerate() {
        let looked_at = &list[..list.len().min(LOOKED_AT * count * nq / 2)];
        let decisions = classifier.decisions(nq, parts.features, looked_at).into_iter().enumerate();
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

/// Those `count` of [`LOOKED_AT`] times as many new configurations that are nearest to the
/// predicted boundary, row major.
fn most_doubtful_of_new(
    classifier: &ObstacleClassifier,
    space: &ConfigSpace,
    parts: &Parts,
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let nq = parts.nq;
    let mut configs = vec![0.0; LOOKED_AT * count * nq];
    configs.chunks_exact_mut(nq).for_each(|q| uniform(space, rng, q));
    let decisions = classifier.decisions(nq, parts.features, &configs).into_iter().map(f64::abs);
    let mut order: Vec<(f64, usize)> = decisions.enumerate().map(|(i, doubt)| (doubt, i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.truncate(count);
    order.iter().flat_map(|(_, i)| configs[i * nq..(i + 1) * nq].iter().copied()).collect()
}

#[cfg(test)]
mod tests;

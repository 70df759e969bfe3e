//! Contacts and signed distances of checked pairs, and pairs that collide often. [`Checker`]
//! documents the functions without docs at its methods of the same names.

use std::collections::BTreeMap;

use crate::collision::checker::{CheckScratch, Checker};
use crate::collision::contacts::{self, BEYOND_NEAREST_SHARE, Contact, ContactQuery, ContactSearch};
use crate::collision::narrow_phase;
use crate::scene::PairId;

pub fn contacts(
    checker: &Checker,
    q: &[f64],
    query: ContactQuery,
    scratch: &mut CheckScratch,
    contacts: &mut Vec<Contact>,
) {
    checker.place(q, scratch);
    checker.find_near(query.margin + checker.most_clearance - checker.clearance, scratch);
    scratch.broad.pairs.sort_unstable();
    for at in 0..scratch.broad.pairs.len() {
        of_pair(checker, scratch.broad.pairs[at] as usize, query, scratch, contacts);
    }
}

pub fn contacts_of(
    checker: &Checker,
    q: &[f64],
    pair: PairId,
    query: ContactQuery,
    scratch: &mut CheckScratch,
    contacts: &mut Vec<Contact>,
) {
    checker.place(q, scratch);
    of_pair(checker, pair.index(), query, scratch, contacts);
}

/// Appends the contacts of a pair at the placed configuration.
fn of_pair(
    checker: &Checker,
    index: usize,
    query: ContactQuery,
    scratch: &mut CheckScratch,
    contacts: &mut Vec<Contact>,
) {
    let start = contacts.len();
    let (clearance, excess) = (checker.clearance_of(index), checker.excess(index));
    let query = ContactQuery { margin: query.margin + excess, ..query };
    for (first, second, parts) in checker.part_pairs(index) {
        let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
        let place = contacts::PairPlace { pair: PairId::new(index), parts, start, clearance };
        let hint = &mut scratch.hints[parts];
        contacts::gather([a, b], query, place, hint, &mut scratch.contact_buffers, contacts);
    }
    contacts[start..].iter_mut().for_each(|contact| contact.distance -= excess);
}

pub fn contacts_are_complete(checker: &Checker, search: ContactSearch) -> bool {
    checker.bodies.all_convex || search != ContactSearch::Exact
}

pub fn exact_within(checker: &Checker, margin: f64) -> f64 {
    if checker.bodies.all_convex && !checker.bodies.has_scenery { margin } else { BEYOND_NEAREST_SHARE * margin }
}

/// Returns the signed distance \[m\] of every checked pair at `q`, in the order of the pairs.
/// [`Checker::clearance`] is the least of them, and they are as exact.
pub fn signed_distances(checker: &Checker, q: &[f64], scratch: &mut CheckScratch) -> Vec<f64> {
    let pairs: Vec<PairId> = (0..checker.pairs.len()).map(PairId::new).collect();
    signed_distances_of(checker, q, &pairs, scratch)
}

/// Returns the signed distances \[m\] of some checked pairs at `q`, in the order of `pairs`.
pub fn signed_distances_of(checker: &Checker, q: &[f64], pairs: &[PairId], scratch: &mut CheckScratch) -> Vec<f64> {
    checker.place(q, scratch);
    let distance = |pair: &PairId| {
        let mut best = f64::INFINITY;
        for (first, second, _) in checker.part_pairs(pair.index()) {
            let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
            best = narrow_phase::signed_distance(a, b, best, &mut scratch.buffers).unwrap_or(best);
        }
        best
    };
    pairs.iter().map(distance).collect()
}

/// Returns the signed distance \[m\] of a checked pair at the placed configuration, if it is below
/// `most`.
pub fn signed_distance_below(checker: &Checker, pair: PairId, most: f64, scratch: &mut CheckScratch) -> Option<f64> {
    let mut best = None;
    for (first, second, _) in checker.part_pairs(pair.index()) {
        let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
        let found = narrow_phase::signed_distance(a, b, best.unwrap_or(most), &mut scratch.buffers);
        best = found.or(best);
    }
    best
}

/// Appends contacts as [`Checker::contacts_within`] does.
pub fn contacts_within(
    checker: &Checker,
    q: &[f64],
    within: f64,
    scratch: &mut CheckScratch,
    contacts: &mut Vec<Contact>,
) {
    // The checker subtracts from distances what a pair keeps beyond the scene's clearance.
    let least = (0..checker.pairs.len()).map(|pair| checker.excess(pair)).fold(0.0, f64::min);
    let query = ContactQuery { margin: within - least, search: ContactSearch::Exact };
    let start = contacts.len();
    // Results then are the same to the last bit, whatever was queried before.
    scratch.forget_contacts();
    self::contacts(checker, q, query, scratch, contacts);
    contacts[start..].iter_mut().for_each(|contact| contact.distance += checker.excess(contact.pair.index()));
    let mut at = 0;
    contacts.retain(|contact| {
        at += 1;
        at <= start || contact.distance < within
    });
}

/// Returns the checked pairs that collide at every one of `configs` (none if there are no
/// configurations). They are most likely links that overlap by design and should not be checked.
pub fn always_colliding(checker: &Checker, configs: impl IntoIterator<Item = impl AsRef<[f64]>>) -> Vec<PairId> {
    nearly_always_colliding(checker, configs, 0).into_iter().map(|(pair, _)| pair).collect()
}

/// Returns the checked pairs that collide at all but at most `misses` of `configs`, with the number
/// of collisions, in the order of the pairs.
pub fn nearly_always_colliding(
    checker: &Checker,
    configs: impl IntoIterator<Item = impl AsRef<[f64]>>,
    misses: usize,
) -> Vec<(PairId, usize)> {
    let (mut scratch, mut pairs) = (CheckScratch::default(), Vec::new());
    let (mut counts, mut seen) = (BTreeMap::new(), 0);
    let mut configs = configs.into_iter();
    // Each such pair collides at one of the first `misses + 1` configurations. Few pairs do, and
    // only those are checked from then on.
    for q in configs.by_ref().take(misses.saturating_add(1)) {
        pairs.clear();
        checker.colliding_pairs(q.as_ref(), &mut scratch, &mut pairs);
        pairs.iter().for_each(|pair| *counts.entry(*pair).or_insert(0) += 1);
        seen += 1;
    }
    let mut left: Vec<(PairId, usize)> = counts.into_iter().filter(|(_, count)| seen - count <= misses).collect();
    for q in configs {
        if left.is_empty() {
            break;
        }
        checker.place(q.as_ref(), &mut scratch);
        seen += 1;
        left.retain_mut(|(pair, count)| {
            *count += usize::from(checker.pair_collides(pair.index(), &mut scratch));
            seen - *count <= misses
        });
    }
    left
}

/// Returns the checked pairs that collide at any of `configs`, with the number of collisions, the
/// most frequent first.
pub fn most_often_colliding(checker: &Checker, configs: &[Vec<f64>]) -> Vec<(PairId, usize)> {
    let (mut scratch, mut pairs) = (CheckScratch::default(), Vec::new());
    let mut counts = vec![0; checker.scene().pairs.len()];
    for q in configs {
        pairs.clear();
        checker.colliding_pairs(q, &mut scratch, &mut pairs);
        pairs.iter().for_each(|pair| counts[pair.index()] += 1);
    }
    let counted = counts.into_iter().enumerate().filter(|(_, count)| *count > 0);
    let mut often: Vec<(PairId, usize)> = counted.map(|(pair, count)| (PairId::new(pair), count)).collect();
    often.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    often
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, builtin};

    #[test]
    fn distances_by_pair_are_those_of_scenes_of_one_pair() {
        let scene = builtin::scene("shelf-arm").unwrap();
        let checker = Checker::new(scene.clone().into());
        let (mut scratch, q) = (CheckScratch::default(), [0.3, -0.4, 0.2, -1.5, 0.1, 1.0, 0.2]);
        let distances = signed_distances(&checker, &q, &mut scratch);
        assert_eq!(distances.len(), scene.pairs.len());
        for (pair, distance) in distances.iter().enumerate().step_by(7) {
            let alone = Checker::new(Scene { pairs: vec![scene.pairs[pair]], ..scene.clone() }.into());
            let expected = alone.clearance(&q, &mut CheckScratch::default());
            assert!((distance - expected).abs() < 1e-9, "{pair}: {distance} {expected}");
        }
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least - checker.clearance(&q, &mut scratch)).abs() < 1e-9);
    }

    #[test]
    fn contacts_within_do_not_depend_on_what_was_asked_before() {
        let scene = builtin::scene("hand").unwrap();
        let nq = scene.space.nq();
        let checker = Checker::new(scene.into());
        let found = |q: f64, scratch: &mut CheckScratch| {
            let mut contacts = Vec::new();
            contacts_within(&checker, &vec![q; nq], 0.1, scratch, &mut contacts);
            let bits = |contact: &Contact| (contact.distance.to_bits(), contact.point_first.map(f64::to_bits));
            contacts.iter().map(bits).collect::<Vec<_>>()
        };
        let mut reused = CheckScratch::default();
        for k in 0..40 {
            let q = 0.1 + 0.01 * f64::from(k);
            let fresh = found(q, &mut CheckScratch::default());
            assert!(!fresh.is_empty() && found(q, &mut reused) == fresh, "{q}");
        }
    }

    #[test]
    fn contacts_within_are_those_of_the_distances_whatever_pairs_keep() {
        let mut scene = builtin::scene("shelf-arm").unwrap();
        let names = scene.pair_names(PairId::new(0)).map(String::from);
        scene.clearances.pairs.push((names, 0.05));
        scene.clearance = 0.02;
        let checker = Checker::new(scene.into());
        let (mut scratch, q) = (CheckScratch::default(), [0.3, -0.4, 0.2, -1.5, 0.1, 1.0, 0.2]);
        let distances = signed_distances(&checker, &q, &mut scratch);
        for within in [0.0, 0.1, 0.6] {
            let mut contacts = Vec::new();
            contacts_within(&checker, &q, within, &mut scratch, &mut contacts);
            for (pair, distance) in distances.iter().enumerate() {
                let own =
                    contacts.iter().filter(|contact| contact.pair.index() == pair).map(|contact| contact.distance);
                let nearest = own.fold(f64::INFINITY, f64::min);
                // Contacts of overlapping meshes are estimates.
                let expected = if *distance < within { *distance } else { f64::INFINITY };
                let agree =
                    nearest == expected || (nearest - expected).abs() < 1e-6 || *distance < 0.0 && nearest <= within;
                assert!(agree, "{within} {pair}: {nearest} {expected}");
            }
        }
    }
}

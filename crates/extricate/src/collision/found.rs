//! What the checker finds where bodies are near: contacts, pairs that collide often.

use serde::Serialize;

use super::{CheckScratch, Checker, part_pair};
use crate::kinematics::{Twists, Wrench};
use crate::math::Vec3;
use crate::scene::Scene;

/// Two places of a checked pair that are near each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Contact {
    /// Index into [`Scene::pairs`].
    pub pair: usize,
    /// Signed distance \[m\]; negative where the two overlap. As [`super::Checker::contacts`] gives
    /// it, less what the pair keeps beyond the clearance of the scene.
    pub distance: f64,
    /// Nearest (or deepest) point on the first body, world coordinates \[m\].
    pub point_first: Vec3,
    /// The same on the second body.
    pub point_second: Vec3,
    /// Unit, world coordinates, from the second body toward the first: moving the first body along
    /// it by `t` changes `distance` by `t`.
    pub normal: Vec3,
}

impl Contact {
    /// Adds the gradient of the distance over the tangent coordinates to `gradient` (length `nv`)
    /// \[m per rad or m\], to first order: the two points stay fixed to their bodies. `twists` are
    /// those of the configuration.
    pub fn add_gradient(&self, scene: &Scene, twists: &Twists, gradient: &mut [f64]) {
        let pair = &scene.pairs[self.pair];
        let (mut first, mut second) = (scene.bodies[pair.first].frame, scene.bodies[pair.second].frame);
        let of_first = Wrench::at(&self.point_first, self.normal);
        let of_second = Wrench::at(&self.point_second, -self.normal);
        // What carries both bodies parts nothing; frames come after those that carry them.
        while first != second {
            let (frame, wrench) = if first > second { (&mut first, &of_first) } else { (&mut second, &of_second) };
            twists.of(*frame).iter().for_each(|twist| gradient[twist.v] += twist.power(wrench));
            *frame = scene.frames[*frame].parent;
        }
    }
}

/// Which contacts are wanted.
#[derive(Debug, Clone, Copy)]
pub struct ContactQuery {
    /// Of pairs nearer than this \[m\].
    pub margin: f64,
    /// How exact they have to be.
    pub search: ContactSearch,
}

/// How exact contacts have to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSearch {
    /// Enough to propose a step. Far contacts of convex shapes may be those of the search before,
    /// moved along; depths may be up to twice too large, and distances of more than twice the
    /// clearance up to a third too small (of meshes, far ones by more). Meshes are taken for convex
    /// pieces around them, which stand out by a few thousandths of their size: deep overlaps are
    /// seen whole, and where no contact is below the clearance the configuration is free.
    Coarse,
    /// The nearest contact, and the depth of convex shapes, within rounding.
    Exact,
}

/// Signed distance \[m\] of every checked pair at `q`, by pair: what [`Checker::clearance`] is the
/// least of, and as exact.
pub fn signed_distances(checker: &Checker, q: &[f64], scratch: &mut CheckScratch) -> Vec<f64> {
    checker.place(q, scratch);
    let distance = |pair: usize| {
        let mut best = f64::INFINITY;
        for (first, second, _) in checker.part_pairs(pair) {
            let (a, b) = checker.bodies.placed(&mut scratch.placement, first, second);
            best = part_pair::signed_distance(a, b, best, &mut scratch.buffers).unwrap_or(best);
        }
        best
    };
    (0..checker.pairs.len()).map(distance).collect()
}

/// Appends the contacts of all checked pairs that are nearer than `within` \[m\] at `q`, free or
/// not, in the order of the pairs. Distances are signed ones between the bodies, whatever
/// clearances they keep; else as
/// [`Checker::contacts`].
pub fn contacts_within(
    checker: &Checker,
    q: &[f64],
    within: f64,
    scratch: &mut CheckScratch,
    contacts: &mut Vec<Contact>,
) {
    // Those of the checker are less what a pair keeps beyond the scene's clearance.
    let least = (0..checker.pairs.len()).map(|pair| checker.excess(pair)).fold(0.0, f64::min);
    let query = ContactQuery { margin: within - least, search: ContactSearch::Exact };
    let start = contacts.len();
    checker.contacts(q, query, scratch, contacts);
    contacts[start..].iter_mut().for_each(|contact| contact.distance += checker.excess(contact.pair));
    let mut at = 0;
    contacts.retain(|contact| {
        at += 1;
        at <= start || contact.distance < within
    });
}

/// Indices of the checked pairs that collide at every one of `configs` (none where there are no
/// configurations): most likely links that overlap by design and should not be checked.
pub fn always_colliding(checker: &Checker, configs: &[Vec<f64>]) -> Vec<usize> {
    let mut scratch = CheckScratch::default();
    let mut always = Vec::new();
    let Some((first, others)) = configs.split_first() else { return always };
    checker.colliding_pairs(first, &mut scratch, &mut always);
    for q in others {
        if always.is_empty() {
            break;
        }
        checker.place(q, &mut scratch);
        always.retain(|&pair| checker.pair_collides(pair, &mut scratch));
    }
    always
}

/// Indices of the checked pairs that collide at any of `configs`, and at how many, the most
/// frequent first.
pub fn most_often_colliding(checker: &Checker, configs: &[Vec<f64>]) -> Vec<(usize, usize)> {
    let (mut scratch, mut pairs) = (CheckScratch::default(), Vec::new());
    let mut counts = vec![0; checker.scene().pairs.len()];
    for q in configs {
        pairs.clear();
        checker.colliding_pairs(q, &mut scratch, &mut pairs);
        pairs.iter().for_each(|pair| counts[*pair] += 1);
    }
    let mut often: Vec<(usize, usize)> = counts.into_iter().enumerate().filter(|(_, count)| *count > 0).collect();
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
    fn contacts_within_are_those_of_the_distances_whatever_pairs_keep() {
        let mut scene = builtin::scene("shelf-arm").unwrap();
        let names = scene.pair_names(0).map(String::from);
        scene.clearances.pairs.push((names, 0.05));
        scene.clearance = 0.02;
        let checker = Checker::new(scene.into());
        let (mut scratch, q) = (CheckScratch::default(), [0.3, -0.4, 0.2, -1.5, 0.1, 1.0, 0.2]);
        let distances = signed_distances(&checker, &q, &mut scratch);
        for within in [0.0, 0.1, 0.6] {
            let mut contacts = Vec::new();
            contacts_within(&checker, &q, within, &mut scratch, &mut contacts);
            for (pair, distance) in distances.iter().enumerate() {
                let own = contacts.iter().filter(|contact| contact.pair == pair).map(|contact| contact.distance);
                let nearest = own.fold(f64::INFINITY, f64::min);
                // Those of overlapping meshes are estimates.
                let expected = if *distance < within { *distance } else { f64::INFINITY };
                let agree =
                    nearest == expected || (nearest - expected).abs() < 1e-6 || *distance < 0.0 && nearest <= within;
                assert!(agree, "{within} {pair}: {nearest} {expected}");
            }
        }
    }
}

//! Distinct ends of the descents of one search, nearest first.

use super::local_metric::LocalMetric;
use crate::cspace::ConfigSpace;
use crate::query::answer::{RIVAL, SEPARATION};

/// A configuration that a descent led to.
#[derive(Debug, Clone, Default)]
pub struct End {
    /// Distance from the query \[metric units\].
    pub distance: f64,
    pub config: Vec<f64>,
    /// Whether it is free by its contacts: an exit.
    pub is_exit: bool,
    /// Whether the exact checker called it free during this query.
    pub is_verified: bool,
    /// Whether the descent ended by itself, so that others that lead here are pruned.
    is_last: bool,
}

/// Ends of descents, no two alike: exits first, nearest first. Memory is reused.
#[derive(Default)]
pub struct Exits {
    ends: Vec<End>,
    exits: usize,
    spare: Vec<End>,
}

impl Exits {
    pub fn clear(&mut self) {
        self.spare.append(&mut self.ends);
        self.exits = 0;
    }

    pub fn nearest(&self) -> Option<&End> {
        self.iter().next()
    }

    /// Returns the distance of the nearest exit; infinite if there is none.
    pub fn depth(&self) -> f64 {
        self.ceiling(1)
    }

    /// Returns the distance that an exit has to beat to be among the `wanted` nearest.
    pub fn ceiling(&self, wanted: usize) -> f64 {
        self.iter().nth(wanted - 1).map_or(f64::INFINITY, |end| end.distance)
    }

    pub fn len(&self) -> usize {
        self.exits
    }

    /// Iterates over the exits, nearest first.
    pub fn iter(&self) -> impl Iterator<Item = &End> {
        self.ends[..self.exits].iter()
    }

    /// Iterates over the ends that descents came to by themselves, exits or not.
    pub fn last(&self) -> impl Iterator<Item = &End> {
        self.ends.iter().filter(|end| end.is_last)
    }

    /// Adds an exit; of those that are alike, the nearest stays.
    pub fn offer(
        &mut self,
        (space, local): (&ConfigSpace, &mut LocalMetric),
        (distance, config): (f64, &[f64]),
        (is_verified, is_last): (bool, bool),
    ) {
        let mut is_alike = |end: &End| are_alike(space, local, (distance, config), (end.distance, &end.config));
        let known = self.ends[..self.exits].iter_mut().find(|end| end.distance <= distance && is_alike(end));
        if let Some(known) = known {
            known.is_last |= is_last;
            return;
        }
        let (mut at, mut was_last) = (0, false);
        while at < self.ends.len() {
            if !is_alike(&self.ends[at]) {
                at += 1;
                continue;
            }
            let end = self.ends.remove(at);
            self.exits -= usize::from(end.is_exit);
            was_last |= end.is_last;
            self.spare.push(end);
        }
        let rank = self.iter().take_while(|end| end.distance <= distance).count();
        let new = End { distance, is_exit: true, is_verified, is_last: is_last || was_last, config: self.copy(config) };
        self.ends.insert(rank, new);
        self.exits += 1;
    }

    /// Adds an end that is no exit, if it is unlike all others.
    pub fn note_stuck(&mut self, (space, local): (&ConfigSpace, &mut LocalMetric), (distance, config): (f64, &[f64])) {
        if self.ends.iter().all(|end| !are_alike(space, local, (distance, config), (end.distance, &end.config))) {
            let new = End { distance, is_exit: false, is_verified: false, is_last: true, config: self.copy(config) };
            self.ends.push(new);
        }
    }

    /// Notes the exact check of the nearest exit, which is dropped if it collides.
    pub fn note_checked(&mut self, is_free: bool) {
        if is_free {
            self.ends[0].is_verified = true;
        } else {
            let end = self.ends.remove(0);
            self.spare.push(end);
            self.exits -= 1;
        }
    }

    /// Iterates over the exits that are distinct from a witness at this distance, nearest first.
    pub fn besides<'a>(
        &'a self,
        space: &'a ConfigSpace,
        local: &'a mut LocalMetric,
        witness: (f64, &'a [f64]),
    ) -> impl Iterator<Item = &'a End> {
        self.iter().filter(move |end| !are_alike(space, local, witness, (end.distance, &end.config)))
    }

    /// Returns whether an exit rivals a witness: distinct from it and hardly farther.
    pub fn rival(&self, space: &ConfigSpace, local: &mut LocalMetric, witness: (f64, &[f64])) -> bool {
        self.besides(space, local, witness).next().is_some_and(|end| end.distance <= RIVAL * witness.0)
    }

    fn copy(&mut self, config: &[f64]) -> Vec<f64> {
        let mut copy = self.spare.pop().unwrap_or_default().config;
        copy.clear();
        copy.extend_from_slice(config);
        copy
    }
}

/// Returns whether two ends (distance, configuration) are too near each other to be distinct, see
/// [`SEPARATION`].
pub fn are_alike(space: &ConfigSpace, local: &mut LocalMetric, a: (f64, &[f64]), b: (f64, &[f64])) -> bool {
    local.distance(space, a.1, b.1) <= SEPARATION * a.0.min(b.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::Manifold;

    fn line() -> (ConfigSpace, LocalMetric) {
        let mut space = ConfigSpace::default();
        space.push("x", Manifold::Interval { lower: -10.0, upper: 10.0 }, 1.0);
        (space, LocalMetric::euclidean(1))
    }

    fn offer(exits: &mut Exits, (space, local): &mut (ConfigSpace, LocalMetric), distance: f64, x: f64) {
        exits.offer((space, local), (distance, &[x]), (false, true));
    }

    #[test]
    fn the_nearest_of_alike_ones_stay_in_order() {
        let (mut line, mut exits) = (line(), Exits::default());
        assert_eq!(exits.depth(), f64::INFINITY);
        for x in [1.0, -1.05, 1.2, 4.0, -1.0, 0.9, 2.0, 2.0] {
            offer(&mut exits, &mut line, f64::abs(x), x);
        }
        let kept: Vec<(f64, f64)> = exits.iter().map(|end| (end.distance, end.config[0])).collect();
        assert_eq!(kept, [(0.9, 0.9), (1.0, -1.0), (2.0, 2.0), (4.0, 4.0)]);
        assert_eq!((exits.depth(), exits.ceiling(3), exits.ceiling(5)), (0.9, 2.0, f64::INFINITY));
        let (space, local) = &mut line;
        let besides: Vec<f64> = exits.besides(space, local, (0.9, &[0.9])).map(|end| end.distance).collect();
        assert_eq!(besides, [1.0, 2.0, 4.0]);
        assert!(exits.rival(space, local, (0.995, &[0.995])));
        assert!(!exits.rival(space, local, (0.9, &[0.9])));
    }

    #[test]
    fn one_that_is_like_two_takes_the_place_of_both() {
        let (mut line, mut exits) = (line(), Exits::default());
        for (distance, x) in [(1.0, 1.0), (1.1, 1.3), (0.9, 1.12)] {
            offer(&mut exits, &mut line, distance, x);
        }
        assert_eq!(exits.iter().map(|end| end.distance).collect::<Vec<_>>(), [0.9]);
    }

    #[test]
    fn what_is_stuck_is_an_end_and_no_exit() {
        let (mut line, mut exits) = (line(), Exits::default());
        exits.note_stuck((&line.0, &mut line.1), (1.0, &[1.0]));
        exits.note_stuck((&line.0, &mut line.1), (1.1, &[1.1]));
        assert_eq!((exits.len(), exits.last().count(), exits.depth()), (0, 1, f64::INFINITY));
        offer(&mut exits, &mut line, 2.0, 2.0);
        offer(&mut exits, &mut line, 1.0, -1.0);
        exits.note_checked(false);
        assert_eq!((exits.len(), exits.last().count(), exits.depth()), (1, 2, 2.0));
        offer(&mut exits, &mut line, 1.05, 1.05);
        assert_eq!((exits.len(), exits.last().count(), exits.depth()), (2, 2, 1.05));
    }
}

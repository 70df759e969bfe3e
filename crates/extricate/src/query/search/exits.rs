//! The distinct exits that one query has met so far.

use super::local_metric::LocalMetric;
use crate::cspace::ConfigSpace;
use crate::query::answer::{RIVAL, SEPARATION};

/// Configurations and their depths, ascending, no two of them alike. Memory is reused.
#[derive(Default)]
pub struct Exits {
    wanted: usize,
    nq: usize,
    /// Depth, and the place of the configuration in `configs`.
    order: Vec<(f64, usize)>,
    configs: Vec<f64>,
}

impl Exits {
    /// Starts anew: the `wanted` nearest, of `nq` coordinates each, are to be kept.
    pub fn reset(&mut self, wanted: usize, nq: usize) {
        (self.wanted, self.nq) = (wanted, nq);
        self.order.clear();
        self.configs.resize((wanted + 1) * nq, 0.0);
    }

    /// An exit that is not nearer than this is not among those wanted.
    pub fn ceiling(&self) -> f64 {
        if self.order.len() < self.wanted { f64::INFINITY } else { self.order.last().map_or(0.0, |last| last.0) }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// The exits, nearest first.
    pub fn iter(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.order.iter().map(|&(depth, at)| (depth, &self.configs[at * self.nq..(at + 1) * self.nq]))
    }

    /// Those that are distinct from a witness, nearest first.
    pub fn besides<'a>(
        &'a self,
        space: &'a ConfigSpace,
        local: &'a mut LocalMetric,
        depth: f64,
        witness: &'a [f64],
    ) -> impl Iterator<Item = (f64, &'a [f64])> {
        self.iter().filter(move |&other| !are_alike(space, local, (depth, witness), other))
    }

    /// Takes an exit in if it is among the nearest; of those that are alike the nearest stays.
    pub fn offer(&mut self, space: &ConfigSpace, local: &mut LocalMetric, depth: f64, config: &[f64]) {
        if depth >= self.ceiling() {
            return;
        }
        let Self { nq, order, configs, .. } = self;
        let mut alike =
            |at: usize, other: f64| are_alike(space, local, (depth, config), (other, &configs[at * *nq..][..*nq]));
        if order.iter().any(|&(other, at)| other <= depth && alike(at, other)) {
            return;
        }
        order.retain(|&(other, at)| !alike(at, other));
        order.truncate(self.wanted.saturating_sub(1));
        let place = (0..=order.len()).find(|place| order.iter().all(|(_, at)| at != place)).unwrap_or(0);
        configs[place * *nq..(place + 1) * *nq].copy_from_slice(config);
        let rank = order.partition_point(|(other, _)| *other <= depth);
        order.insert(rank, (depth, place));
    }

    /// Whether one of them is a rival of a witness: distinct from it and hardly farther.
    pub fn rival(&self, space: &ConfigSpace, local: &mut LocalMetric, depth: f64, witness: &[f64]) -> bool {
        self.iter()
            .take_while(|(other, _)| *other <= RIVAL * depth)
            .any(|other| !are_alike(space, local, (depth, witness), other))
    }
}

/// Whether two exits (depth, configuration) are too near each other to be distinct, see
/// [`SEPARATION`].
pub fn are_alike(space: &ConfigSpace, local: &mut LocalMetric, a: (f64, &[f64]), b: (f64, &[f64])) -> bool {
    local.distance(space, a.1, b.1) <= SEPARATION * a.0.min(b.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::Manifold;

    #[test]
    fn the_nearest_of_alike_ones_stay_in_order() {
        let mut space = ConfigSpace::default();
        space.push("x", Manifold::Interval { lower: -10.0, upper: 10.0 }, 1.0);
        let mut local = LocalMetric::euclidean(1);
        let mut exits = Exits::default();
        exits.reset(3, 1);
        assert_eq!(exits.ceiling(), f64::INFINITY);
        for x in [1.0, -1.05, 1.2, 4.0, -1.0, 0.9, 2.0, 2.0] {
            exits.offer(&space, &mut local, f64::abs(x), &[x]);
        }
        let kept: Vec<(f64, f64)> = exits.iter().map(|(depth, config)| (depth, config[0])).collect();
        assert_eq!(kept, [(0.9, 0.9), (1.0, -1.0), (2.0, 2.0)]);
        assert_eq!(exits.ceiling(), 2.0);
        let besides: Vec<f64> = exits.besides(&space, &mut local, 0.9, &[0.9]).map(|(depth, _)| depth).collect();
        assert_eq!(besides, [1.0, 2.0]);
        assert!(exits.rival(&space, &mut local, 0.995, &[0.995]));
        assert!(!exits.rival(&space, &mut local, 0.9, &[0.9]));
    }

    #[test]
    fn one_that_is_like_two_takes_the_place_of_both() {
        let mut space = ConfigSpace::default();
        space.push("x", Manifold::Interval { lower: -10.0, upper: 10.0 }, 1.0);
        let mut local = LocalMetric::euclidean(1);
        let mut exits = Exits::default();
        exits.reset(3, 1);
        exits.offer(&space, &mut local, 1.0, &[1.0]);
        exits.offer(&space, &mut local, 1.1, &[1.3]);
        exits.offer(&space, &mut local, 0.9, &[1.12]);
        assert_eq!(exits.iter().map(|e| e.0).collect::<Vec<_>>(), [0.9]);
    }
}

//! Configurations that are added one by one, and a search for the nearest.

use kdtree::KdTree;
use kdtree::distance::squared_euclidean;

use crate::metric::{Metric, MetricScratch};

/// Points in a leaf of the tree.
const LEAF_POINTS: usize = 32;

/// Configurations, indexed by the embedding of the scene's metric. Nearest means nearest in the
/// embedding, where distances are at most those of the metric.
pub struct Nodes<'a> {
    metric: &'a Metric,
    nq: usize,
    configs: Vec<f64>,
    tree: KdTree<f64, usize, Vec<f64>>,
}

impl<'a> Nodes<'a> {
    pub fn new(metric: &'a Metric) -> Self {
        let nq = metric.scene().space.nq();
        let tree = KdTree::with_capacity(metric.embedding_len(), LEAF_POINTS);
        Self { metric, nq, configs: Vec::new(), tree }
    }

    pub fn metric(&self) -> &'a Metric {
        self.metric
    }

    pub fn len(&self) -> usize {
        self.configs.len() / self.nq
    }

    pub fn config(&self, index: usize) -> &[f64] {
        &self.configs[index * self.nq..][..self.nq]
    }

    /// Adds a finite configuration and returns its index.
    pub fn push(&mut self, q: &[f64]) -> usize {
        let (index, point) = (self.len(), self.embedded(q));
        self.configs.extend_from_slice(q);
        // The tree refuses only points that are not finite or of another length.
        let added = self.tree.add(point, index);
        debug_assert!(added.is_ok(), "{added:?}");
        index
    }

    /// Returns the `count` nodes nearest to `q`, nearest first.
    pub fn near(&self, q: &[f64], count: usize) -> Vec<usize> {
        let point = self.embedded(q);
        let found = self.tree.nearest(&point, count, &squared_euclidean).unwrap_or_default();
        found.into_iter().map(|(_, index)| *index).collect()
    }

    fn embedded(&self, q: &[f64]) -> Vec<f64> {
        let mut point = vec![0.0; self.metric.embedding_len()];
        self.metric.embed(q, &mut MetricScratch::default(), &mut point);
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cspace::sampling::Halton;
    use crate::scene::builtin;
    use crate::solver::Solver;

    #[test]
    fn the_nearest_are_those_of_a_scan() {
        let solver = Solver::new(builtin::scene("free-box").unwrap());
        let (metric, space) = (solver.metric(), &solver.scene().space);
        let (mut nodes, halton) = (Nodes::new(metric), Halton::new(space.nv(), 4));
        let mut q = vec![0.0; space.nq()];
        assert!(nodes.near(&q, 1).is_empty());
        for index in 0..300 {
            halton.config(space, index, &mut q);
            assert_eq!(nodes.push(&q), index as usize);
        }
        for index in 300..330 {
            halton.config(space, index, &mut q);
            let mut all: Vec<usize> = (0..nodes.len()).collect();
            all.sort_by(|a, b| {
                let distance = |i: usize| metric.distance(nodes.config(i), &q);
                distance(*a).total_cmp(&distance(*b))
            });
            assert_eq!(nodes.near(&q, 5), all[..5]);
        }
    }
}

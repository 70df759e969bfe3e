//! Pairs that no joint connects part independently of each other.

use crate::query::context::Context;
use crate::query::search::coordinates::coordinates;
use crate::scene::{MetricKind, PairId};

/// Pairs, those that share a joint with each other together.
#[derive(Debug, Default)]
pub struct Groups {
    pairs: Vec<PairId>,
    /// Where each group ends.
    ends: Vec<usize>,
    /// Of every tangent coordinate, the group that moves by it; a union-find forest.
    parent: Vec<usize>,
    roots: Vec<(usize, PairId)>,
}

impl Groups {
    /// Groups pairs by the joints that are not locked; under metrics of bodies, whose squares do
    /// not add, all are one group.
    pub fn split(&mut self, context: &Context, pairs: &[PairId]) {
        let scene = context.checker.scene();
        self.parent.clear();
        self.parent.extend(0..scene.space.nv());
        self.roots.clear();
        for &pair in pairs {
            let mut first = None;
            coordinates(scene, pair, &mut |v| {
                if !context.is_locked(v) {
                    let (a, b) = (self.root(*first.get_or_insert(v)), self.root(v));
                    self.parent[a.max(b)] = a.min(b);
                }
            });
            self.roots.push((first.unwrap_or(0), pair));
        }
        let is_one = context.metric.kind() != MetricKind::Joint;
        for k in 0..self.roots.len() {
            self.roots[k].0 = if is_one { 0 } else { self.root(self.roots[k].0) };
        }
        self.roots.sort_unstable();
        self.pairs.clear();
        self.ends.clear();
        for (k, (root, pair)) in self.roots.iter().enumerate() {
            if k > 0 && self.roots[k - 1].0 != *root {
                self.ends.push(k);
            }
            self.pairs.push(*pair);
        }
        if !self.pairs.is_empty() {
            self.ends.push(self.pairs.len());
        }
    }

    /// The pairs of each group.
    pub fn iter(&self) -> impl Iterator<Item = &[PairId]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.pairs[start..*end])
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// Whether a tangent coordinate moves a pair of a group.
    pub fn holds(&self, group: usize, v: usize) -> bool {
        let start = if group == 0 { 0 } else { self.ends[group - 1] };
        self.roots[start].0 == self.root(v)
    }

    fn root(&self, mut v: usize) -> usize {
        while self.parent[v] != v {
            v = self.parent[v];
        }
        v
    }
}

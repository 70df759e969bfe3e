//! Finds a path through a roadmap.

use std::collections::VecDeque;

use super::components::Components;
use super::grower::{Grower, NEIGHBOURS};
use super::kept::Roadmap;

impl Grower<'_, '_> {
    pub fn are_joined(&self, a: usize, b: usize) -> bool {
        self.components.root(a) == self.components.root(b)
    }

    /// Returns the path between two nodes; `None` if they are not joined, or if the budget ends
    /// before all of it is proved.
    ///
    /// # Guarantee
    /// Every edge is proved in this call, whatever scene the roadmap was made for. Edges that are
    /// not are removed, and their nodes are joined anew if possible.
    pub fn solve(&mut self, from: usize, to: usize) -> Option<Vec<Vec<f64>>> {
        while self.are_joined(from, to) {
            let path = branch(self.roadmap, from, to)?;
            let mut prover = self.prover();
            let mut is_proved = |pair: &[usize]| {
                let [a, b] = [pair[0], pair[1]].map(|node| self.roadmap.config(node));
                prover.holds(a) && prover.proves(a, b)
            };
            let bad: Vec<[usize; 2]> =
                path.windows(2).filter(|pair| !is_proved(pair)).map(|pair| [pair[0], pair[1]]).collect();
            let is_spent = prover.is_spent();
            self.spend(prover.checks);
            if bad.is_empty() {
                return Some(path.iter().map(|node| self.roadmap.config(*node).to_vec()).collect());
            }
            // Edges that are not proved for want of checks may well be free, so they stay.
            if is_spent {
                return None;
            }
            self.forget(&bad);
        }
        None
    }

    fn forget(&mut self, bad: &[[usize; 2]]) {
        let is_bad = |[a, b]: &[u32; 2]| {
            let edge = [*a as usize, *b as usize];
            bad.contains(&edge) || bad.contains(&[edge[1], edge[0]])
        };
        self.roadmap.edges.retain(|edge| !is_bad(edge));
        self.components = Components::new(self.roadmap.len(), &self.roadmap.edges);
        let mut prover = self.prover();
        for node in bad.iter().flatten() {
            let q = self.roadmap.config(*node).to_vec();
            if prover.holds(&q) {
                let mut near = self.nodes.near(&q, NEIGHBOURS + 1);
                near.retain(|other| !self.are_joined(*node, *other));
                let joinable = self.joinable(&q, &near, &mut prover);
                self.join(*node, &joinable);
            }
        }
        self.spend(prover.checks);
    }
}

/// Returns the nodes from one to another in a forest, breadth first.
fn branch(roadmap: &Roadmap, from: usize, to: usize) -> Option<Vec<usize>> {
    let mut edges = vec![Vec::new(); roadmap.len()];
    for [a, b] in &roadmap.edges {
        edges[*a as usize].push(*b as usize);
        edges[*b as usize].push(*a as usize);
    }
    let mut parents = vec![None; roadmap.len()];
    let mut queue = VecDeque::from([to]);
    parents[to] = Some(to);
    while let Some(node) = queue.pop_front() {
        if node == from {
            let up = |node: &usize| parents[*node].filter(|parent| parent != node);
            return Some(std::iter::successors(Some(from), up).collect());
        }
        for next in &edges[node] {
            if parents[*next].is_none() {
                parents[*next] = Some(node);
                queue.push_back(*next);
            }
        }
    }
    None
}

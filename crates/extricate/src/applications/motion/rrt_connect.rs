//! Two trees that grow toward each other by proved edges.

use rand_chacha::ChaCha8Rng;

use super::nodes::Nodes;
use super::prover::Prover;
use crate::metric::Metric;

/// Draws a configuration to grow toward.
pub type Sample<'a> = dyn FnMut(&mut ChaCha8Rng, &mut [f64]) + 'a;

/// Two trees, from some configurations to others. They grow on from where they were left.
///
/// # Source
/// J. J. Kuffner and S. M. LaValle, "RRT-Connect: an efficient approach to single-query path
/// planning", ICRA 2000, doi:10.1109/ROBOT.2000.844730. Deviations: edges are proved instead of
/// sampled, and either tree may have several roots.
pub struct RrtConnect<'a> {
    trees: [Tree<'a>; 2],
    /// Index of the tree that grows next.
    grows: usize,
    /// Longest edge, in metric units.
    range: f64,
}

impl<'a> RrtConnect<'a> {
    /// Takes the roots of both trees, all in the set in which they are to grow.
    pub fn new(metric: &'a Metric, roots: [&[Vec<f64>]; 2], range: f64) -> Self {
        Self { trees: roots.map(|roots| Tree::new(metric, roots)), grows: 0, range }
    }

    /// Grows until the trees meet: returns a path in the prover's set, from one of the first roots
    /// to one of the second. Returns `None` if the budget ends before.
    ///
    /// # Guarantee
    /// Every edge is proved. The same roots, random numbers and budgets of checks give the same
    /// path.
    pub fn grow(&mut self, prover: &mut Prover, sample: &mut Sample, rng: &mut ChaCha8Rng) -> Option<Vec<Vec<f64>>> {
        let mut target = vec![0.0; prover.checker.scene().space.nq()];
        while !prover.is_spent() {
            sample(rng, &mut target);
            let grows = self.grows;
            self.grows = 1 - grows;
            let Some((new, _)) = self.trees[grows].extend(prover, &target, self.range) else { continue };
            let goal = self.trees[grows].nodes.config(new).to_vec();
            while let Some((met, is_there)) = self.trees[1 - grows].extend(prover, &goal, self.range) {
                if is_there {
                    return Some(self.joined(if grows == 0 { [new, met] } else { [met, new] }));
                }
                if prover.is_spent() {
                    break;
                }
            }
        }
        None
    }

    /// Returns the grown nodes of each tree, with indices of their parents. Roots are counted
    /// first.
    pub fn grown(&self) -> [Vec<(Vec<f64>, usize)>; 2] {
        [0, 1].map(|side| {
            let tree = &self.trees[side];
            let grown = tree.parents.iter().enumerate();
            grown.filter_map(|(node, parent)| parent.map(|from| (tree.nodes.config(node).to_vec(), from))).collect()
        })
    }

    /// Joins the branches to a node of the first tree and to one of the second at the same
    /// configuration.
    fn joined(&self, [first, second]: [usize; 2]) -> Vec<Vec<f64>> {
        let [from, to] = &self.trees;
        let mut path = from.branch(first);
        path.reverse();
        path.extend(to.branch(second).into_iter().skip(1));
        path
    }
}

struct Tree<'a> {
    nodes: Nodes<'a>,
    parents: Vec<Option<usize>>,
}

impl<'a> Tree<'a> {
    fn new(metric: &'a Metric, roots: &[Vec<f64>]) -> Self {
        let mut nodes = Nodes::new(metric);
        roots.iter().for_each(|root| {
            nodes.push(root);
        });
        Self { nodes, parents: vec![None; roots.len()] }
    }

    /// Adds an edge from the nearest node toward `target`, at most `range` long. Returns its end
    /// and whether that is at the target; `None` if the edge is not proved.
    fn extend(&mut self, prover: &mut Prover, target: &[f64], range: f64) -> Option<(usize, bool)> {
        let near = self.nodes.nearest(target)?;
        let from = self.nodes.config(near);
        let distance = self.nodes.metric().distance(from, target);
        if distance <= 0.0 {
            return Some((near, true));
        }
        let mut to = target.to_vec();
        if distance > range {
            prover.checker.scene().space.interpolate(from, target, range / distance, &mut to);
        }
        if !prover.proves(from, &to) {
            return None;
        }
        self.parents.push(Some(near));
        Some((self.nodes.push(&to), distance <= range))
    }

    /// Returns the configurations of a node, its parent and so on to the root.
    fn branch(&self, node: usize) -> Vec<Vec<f64>> {
        let up = std::iter::successors(Some(node), |node| self.parents[*node]);
        up.map(|node| self.nodes.config(node).to_vec()).collect()
    }
}

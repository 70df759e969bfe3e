//! Two trees that grow toward each other by proved edges, straight or along contacts.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::nodes::Nodes;
use super::prover::Prover;
use super::slide::Slider;
use crate::cspace::ConfigSpace;
use crate::metric::Metric;

/// Longest edge of trees in the whole space, as a share of the metric's diameter. A half takes
/// twice the checks in open scenes (`bench/applications open`).
pub const MAX_EDGE_SHARE: f64 = 0.2;
/// Steps of a slide toward a sample; three times as many lead toward the other tree.
const SLIDE_STEPS: usize = 40;
/// Longest step of a slide, as a share of the longest edge. With half or twice as much a peg in a
/// hole of 1.05 times its width takes 1.5 to 3 times the checks.
const SLIDE_STEP_SHARE: f64 = 0.2;
/// A node failed if the tree comes nearer by less than this share of a slide's longest step.
const STUCK_SHARE: f64 = 0.2;
/// A tree stops growing toward a target if projecting a step leaves less than this share of its
/// gain, as in a corner of what keeps the links.
const MIN_GAIN_SHARE: f64 = 0.1;
/// Nearest nodes among which the one that failed least for its distance grows.
const CANDIDATES: usize = 16;
/// Share of samples that keep some factors of the node nearest to them. Without such samples a
/// chain of eight joints in a corridor takes several hundred times the checks.
const SUBSET_SHARE: f64 = 0.5;

/// Draws a configuration to grow toward.
pub type Sample<'a> = dyn FnMut(&mut ChaCha8Rng, &mut [f64]) + 'a;

/// Two trees, from some configurations to others. They grow on from where they were left.
///
/// # Source
/// J. J. Kuffner and S. M. LaValle, "RRT-Connect: an efficient approach to single-query path
/// planning", ICRA 2000, doi:10.1109/ROBOT.2000.844730. Deviations: edges are proved instead of
/// sampled, and may slide along contacts; either tree may have several roots; a node that failed is
/// chosen less; half of the samples keep some factors of a node. If links are kept, samples and
/// steps are projected to where they are, as in CBiRRT (see `Prover::advance`).
pub struct RrtConnect<'a> {
    trees: [Tree<'a>; 2],
    /// Index of the tree that grows next.
    grows: usize,
    /// Longest edge, in metric units.
    range: f64,
    /// For edges along contacts; `None` if only straight ones are tried.
    slider: Option<Slider<'a>>,
    /// Whether nothing was grown yet.
    is_new: bool,
}

impl<'a> RrtConnect<'a> {
    /// Takes the roots of both trees, all in the set in which they are to grow.
    pub fn new(metric: &'a Metric, roots: [&[Vec<f64>]; 2], range: f64) -> Self {
        Self { trees: roots.map(|roots| Tree::new(metric, roots)), grows: 0, range, slider: None, is_new: true }
    }

    /// Lets edges slide along contacts too. That finds into tight holes. If the trees have only a
    /// few hundred checks, as in gaps of repairs, straight edges find more.
    pub fn sliding(mut self) -> Self {
        self.slider = Some(Slider::new(self.trees[0].nodes.metric(), SLIDE_STEP_SHARE * self.range));
        self
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
            let grows = self.grows;
            self.grows = 1 - grows;
            // A slide to the other root may lead all the way; a straight edge was tried before.
            let is_first = self.slider.is_some() && std::mem::replace(&mut self.is_new, false);
            if is_first {
                target.copy_from_slice(self.trees[1 - grows].nodes.config(0));
            } else {
                sample(rng, &mut target);
                if rng.random_bool(SUBSET_SHARE) {
                    self.trees[grows].keep_some(&prover.checker.scene().space, &mut target, rng);
                }
                if !prover.project(&mut target) {
                    continue;
                }
            }
            let grown = self.trees[grows].grow(prover, self.slider.as_mut(), &target, (self.range, 1), SLIDE_STEPS);
            if grown.is_stuck && !is_first {
                continue;
            }
            let goal = self.trees[grows].nodes.config(grown.node).to_vec();
            let other = &mut self.trees[1 - grows];
            let met = other.grow(prover, self.slider.as_mut(), &goal, (self.range, usize::MAX), 3 * SLIDE_STEPS);
            if met.is_there {
                let (new, met) = (grown.node, met.node);
                return Some(self.joined(if grows == 0 { [new, met] } else { [met, new] }));
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

/// Result of growing a tree toward a target.
struct Grown {
    node: usize,
    is_there: bool,
    /// Whether no node was added.
    is_stuck: bool,
}

struct Tree<'a> {
    nodes: Nodes<'a>,
    parents: Vec<Option<usize>>,
    /// How often each node was chosen and came hardly nearer.
    failures: Vec<u32>,
}

impl<'a> Tree<'a> {
    fn new(metric: &'a Metric, roots: &[Vec<f64>]) -> Self {
        let mut nodes = Nodes::new(metric);
        roots.iter().for_each(|root| {
            nodes.push(root);
        });
        Self { nodes, parents: vec![None; roots.len()], failures: vec![0; roots.len()] }
    }

    /// Grows from a node near `target` toward it: by up to `straight` proved edges, at most `range`
    /// long, then along contacts.
    fn grow(
        &mut self,
        prover: &mut Prover,
        slider: Option<&mut Slider>,
        target: &[f64],
        (range, straight): (f64, usize),
        most_steps: usize,
    ) -> Grown {
        let metric = self.nodes.metric();
        let near = self.node_near(target, if slider.is_some() { CANDIDATES } else { 1 });
        let (mut last, mut from) = (near, self.nodes.config(near).to_vec());
        let begun = metric.distance(&from, target);
        let (mut distance, mut edges) = (begun, 0);
        while distance > 0.0 && edges < straight {
            let (space, mut to) = (&prover.checker.scene().space, target.to_vec());
            if distance > range {
                let share = range / distance;
                space.interpolate(&from, target, share, &mut to);
                let most = (1.0 - MIN_GAIN_SHARE * share) * space.distance(&from, target);
                if prover.is_held() && !(prover.project(&mut to) && space.distance(&to, target) <= most) {
                    break;
                }
            }
            if prover.is_spent() {
                break;
            }
            let (way, is_there) = prover.advance(&from, &to);
            way.iter().for_each(|q| last = self.push(q, last));
            distance = match is_there && distance <= range {
                true => 0.0,
                false => metric.distance(self.nodes.config(last), target),
            };
            if !is_there {
                break;
            }
            (from, edges) = (to, edges + 1);
        }
        let mut is_there = distance <= 0.0;
        if let Some(slider) = slider.filter(|_| !is_there && edges < straight) {
            is_there = slider.slide(prover, &from, target, most_steps, &mut |q| last = self.push(q, last));
            distance = metric.distance(self.nodes.config(last), target);
        }
        self.failures[near] += u32::from(begun - distance < STUCK_SHARE * SLIDE_STEP_SHARE * range);
        Grown { node: last, is_there, is_stuck: last == near }
    }

    /// Returns that of the nearest nodes with the least distance to `target` times the root of one
    /// more than its failures: else a node that is stuck would be tried again and again.
    fn node_near(&self, target: &[f64], candidates: usize) -> usize {
        let weighted = |node: &usize| {
            let distance = self.nodes.metric().distance(self.nodes.config(*node), target);
            distance * f64::from(1 + self.failures[*node]).sqrt()
        };
        let near = self.nodes.near(target, candidates).into_iter();
        near.min_by(|a, b| weighted(a).total_cmp(&weighted(b))).expect("trees have roots")
    }

    /// Replaces some factors of a drawn configuration by those of the node nearest to it. A tree
    /// then grows from there in the other factors alone, so a chain with no room along its length
    /// can still move its end.
    fn keep_some(&self, space: &ConfigSpace, target: &mut [f64], rng: &mut ChaCha8Rng) {
        let node = self.nodes.config(self.node_near(target, 1));
        let factors = space.factors();
        let redrawn = rng.random_range(1..=factors.len());
        let only_last = rng.random_bool(0.5);
        for (at, factor) in factors.iter().enumerate() {
            let is_kept =
                if only_last { at + redrawn < factors.len() } else { rng.random_range(0..factors.len()) >= redrawn };
            if is_kept {
                target[factor.coordinates()].copy_from_slice(&node[factor.coordinates()]);
            }
        }
    }

    fn push(&mut self, q: &[f64], parent: usize) -> usize {
        self.parents.push(Some(parent));
        self.failures.push(0);
        self.nodes.push(q)
    }

    /// Returns the configurations of a node, its parent and so on to the root.
    fn branch(&self, node: usize) -> Vec<Vec<f64>> {
        let up = std::iter::successors(Some(node), |node| self.parents[*node]);
        up.map(|node| self.nodes.config(node).to_vec()).collect()
    }
}

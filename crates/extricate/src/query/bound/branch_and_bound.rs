//! Branch and bound over separating directions: proves that no free configuration is nearer than a
//! share of the depth, or finds one.
//!
//! A node is a set of half-spaces of displacements from the query; every free configuration that is
//! near enough lies in some node. The least-norm point of a node bounds it from below. To expand a
//! node, check its point. If it is free, it is the nearest of its node. Otherwise two bodies
//! overlap there, and every free configuration parts them along a direction of one of a few cells
//! (`cells`). Each cell is a choice of three half-spaces that cut the point off, so the node splits
//! into as many nodes as there are half-spaces.
//!
//! With `d` the displacement from the point `x`, points part along `n` by at most
//! `g . d + l |d|^2 / 2 + K |d|^3 / 6`, where `l` bounds the eigenvalues of the Hessian. Every
//! point of a node nearer than `r` has `|d|^2 <= r^2 - |x|^2`, as `x` is its least-norm point. So
//! half-spaces grow exact as bounds rise.
//!
//! Displacements are tangent vectors times the roots of the weights. The search therefore needs the
//! joint metric, and joints whose displacements add, which those of ball joints do not.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::cells::{Cells, Parting};
use super::half_spaces::Around;
use crate::collision::{CheckScratch, ConvexPair};
use crate::cspace::Manifold;
use crate::math::linear_algebra::dot;
use crate::math::quadratic_form::QuadraticForm;
use crate::math::{Pose, Vec3};
use crate::metric::pair_motion::PairMotion;
use crate::query::context::Context;
use crate::query::groups::coordinates;
use crate::query::qp::{Qp, QpOutcome};
use crate::scene::PairId;

/// Most splits and close bounds of cells of the chosen pair, if no ancestor restricts its
/// directions.
const SPLITS: usize = 96;
/// The same while the pair is chosen, or if an ancestor restricts its directions to a cone.
const FIRST_SPLITS: usize = 24;
/// Most successive repeats of a point that are expanded, each with twice as many splits.
const MAX_REPEATS: u32 = 1;
/// Most numbers in all nodes together: 512 MiB.
const MAX_NODE_NUMBERS: usize = 1 << 26;

/// A branch-and-bound search and its memory.
#[derive(Default)]
pub struct Branches {
    /// Root of the weight of each tangent coordinate.
    roots: Vec<f64>,
    /// Whether each coordinate is searched; the others keep their values of `base`.
    holds: Vec<bool>,
    base: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    nodes: Vec<Node>,
    /// The half-space and the least-norm point of each node, `2 nv` numbers.
    numbers: Vec<f64>,
    open: BinaryHeap<Open>,
    qp: Qp,
    identity: QuadraticForm,
    zero: Vec<f64>,
    cells: Cells,
    motion: PairMotion,
    pairs: Vec<PairId>,
    poses: Vec<Pose>,
    config: Vec<f64>,
    tangent: Vec<f64>,
    best: Vec<Cut>,
    /// Least bound of the nodes that cannot be expanded.
    stuck: f64,
    bound: f64,
    expanded: usize,
}

/// The half-space `row . e >= offset` of displacements `e`. No configuration of its node is nearer
/// than `near`.
#[derive(Debug, Clone)]
struct Cut {
    row: Vec<f64>,
    offset: f64,
    near: f64,
    parts: Option<[usize; 2]>,
    cone: [Vec3; 3],
}

#[derive(Debug, Clone, Copy)]
struct Node {
    parent: usize,
    /// Offset of its half-space; the half-space of the root holds everything.
    offset: f64,
    /// Number of successive ancestors with the same point.
    repeats: u32,
    /// The two convex sets that part in this node, and the cone of their directions.
    parts: Option<[usize; 2]>,
    cone: [Vec3; 3],
}

#[derive(Debug, Clone, Copy)]
struct Open {
    bound: f64,
    node: usize,
}

/// The outcome of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// No node is nearer than the target.
    Closed,
    /// One node was expanded.
    Open,
    /// [`Branches::config`] is free, at this distance.
    Free(f64),
    /// The nearest node cannot be expanded, or the memory for nodes is spent.
    Full,
}

impl Branches {
    /// Whether the metric and the joints that may move allow branch and bound.
    pub fn can_search(context: &Context) -> bool {
        let space = &context.checker.scene().space;
        let is_free = |v: usize| !context.is_locked(v);
        context.metric.kind() == crate::scene::MetricKind::Joint
            && !space.factors().iter().any(|f| f.manifold == Manifold::Rotation && is_free(f.v))
    }

    /// Begins at the query `q`, over all coordinates or over those of a group that `holds` marks.
    /// The others keep their values of `base`, and pairs that they move are ignored.
    pub fn begin(&mut self, context: &Context, q: &[f64], holds: Option<&[bool]>, base: &[f64]) {
        let space = &context.checker.scene().space;
        let nv = space.nv();
        for list in [&mut self.roots, &mut self.low, &mut self.high, &mut self.zero] {
            list.clear();
            list.resize(nv, 0.0);
        }
        self.holds.clear();
        match holds {
            Some(holds) => self.holds.extend_from_slice(holds),
            None => self.holds.resize(nv, true),
        }
        self.base.clear();
        self.base.extend_from_slice(base);
        for factor in space.factors() {
            let root = factor.weight.sqrt();
            for v in factor.tangents() {
                self.roots[v] = root;
                let (low, high) = match factor.manifold {
                    _ if context.is_locked(factor.v) || !self.holds[v] => (0.0, 0.0),
                    Manifold::Interval { lower, upper } => (lower - q[factor.q], upper - q[factor.q]),
                    Manifold::Circle | Manifold::Rotation => (-std::f64::consts::PI, std::f64::consts::PI),
                };
                (self.low[v], self.high[v]) = (root * low, root * high);
            }
        }
        self.identity = QuadraticForm::identity(nv);
        self.nodes.clear();
        self.numbers.clear();
        self.open.clear();
        (self.bound, self.stuck, self.expanded) = (0.0, f64::INFINITY, 0);
        self.nodes.push(Node { parent: usize::MAX, offset: 0.0, repeats: 0, parts: None, cone: [Vec3::zeros(); 3] });
        let nearest: Vec<f64> = (0..nv).map(|v| 0f64.clamp(self.low[v], self.high[v])).collect();
        self.numbers.resize(nv, 0.0);
        self.numbers.extend_from_slice(&nearest);
        self.open.push(Open { bound: norm(&nearest), node: 0 });
    }

    /// Proved: no free configuration is nearer than this (metric units).
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Number of nodes expanded since [`Branches::begin`].
    pub fn expanded(&self) -> usize {
        self.expanded
    }

    /// Returns the distance of a configuration from `q` in the coordinates that are searched.
    pub fn length(&mut self, context: &Context, q: &[f64], config: &[f64]) -> f64 {
        self.tangent.resize(self.roots.len(), 0.0);
        context.checker.scene().space.difference(q, config, &mut self.tangent);
        let of = |(v, tangent): (usize, &f64)| if self.holds[v] { (tangent * self.roots[v]).powi(2) } else { 0.0 };
        self.tangent.iter().enumerate().map(of).sum::<f64>().sqrt()
    }

    /// Returns the configuration at the point that was expanded last.
    pub fn config(&self) -> &[f64] {
        &self.config
    }

    /// Expands the nearest node, unless none is nearer than `target`.
    pub fn step(&mut self, context: &Context, q: &[f64], target: f64, check: &mut CheckScratch) -> Step {
        let nv = self.roots.len();
        let nearest = self.open.peek().map_or(f64::INFINITY, |open| open.bound).min(self.stuck);
        self.bound = self.bound.max(nearest.min(target));
        if nearest >= target {
            return Step::Closed;
        }
        let Some(&Open { bound, node }) = self.open.peek() else { return Step::Full };
        if self.stuck <= bound {
            return Step::Full;
        }
        if self.numbers.len() > MAX_NODE_NUMBERS {
            return Step::Full;
        }
        self.open.pop();
        self.expanded += 1;
        let point = self.numbers[(2 * node + 1) * nv..][..nv].to_vec();
        self.place(context, q, &point);
        let checker = context.checker;
        self.pairs.clear();
        checker.colliding_pairs(&self.config, check, &mut self.pairs);
        self.pairs.retain(|pair| {
            let mut is_of_these = true;
            coordinates(checker.scene(), *pair, &mut |v| is_of_these &= self.holds[v] || context.is_locked(v));
            is_of_these
        });
        if self.pairs.is_empty() {
            return Step::Free(norm(&point));
        }
        self.poses.clear();
        self.poses.extend_from_slice(check.poses());
        if self.nodes[node].repeats > MAX_REPEATS || !self.cut(context, &point, (bound, target), node, check) {
            self.stuck = self.stuck.min(bound);
            return Step::Open;
        }
        self.branch(node, &point, (bound, target));
        Step::Open
    }

    /// Sets `config` to the configuration at a displacement.
    fn place(&mut self, context: &Context, q: &[f64], point: &[f64]) {
        let space = &context.checker.scene().space;
        self.tangent.clear();
        self.tangent.extend(point.iter().zip(&self.roots).map(|(e, root)| e / root));
        self.config.resize(space.nq(), 0.0);
        space.integrate(q, &self.tangent, &mut self.config);
        for factor in space.factors().iter().filter(|factor| !self.holds[factor.v]) {
            self.config[factor.coordinates()].copy_from_slice(&self.base[factor.coordinates()]);
        }
    }

    /// Fills `best` with the half-spaces of the pair whose nearest half-space is farthest. Returns
    /// whether they hold every free configuration nearer than the target.
    fn cut(
        &mut self,
        context: &Context,
        point: &[f64],
        limits: (f64, f64),
        node: usize,
        check: &mut CheckScratch,
    ) -> bool {
        let Self { nodes, cells, motion, pairs, poses, best, config, .. } = self;
        let (checker, (bound, target)) = (context.checker, limits);
        let mut around = Around::new(context.metric, (poses, motion), point, target);
        best.clear();
        // Bound each pair roughly, then split the cells of the one that proves most.
        let (mut promising, mut most, mut number) = (None, f64::NEG_INFINITY, 0);
        checker.inner_pairs(config, pairs, check, &mut |pair| {
            if most < target {
                around.add_pair(context, pair);
                let cone = cone_of(nodes, node, pair).map(|cone| around.to_world(cone));
                let found = cells.cover(pair, cone, &mut around, target, FIRST_SPLITS);
                if found > most {
                    (promising, most) = (Some(number), found);
                }
            }
            number += 1;
        });
        if most >= target {
            return true;
        }
        let (mut is_whole, mut at) = (promising.is_some(), 0);
        checker.inner_pairs(config, pairs, check, &mut |pair| {
            if Some(at) == promising {
                around.add_pair(context, pair);
                let cone = cone_of(nodes, node, pair).map(|cone| around.to_world(cone));
                let splits = if cone.is_some() { FIRST_SPLITS } else { SPLITS };
                cells.cover(pair, cone, &mut around, target, splits << nodes[node].repeats);
                is_whole = add_cuts(&mut around, cells, pair, (bound, target), best);
            }
            at += 1;
        });
        is_whole
    }

    /// Adds a node for each half-space of `best` that is nearer than the target.
    fn branch(&mut self, node: usize, point: &[f64], (bound, target): (f64, f64)) {
        let nv = self.roots.len();
        let best = std::mem::take(&mut self.best);
        for cut in &best {
            self.qp.reset(nv);
            self.qp.set_box(&self.low, &self.high);
            self.qp.push(cut.offset).copy_from_slice(&cut.row);
            let mut at = node;
            while at != 0 {
                let Node { parent, offset, .. } = self.nodes[at];
                self.qp.push(offset).copy_from_slice(&self.numbers[2 * at * nv..][..nv]);
                at = parent;
            }
            let outcome = self.qp.solve(&self.identity, &self.zero, 0.5 * target * target);
            match outcome {
                QpOutcome::Above => continue,
                QpOutcome::Infeasible if self.is_far_from_feasible(target) => continue,
                QpOutcome::Infeasible | QpOutcome::Solved => {}
            }
            let near = (norm(&self.qp.step) * (1.0 - 1e-9)).max(bound).max(cut.near);
            if near >= target {
                continue;
            }
            let new = self.nodes.len();
            let off: f64 = self.qp.step.iter().zip(point).map(|(x, y)| (x - y).abs()).sum();
            let repeats = if off > 1e-6 * target { 0 } else { self.nodes[node].repeats + 1 };
            self.nodes.push(Node { parent: node, offset: cut.offset, repeats, parts: cut.parts, cone: cut.cone });
            self.numbers.extend_from_slice(&cut.row);
            self.numbers.extend_from_slice(&self.qp.step);
            self.open.push(Open { bound: near, node: new });
        }
        self.best = best;
    }

    /// Whether the infeasible program misses a row by more than rounding. Within `target`, no
    /// multiple of the remainder of a row that the others span to ten digits can compensate such a
    /// miss.
    fn is_far_from_feasible(&self, target: f64) -> bool {
        self.qp.largest_violation() > 1e-4 * target
    }
}

/// Returns the cone along which the sets of a pair part, as the nearest ancestor restricts it.
fn cone_of(nodes: &[Node], node: usize, pair: &ConvexPair) -> Option<[Vec3; 3]> {
    let parts = pair.parts()?;
    let mut at = node;
    while at != 0 && nodes[at].parts != Some(parts) {
        at = nodes[at].parent;
    }
    (at != 0).then(|| nodes[at].cone)
}

/// Adds the half-spaces of all open cells; `false` if no coordinate moves the points of one of them
/// along its direction.
fn add_cuts(
    around: &mut Around,
    cells: &Cells,
    pair: &ConvexPair,
    (bound, target): (f64, f64),
    cuts: &mut Vec<Cut>,
) -> bool {
    for cell in cells.open(target) {
        let (points, inequalities) = cell.inequalities(pair);
        let cone = around.in_common(cell.cone());
        around.place(points.each_ref());
        for half in around.choice(&inequalities) {
            let Some((row, offset)) = around.row(&half) else { return false };
            cuts.push(Cut { row, offset, near: half.near.max(bound), parts: pair.parts(), cone });
        }
    }
    true
}

impl Ord for Open {
    /// The nearest node is the greatest; ties go to the newest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(self.node.cmp(&other.node))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Open {}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

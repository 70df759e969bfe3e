//! Branch and bound over separating directions: proves that nothing free is nearer than a share of
//! the depth, or finds it.
//!
//! A node is a set of half-spaces of displacements from the query; all free configurations that are
//! near enough lie in one node or another. The least-norm point of a node bounds it from below. To
//! expand a node, its point is looked at: where it is free, it is the nearest of its node.
//! Otherwise two bodies overlap there, and whatever is free parts them along a direction: along one
//! of a few cells (`cells`), each a choice of three half-spaces, which cut the point off. So the
//! node falls into as many nodes as there are half-spaces.
//!
//! With `d` the displacement from the point `x`, points part along `n` by at most `g . d + l |d|^2
//! / 2 + K |d|^3 / 6`, where `l` bounds the eigenvalues of the Hessian. All of a node that is
//! nearer than `r` has `|d|^2 <= r^2 - |x|^2`, as `x` is its least-norm point. So half-spaces grow
//! exact as bounds rise.
//!
//! Displacements are tangent vectors times the roots of the weights, so this is of the joint
//! metric, and of joints whose displacements add: not of ball joints.

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

/// Splits of cells for each pair that is looked at.
const SPLITS: usize = 96;
/// And to choose one.
const FIRST_SPLITS: usize = 24;
/// How often a point is looked at with twice as many, before it is given up.
const MOST_REPEATS: u32 = 1;
/// Numbers that the nodes may hold.
const MOST_NUMBERS: usize = 1 << 26;

/// One search, and its memory.
#[derive(Default)]
pub struct Branches {
    /// Roots of the weights, by tangent coordinate.
    roots: Vec<f64>,
    /// Which coordinates are searched; the others stay where `base` has them.
    holds: Vec<bool>,
    base: Vec<f64>,
    /// Limits of displacements.
    low: Vec<f64>,
    high: Vec<f64>,
    nodes: Vec<Node>,
    /// Of every node its half-space and its least-norm point.
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
    /// Nearest of the nodes that cannot be expanded.
    stuck: f64,
    /// What is proved.
    bound: f64,
    expanded: usize,
}

/// `row . e >= offset` for displacements `e`, and how near the node is at least.
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
    /// Of its half-space; that of the root holds everything.
    offset: f64,
    /// How often its point was looked at before without being cut off.
    repeats: u32,
    /// Two sets, and the cone of directions along which they part in it.
    parts: Option<[usize; 2]>,
    cone: [Vec3; 3],
}

#[derive(Debug, Clone, Copy)]
struct Open {
    bound: f64,
    node: usize,
}

/// What a step came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Nothing is left that is nearer than the target.
    Closed,
    /// A node was expanded.
    Open,
    /// [`Branches::config`] is free, at this distance.
    Free(f64),
    /// There is no room for more nodes.
    Full,
}

impl Branches {
    /// Whether displacements of the context's joints add.
    pub fn can_search(context: &Context) -> bool {
        let space = &context.checker.scene().space;
        let is_free = |v: usize| !context.is_locked(v);
        context.metric.kind() == crate::scene::MetricKind::Joint
            && !space.factors().iter().any(|f| f.manifold == Manifold::Rotation && is_free(f.v))
    }

    /// Begins at the query `q`: over all coordinates, or those that a group of pairs `holds`, while
    /// the others stay where `base` has them and pairs that they move are not looked at.
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

    /// Proved: nothing free is nearer (metric units).
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Nodes that were expanded.
    pub fn expanded(&self) -> usize {
        self.expanded
    }

    /// How far a configuration is from `q` by the coordinates that are searched.
    pub fn length(&mut self, context: &Context, q: &[f64], config: &[f64]) -> f64 {
        self.tangent.resize(self.roots.len(), 0.0);
        context.checker.scene().space.difference(q, config, &mut self.tangent);
        let of = |(v, tangent): (usize, &f64)| if self.holds[v] { (tangent * self.roots[v]).powi(2) } else { 0.0 };
        self.tangent.iter().enumerate().map(of).sum::<f64>().sqrt()
    }

    /// The configuration that was looked at last.
    pub fn config(&self) -> &[f64] {
        &self.config
    }

    /// Expands the nearest node, unless all are at least as far as `target`.
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
        if self.numbers.len() > MOST_NUMBERS {
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
        if self.nodes[node].repeats > MOST_REPEATS || !self.cut(context, &point, (bound, target), node, check) {
            self.stuck = self.stuck.min(bound);
            return Step::Open;
        }
        self.branch(node, &point, (bound, target));
        Step::Open
    }

    /// `config` becomes the one at a displacement.
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

    /// `best` becomes the half-spaces of the pair whose nearest one is farthest; whether there are
    /// some that hold all that is free.
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
        // A look at each tells which to look at closely.
        let (mut promising, mut most, mut number) = (None, f64::NEG_INFINITY, 0);
        checker.inner_pairs(config, pairs, check, &mut |pair| {
            if most < target {
                around.look_at(context, pair);
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
                around.look_at(context, pair);
                let cone = cone_of(nodes, node, pair).map(|cone| around.to_world(cone));
                let splits = if cone.is_some() { FIRST_SPLITS } else { SPLITS };
                cells.cover(pair, cone, &mut around, target, splits << nodes[node].repeats);
                is_whole = add_cuts(&mut around, cells, pair, (bound, target), best);
            }
            at += 1;
        });
        is_whole
    }

    /// A node for each half-space of `best` that is nearer than the target.
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

    /// Whether a row that no step was found for is missed by more than rounding: within `target`,
    /// no multiple of what is left of a row that the others span to ten digits can make up for it.
    fn is_far_from_feasible(&self, target: f64) -> bool {
        self.qp.largest_violation() > 1e-4 * target
    }
}

/// The cone along which the sets of a pair part in a node, as the nodes above it have it.
fn cone_of(nodes: &[Node], node: usize, pair: &ConvexPair) -> Option<[Vec3; 3]> {
    let parts = pair.parts()?;
    let mut at = node;
    while at != 0 && nodes[at].parts != Some(parts) {
        at = nodes[at].parent;
    }
    (at != 0).then(|| nodes[at].cone)
}

/// The half-spaces of all open cells; `false` where some direction holds or not whatever moves.
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
    /// The nearest is the greatest; of several the newest.
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

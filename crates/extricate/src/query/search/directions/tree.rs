//! The tree of displacements along which colliding bodies part, shortest first. It starts no
//! descents.

use super::choices::{Choices, Measure};
use crate::collision::CheckScratch;
use crate::cspace::Manifold;
use crate::kinematics::{Twists, forward};
use crate::math::linear_algebra::dot;
use crate::math::{Pose, Vec3, sphere};
use crate::query::context::Context;
use crate::query::local_metric::LocalMetric;
use crate::query::qp::{Qp, QpOutcome};
use crate::scene::PairId;

/// Directions that a pair may choose from, evenly spread.
const DIRECTIONS: usize = 32;
/// Choices of a pair that are followed, those of the shortest displacements.
const MOST_CHILDREN: usize = 5;
/// Of two whose displacements have a cosine of more than this, the shorter.
const LIKE_DIRECTION: f64 = 0.95;
/// Displacements aim this \[m\] beyond the clearance.
const SLACK: f64 = 1e-6;
/// A half-space is followed where the limits let a displacement come into it by more than this
/// factor.
const WITHIN_LIMITS: f64 = 1.05;
/// Turns without limits, and rotations, are displaced by at most this \[rad\].
const FARTHEST_TURN: f64 = 2.0;

/// The search tree, and memory for it.
#[derive(Default)]
pub struct Directions {
    sphere: Vec<Vec3>,
    /// In the order in which they were made.
    pub nodes: Vec<Node>,
    /// Whether the query is beyond the limits.
    pub begins_outside: bool,
    /// Displacements from the query, and what the last choice of each node asks of them; `nv`
    /// numbers a node.
    pub steps: Vec<f64>,
    rows: Vec<f64>,
    /// Limits of displacements.
    pub low: Vec<f64>,
    high: Vec<f64>,
    /// Of the pair that is measured, and of the one that has to move farthest.
    measured: Choices,
    farthest: Choices,
    qp: Qp,
    zeros: Vec<f64>,
    /// The displaced query, and the pairs that collide there.
    pub config: Vec<f64>,
    pub colliding: Vec<PairId>,
    poses: Vec<Pose>,
    twists: Twists,
}

/// A displacement, the shortest in the half-spaces of its choices.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// In metric units.
    pub length: f64,
    /// `None` for the query itself.
    parent: Option<usize>,
    /// How many pairs have chosen.
    pub choices: usize,
    /// Right-hand side of what the last choice asks: `row . step >= bound`.
    bound: f64,
    /// Whether it is still to be looked at.
    pub is_open: bool,
    /// Whether it was.
    pub is_visited: bool,
}

impl Directions {
    /// Forgets those of another search.
    pub fn reset(&mut self) {
        self.nodes.clear();
    }

    /// Begins with the query itself.
    pub fn begin(&mut self, context: &Context, local: &LocalMetric, q: &[f64]) {
        let space = &context.checker.scene().space;
        let nv = space.nv();
        if self.sphere.is_empty() {
            self.sphere.extend(sphere(DIRECTIONS));
        }
        for numbers in [&mut self.steps, &mut self.rows, &mut self.zeros, &mut self.low, &mut self.high] {
            numbers.clear();
            numbers.resize(nv, 0.0);
        }
        // A query beyond the limits is looked at where it is moved onto them.
        self.config.clear();
        self.config.extend_from_slice(q);
        space.clamp(&mut self.config);
        self.begins_outside = space.outside(q).next().is_some();
        space.difference(q, &self.config, &mut self.steps);
        let length = local.length(&self.steps);
        self.nodes.push(Node { length, parent: None, choices: 0, bound: 0.0, is_open: true, is_visited: false });
        for factor in space.factors() {
            for v in factor.tangents().filter(|v| !context.is_locked(*v)) {
                (self.low[v], self.high[v]) = match factor.manifold {
                    Manifold::Interval { lower, upper } => (lower - q[factor.q], upper - q[factor.q]),
                    Manifold::Circle | Manifold::Rotation => (-FARTHEST_TURN, FARTHEST_TURN),
                };
            }
        }
    }

    /// The shortest displacement that was not looked at, if it is no longer than `most`.
    pub fn shortest(&self, most: f64) -> Option<usize> {
        let open = (0..self.nodes.len()).filter(|at| self.nodes[*at].is_open);
        let shortest = open.min_by(|a, b| self.nodes[*a].length.total_cmp(&self.nodes[*b].length))?;
        (self.nodes[shortest].length <= most).then_some(shortest)
    }

    /// The choices of the colliding pair that has to move farthest, shortest first.
    pub fn measure(&mut self, context: &Context, local: &LocalMetric, check: &mut CheckScratch) {
        let Self { sphere, measured, farthest, config, colliding, poses, twists, low, high, .. } = self;
        let scene = context.checker.scene();
        forward(scene, config, poses);
        twists.set(scene, poses);
        let limits = (&low[..], &high[..]);
        let distance = context.clearance + SLACK;
        let by = Measure { sphere, scene, twists, local, limits, distance };
        farthest.clear();
        context.checker.overlapping_pieces(config, colliding, check, &mut |pair| {
            measured.set(pair, &by, farthest.least);
            if measured.least > farthest.least {
                std::mem::swap(measured, farthest);
            }
        });
        farthest.sort();
    }

    /// Adds the shortest displacements of the choices that were measured last, no two alike and
    /// none longer than `most`, below the node at `at`.
    pub fn branch(&mut self, at: usize, local: &LocalMetric, most: f64) {
        let nv = self.low.len();
        let first = self.nodes.len();
        for choice in 0..self.farthest.all.len() {
            if self.nodes.len() == first + MOST_CHILDREN {
                break;
            }
            let row = self.farthest.row(choice);
            let bound = self.farthest.all[choice].overlap + dot(row, &self.steps[at * nv..][..nv]);
            let sides = self.low.iter().zip(&self.high);
            let reach: f64 = row.iter().zip(sides).map(|(g, (low, high))| f64::max(g * low, g * high)).sum();
            if reach < WITHIN_LIMITS * bound || !self.solve(at, choice, bound, (local, most)) {
                continue;
            }
            let step = &self.qp.step[..nv];
            let length = local.length(step);
            // Whoever goes the same way parts on the way of the shorter.
            let is_like = |child: usize| {
                let least = LIKE_DIRECTION * length * self.nodes[child].length;
                local.product(step, &self.steps[child * nv..][..nv]) > least
            };
            if (first..self.nodes.len()).any(is_like) {
                continue;
            }
            let choices = self.nodes[at].choices + 1;
            self.nodes.push(Node { length, parent: Some(at), choices, bound, is_open: true, is_visited: false });
            self.steps.extend_from_slice(step);
            self.rows.extend_from_slice(self.farthest.row(choice));
        }
    }

    /// The shortest displacement in the half-spaces of a node and of a choice; whether there is one
    /// that is no longer than `most`.
    fn solve(&mut self, at: usize, choice: usize, bound: f64, (local, most): (&LocalMetric, f64)) -> bool {
        let nv = self.low.len();
        self.qp.reset(nv);
        self.qp.set_box(&self.low, &self.high);
        self.qp.push(bound).copy_from_slice(self.farthest.row(choice));
        let mut above = at;
        while let Some(parent) = self.nodes[above].parent {
            self.qp.push(self.nodes[above].bound).copy_from_slice(&self.rows[above * nv..][..nv]);
            above = parent;
        }
        self.qp.solve(local.tensor(), &self.zeros, 0.5 * most * most) == QpOutcome::Solved
    }
}

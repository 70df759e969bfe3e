//! Tree of displacements along which colliding bodies part. It starts no descents.

use super::pair_directions::{Measure, PairDirections};
use crate::collision::CheckScratch;
use crate::cspace::Manifold;
use crate::kinematics::{Twists, forward};
use crate::math::linear_algebra::dot;
use crate::math::{Pose, Vec3, sphere};
use crate::query::context::Context;
use crate::query::local_metric::LocalMetric;
use crate::query::qp::{Qp, QpOutcome};
use crate::scene::PairId;

/// Directions that a pair may choose from, evenly spread over the sphere. Queries miss as much with
/// 64, for 6 % more checks, and a tenth more with 20.
const SPHERE_DIRECTIONS: usize = 32;
/// Most choices of a pair that are followed, shortest first. With 4, a tenth more queries miss for
/// 4 % fewer checks; 8 find the same for 6 % more.
const MAX_CHILDREN: usize = 5;
/// Displacements of siblings repeat each other above this cosine. With 0.9, a quarter more queries
/// miss for 5 % fewer checks.
const ALIKE_COSINE: f64 = 0.95;
/// Displacements aim this far beyond the clearance \[m\].
const AIM_MARGIN_M: f64 = 1e-6;
/// A half-space is followed if the limits allow at least this multiple of what it requires.
const LIMITS_FACTOR: f64 = 1.05;
/// Largest displacement of rotations and of turns without limits \[rad\].
const MAX_TURN_RAD: f64 = 2.0;

/// The search tree and its memory.
#[derive(Default)]
pub struct Directions {
    sphere: Vec<Vec3>,
    /// Nodes, parents before children.
    pub nodes: Vec<Node>,
    /// Whether the query is beyond the joint limits.
    pub begins_outside: bool,
    /// Displacement from the query and constraint of the last choice of each node; `nv` numbers a
    /// node.
    pub steps: Vec<f64>,
    rows: Vec<f64>,
    /// Bounds of displacements, by the joint limits.
    pub low: Vec<f64>,
    high: Vec<f64>,
    /// PairDirections of the pair that is measured, and of the one that has to move farthest.
    measured: PairDirections,
    farthest: PairDirections,
    qp: Qp,
    zeros: Vec<f64>,
    /// The displaced query; `colliding` are the pairs that collide there.
    pub config: Vec<f64>,
    pub colliding: Vec<PairId>,
    poses: Vec<Pose>,
    twists: Twists,
}

/// A displacement: the shortest in the half-spaces of its choices.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Length of the displacement \[metric units\].
    pub length: f64,
    /// Parent node; `None` for the query itself.
    parent: Option<usize>,
    /// Number of pairs that have chosen a direction.
    pub choices: usize,
    /// Right-hand side of the last choice: `row . step >= bound`.
    bound: f64,
    /// Whether it still has to be visited.
    pub is_open: bool,
    pub is_visited: bool,
}

impl Directions {
    pub fn reset(&mut self) {
        self.nodes.clear();
    }

    /// Begins with the query itself, moved onto the joint limits.
    pub fn begin(&mut self, context: &Context, local: &LocalMetric, q: &[f64]) {
        let space = &context.checker.scene().space;
        let nv = space.nv();
        if self.sphere.is_empty() {
            self.sphere.extend(sphere(SPHERE_DIRECTIONS));
        }
        for numbers in [&mut self.steps, &mut self.rows, &mut self.zeros, &mut self.low, &mut self.high] {
            numbers.clear();
            numbers.resize(nv, 0.0);
        }
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
                    Manifold::Circle | Manifold::Rotation => (-MAX_TURN_RAD, MAX_TURN_RAD),
                };
            }
        }
    }

    /// Returns the shortest open node, if it is no longer than `most`.
    pub fn shortest(&self, most: f64) -> Option<usize> {
        let open = (0..self.nodes.len()).filter(|at| self.nodes[*at].is_open);
        let shortest = open.min_by(|a, b| self.nodes[*a].length.total_cmp(&self.nodes[*b].length))?;
        (self.nodes[shortest].length <= most).then_some(shortest)
    }

    /// Measures the choices of the colliding pair that has to move farthest, shortest first.
    pub fn measure(&mut self, context: &Context, local: &LocalMetric, check: &mut CheckScratch) {
        let Self { sphere, measured, farthest, config, colliding, poses, twists, low, high, .. } = self;
        let scene = context.checker.scene();
        forward(scene, config, poses);
        twists.set(scene, poses);
        let limits = (&low[..], &high[..]);
        let distance = context.clearance + AIM_MARGIN_M;
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

    /// Adds the displacements of the choices measured last as children of node `at`. No two are
    /// alike, and none is longer than `most`.
    pub fn branch(&mut self, at: usize, local: &LocalMetric, most: f64) {
        let nv = self.low.len();
        let first = self.nodes.len();
        for choice in 0..self.farthest.all.len() {
            if self.nodes.len() == first + MAX_CHILDREN {
                break;
            }
            let row = self.farthest.row(choice);
            let bound = self.farthest.all[choice].overlap + dot(row, &self.steps[at * nv..][..nv]);
            let sides = self.low.iter().zip(&self.high);
            let reach: f64 = row.iter().zip(sides).map(|(g, (low, high))| f64::max(g * low, g * high)).sum();
            if reach < LIMITS_FACTOR * bound || !self.solve(at, choice, bound, (local, most)) {
                continue;
            }
            let step = &self.qp.step[..nv];
            let length = local.length(step);
            // An earlier child in about this direction already parts the pair.
            let is_like = |child: usize| {
                let least = ALIKE_COSINE * length * self.nodes[child].length;
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

    /// Finds the shortest displacement in the half-spaces of a node and of a choice. Returns
    /// whether it exists and is no longer than `most`.
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

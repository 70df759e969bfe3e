//! Where colliding bodies part: a best-first search over separating directions.
//!
//! Two convex bodies are apart where some unit direction separates them. So a free configuration
//! chooses, for every colliding pair, a direction on a sphere of two dimensions, whatever the
//! degrees of freedom; to first order each choice is a half-space of displacements, and the
//! shortest displacement in it leads to where to look. Where another pair collides there, that one
//! chooses too, and the displacement has to lie in both half-spaces. Displacements are looked at
//! shortest first, until they are longer than what is known; from each a descent starts.

mod choices;

use super::context::Context;
use super::dense::dot;
use super::descent::Start;
use super::local_metric::LocalMetric;
use super::qp::{Qp, QpOutcome};
use super::search::Search;
use super::starts::PartOf;
use crate::cspace::Manifold;
use crate::kinematics::{Twists, forward};
use crate::math::{Pose, Vec3, sphere};
use choices::{Choices, Measure};

/// Directions that a pair may choose from, evenly spread.
const DIRECTIONS: usize = 32;
/// Choices of a pair that are followed, those of the shortest displacements.
const MOST_CHILDREN: usize = 5;
/// Of two whose displacements have a cosine of more than this, the shorter.
const LIKE_DIRECTION: f64 = 0.95;
/// A displacement is like one that was looked at within this share of its length.
const ALIKE: f64 = 0.2;
/// A descent that ends within this of the displacement it started from has nothing to branch for.
const NEAR: f64 = 1.1;
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
    nodes: Vec<Node>,
    /// Whether the query is beyond the limits.
    begins_outside: bool,
    /// How many were looked at.
    visits: usize,
    /// Displacements from the query, and what the last choice of each node asks of them; `nv`
    /// numbers a node.
    steps: Vec<f64>,
    rows: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Of the pair that is measured, and of the one that has to move farthest.
    measured: Choices,
    farthest: Choices,
    qp: Qp,
    zeros: Vec<f64>,
    config: Vec<f64>,
    colliding: Vec<usize>,
    poses: Vec<Pose>,
    twists: Twists,
}

/// A displacement, the shortest in the half-spaces of its choices.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// In metric units.
    length: f64,
    /// `None` for the query itself.
    parent: Option<usize>,
    choices: usize,
    /// Right-hand side of what the last choice asks: `row . step >= bound`.
    bound: f64,
    /// Whether it is still to be looked at.
    is_open: bool,
    /// Whether it was.
    is_visited: bool,
}

/// Descents from where colliding bodies part.
pub fn try_directions(search: &mut Search) {
    search.known.round.begin();
    // The exit of the last frame is mostly among them.
    if search.turn.is_none() {
        visit_while(search, |_| true);
    }
}

/// The same until anything free is found; [`try_directions`] then goes on from there.
pub fn find_by_directions(search: &mut Search) {
    visit_while(search, |search| search.known.incumbent.depth.is_infinite());
}

/// Looks at displacements, shortest first.
fn visit_while(search: &mut Search, goes_on: impl Fn(&Search) -> bool) {
    let mut tree = std::mem::take(&mut search.known.directions);
    if tree.nodes.is_empty() {
        tree.begin(search.context, &search.known.anchor.q, search.part);
    }
    while tree.visits < search.plan.most_directions && !search.evaluator.is_spent() && goes_on(search) {
        let Some(node) = tree.shortest(search.plan.direction_factor * search.known.ceiling()) else { break };
        tree.visit(search, node);
    }
    search.known.directions = tree;
}

impl Directions {
    /// Forgets those of another search.
    pub fn reset(&mut self) {
        self.nodes.clear();
    }

    /// Begins with the query itself.
    fn begin(&mut self, context: &Context, q: &[f64], part: Option<PartOf>) {
        let space = &context.checker.scene().space;
        let nv = space.nv();
        if self.sphere.is_empty() {
            self.sphere.extend(sphere(DIRECTIONS));
        }
        for numbers in [&mut self.steps, &mut self.rows, &mut self.zeros, &mut self.low, &mut self.high] {
            numbers.clear();
            numbers.resize(nv, 0.0);
        }
        self.visits = 0;
        // A query beyond the limits is looked at where it is moved onto them.
        self.config.clear();
        self.config.extend_from_slice(q);
        space.clamp(&mut self.config);
        self.begins_outside = space.outside(q).next().is_some();
        space.difference(q, &self.config, &mut self.steps);
        self.nodes.push(Node { length: 0.0, parent: None, choices: 0, bound: 0.0, is_open: true, is_visited: false });
        for (at, factor) in space.factors().iter().enumerate() {
            if part.is_some_and(|part| !part.searched.contains(&at)) {
                continue;
            }
            for v in factor.tangents().filter(|v| !context.is_locked(*v)) {
                (self.low[v], self.high[v]) = match factor.manifold {
                    Manifold::Interval { lower, upper } => (lower - q[factor.q], upper - q[factor.q]),
                    Manifold::Circle | Manifold::Rotation => (-FARTHEST_TURN, FARTHEST_TURN),
                };
            }
        }
    }

    /// The shortest displacement that was not looked at, if it is no longer than `most`.
    fn shortest(&self, most: f64) -> Option<usize> {
        let open = (0..self.nodes.len()).filter(|at| self.nodes[*at].is_open);
        let shortest = open.min_by(|a, b| self.nodes[*a].length.total_cmp(&self.nodes[*b].length))?;
        (self.nodes[shortest].length <= most).then_some(shortest)
    }

    /// Descends from a displacement, and branches where it collides.
    fn visit(&mut self, search: &mut Search, at: usize) {
        let (context, nv) = (search.context, self.low.len());
        let scene = context.checker.scene();
        let step = &self.steps[at * nv..][..nv];
        let length = self.nodes[at].length;
        let is_like = |(other, node): (usize, &Node)| {
            node.is_visited && search.known.local.between(step, &self.steps[other * nv..][..nv]) < ALIKE * length
        };
        let is_known = self.nodes.iter().enumerate().any(is_like);
        (self.nodes[at].is_open, self.nodes[at].is_visited) = (false, !is_known);
        if is_known {
            return;
        }
        self.visits += 1;
        self.config.resize(scene.space.nq(), 0.0);
        scene.space.integrate(&search.known.anchor.q, step, &mut self.config);
        if (at > 0 || self.begins_outside)
            && let Some(depth) = search.try_start(Start::at(&self.config))
            && depth <= NEAR * length
        {
            // What its children lead to is hardly nearer.
            return;
        }
        if self.nodes[at].choices == search.plan.most_choices || search.evaluator.is_spent() {
            return;
        }
        self.colliding.clear();
        context.checker.colliding_pairs(&self.config, &mut search.evaluator.check, &mut self.colliding);
        // The query itself was checked before.
        search.evaluator.checks += usize::from(at > 0);
        if !self.colliding.is_empty() {
            self.measure(search);
            let most = search.plan.direction_factor * search.known.ceiling();
            self.branch(at, &search.known.local, most);
        }
    }

    /// The choices of the colliding pair that has to move farthest, shortest first.
    fn measure(&mut self, search: &mut Search) {
        let Self { sphere, measured, farthest, config, colliding, poses, twists, low, high, .. } = self;
        let (context, scene) = (search.context, search.context.checker.scene());
        forward(scene, config, poses);
        twists.set(scene, poses);
        let limits = (&low[..], &high[..]);
        let distance = context.clearance + SLACK;
        let by = Measure { sphere, scene, twists, local: &search.known.local, limits, distance };
        farthest.clear();
        context.checker.convex_pairs(config, colliding, &mut search.evaluator.check, &mut |pair| {
            measured.set(pair, &by, farthest.least);
            if measured.least > farthest.least {
                std::mem::swap(measured, farthest);
            }
        });
        farthest.sort();
    }

    /// Adds the shortest displacements of the choices that were measured last, no two alike and
    /// none longer than `most`, below the node at `at`.
    fn branch(&mut self, at: usize, local: &LocalMetric, most: f64) {
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
            if reach < WITHIN_LIMITS * bound || !self.solve(at, choice, bound, local) {
                continue;
            }
            let step = &self.qp.step[..nv];
            let length = local.length(step);
            // Whoever goes the same way parts on the way of the shorter.
            let is_like = |child: usize| local.cosine(step, &self.steps[child * nv..][..nv]) > LIKE_DIRECTION;
            if length > most || (first..self.nodes.len()).any(is_like) {
                continue;
            }
            let choices = self.nodes[at].choices + 1;
            self.nodes.push(Node { length, parent: Some(at), choices, bound, is_open: true, is_visited: false });
            self.steps.extend_from_slice(step);
            self.rows.extend_from_slice(self.farthest.row(choice));
        }
    }

    /// The shortest displacement in the half-spaces of a node and of a choice; whether there is
    /// one.
    fn solve(&mut self, at: usize, choice: usize, bound: f64, local: &LocalMetric) -> bool {
        let nv = self.low.len();
        self.qp.reset(nv);
        self.qp.set_box(&self.low, &self.high);
        self.qp.push(bound).copy_from_slice(self.farthest.row(choice));
        let mut above = at;
        while let Some(parent) = self.nodes[above].parent {
            self.qp.push(self.nodes[above].bound).copy_from_slice(&self.rows[above * nv..][..nv]);
            above = parent;
        }
        self.qp.solve(local.tensor(), &self.zeros, f64::INFINITY) == QpOutcome::Solved
    }
}

//! Branch and bound over separating directions: proves that nothing free is nearer than a share of the depth, or finds it.
//!
//! A node is a set of half-spaces of displacements from the query; all free configurations that are near enough lie in one node or
//! another. The least-norm point of a node bounds it from below. To expand a node, its point is looked at: where it is free, it is the
//! nearest of its node. Otherwise two bodies overlap there, and whatever is free parts them along a direction: along one of a few
//! [`Cells`], each a choice of three half-spaces, which cut the point off. So the node falls into as many nodes as there are half-spaces.
//!
//! With `d` the displacement from the point `x`, points part along `n` by at most `g . d + l |d|^2 / 2 + K |d|^3 / 6`, where `l` bounds the
//! eigenvalues of the Hessian. All of a node that is nearer than `r` has `|d|^2 <= r^2 - |x|^2`, as `x` is its least-norm point. So half-spaces grow
//! exact as bounds rise.
//!
//! Displacements are tangent vectors times the roots of the weights, so this is of the joint metric, and of joints whose displacements add:
//! not of ball joints.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::cells::{Cells, Parting};
use crate::collision::{CheckScratch, Checker, ConvexPair};
use crate::cspace::Manifold;
use crate::math::{Pose, Vec3};
use crate::metric::Metric;
use crate::metric::pair_motion::PairMotion;
use crate::penetration::context::Context;
use crate::penetration::dense::dot;
use crate::penetration::parts::coordinates;
use crate::penetration::qp::{Qp, QpOutcome};

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
    identity: Vec<f64>,
    zero: Vec<f64>,
    cells: Cells,
    motion: PairMotion,
    pairs: Vec<usize>,
    poses: Vec<Pose>,
    config: Vec<f64>,
    tangent: Vec<f64>,
    cuts: Vec<Cut>,
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
        context.metric.kind() == crate::scene::MetricSpec::Joint
            && !space.factors().iter().any(|f| f.manifold == Manifold::Rotation && is_free(f.v))
    }

    /// Begins at the query `q`: over all coordinates, or those that a group of pairs `holds`, while the others stay where `base` has them
    /// and pairs that they move are not looked at.
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
        self.identity.clear();
        self.identity.extend((0..nv * nv).map(|i| if i % (nv + 1) == 0 { 1.0 } else { 0.0 }));
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
        if self.nodes[node].repeats > MOST_REPEATS || !self.cut(checker, context, &point, (bound, target), node, check)
        {
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

    /// `best` becomes the half-spaces of the pair whose nearest one is farthest; whether there are some that hold all that is free.
    fn cut(
        &mut self,
        checker: &Checker,
        context: &Context,
        point: &[f64],
        (bound, target): (f64, f64),
        node: usize,
        check: &mut CheckScratch,
    ) -> bool {
        let Self { nodes, cells, motion, pairs, poses, cuts, best, roots, config, .. } = self;
        let repeats = nodes[node].repeats;
        let cone_of = |pair: &ConvexPair, around: &Around| {
            let parts = pair.parts()?;
            let mut at = node;
            while at != 0 && nodes[at].parts != Some(parts) {
                at = nodes[at].parent;
            }
            (at != 0).then(|| nodes[at].cone.map(|n| around.poses[around.motion.common()].vector(&n)))
        };
        let mut is_whole = true;
        best.clear();
        let distance = norm(point);
        let mut around = Around {
            metric: context.metric,
            poses,
            motion,
            point,
            here: Vec::new(),
            distance,
            target,
            is_bounded: false,
            second: 0.0,
            third: 0.0,
            hessian: Vec::new(),
            row: Vec::new(),
        };
        // A look at each tells which to look at closely.
        let (mut promising, mut most, mut number) = (usize::MAX, f64::NEG_INFINITY, 0);
        checker.inner_pairs(config, pairs, check, &mut |pair| {
            if most < target {
                around.look_at(context, pair);
                let cone = cone_of(pair, &around);
                let found = cells.cover(pair, cone, &mut around, target, FIRST_SPLITS);
                if found > most {
                    (promising, most) = (number, found);
                }
            }
            number += 1;
        });
        if most >= target {
            return true;
        }
        number = 0;
        checker.inner_pairs(config, pairs, check, &mut |pair| {
            number += 1;
            if number != promising + 1 {
                return;
            }
            around.look_at(context, pair);
            let cone = cone_of(pair, &around);
            let splits = if cone.is_some() { FIRST_SPLITS } else { SPLITS };
            cells.cover(pair, cone, &mut around, target, splits << repeats);
            cuts.clear();
            for cell in cells.open(target) {
                let (points, inequalities) = cell.inequalities(pair);
                let cone = cell.cone().map(|n| around.poses[around.motion.common()].inverse_vector(&n));
                around.place(points.each_ref());
                for HalfSpace { along, signs, near, .. } in around.choice(&inequalities) {
                    let (offset, slope) = around.offset(&along, signs, target);
                    if slope <= 0.0 {
                        // Holds or not whatever moves.
                        is_whole = false;
                        return;
                    }
                    let mut row = vec![0.0; roots.len()];
                    for (v, entry) in around.motion.coordinates().iter().zip(&around.row) {
                        row[*v] = entry / slope;
                    }
                    cuts.push(Cut { row, offset: offset / slope, near: near.max(bound), parts: pair.parts(), cone });
                }
            }
            std::mem::swap(cuts, best);
        });
        is_whole && promising < usize::MAX
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

    /// Whether a row that no step was found for is missed by more than rounding: within `target`, no multiple of what is left of a row that the
    /// others span to ten digits can make up for it.
    fn is_far_from_feasible(&self, target: f64) -> bool {
        self.qp.largest_violation() > 1e-4 * target
    }
}

/// Half-spaces of displacements that part points, seen from a configuration.
struct Around<'a> {
    metric: &'a Metric,
    poses: &'a [Pose],
    motion: &'a mut PairMotion,
    /// Its displacement from the query, how much of it is by coordinates of the motion, and how long it is.
    point: &'a [f64],
    here: Vec<f64>,
    distance: f64,
    target: f64,
    /// Whether the next two are of the points that are looked at.
    is_bounded: bool,
    /// On second derivatives, and on third ones over 6.
    second: f64,
    third: f64,
    hessian: Vec<f64>,
    row: Vec<f64>,
}

/// What is known of a direction.
#[derive(Clone)]
struct Along {
    gradient: Vec<f64>,
    /// The directions in which the Hessian bends most, each times half the eigenvalue, and what is left over.
    bent: Vec<Vec<f64>>,
    rest: f64,
    needed: f64,
    /// By how much gradients of other directions that it stands for differ, and these directions themselves.
    spread: f64,
    turned: f64,
    middle: Vec3,
}

impl Around<'_> {
    fn look_at(&mut self, context: &Context, pair: &ConvexPair) {
        let scene = context.checker.scene();
        let bodies = scene.pairs[pair.pair()];
        let frames = [bodies.first, bodies.second].map(|body| scene.bodies[body].frame);
        context.metric.pair_motion(self.poses, frames, |v| context.is_locked(v), self.motion);
        self.here.clear();
        self.here.extend(self.motion.coordinates().iter().map(|v| self.point[*v]));
    }

    /// All that is nearer than `r` is at most so far from here.
    fn radius(&self, r: f64) -> f64 {
        (r * r - self.distance * self.distance).max(0.0).sqrt()
    }

    fn along(&mut self, n: &Vec3, needed: f64) -> Along {
        if !std::mem::replace(&mut self.is_bounded, true) {
            let radius = self.radius(self.target);
            (self.second, self.third) = (self.motion.second(), self.motion.third(radius) / 6.0);
        }
        let gradient = self.motion.columns().iter().map(|column| n.dot(column)).collect();
        Along { gradient, bent: Vec::new(), rest: 0.5 * self.second, needed, spread: 0.0, turned: 0.0, middle: *n }
    }

    /// Splits off the directions in which the Hessian bends most.
    fn bend(&mut self, n: &Vec3, along: &mut Along) {
        let width = along.gradient.len();
        self.motion.hessian(n, &mut self.hessian);
        let eigen = nalgebra::DMatrix::from_row_slice(width, width, &self.hessian).symmetric_eigen();
        let mut order: Vec<usize> = (0..width).collect();
        order.sort_by(|i, j| eigen.eigenvalues[*j].total_cmp(&eigen.eigenvalues[*i]));
        // What rounding does to the decomposition is far below.
        let rounding = 1e-9 * self.second;
        let radius = self.radius(self.target);
        for &k in &order {
            let half = 0.5 * eigen.eigenvalues[k].max(0.0) + rounding;
            along.rest = half;
            if along.bent.len() == MOST_BENDS || half * radius * radius < LEAST_BEND * along.needed {
                return;
            }
            along.bent.push(eigen.eigenvectors.column(k).iter().map(|x| x * half).collect());
        }
        along.rest = rounding;
    }

    /// Proved: all that is nearer than `r` misses the half-space with these signs, if it is at least so far.
    fn offset(&mut self, along: &Along, signs: usize, r: f64) -> (f64, f64) {
        let radius = self.radius(r);
        self.row.clear();
        self.row.extend_from_slice(&along.gradient);
        for (k, bent) in along.bent.iter().enumerate() {
            // With `s` between 0 and the radius, `s^2` is at most the radius times `s`.
            let share = if signs >> k & 1 == 0 { radius } else { -radius };
            self.row.iter_mut().zip(bent).for_each(|(entry, bend)| *entry += share * bend);
        }
        let rest = along.rest + 0.5 * self.second * along.turned;
        let left =
            along.needed - along.spread * radius - rest * radius * radius - self.third * radius * radius * radius;
        let slope = dot(&self.row, &self.row).sqrt();
        (left + dot(&self.row, &self.here), slope)
    }

    /// A distance up to the target that the half-space with these signs has.
    fn near(&mut self, along: &Along, signs: usize) -> f64 {
        let target = self.target;
        let mut holds = |r: f64| {
            let (offset, slope) = self.offset(along, signs, r);
            offset >= slope * r
        };
        if holds(target) {
            return target;
        }
        // Whatever was seen to hold is proved; it is the largest where holding ends once.
        let (mut low, mut high) = (0.0, target);
        while high - low > 2e-3 * target {
            let middle = 0.5 * (low + high);
            if holds(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        if low > 0.0 {
            return low;
        }
        let (offset, slope) = self.offset(along, signs, 0.0);
        (offset / slope.max(f64::MIN_POSITIVE)).clamp(-target, 0.0)
    }

    /// Half-spaces that hold all that keeps one of three inequalities, with their distances, as far as those are below the target: as few as
    /// bound hardly less than each corner's own.
    fn choice(&mut self, inequalities: &[(Vec3, f64); 3]) -> Vec<HalfSpace> {
        let target = self.target;
        let mut each = Vec::new();
        for (n, needed) in inequalities {
            let mut along = self.along(n, *needed);
            if self.nearest(&along) < target {
                self.bend(n, &mut along);
                self.list(along, &mut each);
            }
        }
        let least = |all: &[HalfSpace], of: fn(&HalfSpace) -> f64| all.iter().map(of).fold(f64::INFINITY, f64::min);
        let near = least(&each, |half| half.near) - LEAST_LOSS * target;
        let depth = least(&each, |half| half.depth);
        let depth = if depth > 0.0 { KEPT * depth } else { depth };
        if each.len() <= 1 {
            return each;
        }
        let mut merged = self.merged(inequalities);
        for bends in [false, true] {
            if bends {
                let middle = merged.middle;
                self.bend(&middle, &mut merged);
            }
            let mut few = Vec::new();
            self.list(merged.clone(), &mut few);
            let is_as_good = least(&few, |half| half.near) >= near && least(&few, |half| half.depth) >= depth;
            if few.len() < each.len() && is_as_good {
                return few;
            }
        }
        each
    }

    fn list(&mut self, along: Along, all: &mut Vec<HalfSpace>) {
        for signs in 0..1 << along.bent.len() {
            let near = self.near(&along, signs);
            if near < self.target {
                let (offset, slope) = self.offset(&along, signs, self.target);
                let depth = (offset - dot(&self.row, &self.here)) / slope.max(f64::MIN_POSITIVE);
                all.push(HalfSpace { along: along.clone(), signs, near, depth });
            }
        }
    }

    /// One inequality that holds wherever one of three does: along their middle, with what gradients and Hessians differ by.
    fn merged(&mut self, inequalities: &[(Vec3, f64); 3]) -> Along {
        let middle = inequalities.iter().map(|(n, _)| n).sum::<Vec3>().normalize();
        let needed = inequalities.iter().map(|(_, needed)| *needed).fold(f64::INFINITY, f64::min);
        let mut along = self.along(&middle, needed);
        along.middle = middle;
        let difference = |n: &Vec3| {
            let columns = self.motion.columns().iter();
            columns.map(|column| (n - middle).dot(column).powi(2)).sum::<f64>().sqrt()
        };
        along.spread = inequalities.iter().map(|(n, _)| difference(n)).fold(0.0, f64::max);
        along.turned = inequalities.iter().map(|(n, _)| (n - middle).norm()).fold(0.0, f64::max);
        along
    }

    /// The nearest of the half-spaces of a direction.
    fn nearest(&mut self, along: &Along) -> f64 {
        (0..1 << along.bent.len()).map(|signs| self.near(along, signs)).fold(f64::INFINITY, f64::min)
    }
}

/// One of the half-spaces of a direction.
struct HalfSpace {
    along: Along,
    /// Of the directions in which the Hessian bends.
    signs: usize,
    /// No point of it is nearer to the query.
    near: f64,
    /// How far from it the point is that is looked at.
    depth: f64,
}

/// Share of that depth which is kept where there are to be fewer.
const KEPT: f64 = 0.8;
/// Share of the target that half-spaces may be nearer for there to be fewer.
const LEAST_LOSS: f64 = 0.02;
/// Directions in which the Hessian bends that are parted by sign.
const MOST_BENDS: usize = 2;
/// A bend that counts less than this share of what is needed is not.
const LEAST_BEND: f64 = 0.02;

impl Parting for Around<'_> {
    fn place(&mut self, points: [&Vec3; 2]) {
        self.metric.place_points(self.poses, points, self.motion);
        self.is_bounded = false;
    }

    fn linear_distance(&mut self, n: &Vec3, needed: f64) -> f64 {
        let (mut squared, mut along) = (0.0, 0.0);
        for (column, here) in self.motion.columns().iter().zip(&self.here) {
            let slope = n.dot(column);
            squared += slope * slope;
            along += slope * here;
        }
        (needed + along) / f64::sqrt(squared).max(f64::MIN_POSITIVE)
    }

    fn distance(&mut self, n: &Vec3, needed: f64, enough: f64) -> f64 {
        let mut along = self.along(n, needed);
        let near = self.nearest(&along);
        if near >= enough {
            return near;
        }
        self.bend(n, &mut along);
        self.nearest(&along).max(near)
    }

    fn rough_distance(&mut self, n: &Vec3, needed: f64) -> f64 {
        let along = self.along(n, needed);
        self.nearest(&along)
    }
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

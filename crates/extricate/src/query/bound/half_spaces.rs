//! Half-spaces of displacements that part two points along directions, seen from a configuration.
//!
//! With `d` the displacement from there, points part along `n` by at most
//! `g . d + d' H d / 2 + K |d|^3 / 6`. Directions in which `H` bends most are parted by sign: with
//! `s` the displacement along one, between 0 and `r`, `s^2 <= r s`, which is linear.

use super::cells::{Candidate, Parting};
use crate::collision::ConvexPair;
use crate::math::linear_algebra::dot;
use crate::math::{LANES, Pose, Vec3};
use crate::metric::Metric;
use crate::metric::pair_motion::{Lanes, PairMotion};
use crate::query::context::Context;

/// What they are seen from, and the points that are to part.
pub struct Around<'a> {
    metric: &'a Metric,
    poses: &'a [Pose],
    motion: &'a mut PairMotion,
    /// Its displacement from the query, how much of it is by coordinates of the motion, and how
    /// long it is.
    point: &'a [f64],
    here: Vec<f64>,
    distance: f64,
    target: f64,
    /// Whether the next two are of the points that are looked at.
    is_bounded: bool,
    /// On second derivatives, and on third ones over 6.
    second: f64,
    third: f64,
    /// What the points may have moved by, as steps keep limits to [`HELD`] only \[m\].
    slack: f64,
    hessian: Vec<[f64; 1]>,
    row: Vec<f64>,
}

/// What is known of a direction.
#[derive(Clone)]
struct Along {
    gradient: Vec<f64>,
    /// The directions in which the Hessian bends most, each times half the eigenvalue, and what is
    /// left over.
    bent: Vec<Vec<f64>>,
    rest: f64,
    needed: f64,
    /// By how much gradients of other directions that it stands for differ, and these directions
    /// themselves.
    spread: f64,
    turned: f64,
    middle: Vec3,
}

impl<'a> Around<'a> {
    /// Seen from the configuration at the displacement `point`, with frame poses `poses`, as far as
    /// `target`.
    pub fn new(
        metric: &'a Metric,
        (poses, motion): (&'a [Pose], &'a mut PairMotion),
        point: &'a [f64],
        target: f64,
    ) -> Self {
        Self {
            metric,
            poses,
            motion,
            point,
            here: Vec::new(),
            distance: dot(point, point).sqrt(),
            target,
            is_bounded: false,
            second: 0.0,
            third: 0.0,
            slack: 0.0,
            hessian: Vec::new(),
            row: Vec::new(),
        }
    }

    /// Directions of the world in the frame from which displacements of the pair are seen, which
    /// they keep to.
    pub fn in_common(&self, cone: [Vec3; 3]) -> [Vec3; 3] {
        cone.map(|n| self.poses[self.motion.common()].inverse_vector(&n))
    }

    /// The inverse of [`Around::in_common`].
    pub fn to_world(&self, cone: [Vec3; 3]) -> [Vec3; 3] {
        cone.map(|n| self.poses[self.motion.common()].vector(&n))
    }

    /// A half-space as a row of length 1 over all coordinates and its offset; none where nothing
    /// moves the points along it.
    pub fn row(&mut self, half: &HalfSpace) -> Option<(Vec<f64>, f64)> {
        let (offset, slope) = self.offset(&half.along, half.signs, self.target);
        let mut row = vec![0.0; self.point.len()];
        for (v, entry) in self.motion.coordinates().iter().zip(&self.row) {
            row[*v] = entry / slope;
        }
        (slope > 0.0).then_some((row, offset / slope))
    }

    /// Looks at a pair of convex sets.
    pub fn look_at(&mut self, context: &Context, pair: &ConvexPair) {
        let scene = context.checker.scene();
        let bodies = scene.pairs[pair.pair().index()];
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
            let [second, third] = self.motion.derivatives(radius);
            (self.second, self.third) = (second, third / 6.0);
            let slopes = self.motion.columns().iter().map(Vec3::norm).sum::<f64>();
            self.slack = HELD * (slopes + self.second);
        }
        let gradient = self.motion.columns().iter().map(|column| n.dot(column)).collect();
        Along { gradient, bent: Vec::new(), rest: 0.5 * self.second, needed, spread: 0.0, turned: 0.0, middle: *n }
    }

    /// Splits off the directions in which the Hessian bends most.
    fn bend(&mut self, n: &Vec3, along: &mut Along) {
        let width = along.gradient.len();
        self.motion.hessian(&[[n.x], [n.y], [n.z]], &mut self.hessian);
        let eigen = nalgebra::DMatrix::from_row_slice(width, width, self.hessian.as_flattened()).symmetric_eigen();
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

    /// Proved: all that is nearer than `r` misses the half-space with these signs, if it is at
    /// least so far.
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
        let left = along.needed
            - self.slack
            - along.spread * radius
            - rest * radius * radius
            - self.third * radius * radius * radius;
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

    /// Half-spaces that hold all that keeps one of three inequalities, with their distances, as far
    /// as those are below the target: as few as bound hardly less than each corner's own.
    pub fn choice(&mut self, inequalities: &[(Vec3, f64); 3]) -> Vec<HalfSpace> {
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

    /// One inequality that holds wherever one of three does: along their middle, with what
    /// gradients and Hessians differ by.
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
pub struct HalfSpace {
    along: Along,
    /// Of the directions in which the Hessian bends.
    signs: usize,
    /// No point of it is nearer to the query.
    pub near: f64,
    /// How far from it the point is that is looked at.
    depth: f64,
}

/// How far a step may be beyond limits, and a configuration that is held to them from it: a few
/// times what the quadratic program lets pass.
const HELD: f64 = 1e-9;
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

    fn least_distance(&mut self, needs: &[(Vec3, f64); 3], enough: f64) -> f64 {
        needs.iter().fold(enough, |least, (n, needed)| {
            let mut along = self.along(n, *needed);
            let near = self.nearest(&along);
            if near >= least {
                return least;
            }
            self.bend(n, &mut along);
            self.nearest(&along).max(near).min(least)
        })
    }

    fn rough_distances(&mut self, candidates: &[Candidate], enough: f64) -> Lanes {
        let mut bounds = [enough; LANES];
        for (Candidate { points, needs }, bound) in candidates.iter().zip(&mut bounds) {
            self.place(points.each_ref());
            for (n, needed) in needs {
                let along = self.along(n, *needed);
                *bound = bound.min(self.nearest(&along));
            }
        }
        bounds
    }
}

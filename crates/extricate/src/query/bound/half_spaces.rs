//! Half-spaces of displacements that part two points along directions, expanded at a configuration.
//!
//! With `d` the displacement from there, points part along `n` by at most
//! `g . d + d' H d / 2 + K |d|^3 / 6`. The directions in which `H` bends most are split by sign:
//! with `s` the displacement along one, between 0 and `r`, `s^2 <= r s`, which is linear.

use super::cells::{Candidate, Parting};
use crate::collision::ConvexPair;
use crate::math::linear_algebra::dot;
use crate::math::{LANES, Pose, Vec3};
use crate::metric::Metric;
use crate::metric::pair_motion::{Lanes, PairMotion};
use crate::query::context::Context;

/// The configuration at which half-spaces are expanded, and the points that have to part.
pub struct Around<'a> {
    metric: &'a Metric,
    poses: &'a [Pose],
    motion: &'a mut PairMotion,
    /// Displacement of the configuration from the query, its part in the coordinates of `motion`,
    /// and its length.
    point: &'a [f64],
    here: Vec<f64>,
    distance: f64,
    target: f64,
    /// Whether `second`, `third` and `slack` belong to the placed points.
    is_bounded: bool,
    /// Bounds on second derivatives, and on third ones divided by 6.
    second: f64,
    third: f64,
    /// Motion \[m\] of the points that is allowed for because steps keep limits only to
    /// [`LIMIT_TOLERANCE`].
    slack: f64,
    hessian: Vec<[f64; 1]>,
    row: Vec<f64>,
}

/// Expansion of the distance of the points along a direction.
#[derive(Clone)]
struct Along {
    gradient: Vec<f64>,
    /// The directions in which the Hessian bends most, each times half its eigenvalue.
    bent: Vec<Vec<f64>>,
    /// Upper bound on half of each remaining eigenvalue.
    rest: f64,
    needed: f64,
    /// Largest differences of the gradients and unit vectors of all directions that this one
    /// represents.
    spread: f64,
    turned: f64,
    middle: Vec3,
}

impl<'a> Around<'a> {
    /// Expands at the displacement `point`, with frame poses `poses`, up to the distance `target`.
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

    /// Converts world directions to the common frame of the pair, in which its cones are stored.
    pub fn in_common(&self, cone: [Vec3; 3]) -> [Vec3; 3] {
        cone.map(|n| self.poses[self.motion.common()].inverse_vector(&n))
    }

    /// Inverts [`Around::in_common`].
    pub fn to_world(&self, cone: [Vec3; 3]) -> [Vec3; 3] {
        cone.map(|n| self.poses[self.motion.common()].vector(&n))
    }

    /// Returns a half-space as a unit row over all coordinates and its offset; `None` if no
    /// coordinate moves the points along it.
    pub fn row(&mut self, half: &HalfSpace) -> Option<(Vec<f64>, f64)> {
        let (offset, slope) = self.offset(&half.along, half.signs, self.target);
        let mut row = vec![0.0; self.point.len()];
        for (v, entry) in self.motion.coordinates().iter().zip(&self.row) {
            row[*v] = entry / slope;
        }
        (slope > 0.0).then_some((row, offset / slope))
    }

    /// Prepares the motion of a pair of convex sets.
    pub fn add_pair(&mut self, context: &Context, pair: &ConvexPair) {
        let scene = context.checker.scene();
        let bodies = scene.pairs[pair.pair().index()];
        let frames = [bodies.first, bodies.second].map(|body| scene.bodies[body].frame);
        context.metric.pair_motion(self.poses, frames, |v| context.is_locked(v), self.motion);
        self.here.clear();
        self.here.extend(self.motion.coordinates().iter().map(|v| self.point[*v]));
    }

    /// Returns how far a point of the node within `r` of the query is from here at most.
    fn radius(&self, r: f64) -> f64 {
        (r * r - self.distance * self.distance).max(0.0).sqrt()
    }

    fn along(&mut self, n: &Vec3, needed: f64) -> Along {
        if !std::mem::replace(&mut self.is_bounded, true) {
            let radius = self.radius(self.target);
            let [second, third] = self.motion.derivatives(radius);
            (self.second, self.third) = (second, third / 6.0);
            let slopes = self.motion.columns().iter().map(Vec3::norm).sum::<f64>();
            self.slack = LIMIT_TOLERANCE * (slopes + self.second);
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
        // Far above the rounding error of the decomposition.
        let rounding = 1e-9 * self.second;
        let radius = self.radius(self.target);
        for &k in &order {
            let half = 0.5 * eigen.eigenvalues[k].max(0.0) + rounding;
            along.rest = half;
            if along.bent.len() == MAX_BENDS || half * radius * radius < MIN_BEND_SHARE * along.needed {
                return;
            }
            along.bent.push(eigen.eigenvectors.column(k).iter().map(|x| x * half).collect());
        }
        along.rest = rounding;
    }

    /// Returns offset and slope of the half-space with these signs for all points within `r`.
    /// Proved: if the offset is at least the slope times `r`, no such point lies in it.
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

    /// Returns a proved distance of the half-space with these signs, at most the target.
    fn near(&mut self, along: &Along, signs: usize) -> f64 {
        let target = self.target;
        let mut holds = |r: f64| {
            let (offset, slope) = self.offset(along, signs, r);
            offset >= slope * r
        };
        if holds(target) {
            return target;
        }
        // Each distance that holds is proved. Bisection finds the largest if `holds` changes once.
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

    /// Returns half-spaces nearer than the target that hold every displacement which satisfies one
    /// of three inequalities. Prefers few half-spaces if they bound hardly less than those of each
    /// corner.
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
        let near = least(&each, |half| half.near) - MERGED_LOSS_SHARE * target;
        let depth = least(&each, |half| half.depth);
        let depth = if depth > 0.0 { MERGED_DEPTH_SHARE * depth } else { depth };
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

    /// Returns one inequality that holds wherever one of three does: along their middle, less the
    /// differences of gradients and Hessians.
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

    /// Returns the distance of the nearest half-space of a direction.
    fn nearest(&mut self, along: &Along) -> f64 {
        (0..1 << along.bent.len()).map(|signs| self.near(along, signs)).fold(f64::INFINITY, f64::min)
    }
}

pub struct HalfSpace {
    along: Along,
    /// Sign of the displacement along each bent direction, one bit each.
    signs: usize,
    /// No point of the half-space is nearer to the query than this.
    pub near: f64,
    /// Distance of the expanded point from the half-space.
    depth: f64,
}

/// How far a step may exceed limits, and a configuration clamped to them may be from it: a few
/// times the tolerance of the quadratic program.
const LIMIT_TOLERANCE: f64 = 1e-9;
/// Share of `HalfSpace::depth` that merged half-spaces have to keep.
const MERGED_DEPTH_SHARE: f64 = 0.8;
/// Share of the target by which merged half-spaces may be nearer.
const MERGED_LOSS_SHARE: f64 = 0.02;
/// Most directions of the Hessian that are split by sign.
const MAX_BENDS: usize = 2;
/// A bend that changes the distance by less than this share of the need is not split.
const MIN_BEND_SHARE: f64 = 0.02;

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

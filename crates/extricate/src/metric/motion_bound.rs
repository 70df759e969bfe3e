//! Bounds on how far a point can move while the configuration moves by a given distance. Proofs of
//! lower bounds and free radii rest on them.

use super::Metric;
use super::coordinate_use::CoordinateUse;
use crate::math::elementary::hypot;
use crate::math::{LANES, Mat3, Pose, Vec3};
use crate::scene::{MetricKind, Motion, Scene};

/// Motion bounds for points of one frame seen from another, prepared in two steps:
/// [`Metric::motion_between`] for the frames, then [`Metric::motion_of`] for a point.
#[derive(Debug, Clone, Default)]
pub struct MotionPath {
    of: usize,
    relative_to: usize,
    /// Joints between the frames, from the point outward; empty unless the metric is `joint`.
    steps: Vec<Step>,
    /// Displacement \[m\] per metric unit; 0 for the joint metric.
    rate: f64,
    /// Sum of the reaches of the joints that share a coordinate, by coordinate.
    reach: Vec<f64>,
    frames: Vec<usize>,
}

/// A joint between the two frames.
#[derive(Debug, Clone, Copy)]
struct Step {
    kind: StepKind,
    /// Point of the axis \[m\], in world coordinates like `axis`.
    origin: Vec3,
    axis: Vec3,
    multiplier: f64,
    /// `1 / weight` of the coordinate in the joint metric.
    per_weight: f64,
    /// The coordinate, if several joints move with it.
    shared: Option<usize>,
    /// Displacement \[m\] of the point per rad or m while the joints nearer to it rest.
    lever: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum StepKind {
    /// Slide with its share of the squared displacement per squared distance, see
    /// [`OrthogonalSlides`].
    Slide(f64),
    SharedSlide,
    Turn,
    Ball,
}

impl Metric {
    /// Upper bound \[m\] on the displacement of a point fixed to frame `of`, seen from frame
    /// `relative_to` (0: the world), if the configuration moves by at most `distance` (metric
    /// units). `poses` are the frame poses at the present configuration.
    ///
    /// # Guarantee
    /// Proved for every such configuration; grows with `distance`.
    ///
    /// Joint metric: walks the joints between the two frames outward from the point. A joint that
    /// turns by `delta` moves the point by at most `reach * delta`. `reach` is the present distance
    /// of the point from the axis plus the displacement by the joints nearer to the point.
    /// Cauchy-Schwarz sums these terms. Object norm: [`super::solids::FrameSolid::motion_factor`];
    /// the squares for two moving frames add, since their shares of the volume do. Largest
    /// displacement: 1 per moving frame whose hull holds the point, else the object norm's factor.
    #[doc(hidden)]
    pub fn motion_bound(&self, poses: &[Pose], point: &BoundedPoint, distance: f64, path: &mut MotionPath) -> f64 {
        self.motion_between(poses, point.of, point.relative_to, path);
        self.motion_of(poses, point, path);
        path.bound(distance)
    }

    /// Prepares `path` for points of frame `of`, seen from `relative_to`.
    #[doc(hidden)]
    pub fn motion_between(&self, poses: &[Pose], of: usize, relative_to: usize, path: &mut MotionPath) {
        (path.of, path.relative_to) = (of, relative_to);
        path.steps.clear();
        path.rate = 0.0;
        if self.kind() == MetricKind::Joint {
            joint_steps(self.scene(), self.coordinate_uses(), poses, path);
        }
    }

    /// Prepares `path` for one point; [`Metric::motion_between`] has to have prepared its frames.
    #[doc(hidden)]
    pub fn motion_of(&self, poses: &[Pose], point: &BoundedPoint, path: &mut MotionPath) {
        debug_assert_eq!((point.of, point.relative_to), (path.of, path.relative_to));
        match self.kind() {
            MetricKind::Joint => path.place(&point.position),
            MetricKind::ObjectNorm => path.rate = self.factor(poses, point, false),
            MetricKind::MaxDisplacement => path.rate = self.factor(poses, point, true),
        }
    }

    /// Displacement \[m\] per metric unit: the root of the sum of both frames' squared factors, or
    /// for the largest displacement (`largest`) their sum, with 1 for a hull that holds the point.
    fn factor(&self, poses: &[Pose], point: &BoundedPoint, largest: bool) -> f64 {
        let of_frame = |frame: usize, inside: bool| {
            if frame == 0 {
                return 0.0;
            }
            if largest && inside {
                return 1.0;
            }
            let solid = self.solids().frames.iter().find(|s| s.frame == frame);
            let spread = poses[frame].inverse_point(&point.position);
            solid.map_or(f64::INFINITY, |s| s.motion_factor(&spread))
        };
        let a = of_frame(point.of, point.inside_of);
        let b = of_frame(point.relative_to, point.inside_relative_to);
        if largest { a + b } else { hypot(a, b) }
    }
}

/// A point and the two frames between which its motion is bounded.
#[derive(Debug, Clone, Copy)]
pub struct BoundedPoint {
    /// World coordinates \[m\] at the present configuration.
    pub position: Vec3,
    /// Index of the frame that carries the point.
    pub of: usize,
    /// Index of the frame from which the point is seen; 0 for the world.
    pub relative_to: usize,
    /// Whether the point lies in the convex hull of the geometry that `of` carries.
    pub inside_of: bool,
    /// Whether the point lies in the convex hull of the geometry that `relative_to` carries.
    pub inside_relative_to: bool,
}

fn joint_steps(scene: &Scene, uses: &[CoordinateUse], poses: &[Pose], path: &mut MotionPath) {
    let MotionPath { of, relative_to, steps, frames, reach, .. } = path;
    chain(scene, *of, *relative_to, frames);
    reach.clear();
    reach.resize(uses.len(), 0.0);
    let mut slides = OrthogonalSlides::default();
    for &frame in frames.iter() {
        let pose = &poses[frame];
        let (kind, axis, v, multiplier) = match &scene.frames[frame].motion {
            Motion::World => continue,
            Motion::Prismatic { axis, coordinate } => {
                let (axis, multiplier) = (pose.vector(axis), coordinate.multiplier.abs());
                let CoordinateUse { weight, shared } = uses[coordinate.v];
                if shared {
                    (StepKind::SharedSlide, axis, coordinate.v, multiplier)
                } else {
                    let counts = slides.add(&axis, multiplier * multiplier / weight);
                    (StepKind::Slide(counts), axis, coordinate.v, multiplier)
                }
            }
            Motion::Revolute { axis, coordinate } => {
                (StepKind::Turn, pose.vector(axis), coordinate.v, coordinate.multiplier.abs())
            }
            Motion::Ball { v, .. } => (StepKind::Ball, Vec3::zeros(), *v, 1.0),
        };
        if !matches!(kind, StepKind::Slide(_)) {
            slides = OrthogonalSlides::default();
        }
        let CoordinateUse { weight, shared } = uses[v];
        let (origin, shared) = (pose.translation, shared.then_some(v));
        steps.push(Step { kind, origin, axis, multiplier, per_weight: 1.0 / weight, shared, lever: 0.0 });
    }
}

impl MotionPath {
    /// Returns the sum of the joints' squared levers as a form of the point: a lower bound on the
    /// squared rate of [`MotionPath::bound`], and 0 for other metrics than the joint metric.
    #[doc(hidden)]
    pub fn levers(&self) -> Levers {
        let mut levers = Levers { squared: Mat3::zeros(), linear: Vec3::zeros(), constant: 0.0 };
        for step in &self.steps {
            let square = step.multiplier * step.multiplier * step.per_weight;
            // This projects an arm to its part across the axis, whose length is the lever.
            let across = match step.kind {
                StepKind::Slide(_) => continue,
                StepKind::SharedSlide => {
                    levers.constant += square;
                    continue;
                }
                StepKind::Turn => Mat3::identity() - step.axis * step.axis.transpose(),
                StepKind::Ball => Mat3::identity(),
            } * square;
            let linear = across * step.origin;
            levers.squared += across;
            levers.linear += linear;
            levers.constant += linear.dot(&step.origin);
        }
        levers
    }

    fn place(&mut self, point: &Vec3) {
        for step in &mut self.steps {
            let arm = point - step.origin;
            step.lever = match step.kind {
                StepKind::Slide(_) | StepKind::SharedSlide => step.multiplier,
                StepKind::Turn => step.multiplier * step.axis.cross(&arm).norm(),
                StepKind::Ball => arm.norm(),
            };
        }
    }

    /// Returns the ratio of bound to distance if it is constant; `None` for joints under `joint`.
    pub fn factor(&self) -> Option<f64> {
        self.steps.is_empty().then_some(self.rate)
    }

    /// Returns an upper bound \[m\] on the displacement of the point within `distance` (metric
    /// units), see [`Metric::motion_bound`].
    ///
    /// # Guarantee
    /// The bound grows with `distance` from 0 and is convex: it is `distance` times a norm of terms
    /// that are nonnegative, increasing and convex.
    pub fn bound(&mut self, distance: f64) -> f64 {
        let Self { steps, reach, .. } = self;
        steps.iter().filter_map(|step| step.shared).for_each(|v| reach[v] = 0.0);
        // Squared displacement per squared distance by the joints so far.
        let mut squared: f64 = 0.0;
        for step in steps.iter() {
            let far = match step.kind {
                StepKind::Slide(counts) => {
                    squared += counts;
                    continue;
                }
                StepKind::SharedSlide => step.lever,
                StepKind::Turn | StepKind::Ball => step.lever + step.multiplier * distance * squared.sqrt(),
            };
            let Some(v) = step.shared else {
                squared += far * far * step.per_weight;
                continue;
            };
            // A mimic joint adds to the reach of the coordinate that it shares.
            let before = reach[v];
            reach[v] += far;
            squared += (reach[v] * reach[v] - before * before) * step.per_weight;
        }
        distance * (self.rate + squared.max(0.0).sqrt())
    }
}

/// The sum of squared levers as a form `p' A p - 2 b' p + c` of the point `p`, so that many points
/// of one frame cost little more than one.
#[derive(Debug, Clone, Copy)]
pub struct Levers {
    squared: Mat3,
    linear: Vec3,
    constant: f64,
}

impl Levers {
    /// Returns the squared rates \[m per metric unit\], at least 0, of points at `positions` (world
    /// \[m\], axis by axis). [`MotionPath::bound`] grows at least that fast.
    #[inline(always)]
    pub fn squared_rates(&self, positions: &[[f64; LANES]; 3]) -> [f64; LANES] {
        let (a, b) = (&self.squared, &self.linear);
        let [xs, ys, zs] = positions;
        let mut rates = [0.0; LANES];
        for (lane, rate) in rates.iter_mut().enumerate() {
            let (x, y, z) = (xs[lane], ys[lane], zs[lane]);
            let square = a[(0, 0)] * x * x
                + a[(1, 1)] * y * y
                + a[(2, 2)] * z * z
                + 2.0 * (a[(0, 1)] * x * y + a[(0, 2)] * x * z + a[(1, 2)] * y * z);
            let linear = 2.0 * (b.x * x + b.y * y + b.z * z);
            // Near an axis the terms cancel, so the largest rounding error is subtracted.
            let rounding = ROUNDING_SHARE * (square + linear.abs() + self.constant);
            let left = square - linear + self.constant - rounding;
            *rate = if left > 0.0 { left } else { 0.0 };
        }
        rates
    }
}

/// Rounding error of a few dozen operations, as a share of the sum of the terms' magnitudes.
const ROUNDING_SHARE: f64 = 1e-14;

/// Consecutive prismatic joints along orthogonal axes, without a rotating joint between them. Their
/// displacements are orthogonal, so together they add only the largest `multiplier^2 / weight`.
#[derive(Default)]
struct OrthogonalSlides {
    axes: [Vec3; 3],
    count: usize,
    most: f64,
}

impl OrthogonalSlides {
    /// Adds a slide along `axis`, and returns the growth of the squared displacement.
    fn add(&mut self, axis: &Vec3, square: f64) -> f64 {
        if self.count == 3 || self.axes[..self.count].iter().any(|other| other.dot(axis).abs() > 1e-12) {
            *self = Self::default();
        }
        self.axes[self.count] = *axis;
        self.count += 1;
        let grown = (square - self.most).max(0.0);
        self.most += grown;
        grown
    }
}

/// Writes the frames whose joints lie between `of` and `relative_to` to `path`, from `of` up to the
/// common ancestor and down to the other.
fn chain(scene: &Scene, of: usize, relative_to: usize, path: &mut Vec<usize>) {
    path.clear();
    let (mut a, mut b) = (of, relative_to);
    // A parent precedes its children, so the larger index is never an ancestor of the smaller one.
    while a != b {
        if a > b {
            path.push(a);
            a = scene.frames[a].parent;
        } else {
            b = scene.frames[b].parent;
        }
    }
    let turn = path.len();
    let mut b = relative_to;
    while b != a {
        path.push(b);
        b = scene.frames[b].parent;
    }
    path[turn..].reverse();
}

//! Poses of one mesh relative to another: at random, and next to contact.

use extricate::geometry::{Pose, TriangleMesh};
use extricate::internals::collision::{PairScratch, PreparedShape};
use extricate::internals::math::Vec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A mesh with the shape that was prepared from it.
pub struct Body {
    pub mesh: TriangleMesh,
    pub shape: PreparedShape,
    /// Centre of its bounding box, and half the diagonal \[m\].
    pub ball: (Vec3, f64),
}

impl Body {
    /// Prepares a mesh that has triangles.
    pub fn new(mesh: TriangleMesh) -> Self {
        let shape = PreparedShape::new(&extricate::geometry::Geometry::Mesh(mesh.clone().into()));
        let lower = mesh.vertices.iter().fold(Vec3::repeat(f64::INFINITY), |a, v| a.inf(v));
        let upper = mesh.vertices.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, v| a.sup(v));
        Self {
            shape: shape.expect("a mesh with triangles"),
            mesh,
            ball: ((lower + upper) / 2.0, (upper - lower).norm() / 2.0),
        }
    }

    /// Whether two bodies are nearer than `limit` \[m\].
    pub fn is_nearer(&self, other: &Self, pose: &Pose, limit: f64, scratch: &mut PairScratch) -> bool {
        self.shape.is_nearer(&other.shape, pose, limit, scratch)
    }
}

/// A line of approach: the second body, randomly rotated, moves away from the middle of the first.
pub struct Approach {
    start: Pose,
    direction: Vec3,
}

impl Approach {
    /// Draws an approach whose bounding boxes' centres begin at most a third of the summed radii
    /// apart.
    pub fn random(a: &Body, b: &Body, rng: &mut ChaCha8Rng) -> Self {
        let mut start = Pose { rotation: rotation(rng), translation: Vec3::zeros() };
        let offset = direction(rng) * (rng.random::<f64>() * (a.ball.1 + b.ball.1) / 3.0);
        start.translation = a.ball.0 + offset - start.vector(&b.ball.0);
        Self { start, direction: direction(rng) }
    }

    /// Removes the rotation and approaches along an axis, so that parallel faces stay parallel.
    pub fn align(&mut self, axis: usize) {
        self.start.rotation = extricate::internals::math::Mat3::identity();
        self.direction = Vec3::ith(axis, 1.0);
    }

    /// The pose after `way` \[m\].
    pub fn at(&self, way: f64) -> Pose {
        Pose { translation: self.start.translation + self.direction * way, ..self.start }
    }

    /// Bisects for a `way` within `precision` \[m\] of one at which the pair stops being nearer
    /// than `limit`; there may be others. Returns `None` if it is not nearer at the start.
    pub fn last_contact(
        &self,
        a: &Body,
        b: &Body,
        limit: f64,
        precision: f64,
        scratch: &mut PairScratch,
    ) -> Option<f64> {
        let (mut near, mut far) = (0.0, 2.0 * (a.ball.1 + b.ball.1) + limit);
        if !a.is_nearer(b, &self.at(near), limit, scratch) {
            return None;
        }
        while far - near > precision {
            let middle = 0.5 * (near + far);
            // For a large mesh, rounding may prevent the precision from being reached.
            if middle <= near || middle >= far {
                break;
            }
            *(if a.is_nearer(b, &self.at(middle), limit, scratch) { &mut near } else { &mut far }) = middle;
        }
        Some(near)
    }
}

/// Draws up to `count` random poses, about half of them nearer than `limit`.
pub fn half_colliding(a: &Body, b: &Body, limit: f64, count: usize, rng: &mut ChaCha8Rng) -> Vec<Pose> {
    let (mut near, mut far) = (Vec::new(), Vec::new());
    let mut scratch = PairScratch::default();
    let mut tries = 0;
    while near.len() + far.len() < count && tries < 200 * count {
        tries += 1;
        let way = rng.random::<f64>() * (a.ball.1 + b.ball.1);
        let pose = Approach::random(a, b, rng).at(way);
        let kind = if a.is_nearer(b, &pose, limit, &mut scratch) { &mut near } else { &mut far };
        if kind.len() < count.div_ceil(2) {
            kind.push(pose);
        }
    }
    shuffled(near.into_iter().chain(far).collect(), rng)
}

/// Draws poses within 1 mm, along a random approach, of one at which the distance is `limit`; half
/// of them on each side on average.
pub fn near_contact(a: &Body, b: &Body, limit: f64, count: usize, rng: &mut ChaCha8Rng) -> Vec<Pose> {
    let mut poses = Vec::new();
    let mut scratch = PairScratch::default();
    for _ in 0..200 * count {
        let approach = Approach::random(a, b, rng);
        if let Some(way) = approach.last_contact(a, b, limit, 1e-9, &mut scratch) {
            poses.push(approach.at(way + 1e-3 * (2.0 * rng.random::<f64>() - 1.0)));
            if poses.len() == count {
                break;
            }
        }
    }
    poses
}

fn shuffled(mut poses: Vec<Pose>, rng: &mut ChaCha8Rng) -> Vec<Pose> {
    for k in (1..poses.len()).rev() {
        poses.swap(k, rng.random_range(0..=k));
    }
    poses
}

/// Draws a point uniformly from the unit sphere.
pub fn direction(rng: &mut ChaCha8Rng) -> Vec3 {
    loop {
        let v = Vec3::from_fn(|_, _| 2.0 * rng.random::<f64>() - 1.0);
        let norm = v.norm();
        if (0.1..=1.0).contains(&norm) {
            return v / norm;
        }
    }
}

/// Draws a uniform rotation: K. Shoemake, Uniform random rotations, Graphics Gems III, 1992.
fn rotation(rng: &mut ChaCha8Rng) -> extricate::internals::math::Mat3 {
    let [u, v, w] = [0; 3].map(|_| rng.random::<f64>());
    let (r, s) = ((1.0 - u).sqrt(), u.sqrt());
    let (a, b) = (std::f64::consts::TAU * v, std::f64::consts::TAU * w);
    extricate::internals::math::quaternion_matrix(&[r * a.sin(), r * a.cos(), s * b.sin(), s * b.cos()])
}

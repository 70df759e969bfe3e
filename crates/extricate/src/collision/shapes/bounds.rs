//! Bounding boxes and balls, and lower bounds on the distance of two of them. They never prove that
//! shapes touch.

use crate::math::{Mat3, Pose, Vec3};

/// An axis-aligned box \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Centre of the box.
    pub center: Vec3,
    /// Half of each side, rounded up.
    pub half: Vec3,
}

impl Aabb {
    /// Returns the eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        let side = |k: usize, i: usize| if k >> i & 1 == 1 { self.half[i] } else { -self.half[i] };
        std::array::from_fn(|k| self.center + Vec3::from_fn(|i, _| side(k, i)))
    }

    /// The box from `lower` to `upper`, widened to cover rounding.
    pub fn between(lower: &Vec3, upper: &Vec3) -> Self {
        let center = (lower + upper) * 0.5;
        let half = (upper - center).sup(&(center - lower));
        Self { center, half: half + (center.abs() + half) * (4.0 * f64::EPSILON) }
    }

    /// The least box around `points`, of which at least one is required.
    pub fn around<'a>(points: impl Iterator<Item = &'a Vec3>) -> Self {
        let (lower, upper) = points.fold(EMPTY, |(lower, upper), p| (lower.inf(p), upper.sup(p)));
        Self::between(&lower, &upper)
    }

    /// Whether `point` lies in the box.
    pub fn contains(&self, point: &Vec3) -> bool {
        let offset = (point - self.center).abs();
        offset.x <= self.half.x && offset.y <= self.half.y && offset.z <= self.half.z
    }
}

/// Lower and upper corner of an empty set of points.
pub const EMPTY: (Vec3, Vec3) = (
    Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
    Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
);

/// Rounding error \[m\] of a gap in scenes of some metres. Boxes must not separate shapes that
/// exact tests call near.
pub const ROUNDING: f64 = 1e-12;

/// The pose of frame `b` in frame `a`, prepared for many box tests.
#[derive(Debug, Clone, Copy)]
pub struct Relative {
    /// Maps frame `b` to frame `a`.
    pub pose_a_b: Pose,
    /// Absolute values of the rotation, rounded up so that nearly parallel axes separate nothing.
    absolute: Mat3,
}

impl Relative {
    /// Prepares `pose_a_b` for box tests.
    pub fn new(pose_a_b: Pose) -> Self {
        Self { pose_a_b, absolute: pose_a_b.rotation.abs().add_scalar(1e-15) }
    }

    /// Relative pose from the poses of both frames in a third one.
    pub fn between(pose_w_a: &Pose, pose_w_b: &Pose) -> Self {
        let rotation = pose_w_a.rotation.tr_mul(&pose_w_b.rotation);
        let translation = pose_w_a.inverse_vector(&(pose_w_b.translation - pose_w_a.translation));
        Self::new(Pose { rotation, translation })
    }

    /// Whether a box in `a` and a box in `b` are proved farther apart than `margin` \[m\].
    ///
    /// # Source
    /// S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996,
    /// doi:10.1145/237170.237244: fifteen separating axes. Deviation: the three gaps along the axes
    /// of one box are also added up as a vector.
    pub fn apart(&self, a: &Aabb, b: &Aabb, margin: f64) -> bool {
        let margin = margin + ROUNDING;
        let rotation = &self.pose_a_b.rotation;
        let t = self.pose_a_b.point(&b.center) - a.center;
        let squared = margin * margin;
        if positive_squared(&(t.abs() - a.half - self.absolute * b.half)) > squared {
            return true;
        }
        if positive_squared(&(rotation.tr_mul(&t).abs() - b.half - self.absolute.tr_mul(&a.half))) > squared {
            return true;
        }
        // Cross products of nearly parallel axes are shorter than unit length. Using the full
        // `margin` for them is conservative.
        let (r, m) = (rotation, &self.absolute);
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let reach_a = a.half[i1] * m[(i2, j)] + a.half[i2] * m[(i1, j)];
                let reach_b = b.half[j1] * m[(i, j2)] + b.half[j2] * m[(i, j1)];
                if (t[i2] * r[(i1, j)] - t[i1] * r[(i2, j)]).abs() > reach_a + reach_b + margin {
                    return true;
                }
            }
        }
        false
    }

    /// Lower bound \[m\] on the signed distance of the contents of two boxes; negative if they
    /// overlap along all face axes.
    pub fn lower_bound(&self, a: &Aabb, b: &Aabb) -> f64 {
        let t = self.pose_a_b.point(&b.center) - a.center;
        let in_a = t.abs() - a.half - self.absolute * b.half;
        let in_b = self.pose_a_b.rotation.tr_mul(&t).abs() - b.half - self.absolute.tr_mul(&a.half);
        let squared = positive_squared(&in_a).max(positive_squared(&in_b));
        if squared > 0.0 { squared.sqrt() } else { in_a.max().max(in_b.max()) }
    }
}

fn positive_squared(gaps: &Vec3) -> f64 {
    gaps.sup(&Vec3::zeros()).norm_squared()
}

/// Bounding ball of points: `(centre, radius)` \[m\], a few per cent larger than the least one.
///
/// # Source
/// M. Badoiu and K. L. Clarkson, "Smaller core-sets for balls", SODA 2003: step toward the farthest
/// point by 1/(i+1).
pub fn bounding_ball(points: &[Vec3]) -> (Vec3, f64) {
    let mut center = Aabb::around(points.iter()).center;
    // The last of several equally far points.
    let farthest = |center: &Vec3| {
        let mut found = (f64::NEG_INFINITY, center);
        for point in points {
            let squared = (point - center).norm_squared();
            found = if squared >= found.0 { (squared, point) } else { found };
        }
        *found.1
    };
    let mut far = farthest(&center);
    let mut best = (center, (far - center).norm());
    for i in 1..64 {
        center += (far - center) / (i as f64 + 1.0);
        far = farthest(&center);
        let radius = (far - center).norm();
        if radius < best.1 {
            best = (center, radius);
        }
    }
    (best.0, best.1 * (1.0 + 1e-12))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn bounds_never_exceed_the_distance_of_points() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (mut apart, mut bounded) = (0, 0);
        for _ in 0..3000 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let (x, r) = (vector(3.0), vector(6.0));
            let relative = Relative::new(Pose::from_xyz_rpy(x.into(), r.into()));
            let cloud_a: Vec<Vec3> = (0..12).map(|_| vector(1.0)).collect();
            let cloud_b: Vec<Vec3> = (0..12).map(|_| vector(1.5)).collect();
            let (a, b) = (Aabb::around(cloud_a.iter()), Aabb::around(cloud_b.iter()));
            let gap = |p: &Vec3| cloud_a.iter().map(|s| (relative.pose_a_b.point(p) - s).norm()).fold(9.0, f64::min);
            let nearest = cloud_b.iter().map(gap).fold(9.0, f64::min);
            assert!(cloud_a.iter().all(|p| a.contains(p)));
            assert!(relative.lower_bound(&a, &b) <= nearest);
            for margin in [0.0, 0.1, 0.5] {
                apart += usize::from(relative.apart(&a, &b, margin));
                assert!(!relative.apart(&a, &b, margin) || nearest > margin);
            }
            bounded += usize::from(relative.lower_bound(&a, &b) > 0.0);
        }
        assert!(apart > 2000 && bounded > 1000, "{apart} {bounded}");
    }

    #[test]
    fn ball_holds_its_points_and_is_tight() {
        let corners: Vec<Vec3> =
            (0..8).map(|k| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)).collect();
        let (center, radius) = bounding_ball(&corners);
        assert!(corners.iter().all(|p| (p - center).norm() <= radius));
        assert!(radius < 0.8661, "{radius}");
    }
}

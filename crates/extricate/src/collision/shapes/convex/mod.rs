//! Convex shapes by their support functions: a polyhedral or smooth core, rounded by a radius.

mod hull;

pub use hull::HullPoints;

use crate::math::Vec3;
use crate::math::elementary::hypot;

/// A convex core in its own frame, swept by a ball of `radius` \[m\].
///
/// ```
/// use extricate::internals::collision::shapes::convex::{ConvexCore, ConvexShape};
/// let sphere = ConvexShape { core: ConvexCore::Point, radius: 0.1 };
/// let capsule = ConvexShape { core: ConvexCore::Segment { half_length: 0.2 }, radius: 0.05 };
/// assert_eq!(sphere.core.reach() + capsule.core.reach(), 0.2);
/// ```
#[derive(Debug, Clone)]
pub struct ConvexShape {
    /// Core that the ball sweeps.
    pub core: ConvexCore,
    /// Radius of the ball \[m\].
    pub radius: f64,
}

/// A convex set given by its support function.
#[derive(Debug, Clone)]
pub enum ConvexCore {
    /// Only the origin.
    Point,
    /// Line segment from `-half_length` to `half_length` along z.
    Segment {
        /// Half of the length \[m\].
        half_length: f64,
    },
    /// Cuboid centred at the origin.
    Box {
        /// Half of each side \[m\].
        half_extents: Vec3,
    },
    /// Cylinder along z, centred at the origin.
    Cylinder {
        /// Radius of the discs \[m\].
        radius: f64,
        /// Half of the length \[m\].
        half_length: f64,
    },
    /// Triangle with these corners \[m\].
    Triangle([Vec3; 3]),
    /// The convex hull of points.
    Hull(HullPoints),
    /// Set between a triangle and its shadow on a horizontal plane below it.
    Prism {
        /// Corners of the triangle \[m\].
        top: [Vec3; 3],
        /// Height of the plane \[m\], below all corners.
        bottom: f64,
    },
}

impl ConvexCore {
    /// Point of the core that lies farthest along `direction` (of any length) \[m\].
    #[inline(always)]
    pub fn support(&self, direction: &Vec3) -> Vec3 {
        match self {
            Self::Point => Vec3::zeros(),
            Self::Segment { half_length } => Vec3::new(0.0, 0.0, half_length.copysign(direction.z)),
            Self::Box { half_extents } => half_extents.zip_map(direction, f64::copysign),
            Self::Cylinder { radius, half_length } => {
                let along_disc = (direction.x * direction.x + direction.y * direction.y).sqrt();
                let scale = if along_disc > 0.0 { radius / along_disc } else { 0.0 };
                Vec3::new(direction.x * scale, direction.y * scale, half_length.copysign(direction.z))
            }
            Self::Triangle([a, b, c]) => {
                let (along_a, along_b, along_c) = (a.dot(direction), b.dot(direction), c.dot(direction));
                let (best, along_best) = if along_b > along_a { (b, along_b) } else { (a, along_a) };
                if along_c > along_best { *c } else { *best }
            }
            Self::Hull(hull) => hull.support(direction),
            Self::Prism { top, bottom } => {
                let steep = if direction.z < 0.0 { 0.0 } else { direction.z };
                let along = |p: &Vec3| direction.x * p.x + direction.y * p.y + steep * p.z;
                let (along_a, along_b, along_c) = (along(&top[0]), along(&top[1]), along(&top[2]));
                let (best, along_best) = if along_b > along_a { (top[1], along_b) } else { (top[0], along_a) };
                let best = if along_c > along_best { top[2] } else { best };
                if direction.z < 0.0 { Vec3::new(best.x, best.y, *bottom) } else { best }
            }
        }
    }

    /// Point within the core, near its middle \[m\].
    pub fn center(&self) -> Vec3 {
        match self {
            Self::Triangle([a, b, c]) => (a + b + c) / 3.0,
            Self::Hull(hull) => hull.center(),
            Self::Prism { top: [a, b, c], bottom } => {
                let middle = (a + b + c) / 3.0;
                Vec3::new(middle.x, middle.y, 0.5 * (middle.z + bottom))
            }
            _ => Vec3::zeros(),
        }
    }

    /// Distance from the origin of the frame to the farthest point of the core \[m\].
    pub fn reach(&self) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Segment { half_length } => *half_length,
            Self::Box { half_extents } => half_extents.norm(),
            Self::Cylinder { radius, half_length } => hypot(*radius, *half_length),
            Self::Triangle(corners) => corners.iter().map(|corner| corner.norm()).fold(0.0, f64::max),
            Self::Hull(hull) => hull.reach(),
            Self::Prism { top, bottom } => {
                top.iter().map(|p| p.norm().max(hypot(hypot(p.x, p.y), *bottom))).fold(0.0, f64::max)
            }
        }
    }

    /// Whether the boundary has smooth parts, so that support points never repeat exactly.
    pub(crate) fn is_curved(&self) -> bool {
        matches!(self, Self::Cylinder { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn supports_bound_every_core() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let triangle = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(-0.2, 0.1, 0.0), Vec3::new(0.0, -0.3, 0.2)];
        for _ in 0..1000 {
            let d = Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5);
            let height = |core: &ConvexCore| core.support(&d).dot(&d);
            let disc = (d.x * d.x + d.y * d.y).sqrt();
            let cylinder = ConvexCore::Cylinder { radius: 0.3, half_length: 0.7 };
            assert!((height(&cylinder) - (0.3 * disc + 0.7 * d.z.abs())).abs() < 1e-15);
            let cuboid = ConvexCore::Box { half_extents: Vec3::new(0.1, 0.2, 0.3) };
            assert!((height(&cuboid) - (0.1 * d.x.abs() + 0.2 * d.y.abs() + 0.3 * d.z.abs())).abs() < 1e-15);
            assert_eq!(height(&ConvexCore::Segment { half_length: 0.4 }), 0.4 * d.z.abs());
            let farthest = triangle.iter().map(|p| p.dot(&d)).fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(height(&ConvexCore::Triangle(triangle)), farthest);
            let prism = ConvexCore::Prism { top: triangle, bottom: -0.4 };
            let shadow = triangle.map(|p| Vec3::new(p.x, p.y, -0.4).dot(&d)).into_iter().fold(farthest, f64::max);
            assert!((height(&prism) - shadow).abs() < 1e-15);
        }
    }

    #[test]
    fn a_cylinder_seen_along_its_axis_gives_a_finite_point() {
        let cylinder = ConvexCore::Cylinder { radius: 0.3, half_length: 0.7 };
        assert_eq!(cylinder.support(&Vec3::new(0.0, 0.0, -2.0)), Vec3::new(0.0, 0.0, -0.7));
    }
}

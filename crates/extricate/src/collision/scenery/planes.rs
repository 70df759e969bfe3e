//! Supporting planes of a convex shape, collected from searches. Most later elements lie beyond one
//! of them, which saves their search.

use arrayvec::ArrayVec;

use super::nodes::Element;
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::convex::ConvexCore;
use crate::math::{Pose, Vec3};

/// Planes that are kept; a new one replaces the oldest. Testing one costs a thirtieth of a search.
const MAX_PLANES: usize = 8;

/// Unit normals and offsets \[m\] in the frame of the scenery.
#[derive(Debug, Clone, Default)]
pub struct Planes {
    all: ArrayVec<(Vec3, f64), MAX_PLANES>,
    oldest: usize,
}

impl Planes {
    /// Whether a plane proves that an element is at least `limit` \[m\] from the shape.
    #[inline]
    pub fn part(&self, element: &Element, limit: f64) -> bool {
        self.all.iter().any(|(normal, offset)| {
            let below = match element.solid.shape.core {
                ConvexCore::Point => element.solid.shape.radius,
                _ => normal.abs().dot(&element.bounds.half) - normal.dot(&element.bounds.center),
            };
            normal.dot(&element.place) - below - offset >= limit
        })
    }

    /// Whether a plane proves that a box (frame of the scenery) is at least `limit` \[m\] from the
    /// shape.
    #[inline]
    pub fn part_box(&self, bounds: &Aabb, limit: f64) -> bool {
        let lowest = |normal: &Vec3| normal.dot(&bounds.center) - normal.abs().dot(&bounds.half);
        self.all.iter().any(|(normal, offset)| lowest(normal) - offset >= limit)
    }

    /// Adds the plane across `normal` that touches the shape. `normal` has any length, lies in the
    /// frame of the scenery and points away from the shape.
    pub fn add(&mut self, normal: &Vec3, solid: &ConvexSolid, pose: &Pose) {
        let Some(normal) = normal.try_normalize(0.0) else { return };
        let farthest = pose.point(&solid.shape.core.support(&pose.inverse_vector(&normal)));
        let plane = (normal, normal.dot(&farthest) + solid.shape.radius);
        if self.all.is_full() {
            self.all[self.oldest] = plane;
            self.oldest = (self.oldest + 1) % MAX_PLANES;
        } else {
            self.all.push(plane);
        }
    }
}

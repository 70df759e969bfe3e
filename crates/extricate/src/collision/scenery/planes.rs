//! Planes that a convex shape lies behind, as searches find them: most elements that are looked at
//! next are beyond one of them.

use arrayvec::ArrayVec;

use super::tree::Element;
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::convex::ConvexCore;
use crate::math::{Pose, Vec3};

/// Planes that are remembered; the oldest gives way. A test of one takes a thirtieth of a search.
const MOST: usize = 8;

/// Unit normals and offsets \[m\] in the frame of the scenery.
#[derive(Debug, Clone, Default)]
pub struct Planes {
    all: ArrayVec<(Vec3, f64), MOST>,
    oldest: usize,
}

impl Planes {
    /// Whether one of them proves that an element is at least `limit` \[m\] from the shape.
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

    /// Whether one of them proves that all that lies in a box (frame of the scenery) is at least
    /// `limit` \[m\] from the shape.
    #[inline]
    pub fn part_box(&self, bounds: &Aabb, limit: f64) -> bool {
        let lowest = |normal: &Vec3| normal.dot(&bounds.center) - normal.abs().dot(&bounds.half);
        self.all.iter().any(|(normal, offset)| lowest(normal) - offset >= limit)
    }

    /// Adds the one across `normal` (of any length, frame of the scenery, away from the shape) that
    /// touches the shape.
    pub fn add(&mut self, normal: &Vec3, solid: &ConvexSolid, pose: &Pose) {
        let Some(normal) = normal.try_normalize(0.0) else { return };
        let farthest = pose.point(&solid.shape.core.support(&pose.inverse_vector(&normal)));
        let plane = (normal, normal.dot(&farthest) + solid.shape.radius);
        if self.all.is_full() {
            self.all[self.oldest] = plane;
            self.oldest = (self.oldest + 1) % MOST;
        } else {
            self.all.push(plane);
        }
    }
}

//! Convex hulls of vertex sets. The only file that names the library which computes them.

use super::TriangleMesh;
use crate::math::Vec3;

/// The convex hull as a closed mesh with outward faces; `None` where the points lie (nearly) in one plane.
pub fn convex_hull(points: &[Vec3]) -> Option<TriangleMesh> {
    todo!("{points:?}")
}

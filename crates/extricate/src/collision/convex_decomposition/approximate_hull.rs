//! The farthest points of a set in a few directions, for an approximate hull that is made quickly.

use crate::math::Vec3;
use crate::robot::TriangleMesh;
use crate::robot::mesh::convex_hull::convex_hull;

/// One of each two opposite directions of a sketch: axes, and diagonals of the faces of a cube and
/// of a cube.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// The farthest points of a set along [`DIRECTIONS`] and against them.
pub struct Sketch {
    least: [(f64, Vec3); DIRECTIONS.len()],
    most: [(f64, Vec3); DIRECTIONS.len()],
}

impl Default for Sketch {
    fn default() -> Self {
        let none = |along| [(along, Vec3::zeros()); DIRECTIONS.len()];
        Self { least: none(f64::INFINITY), most: none(f64::NEG_INFINITY) }
    }
}

impl Sketch {
    pub fn add(&mut self, point: &Vec3) {
        for (k, [x, y, z]) in DIRECTIONS.iter().enumerate() {
            let along = x * point.x + y * point.y + z * point.z;
            if along < self.least[k].0 {
                self.least[k] = (along, *point);
            }
            if along > self.most[k].0 {
                self.most[k] = (along, *point);
            }
        }
    }

    /// Returns the hull of the farthest points; `None` if they lie in a plane.
    pub fn hull(&self) -> Option<TriangleMesh> {
        let known = self.least.iter().chain(&self.most).filter(|(along, _)| along.is_finite());
        convex_hull(&known.map(|(_, point)| *point).collect::<Vec<_>>())
    }
}

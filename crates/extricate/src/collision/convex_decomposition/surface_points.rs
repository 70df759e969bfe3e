//! Points spread evenly over triangles.

use crate::cspace::sampling::Halton;
use crate::math::Vec3;

/// A point of the mesh.
#[derive(Clone, Copy)]
pub struct SurfacePoint {
    /// Position of the point \[m\].
    pub point: Vec3,
    /// Unit normal of its triangle.
    pub normal: Vec3,
}

/// Returns about `count` points, one for each equal share of the area.
pub fn surface_points(triangles: &[[Vec3; 3]], count: usize) -> Vec<SurfacePoint> {
    let spread = Halton::new(2, 0);
    let normal = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a));
    let share = triangles.iter().map(|t| normal(t).norm()).sum::<f64>() / count as f64;
    let (mut points, mut left) = (Vec::new(), 0.5 * share);
    for triangle in triangles {
        let [a, b, c] = triangle;
        let normal = normal(triangle);
        left += normal.norm();
        while share > 0.0 && left >= share {
            left -= share;
            let [s, t] = [0, 1].map(|k| spread.coordinate(points.len() as u64, k));
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            let point = a + (b - a) * s + (c - a) * t;
            points.push(SurfacePoint { point, normal: normal.normalize() });
        }
    }
    points
}

//! Convex pieces inside a mesh, which stand for it in proofs.
//!
//! Planes cut the box of the mesh around the centre of a large ball in the solid, until no triangle
//! is left in it. Each plane cuts off the nearest remaining triangle: it passes through the nearest
//! point of that triangle, perpendicular to the line from the centre. The rest is convex, contains
//! the centre and meets no triangle, so it lies in the solid.
//!
//! # Source
//! The order of cuts is that of R. Deits and R. Tedrake, "Computing large convex regions of
//! obstacle-free space through semidefinite programming", WAFR 2014,
//! doi:10.1007/978-3-319-16595-0_7. Deviations: a ball replaces the ellipsoid, and it does not
//! grow.

use crate::collision::narrow_phase::triangle::{Triangle, closest_on_triangle};
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::convex::{ConvexCore, ConvexShape, HullPoints};
use crate::collision::shapes::inner_spheres::largest_balls;
use crate::collision::shapes::mesh::MeshShape;
use crate::math::Vec3;
use crate::robot::mesh::convex_hull::convex_hull;

/// A convex piece inside a solid.
#[derive(Debug, Clone)]
pub struct InnerPiece {
    /// The piece in the frame of the mesh.
    pub shape: ConvexShape,
    /// A ball in the piece: centre and radius \[m\].
    pub ball: (Vec3, f64),
    /// Distance \[m\] from the centre of the ball to the farthest point of the piece.
    pub reach: f64,
}

/// Balls from which pieces are grown.
const MAX_SEEDS: usize = 16;
/// A ball is skipped if a piece contains its centre deeper than this share of its radius.
const COVERED_DEPTH_SHARE: f64 = 0.5;
/// Share by which corners are moved toward the centre, far above rounding.
const SHRINK_SHARE: f64 = 1e-9;

/// Convex pieces inside the solids of a mesh with box `bounds`; open surfaces have none.
pub fn inner_pieces(mesh: &MeshShape, bounds: &Aabb) -> Vec<InnerPiece> {
    let (low, high) = (bounds.center - bounds.half, bounds.center + bounds.half);
    let mut stack = Vec::new();
    let depth = |p: &Vec3| mesh.depth_above(p, 0.0, &mut stack).unwrap_or(f64::NEG_INFINITY);
    let seeds = largest_balls(&low, &high, MAX_SEEDS, depth);
    let triangles: Vec<Triangle> = mesh.tree.triangles(0..mesh.tree.blocks.len()).collect();
    let mut grown: Vec<(Vec<Plane>, InnerPiece)> = Vec::new();
    for (center, radius) in seeds {
        let is_held = |planes: &[Plane]| planes.iter().all(|plane| plane.depth(&center) > COVERED_DEPTH_SHARE * radius);
        if grown.iter().any(|(planes, _)| is_held(planes)) {
            continue;
        }
        let planes = planes_around(&center, &triangles, &low, &high);
        if let Some(piece) = piece(&planes, center, radius) {
            grown.push((planes, piece));
        }
    }
    grown.into_iter().map(|(_, piece)| piece).collect()
}

/// A piece lies where `normal . x <= offset`.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vec3,
    offset: f64,
}

impl Plane {
    fn depth(&self, point: &Vec3) -> f64 {
        self.offset - self.normal.dot(point)
    }
}

fn planes_around(center: &Vec3, triangles: &[Triangle], low: &Vec3, high: &Vec3) -> Vec<Plane> {
    let sides = (0..3).flat_map(|k| [(Vec3::ith(k, 1.0), high[k]), (Vec3::ith(k, -1.0), -low[k])]);
    let mut planes: Vec<Plane> = sides.map(|(normal, offset)| Plane { normal, offset }).collect();
    let mut nearest: Vec<(f64, Vec3, usize)> = Vec::with_capacity(triangles.len());
    for (number, triangle) in triangles.iter().enumerate() {
        let point = closest_on_triangle(triangle, center);
        nearest.push(((point - center).norm(), point, number));
    }
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (distance, point, number) in nearest {
        let corners = &triangles[number].points;
        let is_out = |plane: &Plane| corners.iter().all(|corner| plane.depth(corner) <= 0.0);
        if planes.iter().rev().any(is_out) {
            continue;
        }
        let normal = (point - center) / distance;
        // Rounding may put a corner slightly before the nearest point of its triangle.
        let offset = corners.iter().map(|corner| normal.dot(corner)).fold(normal.dot(&point), f64::min);
        planes.push(Plane { normal, offset });
    }
    planes
}

/// Finds the corners of the polytope, as faces of the hull of its dual about the centre.
fn piece(planes: &[Plane], center: Vec3, radius: f64) -> Option<InnerPiece> {
    let duals: Vec<Vec3> = planes.iter().map(|plane| plane.normal / plane.depth(&center)).collect();
    let hull = convex_hull(&duals)?;
    let mut corners: Vec<Vec3> = Vec::new();
    for triangle in &hull.triangles {
        let [a, b, c] = triangle.map(|v| hull.vertices[v as usize]);
        let normal = (b - a).cross(&(c - a));
        let way = normal / normal.dot(&a);
        // Rounding, or a plane that the hull dropped, may have displaced the corner. Move it inside
        // all planes.
        let reached = planes.iter().map(|plane| plane.depth(&center) / plane.normal.dot(&way));
        let share = reached.filter(|share| *share > 0.0).fold(1.0, f64::min) * (1.0 - SHRINK_SHARE);
        let corner = center + way * share;
        let is_new = corners.iter().all(|other| (other - corner).norm() > SHRINK_SHARE * radius);
        if corner.iter().all(|x| x.is_finite()) && is_new {
            corners.push(corner);
        }
    }
    let reach = corners.iter().map(|corner| (corner - center).norm()).fold(0.0, f64::max);
    let shape = ConvexShape { core: ConvexCore::Hull(HullPoints::new(&corners)), radius: 0.0 };
    (corners.len() >= 4).then_some(InnerPiece { shape, ball: (center, radius), reach })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid, joined};
    use crate::robot::TriangleMesh;
    use rand::{RngExt, SeedableRng};

    fn pieces_of(mesh: &TriangleMesh) -> (MeshShape, Vec<InnerPiece>) {
        let shape = MeshShape::new(mesh);
        let bounds = Aabb::around(shape.vertices.iter());
        let pieces = inner_pieces(&shape, &bounds);
        (shape, pieces)
    }

    #[test]
    fn points_of_pieces_lie_in_the_solid() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let corner = joined(&[cuboid(Vec3::zeros(), Vec3::new(0.3, 0.05, 0.05)), bumpy(4, 3, 0.2)]);
        for mesh in [bumpy(2, 3, 0.4), bumpy(3, 2, 0.6), corner] {
            let (shape, pieces) = pieces_of(&mesh);
            assert!(!pieces.is_empty());
            for piece in &pieces {
                let ConvexCore::Hull(hull) = &piece.shape.core else { panic!("a hull") };
                for _ in 0..200 {
                    let weights: Vec<f64> = hull.points().iter().map(|_| -rng.random::<f64>().ln()).collect();
                    let sum: f64 = weights.iter().sum();
                    let point: Vec3 = hull.points().iter().zip(&weights).map(|(p, w)| p * (w / sum)).sum();
                    assert!(shape.holds(&point, &mut Vec::new()), "{point}");
                }
            }
        }
    }

    #[test]
    fn a_cuboid_is_one_piece() {
        let (_, pieces) = pieces_of(&cuboid(Vec3::zeros(), Vec3::new(0.1, 0.2, 0.3)));
        assert_eq!(pieces.len(), 1);
        let ConvexCore::Hull(hull) = &pieces[0].shape.core else { panic!("a hull") };
        let corner = Vec3::new(0.1, 0.2, 0.3);
        assert!(hull.points().iter().any(|p| (p - corner).norm() < 1e-6), "{:?}", hull.points());
    }
}

//! Geometry of a part for checks: a convex solid, a mesh or scenery, with a bounding box and a
//! bounding ball. Data for proposals is derived elsewhere.

use super::bounds::{Aabb, bounding_ball};
use super::bvh::TreeLayout;
use super::convex::{ConvexCore, ConvexShape, HullPoints};
use super::convex_solid::ConvexSolid;
use super::mesh::MeshShape;
use crate::collision::narrow_phase::triangle::Triangle;
use crate::collision::scenery::{HalfSpace, Scenery};
use crate::math::Vec3;
use crate::math::elementary::hypot;
use crate::robot::Geometry;

/// A shape in its own frame.
#[derive(Debug, Clone)]
pub struct Shape {
    /// Kind of shape, with its data.
    pub kind: ShapeKind,
    /// Bounding box in the frame of the shape.
    pub bounds: Aabb,
    /// Bounding ball: centre and radius \[m\].
    pub ball: (Vec3, f64),
}

/// Kinds of shapes that are checked against each other.
#[derive(Debug, Clone)]
pub enum ShapeKind {
    /// Convex solid with a support function.
    Convex(ConvexSolid),
    /// Triangle mesh that is not known to be convex.
    Mesh(MeshShape),
    /// Shape that only obstacles have.
    Scenery(Scenery),
}

/// Distance, as a share of its size, to which vertices may lie above faces of a mesh that still
/// counts as convex.
const CONVEX_TOLERANCE_SHARE: f64 = 1e-12;
/// Meshes with more vertices are not tested for convexity, which compares every face with every
/// vertex. For so many vertices, a tree of triangles is as fast as a support function.
const MAX_HULL_VERTICES: usize = 2048;

impl Shape {
    /// Prepares `geometry`; `None` for a mesh without triangles, and for an empty cloud or grid.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        if geometry.is_scenery() {
            let (scenery, bounds, ball) = Scenery::new(geometry)?;
            return Some(Self { kind: ShapeKind::Scenery(scenery), bounds, ball });
        }
        let solid = |core, radius| {
            let shape = ConvexShape { core, radius };
            ShapeKind::Convex(ConvexSolid::without_planes(shape))
        };
        let (radius, reach) = match *geometry {
            Geometry::Mesh(ref mesh) | Geometry::ConvexHull(ref mesh) => {
                return (!mesh.triangles.is_empty()).then(|| Self::of_mesh(MeshShape::new(mesh), geometry));
            }
            Geometry::Sphere { radius } => (radius, Vec3::repeat(radius)),
            Geometry::Box { half_extents } => {
                let half_extents = Vec3::from(half_extents);
                (half_extents.norm(), half_extents)
            }
            Geometry::Cylinder { radius, half_length } => {
                (hypot(radius, half_length), Vec3::new(radius, radius, half_length))
            }
            Geometry::Capsule { radius, half_length } => {
                (radius + half_length, Vec3::new(radius, radius, radius + half_length))
            }
            _ => unreachable!("scenery is prepared above"),
        };
        let kind = match *geometry {
            Geometry::Sphere { radius } => solid(ConvexCore::Point, radius),
            Geometry::Box { half_extents } => solid(ConvexCore::Box { half_extents: half_extents.into() }, 0.0),
            Geometry::Cylinder { radius, half_length } => solid(ConvexCore::Cylinder { radius, half_length }, 0.0),
            Geometry::Capsule { radius, half_length } => solid(ConvexCore::Segment { half_length }, radius),
            _ => unreachable!("returned above"),
        };
        let bounds = Aabb::between(&-reach, &reach);
        Some(Self { kind, bounds, ball: (Vec3::zeros(), radius * (1.0 + 1e-12)) })
    }

    /// Prepares a mesh or the hull of one with a tree from `layout`; `None` if that does not fit.
    pub fn with_layout(geometry: &Geometry, layout: TreeLayout) -> Option<Self> {
        let (Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh)) = geometry else { return None };
        Some(Self::of_mesh(MeshShape::with_layout(mesh, layout)?, geometry))
    }

    fn of_mesh(shape: MeshShape, geometry: &Geometry) -> Self {
        let (bounds, ball) = (Aabb::around(shape.vertices.iter()), bounding_ball(&shape.vertices));
        let kind = if matches!(geometry, Geometry::ConvexHull(_)) || is_convex(&shape, bounds.half.max()) {
            ShapeKind::Convex(hull(shape))
        } else {
            ShapeKind::Mesh(shape)
        };
        Self { kind, bounds, ball }
    }

    /// Returns the half-space if the shape is one.
    pub fn half_space(&self) -> Option<&HalfSpace> {
        match &self.kind {
            ShapeKind::Scenery(Scenery::HalfSpace(half)) => Some(half),
            _ => None,
        }
    }

    /// Signed depth \[m\] of `point`: positive inside the solid, minus the distance outside.
    pub fn depth(&self, point: &Vec3, stack: &mut Vec<(f64, u32)>) -> f64 {
        match &self.kind {
            ShapeKind::Convex(solid) => solid.depth(point),
            ShapeKind::Mesh(mesh) => mesh.depth_above(point, f64::NEG_INFINITY, stack).unwrap_or(0.0),
            ShapeKind::Scenery(scenery) => scenery.depth_above(point, f64::NEG_INFINITY, stack).unwrap_or(0.0),
        }
    }

    /// Same as [`Shape::depth`] if above `least`, else `None`; often faster.
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        match &self.kind {
            ShapeKind::Convex(solid) => Some(solid.depth(point)).filter(|depth| *depth > least),
            ShapeKind::Mesh(mesh) => mesh.depth_above(point, least, stack),
            ShapeKind::Scenery(scenery) => scenery.depth_above(point, least, stack),
        }
    }
}

fn is_convex(shape: &MeshShape, size: f64) -> bool {
    shape.closed == [true]
        && shape.vertices.len() <= MAX_HULL_VERTICES
        && all_triangles(shape).all(|t| shape.vertices.iter().all(|v| t.height(v) <= CONVEX_TOLERANCE_SHARE * size))
}

fn all_triangles(shape: &MeshShape) -> impl Iterator<Item = Triangle> {
    shape.tree.triangles(0..shape.tree.blocks.len())
}

fn hull(shape: MeshShape) -> ConvexSolid {
    let faces = all_triangles(&shape).filter(|t| t.normal != Vec3::zeros());
    let mut planes: Vec<(Vec3, f64)> =
        faces.map(|t| (t.normal, shape.vertices.iter().map(|v| t.normal.dot(v)).fold(f64::MIN, f64::max))).collect();
    planes.dedup_by(|a, b| a == b);
    let core = ConvexCore::Hull(HullPoints::new(&shape.vertices));
    ConvexSolid::with_planes(ConvexShape { core, radius: 0.0 }, planes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid, placed};
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    fn depth(geometry: Geometry, x: f64, y: f64, z: f64) -> f64 {
        Shape::new(&geometry).unwrap().depth(&Vec3::new(x, y, z), &mut Vec::new())
    }

    #[test]
    fn depths_of_primitives_in_closed_form() {
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        close(depth(Geometry::Sphere { radius: 2.0 }, 0.0, 0.6, 0.8), 1.0);
        let block = Geometry::Box { half_extents: [1.0, 2.0, 3.0] };
        close(depth(block.clone(), 0.5, 0.0, 0.0), 0.5);
        close(depth(block, 4.0, 6.0, 0.0), -5.0);
        let can = Geometry::Cylinder { radius: 1.0, half_length: 2.0 };
        close(depth(can.clone(), 0.6, 0.0, 1.9), 0.1);
        close(depth(can.clone(), 0.6, 0.0, 0.0), 0.4);
        close(depth(can, 4.0, 0.0, 6.0), -5.0);
        let pill = Geometry::Capsule { radius: 1.0, half_length: 2.0 };
        close(depth(pill.clone(), 0.5, 0.0, 1.0), 0.5);
        close(depth(pill, 0.0, 3.0, 6.0), -4.0);
    }

    #[test]
    fn hull_depth_equals_box_depth() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let shape = Shape::new(&Geometry::Mesh(Arc::new(cuboid(Vec3::zeros(), half)))).unwrap();
        assert!(matches!(shape.kind, ShapeKind::Convex(_)), "a closed convex mesh is its own hull");
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
        for _ in 0..500 {
            let p = Vec3::from_fn(|_, _| 8.0 * (rng.random::<f64>() - 0.5));
            let found = shape.depth(&p, &mut Vec::new());
            let expected = depth(Geometry::Box { half_extents: half.into() }, p.x, p.y, p.z);
            assert!((found - expected).abs() < 1e-9, "{p} {found} {expected}");
        }
    }

    #[test]
    fn boxes_and_balls_hold_their_meshes() {
        let mesh = placed(bumpy(9, 3, 0.3), 0.3, Vec3::new(1.0, 2.0, 3.0));
        let shape = Shape::new(&Geometry::Mesh(Arc::new(mesh.clone()))).unwrap();
        assert!(matches!(shape.kind, ShapeKind::Mesh(_)));
        for v in &mesh.vertices {
            assert!(shape.bounds.contains(v) && (v - shape.ball.0).norm() <= shape.ball.1);
        }
    }
}

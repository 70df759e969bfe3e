//! A part's geometry prepared for checks: a convex solid or a mesh, with a box and a ball around it.

use std::sync::{Arc, OnceLock};

use super::bounds::{Aabb, bounding_ball};
use super::convex::{ConvexCore, ConvexShape, HullPoints};
use super::cover::InnerBalls;
use super::gjk;
use super::inner_pieces::{InnerPiece, inner_pieces};
use super::mesh_shape::MeshShape;
use super::pieces::{Pieces, PiecesRef, pieces};
use super::scenery::{HalfSpace, Scenery};
use super::triangle::Triangle;
use crate::math::{Pose, Vec3};
use crate::robot::{Geometry, TriangleMesh};

/// A shape in its own frame.
#[derive(Debug, Clone)]
pub struct Shape {
    /// What it is.
    pub kind: ShapeKind,
    /// The least box around it.
    pub bounds: Aabb,
    /// Centre and radius \[m\] of a ball around it.
    pub ball: (Vec3, f64),
    /// Balls in it.
    pub inner: InnerBalls,
    /// Of a mesh; made when they are first needed.
    pieces: OnceLock<Arc<Pieces>>,
    inner_pieces: OnceLock<Arc<[InnerPiece]>>,
}

/// The kinds that pairs are made of.
#[derive(Debug, Clone)]
pub enum ShapeKind {
    /// A convex solid.
    Convex(ConvexSolid),
    /// Triangles.
    Mesh(MeshShape),
    /// What only obstacles have.
    Scenery(Scenery),
}

/// A convex solid.
#[derive(Debug, Clone)]
pub struct ConvexSolid {
    /// Its support function.
    pub shape: ConvexShape,
    /// Unit outward normals and offsets of a hull's faces: `normal . x <= offset` inside.
    planes: Vec<(Vec3, f64)>,
}

/// How far, relative to its size, a vertex may stand out of a face of a mesh that is still taken for its convex hull.
const CONVEX_TOLERANCE: f64 = 1e-12;
/// Meshes of more vertices are not asked whether they are convex: every face would be compared with every vertex, and where a support
/// function walks over so many vertices a tree of triangles is as fast.
const MOST_HULL_VERTICES: usize = 2048;

impl Shape {
    /// Prepares `geometry`; `None` for a mesh without triangles, and for a cloud or grid that holds
    /// nothing.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        if geometry.is_scenery() {
            let (scenery, bounds, ball) = Scenery::new(geometry)?;
            return Some(Self::without_inner_balls(ShapeKind::Scenery(scenery), bounds, ball));
        }
        let solid = |core, radius| {
            let shape = ConvexShape { core, radius };
            ShapeKind::Convex(ConvexSolid { shape, planes: Vec::new() })
        };
        let (radius, reach) = match *geometry {
            Geometry::Mesh(ref mesh) | Geometry::ConvexHull(ref mesh) => {
                return (!mesh.triangles.is_empty()).then(|| Self::from_mesh(mesh, geometry));
            }
            Geometry::Sphere { radius } => (radius, Vec3::repeat(radius)),
            Geometry::Box { half_extents } => (half_extents.norm(), half_extents),
            Geometry::Cylinder { radius, half_length } => {
                (radius.hypot(half_length), Vec3::new(radius, radius, half_length))
            }
            Geometry::Capsule { radius, half_length } => {
                (radius + half_length, Vec3::new(radius, radius, radius + half_length))
            }
            _ => unreachable!("scenery is prepared above"),
        };
        let kind = match *geometry {
            Geometry::Sphere { radius } => solid(ConvexCore::Point, radius),
            Geometry::Box { half_extents } => solid(ConvexCore::Box { half_extents }, 0.0),
            Geometry::Cylinder { radius, half_length } => solid(ConvexCore::Cylinder { radius, half_length }, 0.0),
            Geometry::Capsule { radius, half_length } => solid(ConvexCore::Segment { half_length }, radius),
            _ => unreachable!("returned above"),
        };
        let bounds = Aabb::between(&-reach, &reach);
        Some(Self::prepared(kind, bounds, (Vec3::zeros(), radius * (1.0 + 1e-12))))
    }

    fn from_mesh(mesh: &TriangleMesh, geometry: &Geometry) -> Self {
        let shape = MeshShape::new(mesh);
        let (bounds, ball) = (Aabb::around(shape.vertices.iter()), bounding_ball(&shape.vertices));
        let kind = if matches!(geometry, Geometry::ConvexHull(_)) || is_convex(&shape, bounds.half.max()) {
            ShapeKind::Convex(hull(shape))
        } else {
            ShapeKind::Mesh(shape)
        };
        Self::prepared(kind, bounds, ball)
    }

    fn prepared(kind: ShapeKind, bounds: Aabb, ball: (Vec3, f64)) -> Self {
        let mut shape = Self::without_inner_balls(kind, bounds, ball);
        shape.inner = InnerBalls::of(&shape);
        shape
    }

    /// A shape whose overlaps are decided without balls in it.
    pub fn without_inner_balls(kind: ShapeKind, bounds: Aabb, ball: (Vec3, f64)) -> Self {
        Self {
            kind,
            bounds,
            ball,
            inner: InnerBalls::default(),
            pieces: OnceLock::new(),
            inner_pieces: OnceLock::new(),
        }
    }

    /// [`Shape::pieces`], unless they would first have to be made.
    pub fn known_pieces(&self) -> Option<PiecesRef<'_>> {
        match &self.kind {
            ShapeKind::Convex(_) => Some(self.into()),
            ShapeKind::Mesh(_) => self.pieces.get().map(|pieces| pieces.all()),
            ShapeKind::Scenery(_) => None,
        }
    }

    /// Convex shapes in the same frame whose union holds it: itself, or those of [`pieces`]; none
    /// of scenery, which is asked for its elements.
    pub fn pieces(&self) -> PiecesRef<'_> {
        match &self.kind {
            ShapeKind::Convex(_) => self.into(),
            ShapeKind::Mesh(mesh) => {
                // Made outside of the lock: it is shared work, and a thread that waits for its parts may come to ask for the same pieces.
                let made = self.pieces.get().is_none().then(|| Arc::new(pieces(mesh, &self.bounds)));
                self.pieces.get_or_init(|| made.unwrap_or_default()).all()
            }
            ShapeKind::Scenery(_) => PiecesRef { shapes: &[], boxes: &[] },
        }
    }

    /// Of a mesh, convex pieces inside it; made when they are first asked for.
    pub fn inner_pieces(&self) -> &[InnerPiece] {
        let ShapeKind::Mesh(mesh) = &self.kind else { return &[] };
        self.inner_pieces.get_or_init(|| inner_pieces(mesh, &self.bounds).into())
    }

    /// The half-space that it is, if it is one.
    pub fn half_space(&self) -> Option<&HalfSpace> {
        match &self.kind {
            ShapeKind::Scenery(Scenery::HalfSpace(half)) => Some(half),
            _ => None,
        }
    }

    /// Takes the pieces of a mesh over from where they were made before; not where it has some.
    pub fn set_pieces(&self, pieces: Pieces) {
        self.pieces.get_or_init(|| Arc::new(pieces));
    }

    /// Signed depth \[m\] of `point`: positive inside the solid, minus the distance outside.
    pub fn depth(&self, point: &Vec3, stack: &mut Vec<(f64, u32)>) -> f64 {
        match &self.kind {
            ShapeKind::Convex(solid) => solid.depth(point),
            ShapeKind::Mesh(mesh) => mesh.depth_above(point, f64::NEG_INFINITY, stack).unwrap_or(0.0),
            ShapeKind::Scenery(scenery) => scenery.depth_above(point, f64::NEG_INFINITY, stack).unwrap_or(0.0),
        }
    }

    /// The same where it is above `least`, which may be told sooner.
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        match &self.kind {
            ShapeKind::Convex(solid) => Some(solid.depth(point)).filter(|depth| *depth > least),
            ShapeKind::Mesh(mesh) => mesh.depth_above(point, least, stack),
            ShapeKind::Scenery(scenery) => scenery.depth_above(point, least, stack),
        }
    }
}

impl ConvexSolid {
    /// A solid that is only asked for its support: depths of points in a hull need planes.
    pub fn without_planes(shape: ConvexShape) -> Self {
        Self { shape, planes: Vec::new() }
    }

    /// Unit outward normals and offsets of planes that a hull lies behind; none for other shapes.
    pub fn planes(&self) -> &[(Vec3, f64)] {
        &self.planes
    }

    /// Whether depths are known in closed form everywhere, without a loop.
    pub fn is_primitive(&self) -> bool {
        !matches!(self.shape.core, ConvexCore::Triangle(_) | ConvexCore::Hull(_) | ConvexCore::Prism { .. })
    }

    /// Signed depth \[m\] of `point`: positive inside, minus the distance outside. In closed form but for points outside a
    /// hull.
    pub fn depth(&self, point: &Vec3) -> f64 {
        let core = match &self.shape.core {
            ConvexCore::Point => -point.norm(),
            ConvexCore::Segment { half_length } => {
                -(point - Vec3::z() * point.z.clamp(-half_length, *half_length)).norm()
            }
            ConvexCore::Box { half_extents } => slab_depth(point.abs() - half_extents),
            ConvexCore::Cylinder { radius, half_length } => {
                slab_depth(Vec3::new(point.x.hypot(point.y) - radius, point.z.abs() - half_length, f64::NEG_INFINITY))
            }
            ConvexCore::Triangle(_) | ConvexCore::Hull(_) | ConvexCore::Prism { .. } => {
                let outside = self.planes.iter().map(|(n, offset)| n.dot(point) - offset).fold(f64::MIN, f64::max);
                if outside <= 0.0 { -outside } else { -self.distance_outside(point, outside) }
            }
        };
        core + self.shape.radius
    }

    /// Of a point in a core that has faces, the depth \[m\] below the nearest of them and its
    /// outward normal; `None` outside, and where faces are not known.
    pub fn nearest_face(&self, point: &Vec3) -> Option<(f64, Vec3)> {
        let along = |axis: usize| Vec3::ith(axis, 1.0f64.copysign(point[axis]));
        let (depth, normal) = match &self.shape.core {
            ConvexCore::Box { half_extents } => {
                let below = half_extents - point.abs();
                let axis = below.imin();
                (below[axis], along(axis))
            }
            ConvexCore::Cylinder { radius, half_length } => {
                let across = point.x.hypot(point.y);
                let (side, end) = (radius - across, half_length - point.z.abs());
                let out = if across > 0.0 { Vec3::new(point.x, point.y, 0.0) / across } else { Vec3::x() };
                if side < end { (side, out) } else { (end, along(2)) }
            }
            ConvexCore::Hull(_) => {
                let mut nearest = (f64::INFINITY, Vec3::zeros());
                for (normal, offset) in &self.planes {
                    let below = offset - normal.dot(point);
                    if below < 0.0 {
                        return None;
                    }
                    nearest = if below < nearest.0 { (below, *normal) } else { nearest };
                }
                nearest
            }
            _ => return None,
        };
        (0.0..f64::INFINITY).contains(&depth).then_some((depth, normal))
    }

    fn distance_outside(&self, point: &Vec3, at_least: f64) -> f64 {
        let ball = ConvexShape { core: ConvexCore::Point, radius: 0.0 };
        let identity = Pose::identity();
        gjk::separation(&ball, &Pose::translation(*point), &self.shape, &identity, f64::INFINITY)
            .map_or(at_least, |separation| separation.distance.max(at_least))
    }
}

/// Depth of a point in a product of intervals, from how far it is beyond each.
pub fn slab_depth(beyond: Vec3) -> f64 {
    let outside = beyond.sup(&Vec3::zeros()).norm();
    if outside > 0.0 { -outside } else { -beyond.max() }
}

fn is_convex(shape: &MeshShape, size: f64) -> bool {
    shape.closed == [true]
        && shape.vertices.len() <= MOST_HULL_VERTICES
        && all_triangles(shape).all(|t| shape.vertices.iter().all(|v| t.height(v) <= CONVEX_TOLERANCE * size))
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
    ConvexSolid { shape: ConvexShape { core, radius: 0.0 }, planes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::test_mesh::{bumpy, cuboid, placed};
    use rand::{RngExt, SeedableRng};

    fn depth(geometry: Geometry, x: f64, y: f64, z: f64) -> f64 {
        Shape::new(&geometry).unwrap().depth(&Vec3::new(x, y, z), &mut Vec::new())
    }

    #[test]
    fn depths_of_primitives_in_closed_form() {
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        close(depth(Geometry::Sphere { radius: 2.0 }, 0.0, 0.6, 0.8), 1.0);
        let block = Geometry::Box { half_extents: Vec3::new(1.0, 2.0, 3.0) };
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
            let expected = depth(Geometry::Box { half_extents: half }, p.x, p.y, p.z);
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

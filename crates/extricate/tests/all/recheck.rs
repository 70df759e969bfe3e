//! A second opinion on configurations: another library's distances over every checked pair, with
//! nothing remembered and nothing skipped. It is slow. It shares the scene's poses and shapes with
//! the checker, but no code that decides.

use extricate::Scene;
use extricate::geometry::{Geometry, Pose, TriangleMesh};
use extricate::internals::kinematics::forward;
use extricate::internals::math::Vec3;
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query::{self, ClosestPoints};
use parry3d_f64::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, Cylinder, Shape, TriMesh};

/// Shapes of all bodies of a scene, as the other library represents them.
pub struct Recheck<'a> {
    scene: &'a Scene,
    bodies: Vec<Vec<Part>>,
}

struct Part {
    pose_frame_shape: Pose,
    shape: Box<dyn Shape>,
    /// Ball around the shape, in its own coordinates: centre and radius \[m\].
    ball: (Vec3, f64),
    /// Whether the shape is a mesh, whose surface does not show what is inside of it.
    is_mesh: bool,
}

/// Slack for rounding and for the other library's own tolerances \[m\].
pub const SLACK: f64 = 2e-6;

impl<'a> Recheck<'a> {
    /// Prepares the shapes of every body.
    pub fn new(scene: &'a Scene) -> Self {
        let bodies = scene.bodies().iter().map(|body| {
            let part = |part: &extricate::internals::scene::Part| {
                // Cylinders of the other library stand along y.
                let upright = Pose::from_xyz_rpy([0.0; 3], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
                let is_cylinder = matches!(part.geometry, Geometry::Cylinder { .. });
                let pose = if is_cylinder { part.pose_frame_part.then(&upright) } else { part.pose_frame_part };
                let shape = shape(&part.geometry);
                let sphere = shape.compute_local_bounding_sphere();
                let center = sphere.center();
                Part {
                    pose_frame_shape: pose,
                    ball: (Vec3::new(center.x, center.y, center.z), sphere.radius()),
                    is_mesh: matches!(part.geometry, Geometry::Mesh(_)),
                    shape,
                }
            };
            body.parts.iter().map(part).collect()
        });
        Self { scene, bodies: bodies.collect() }
    }

    /// Returns the distance \[m\] of every checked pair, 0 if it overlaps; distances above `far`
    /// count as `far`. Meshes count as surfaces.
    pub fn distances(&self, q: &[f64], far: f64) -> Vec<f64> {
        let mut poses = Vec::new();
        forward(self.scene, q, &mut poses);
        (0..self.scene.pairs().len()).map(|pair| self.distance(pair, &poses, far)).collect()
    }

    fn distance(&self, pair: usize, poses: &[Pose], far: f64) -> f64 {
        let pair = &self.scene.pairs()[pair];
        let placed = |body: usize| {
            let pose = poses[self.scene.bodies()[body].frame];
            self.bodies[body].iter().map(move |part| (pose.then(&part.pose_frame_shape), part))
        };
        let mut least = far;
        for (a, first) in placed(pair.first) {
            for (b, second) in placed(pair.second) {
                let centers = (a.point(&first.ball.0) - b.point(&second.ball.0)).norm();
                if centers - first.ball.1 - second.ball.1 >= least {
                    continue;
                }
                // With a limit the library skips what is farther; a distance without one would
                // measure everything.
                let found = query::closest_points(&moved(&a), &*first.shape, &moved(&b), &*second.shape, least);
                least = match found.expect("these shapes have closest points") {
                    ClosestPoints::Intersecting => 0.0,
                    ClosestPoints::WithinMargin(one, other) => least.min((one - other).length()),
                    ClosestPoints::Disjoint => least,
                };
            }
        }
        least
    }

    /// Returns whether a mesh is among the bodies of a pair: one may contain the other without
    /// touching surfaces.
    pub fn has_mesh(&self, pair: usize) -> bool {
        let pair = &self.scene.pairs()[pair];
        [pair.first, pair.second].iter().any(|&body| self.bodies[body].iter().any(|part| part.is_mesh))
    }

    /// Returns whether the other library agrees that `q` is free. Distances above the clearance
    /// count as equal: they decide nothing, and balls around the shapes rule most of them out.
    pub fn agrees_free(&self, q: &[f64]) -> bool {
        let far = self.scene.clearance() + 2.0 * SLACK;
        self.distances(q, far).iter().all(|distance| *distance >= self.scene.clearance() - SLACK)
    }
}

fn shape(geometry: &Geometry) -> Box<dyn Shape> {
    let points = |mesh: &TriangleMesh| mesh.vertices.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect::<Vec<_>>();
    match geometry {
        Geometry::Sphere { radius } => Box::new(Ball::new(*radius)),
        Geometry::Box { half_extents: h } => Box::new(Cuboid::new(Vector::new(h[0], h[1], h[2]))),
        Geometry::Cylinder { radius, half_length } => Box::new(Cylinder::new(*half_length, *radius)),
        Geometry::Capsule { radius, half_length } => Box::new(Capsule::new_z(*half_length, *radius)),
        Geometry::Mesh(mesh) => Box::new(TriMesh::new(points(mesh), mesh.triangles.clone()).expect("a mesh")),
        Geometry::ConvexHull(mesh) => {
            // If the library's convexity test rejects a hull because of rounding, the surface
            // decides as well for free configurations.
            match ConvexPolyhedron::from_convex_mesh(points(mesh), &mesh.triangles) {
                Some(hull) => Box::new(hull),
                None => Box::new(TriMesh::new(points(mesh), mesh.triangles.clone()).expect("a hull")),
            }
        }
        _ => panic!("no judged scene has scenery"),
    }
}

fn moved(pose: &Pose) -> ParryPose {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.rotation);
    let q = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
    let t = pose.translation;
    ParryPose::from_parts(Vector::new(t.x, t.y, t.z), Rotation::from_xyzw(q.i, q.j, q.k, q.w))
}

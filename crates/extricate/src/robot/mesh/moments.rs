//! Volume and area moments of shapes: closed forms for primitives, exact sums over triangles for
//! meshes.

use std::f64::consts::PI;

use crate::math::{Mat3, Pose, Vec3};
use crate::robot::{Geometry, TriangleMesh};

/// Segments of the tessellation that stands for a primitive's surface; its area is 0.2 % too small.
const SURFACE_SEGMENTS: usize = 64;

/// Size, centre and spread of a uniform solid or surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Volume [m^3] or area [m^2].
    pub measure: f64,
    /// Centre of the solid or surface \[m\].
    pub centroid: Vec3,
    /// Mean of `(x - centroid)(x - centroid)'` [m^2].
    pub second_moment: Mat3,
}

/// Integrals from which [`Moments`] are made: of 1, `x - origin` and `(x - origin)(x - origin)'`.
struct Sums {
    origin: Vec3,
    measure: f64,
    first: Vec3,
    second: Mat3,
}

impl Sums {
    fn new(origin: Vec3) -> Self {
        Self { origin, measure: 0.0, first: Vec3::zeros(), second: Mat3::zeros() }
    }

    /// Adds a simplex of this measure: a triangle by its three corners, a tetrahedron by three
    /// corners and the origin.
    ///
    /// Barycentric coordinates have mean `1/n` and mean products `(1 + [i = j]) / (n (n + 1))` for
    /// `n` corners.
    fn add_simplex(&mut self, measure: f64, corners: &[Vec3; 3], n: f64) {
        let sum = corners[0] + corners[1] + corners[2];
        let squares: Mat3 = corners.iter().map(|c| c * c.transpose()).sum();
        self.measure += measure;
        self.first += sum * (measure / n);
        self.second += (squares + sum * sum.transpose()) * (measure / (n * (n + 1.0)));
    }

    fn moments(&self) -> Option<Moments> {
        if self.measure.is_nan() || self.measure <= 0.0 {
            return None;
        }
        let mean = self.first / self.measure;
        let second_moment = self.second / self.measure - mean * mean.transpose();
        Some(Moments { measure: self.measure, centroid: self.origin + mean, second_moment })
    }
}

impl Moments {
    /// The moments of the shape moved by `pose`.
    pub fn transformed(&self, pose: &Pose) -> Moments {
        Moments {
            measure: self.measure,
            centroid: pose.point(&self.centroid),
            second_moment: pose.rotation * self.second_moment * pose.rotation.transpose(),
        }
    }

    /// Combines the moments of parts in one frame; `None` if they measure nothing. A volume that
    /// several parts cover counts for each of them.
    pub fn combine(parts: impl IntoIterator<Item = Moments>) -> Option<Moments> {
        let mut parts = parts.into_iter().peekable();
        let mut sums = Sums::new(parts.peek()?.centroid);
        for part in parts {
            let offset = part.centroid - sums.origin;
            sums.measure += part.measure;
            sums.first += offset * part.measure;
            sums.second += (part.second_moment + offset * offset.transpose()) * part.measure;
        }
        sums.moments()
    }
}

impl Geometry {
    /// Moments of the solid; `None` if it has no volume, and for a mesh with an open component or
    /// whose triangles contradict each other. Overlaps of components count for each of them.
    #[doc(hidden)]
    pub fn volume_moments(&self) -> Option<Moments> {
        match *self {
            Geometry::Sphere { radius } => solid(4.0 / 3.0 * PI * radius.powi(3), Vec3::repeat(radius * radius / 5.0)),
            Geometry::Box { half_extents: [x, y, z] } => solid(8.0 * x * y * z, Vec3::new(x * x, y * y, z * z) / 3.0),
            Geometry::Cylinder { radius, half_length } => cylinder(radius, half_length),
            Geometry::Capsule { radius, half_length } => {
                let ball = 4.0 / 3.0 * PI * radius.powi(3);
                // A half ball about the centre of its flat side: mean height 3/8 r, mean square
                // r^2/5 along each axis.
                let square = radius * radius / 5.0;
                let along = square + 0.75 * radius * half_length + half_length * half_length;
                Moments::combine(
                    cylinder(radius, half_length).into_iter().chain(solid(ball, Vec3::new(square, square, along))),
                )
            }
            Geometry::Mesh(ref mesh) | Geometry::ConvexHull(ref mesh) => mesh_volume(mesh),
            // Only moving bodies need moments, and these shapes do not move.
            _ => None,
        }
    }

    /// Moments of the surface: exact for meshes, from a tessellation for primitives. A surface
    /// without area has measure 0 and no spread, at its first vertex.
    #[doc(hidden)]
    pub fn area_moments(&self) -> Moments {
        let mesh = self.tessellate(SURFACE_SEGMENTS);
        let origin = mesh.vertices.first().copied().unwrap_or_default();
        let mut sums = Sums::new(origin);
        for t in 0..mesh.triangles.len() {
            let corners = mesh.corners(t).map(|corner| corner - origin);
            let area = 0.5 * (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
            sums.add_simplex(area, &corners, 3.0);
        }
        sums.moments().unwrap_or(Moments { measure: 0.0, centroid: origin, second_moment: Mat3::zeros() })
    }
}

/// Moments of a solid about the origin, with its axes of symmetry along the frame's.
fn solid(measure: f64, squares: Vec3) -> Option<Moments> {
    let second_moment = Mat3::from_diagonal(&squares);
    (measure > 0.0).then_some(Moments { measure, centroid: Vec3::zeros(), second_moment })
}

fn cylinder(radius: f64, half_length: f64) -> Option<Moments> {
    let across = radius * radius / 4.0;
    solid(2.0 * PI * radius * radius * half_length, Vec3::new(across, across, half_length * half_length / 3.0))
}

fn mesh_volume(mesh: &TriangleMesh) -> Option<Moments> {
    let origin = *mesh.vertices.first()?;
    let mut sums = Sums::new(origin);
    for component in &mesh.components {
        if !component.closed {
            return None;
        }
        let mut area_vector = Vec3::zeros();
        let mut area = 0.0;
        for t in component.triangles.clone() {
            let corners = mesh.corners(t).map(|corner| corner - origin);
            let cross = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            area_vector += cross;
            area += cross.norm();
            sums.add_simplex(corners[0].cross(&corners[1]).dot(&corners[2]) / 6.0, &corners, 4.0);
        }
        // If all faces face outward, their area vectors cancel; otherwise the sums mean nothing.
        if area_vector.norm() > 1e-6 * area {
            return None;
        }
    }
    sums.moments()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    const SHAPES: [Geometry; 4] = [
        Geometry::Sphere { radius: 0.4 },
        Geometry::Box { half_extents: [0.1, 0.2, 0.3] },
        Geometry::Cylinder { radius: 0.2, half_length: 0.5 },
        Geometry::Capsule { radius: 0.2, half_length: 0.3 },
    ];

    fn assert_near(a: &Moments, b: &Moments, tolerance: f64) {
        assert!((a.measure / b.measure - 1.0).abs() < tolerance, "{a:?} {b:?}");
        assert!((a.centroid - b.centroid).norm() < tolerance, "{a:?} {b:?}");
        assert!((a.second_moment - b.second_moment).norm() < tolerance, "{a:?} {b:?}");
    }

    fn inside(shape: &Geometry, p: &Vec3) -> bool {
        let across = p.x.hypot(p.y);
        match *shape {
            Geometry::Sphere { radius } => p.norm() < radius,
            Geometry::Box { half_extents } => (0..3).all(|k| p[k].abs() < half_extents[k]),
            Geometry::Cylinder { radius, half_length } => across < radius && p.z.abs() < half_length,
            Geometry::Capsule { radius, half_length } => across.hypot((p.z.abs() - half_length).max(0.0)) < radius,
            _ => unreachable!(),
        }
    }

    #[test]
    fn closed_forms_agree_with_monte_carlo() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for shape in &SHAPES {
            let half = 0.55;
            let total = 400_000;
            let mut sums = Sums::new(Vec3::zeros());
            for _ in 0..total {
                let p = Vec3::from_fn(|_, _| half * (2.0 * rng.random::<f64>() - 1.0));
                if inside(shape, &p) {
                    sums.measure += 1.0;
                    sums.first += p;
                    sums.second += p * p.transpose();
                }
            }
            let mut sampled = sums.moments().unwrap();
            sampled.measure *= (2.0 * half).powi(3) / total as f64;
            assert_near(&sampled, &shape.volume_moments().unwrap(), 0.02);
        }
    }

    #[test]
    fn meshes_agree_with_closed_forms() {
        let pose = Pose::from_xyz_rpy([3.0, -1.0, 2.0], [0.4, -1.2, 2.0]);
        for shape in &SHAPES {
            let mut mesh = shape.tessellate(256);
            mesh.vertices.iter_mut().for_each(|v| *v = pose.point(v));
            let expected = shape.volume_moments().unwrap().transformed(&pose);
            let found = Geometry::Mesh(Arc::new(mesh)).volume_moments().unwrap();
            assert_near(&found, &expected, 1e-3);
            if let Geometry::Box { .. } = shape {
                assert_near(&found, &expected, 1e-12);
            }
        }
    }

    #[test]
    fn surfaces_agree_with_closed_forms() {
        let sphere = SHAPES[0].area_moments();
        assert!((sphere.measure / (4.0 * PI * 0.16) - 1.0).abs() < 3e-3);
        assert!((sphere.second_moment - Mat3::identity() * (0.16 / 3.0)).norm() < 3e-4);
        let square = Geometry::Mesh(Arc::new(TriangleMesh::new(
            vec![Vec3::new(1., 0., 5.), Vec3::new(3., 0., 5.), Vec3::new(3., 2., 5.), Vec3::new(1., 2., 5.)],
            vec![[0, 1, 2], [0, 2, 3]],
        )));
        let third = 1.0 / 3.0;
        let second_moment = Mat3::from_diagonal(&Vec3::new(third, third, 0.0));
        let expected = Moments { measure: 4.0, centroid: Vec3::new(2., 1., 5.), second_moment };
        assert_near(&square.area_moments(), &expected, 1e-12);
        assert!(square.volume_moments().is_none());
        assert_eq!(Geometry::Sphere { radius: 0.0 }.area_moments().measure, 0.0);
        assert!(Geometry::Sphere { radius: 0.0 }.volume_moments().is_none());
    }

    #[test]
    fn parts_combine() {
        // Two half boxes make the box.
        let half = Geometry::Box { half_extents: [0.1, 0.2, 0.15] }.volume_moments().unwrap();
        let parts = [-0.15, 0.15].map(|z| half.transformed(&Pose::translation(Vec3::new(0.0, 0.0, z))));
        assert_near(&Moments::combine(parts).unwrap(), &SHAPES[1].volume_moments().unwrap(), 1e-12);
        assert!(Moments::combine([]).is_none());
        let far = Pose::translation(Vec3::repeat(1e3));
        let moved = Moments::combine(parts.map(|part| part.transformed(&far))).unwrap();
        assert!((moved.second_moment - SHAPES[1].volume_moments().unwrap().second_moment).norm() < 1e-9);
    }
}

//! Triangles for primitives: closed, outward, with vertices on the true surface.

use std::f64::consts::{PI, TAU};

use crate::math::Vec3;
use crate::robot::{Geometry, TriangleMesh};

impl Geometry {
    /// Returns a mesh of the shape. A primitive gets an inscribed one with `segments` (at least 3)
    /// sides around z, and half as many bands from pole to pole.
    ///
    /// If a primitive has no extent, the mesh is empty or flat.
    pub fn tessellate(&self, segments: usize) -> TriangleMesh {
        let segments = segments.max(3);
        match *self {
            Geometry::Box { half_extents } => cuboid(half_extents.into()),
            Geometry::Cylinder { radius, half_length } => {
                let ring = [(0.0, half_length), (radius, half_length), (radius, -half_length), (0.0, -half_length)];
                revolved(&ring, segments)
            }
            Geometry::Sphere { radius } => ball_profile(radius, 0.0, segments),
            Geometry::Capsule { radius, half_length } => ball_profile(radius, half_length, segments),
            Geometry::Mesh(ref mesh) | Geometry::ConvexHull(ref mesh) => TriangleMesh::clone(mesh),
            _ => self.scenery_triangles(segments),
        }
    }
}

fn cuboid(half: Vec3) -> TriangleMesh {
    let sign = |k: usize, bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let corners = (0..8).map(|k| half.component_mul(&Vec3::new(sign(k, 0), sign(k, 1), sign(k, 2)))).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    TriangleMesh::new(corners, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Meshes two half balls, `half_length` above and below the origin, and the cylinder between them.
fn ball_profile(radius: f64, half_length: f64, segments: usize) -> TriangleMesh {
    let bands = segments.div_ceil(4).max(2);
    let mut profile = Vec::with_capacity(2 * bands + 2);
    for (end, first) in [(half_length, 0), (-half_length, bands)] {
        for k in first..=first + bands {
            let angle = PI * k as f64 / (2 * bands) as f64;
            profile.push((radius * angle.sin(), end + radius * angle.cos()));
        }
    }
    // Both ends are poles; the sine of pi is not quite 0.
    let last = profile.len() - 1;
    profile[last].0 = 0.0;
    if half_length == 0.0 {
        profile.remove(bands);
    }
    revolved(&profile, segments)
}

/// Revolves a profile of (distance from z, height), from the upper pole to the lower one, around z.
fn revolved(profile: &[(f64, f64)], segments: usize) -> TriangleMesh {
    let mut vertices = vec![Vec3::new(0.0, 0.0, profile[0].1)];
    for &(distance, height) in &profile[1..profile.len() - 1] {
        for k in 0..segments {
            let (sin, cos) = (TAU * k as f64 / segments as f64).sin_cos();
            vertices.push(Vec3::new(distance * cos, distance * sin, height));
        }
    }
    vertices.push(Vec3::new(0.0, 0.0, profile[profile.len() - 1].1));
    let rings = profile.len() - 2;
    let at = |ring: usize, k: usize| (1 + ring * segments + k % segments) as u32;
    let last = vertices.len() as u32 - 1;
    let mut triangles = Vec::with_capacity(2 * rings * segments);
    for k in 0..segments {
        triangles.push([0, at(0, k), at(0, k + 1)]);
        for ring in 1..rings {
            let [a, b] = [at(ring - 1, k), at(ring - 1, k + 1)];
            let [c, d] = [at(ring, k), at(ring, k + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
        triangles.push([last, at(rings - 1, k + 1), at(rings - 1, k)]);
    }
    TriangleMesh::new(vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primitives_become_closed_outward_meshes_on_their_surface() {
        for shape in [
            Geometry::Sphere { radius: 0.4 },
            Geometry::Box { half_extents: [0.1, 0.2, 0.3] },
            Geometry::Cylinder { radius: 0.2, half_length: 0.5 },
            Geometry::Capsule { radius: 0.2, half_length: 0.3 },
        ] {
            for segments in [0, 3, 4, 7, 32] {
                let mesh = shape.tessellate(segments);
                assert!(mesh.is_closed() && mesh.components.len() == 1, "{shape:?} {segments}");
                assert_eq!(mesh.triangles.len(), 2 * mesh.vertices.len() - 4, "{shape:?} {segments}");
                let centre = mesh.vertices.iter().sum::<Vec3>() / mesh.vertices.len() as f64;
                for t in 0..mesh.triangles.len() {
                    let [a, b, c] = mesh.corners(t);
                    assert!((b - a).cross(&(c - a)).dot(&(a - centre)) > 0.0);
                }
                for v in &mesh.vertices {
                    let distance = match shape {
                        Geometry::Sphere { radius } => v.norm() - radius,
                        Geometry::Capsule { radius, half_length } => {
                            v.x.hypot(v.y).hypot((v.z.abs() - half_length).max(0.0)) - radius
                        }
                        Geometry::Cylinder { half_length, .. } => v.z.abs() - half_length,
                        _ => 0.0,
                    };
                    assert!(distance.abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn shapes_without_extent_do_no_harm() {
        assert!(Geometry::Sphere { radius: 0.0 }.tessellate(8).triangles.is_empty());
        assert!(!Geometry::Box { half_extents: [1.0, 1.0, 0.0] }.tessellate(8).triangles.is_empty());
    }
}

//! Checks deserialised shapes against what robot and scene files can describe. Faults are reported,
//! not repaired.

use super::mesh::cavities::face_inward;
use super::mesh::edges::all_edges_even;
use super::{Geometry, TriangleMesh};
use crate::math::FARTHEST;

impl Geometry {
    /// Checks that sizes are positive and within 1e9 m, that indices exist, and that components are
    /// as closed and oriented as they claim.
    ///
    /// # Errors
    /// The element, the value, and what was expected.
    pub(crate) fn check(&self) -> Result<(), String> {
        let sizes = |sizes: &[f64]| match sizes.iter().find(|size| !(**size > 0.0 && **size <= FARTHEST)) {
            Some(bad) => Err(format!("got {bad:?}, expected sizes > 0 and within 1e9 [m]")),
            None => Ok(()),
        };
        match self {
            Self::Sphere { radius } => sizes(&[*radius]),
            Self::Box { half_extents } => sizes(half_extents.as_slice()),
            Self::Cylinder { radius, half_length } | Self::Capsule { radius, half_length } => {
                sizes(&[*radius, *half_length])
            }
            Self::Mesh(mesh) | Self::ConvexHull(mesh) => mesh.check(),
            Self::Voxels(_) | Self::Points(_) | Self::HalfSpace { .. } | Self::HeightField(_) => {
                self.check_scenery().map_err(|error| error.to_string())
            }
        }
    }
}

impl TriangleMesh {
    fn check(&self) -> Result<(), String> {
        if let Some(index) = self.vertices.iter().position(|v| !v.iter().all(|x| x.abs() <= FARTHEST)) {
            let found = self.vertices[index].as_slice();
            return Err(format!("vertex {index}: got {found:?}, expected finite coordinates [m] within 1e9"));
        }
        let count = self.vertices.len();
        let is_one =
            |t: &[u32; 3]| t.iter().all(|k| (*k as usize) < count) && t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        if let Some(index) = self.triangles.iter().position(|t| !is_one(t)) {
            let found = self.triangles[index];
            return Err(format!("triangle {index}: got {found:?}, expected three indices below {count}"));
        }
        let mut end = 0;
        for (number, component) in self.components.iter().enumerate() {
            let range = component.triangles.clone();
            if range.start != end || range.end <= end || range.end > self.triangles.len() {
                let all = self.triangles.len();
                return Err(format!(
                    "component {number}: got the triangles {range:?}, expected some from {end} to {all}"
                ));
            }
            end = range.end;
            let triangles = &self.triangles[range];
            if component.closed && !all_edges_even(triangles) {
                return Err(format!("component {number}: got an open one that is said to be closed"));
            }
            if component.closed && !self.is_cavity(number) && face_inward(&self.vertices, triangles) {
                return Err(format!(
                    "component {number}: got a solid that faces inward, expected one that faces outward"
                ));
            }
        }
        if end == 0 || end != self.triangles.len() {
            let all = self.triangles.len();
            return Err(format!("got components of {end} triangles, expected all {all} of at least one"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::robot::{HeightField, PointCloud, Voxels};
    use std::sync::Arc;

    fn tetrahedron() -> TriangleMesh {
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(Vec3::from).to_vec();
        TriangleMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    #[test]
    fn meshes_that_contradict_themselves_are_refused() {
        type Spoil = fn(&mut TriangleMesh);
        let spoils: [(Spoil, &str); 11] = [
            (|_| (), ""),
            (|mesh| mesh.vertices[1].y = f64::INFINITY, "vertex 1: got [0.0, inf, 0.0]"),
            (|mesh| mesh.triangles[3][1] = 4, "triangle 3: got"),
            (|mesh| mesh.triangles[2][1] = mesh.triangles[2][0], "triangle 2: got"),
            (|mesh| mesh.triangles.truncate(3), "component 0: got the triangles 0..4"),
            (|mesh| mesh.components[0].triangles.end = 2, "component 0: got an open one"),
            (|mesh| mesh.components[0].triangles.start = 1, "component 0: got the triangles 1..4"),
            (|mesh| mesh.components[0].triangles = std::ops::Range { start: 3, end: 1 }, "component 0"),
            (|mesh| mesh.components.clear(), "got components of 0 triangles"),
            (|mesh| mesh.triangles.swap(0, 1), ""),
            (|mesh| mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1)), "component 0: got a solid that faces inward"),
        ];
        for (spoil, expected) in spoils {
            let mut mesh = tetrahedron();
            spoil(&mut mesh);
            for geometry in [Geometry::Mesh(Arc::new(mesh.clone())), Geometry::ConvexHull(Arc::new(mesh))] {
                let message = geometry.check().err().unwrap_or_default();
                assert!(message.contains(expected) && message.is_empty() == expected.is_empty(), "{message}");
            }
        }
    }

    #[test]
    fn sizes_are_positive() {
        let sound = [
            Geometry::Sphere { radius: 1.0 },
            Geometry::Voxels(Arc::new(Voxels::new("s", "v", 1.0, vec![[1, 2, 3]]).unwrap())),
            Geometry::Points(Arc::new(PointCloud::new("s", "p", 0.0, &[[0.0, 1.0, 0.0]]).unwrap())),
            Geometry::half_space("s", "h", [0.3, 0.5, 2.0], 1.0).unwrap(),
            Geometry::HeightField(Arc::new(HeightField::new("s", "f", 1.0, 2, vec![0.0; 4]).unwrap())),
        ];
        sound.iter().for_each(|geometry| assert_eq!(geometry.check(), Ok(())));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e10] {
            let wrong = [
                Geometry::Sphere { radius: bad },
                Geometry::Box { half_extents: [1.0, bad, 1.0] },
                Geometry::Cylinder { radius: 1.0, half_length: bad },
                Geometry::Capsule { radius: bad, half_length: 1.0 },
                Geometry::HalfSpace { normal: [0.3, 0.0, bad], offset: 0.0 },
            ];
            wrong.iter().for_each(|geometry| assert!(geometry.check().unwrap_err().contains("expected"), "{bad}"));
        }
    }
}

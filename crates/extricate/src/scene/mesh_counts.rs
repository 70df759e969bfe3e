//! Counts the triangles of the links of a scene and of their convex hulls, because checks take
//! longer with more triangles.

use super::assemble::bodies::OncePerMesh;
use super::{Part, Scene};
use crate::robot::Geometry;
use crate::robot::mesh::convex_hull::convex_hull;

/// Triangles of a link whose meshes are checked as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshCount {
    /// Index of the link among the bodies.
    pub body: usize,
    /// Number of triangles of its meshes.
    pub triangles: usize,
    /// Number of triangles of their convex hulls; a flat mesh has no hull and counts itself.
    pub hull_triangles: usize,
}

impl Scene {
    /// Counts the triangles of links whose meshes are checked as they are, largest count first.
    pub fn mesh_counts(&self) -> Vec<MeshCount> {
        let mut hulls = OncePerMesh::default();
        let mut count = |part: &Part| match &part.geometry {
            Geometry::Mesh(mesh) => {
                let own = mesh.triangles.len();
                let hull = |_: &Geometry| convex_hull(&mesh.vertices).map_or(own, |hull| hull.triangles.len());
                [own, hulls.of(&part.geometry, hull)]
            }
            _ => [0, 0],
        };
        let mut counts = Vec::new();
        for (body, link) in self.bodies.iter().enumerate().filter(|(_, body)| body.robot.is_some()) {
            let [triangles, hull_triangles] =
                link.parts.iter().map(&mut count).fold([0, 0], |all, part| [all[0] + part[0], all[1] + part[1]]);
            if triangles > 0 {
                counts.push(MeshCount { body, triangles, hull_triangles });
            }
        }
        counts.sort_by_key(|count| std::cmp::Reverse(count.triangles));
        counts
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::{Pose, Vec3};
    use crate::robot::TriangleMesh;
    use crate::scene::builtin;

    #[test]
    fn meshes_are_counted_and_so_are_their_hulls() {
        let mut scene = builtin::scene("planar-arm").unwrap();
        assert_eq!(scene.mesh_counts(), []);
        // `solid` is a tetrahedron with a dent.
        let (a, b, c, d) = (Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z());
        let dent = Vec3::new(0.1, 0.1, 0.1);
        let solid = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]];
        let solid = Arc::new(TriangleMesh::new(vec![a, b, c, d, dent], solid));
        let sheet = Arc::new(TriangleMesh::new(vec![a, b, c], vec![[0, 1, 2]]));
        let part = |geometry| Part { pose_frame_part: Pose::identity(), geometry };
        let links: Vec<usize> = (0..scene.bodies.len()).filter(|body| scene.bodies[*body].robot.is_some()).collect();
        scene.bodies[links[0]].parts = vec![part(Geometry::Mesh(sheet)), part(Geometry::Sphere { radius: 1.0 })];
        scene.bodies[links[1]].parts =
            vec![part(Geometry::Mesh(Arc::clone(&solid))), part(Geometry::Mesh(Arc::clone(&solid)))];
        let count = |body, triangles, hull_triangles| MeshCount { body, triangles, hull_triangles };
        assert_eq!(scene.mesh_counts(), [count(links[1], 12, 8), count(links[0], 1, 1)]);
        scene.bodies[links[1]].parts = vec![part(Geometry::ConvexHull(solid))];
        assert_eq!(scene.mesh_counts(), [count(links[0], 1, 1)]);
    }
}

//! A mesh prepared for checks: its tree, and which of its components bound a solid. One mesh, no pairs.

use super::bvh::{Bvh, Nearest, build};
use super::inside::is_inside;
use super::orient::outward;
use crate::math::Vec3;
use crate::robot::TriangleMesh;
use crate::robot::mesh::Component;

/// A mesh with its tree. Components without triangles are dropped; triangles of closed ones have outward normals.
#[derive(Debug, Clone)]
pub struct MeshShape {
    /// One group for each closed component, and one for all triangles of open ones.
    pub tree: Bvh,
    /// Whether each group is closed: a solid by itself, also within another one. Open ones are surfaces.
    pub closed: Vec<bool>,
    /// A vertex of each component.
    pub representatives: Vec<Vec3>,
    /// Every vertex that a triangle uses.
    pub vertices: Vec<Vec3>,
}

impl MeshShape {
    /// Prepares `mesh`, which must have a triangle.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let components = || mesh.components.iter().filter(|c| !c.triangles.is_empty());
        let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize]);
        let solid = |c: &Component| {
            outward(&mesh.triangles[c.triangles.clone()], &mesh.vertices).iter().map(corners).collect::<Vec<_>>()
        };
        let mut groups: Vec<Vec<[Vec3; 3]>> = components().filter(|c| c.closed).map(solid).collect();
        let mut closed = vec![true; groups.len()];
        let open = components().filter(|c| !c.closed);
        let surfaces: Vec<[Vec3; 3]> =
            open.flat_map(|c| mesh.triangles[c.triangles.clone()].iter().map(corners)).collect();
        if !surfaces.is_empty() {
            groups.push(surfaces);
            closed.push(false);
        }
        let mut used = vec![false; mesh.vertices.len()];
        mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        Self {
            tree: build(&groups),
            closed,
            representatives: components().map(|c| corners(&mesh.triangles[c.triangles.start])[0]).collect(),
            vertices: mesh.vertices.iter().zip(used).filter_map(|(v, used)| used.then_some(*v)).collect(),
        }
    }

    /// Whether `point` lies inside a closed component.
    pub fn holds(&self, point: &Vec3, stack: &mut Vec<(f64, u32)>) -> bool {
        self.tree.cuboid.may_hold(point)
            && (0..self.closed.len()).any(|c| self.closed[c] && is_inside(&self.tree, c, point, stack))
    }

    /// Depth \[m\] of `point` below the surface of the closed component that holds it deepest, and the nearest point of that
    /// surface; `None` where it is nowhere deeper than `floor` >= 0.
    pub fn depth_inside(&self, point: &Vec3, floor: f64, stack: &mut Vec<(f64, u32)>) -> Option<(f64, Vec3)> {
        let mut best = None;
        let mut floor_squared = floor * floor;
        for c in (0..self.closed.len()).filter(|c| self.closed[*c]) {
            let root = self.tree.groups[c].root;
            if !self.tree.bounds_of(root).may_hold(point) {
                continue;
            }
            let nearest = self.tree.closest_point(root, point, f64::INFINITY, floor_squared, stack);
            if let Some(Nearest { point: surface, squared, .. }) = nearest
                && squared > floor_squared
                && is_inside(&self.tree, c, point, stack)
            {
                (best, floor_squared) = (Some((squared.sqrt(), surface)), squared);
            }
        }
        best
    }

    /// Signed depth \[m\] of `point` in the union of the closed components: at least that in the deepest one; outside minus
    /// the distance to the nearest triangle. `None` where it is not above `least`.
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        if let Some((depth, _)) = self.depth_inside(point, least.max(0.0), stack) {
            return Some(depth);
        }
        if least >= 0.0 {
            return None;
        }
        let nearest = self.tree.closest_point(self.tree.root, point, least * least, 0.0, stack);
        nearest.map(|near| -near.squared.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::test_mesh::{cuboid, joined, opened};

    #[test]
    fn depth_is_that_of_the_deepest_component() {
        let big = cuboid(Vec3::zeros(), Vec3::new(1.0, 1.0, 1.0));
        let small = cuboid(Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.25, 0.25, 0.25));
        let lid = opened(cuboid(Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.5, 0.5, 0.5)), 2);
        let shape = MeshShape::new(&joined(&[big, small, lid]));
        let mut stack = Vec::new();
        let mut above = |x: f64, least: f64| shape.depth_above(&Vec3::new(x, 0.01, 0.02), least, &mut stack);
        let mut depth = |x: f64| above(x, f64::NEG_INFINITY).unwrap();
        assert!((depth(0.5) - 0.5).abs() < 1e-12, "a shell within the solid does not make it shallower");
        assert!((depth(0.1) - 0.9).abs() < 1e-12);
        assert!((depth(1.5) + 0.5).abs() < 1e-12);
        assert!((depth(3.0) + 0.48).abs() < 1e-12, "an open box holds nothing: {}", depth(3.0));
    }
}

//! A mesh prepared for checks: its tree, and which of its components bound a solid. One mesh, no pairs.

use super::bvh::Bvh;
use super::inside::is_inside;
use super::orient::outward;
use crate::math::Vec3;
use crate::robot::TriangleMesh;

/// A mesh with its tree. Components without triangles are dropped; triangles of closed ones have outward normals.
#[derive(Debug, Clone)]
pub struct MeshShape {
    /// One group a component.
    pub tree: Bvh,
    /// Whether each component is closed: a solid by itself, also within another one. Open ones are surfaces.
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
        let groups: Vec<Vec<[Vec3; 3]>> = components()
            .map(|c| {
                let triangles = &mesh.triangles[c.triangles.clone()];
                let turned = if c.closed { outward(triangles, &mesh.vertices) } else { triangles.to_vec() };
                turned.iter().map(corners).collect()
            })
            .collect();
        let mut used = vec![false; mesh.vertices.len()];
        mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        Self {
            tree: Bvh::new(&groups),
            closed: components().map(|c| c.closed).collect(),
            representatives: groups.iter().map(|g| g[0][0]).collect(),
            vertices: mesh.vertices.iter().zip(used).filter_map(|(v, used)| used.then_some(*v)).collect(),
        }
    }

    /// Whether triangle `index` of the tree belongs to a closed component.
    pub fn is_closed(&self, index: usize) -> bool {
        self.closed[self.tree.group_of[index] as usize]
    }

    /// Whether `point` lies inside a closed component.
    pub fn holds(&self, point: &Vec3, stack: &mut Vec<(f64, u32)>) -> bool {
        (0..self.closed.len()).any(|c| self.closed[c] && is_inside(&self.tree, c, point, stack))
    }

    /// Depth \[m\] of `point` below the surface of the closed component that holds it deepest, and the nearest point of that
    /// surface; `None` where it is nowhere deeper than `floor` >= 0.
    pub fn depth_inside(&self, point: &Vec3, floor: f64, stack: &mut Vec<(f64, u32)>) -> Option<(f64, Vec3)> {
        let mut best = None;
        let mut floor_squared = floor * floor;
        for c in (0..self.closed.len()).filter(|c| self.closed[*c]) {
            let root = self.tree.groups[c].0;
            if !self.tree.nodes[root as usize].bounds.contains(point) {
                continue;
            }
            let nearest = self.tree.closest_point(root, point, f64::INFINITY, floor_squared, stack);
            if let Some((surface, _, squared)) = nearest
                && squared > floor_squared
                && is_inside(&self.tree, c, point, stack)
            {
                (best, floor_squared) = (Some((squared.sqrt(), surface)), squared);
            }
        }
        best
    }

    /// Signed depth \[m\] of `point` in the union of the closed components: at least that in the deepest one; outside minus
    /// the distance to the nearest triangle.
    pub fn depth(&self, point: &Vec3, stack: &mut Vec<(f64, u32)>) -> f64 {
        match self.depth_inside(point, 0.0, stack) {
            Some((depth, _)) => depth,
            None => self.tree.closest_point(0, point, f64::INFINITY, 0.0, stack).map_or(0.0, |(_, _, d)| -d.sqrt()),
        }
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
        let mut depth = |x: f64| shape.depth(&Vec3::new(x, 0.01, 0.02), &mut stack);
        assert!((depth(0.5) - 0.5).abs() < 1e-12, "a shell within the solid does not make it shallower");
        assert!((depth(0.1) - 0.9).abs() < 1e-12);
        assert!((depth(1.5) + 0.5).abs() < 1e-12);
        assert!((depth(3.0) + 0.48).abs() < 1e-12, "an open box holds nothing: {}", depth(3.0));
    }
}

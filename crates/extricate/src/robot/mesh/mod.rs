//! Triangle meshes: the type, its construction and its scaling. File formats are in `formats`.

pub mod cavities;
pub mod components;
pub mod convex_hull;
pub(crate) mod edges;
pub mod moments;
pub mod openings;
mod part;
mod partition;
pub mod polygon;
pub mod seams;
pub mod tessellation;
mod walls;
pub mod weld;

use serde::{Deserialize, Serialize};

use crate::math::Vec3;
use components::Mending;
pub use part::Component;

/// Welded triangles, sorted into connected components.
///
/// ```
/// use extricate::geometry::TriangleMesh;
/// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
/// let mesh = TriangleMesh::from_arrays(&corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
/// assert!(mesh.is_closed());
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Corners of the triangles \[m\], without repeats.
    #[doc(hidden)]
    pub vertices: Vec<Vec3>,
    /// Indices into `vertices`; triangles of one component are contiguous, in the order of
    /// `components`.
    pub triangles: Vec<[u32; 3]>,
    /// Connected components: triangles that share edges. Closed ones face outward, but a cavity
    /// faces inward and follows the solid that it is in.
    pub components: Vec<Component>,
}

/// Compares addresses first: equal shapes share a mesh, so most comparisons are of one with itself.
impl PartialEq for TriangleMesh {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
            || self.vertices == other.vertices
                && self.triangles == other.triangles
                && self.components == other.components
    }
}

impl TriangleMesh {
    /// Welds vertices nearer than 1e-9 of the bounding box's diagonal, and drops repeated triangles
    /// and those without area (slivers stay). Sorts the rest into components, in the order of
    /// `triangles` (if some are open, closed ones come first).
    ///
    /// Corners of open edges are welded at the precision of `f32` too, if that closes a component.
    ///
    /// # Guarantee
    /// The same input gives the same mesh. A closed component faces outward (positive volume) if
    /// its triangles can be oriented at all; open ones keep their winding.
    ///
    /// A closed component within another one is a cavity, which faces inward (negative volume), if
    /// three conditions hold. It was wound to face the other way than the outermost one around it;
    /// that one does not contradict itself; and winding numbers say that what it encloses is
    /// outside.
    ///
    /// Triangles that edges of two triangles connect stay closed if they are closed by themselves,
    /// whatever touches them. Triangles inside a solid that meet its surface along edges of three
    /// triangles or more are left out. A triangle whose corners lie exactly on a line counts as a
    /// bridge when closedness is decided, and is dropped then.
    ///
    /// # Panics
    /// If an index is not one of a vertex.
    pub fn from_arrays(vertices: &[[f64; 3]], triangles: Vec<[u32; 3]>) -> TriangleMesh {
        Self::new(vertices.iter().copied().map(Vec3::from).collect(), triangles)
    }

    /// As [`TriangleMesh::from_arrays`], from vectors.
    #[doc(hidden)]
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
        Self::mended(vertices, triangles).0
    }

    /// As [`TriangleMesh::new`], but also returns what was mended.
    pub(crate) fn mended(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> (TriangleMesh, Mending) {
        let mut used = vec![u32::MAX; vertices.len()];
        let mut points = Vec::with_capacity(vertices.len());
        for &index in triangles.as_flattened() {
            let slot = &mut used[index as usize];
            if *slot == u32::MAX {
                *slot = points.len() as u32;
                points.push(vertices[index as usize]);
            }
        }
        let (points, welded) = weld::weld(&points);
        let triangles = triangles
            .iter()
            .map(|t| t.map(|index| welded[used[index as usize] as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let (triangles, components, mending) = components::components(&points, triangles);
        (Self { vertices: points, triangles, components }.without_unused_vertices(), mending)
    }

    /// Scales the axes about the origin by factors that [`is_scale`] accepts. A mirroring scale
    /// reverses the windings, so outward stays outward.
    pub fn scaled(&self, scale: [f64; 3]) -> TriangleMesh {
        let mut mesh = self.clone();
        mesh.vertices.iter_mut().for_each(|v| v.component_mul_assign(&Vec3::from(scale)));
        if scale.iter().product::<f64>() < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        mesh
    }

    /// The distinct points \[m\].
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = [f64; 3]> + '_ {
        self.vertices.iter().map(|vertex| (*vertex).into())
    }

    /// Whether there are triangles and every component is closed.
    pub fn is_closed(&self) -> bool {
        !self.components.is_empty() && self.components.iter().all(|c| c.closed)
    }

    /// Whether a component is a cavity of the closed one before it: closed, and facing inward.
    pub fn is_cavity(&self, component: usize) -> bool {
        let Component { triangles, closed } = &self.components[component];
        let after_solid = self.components[..component].last().is_some_and(|before| before.closed);
        *closed && after_solid && cavities::face_inward(&self.vertices, &self.triangles[triangles.clone()])
    }

    /// The corners of a triangle \[m\].
    #[doc(hidden)]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|index| self.vertices[index as usize])
    }

    fn without_unused_vertices(mut self) -> Self {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        self.triangles.as_flattened().iter().for_each(|&index| new_index[index as usize] = 0);
        for (slot, index) in new_index.iter_mut().filter(|slot| **slot == 0).zip(0..) {
            *slot = index;
        }
        self.triangles.as_flattened_mut().iter_mut().for_each(|index| *index = new_index[*index as usize]);
        let mut index = 0;
        self.vertices.retain(|_| {
            index += 1;
            new_index[index - 1] != u32::MAX
        });
        self
    }
}

/// Whether a mesh can be scaled by these factors: others collapse it to a point or overflow.
pub fn is_scale(scale: &[f64; 3]) -> bool {
    scale.iter().all(|x| (1e-9..=1e9).contains(&x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soup_becomes_a_mesh() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(Vec3::from);
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut soup: Vec<Vec3> = faces.as_flattened().iter().map(|&k: &usize| corners[k]).collect();
        soup[4].x += 1e-10;
        soup.push(Vec3::repeat(1e9));
        let triangles = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mesh = TriangleMesh::new(soup, triangles);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4));
        assert!(mesh.is_closed());
        assert!(!TriangleMesh::new(vec![], vec![]).is_closed());
    }

    #[test]
    fn mirroring_keeps_faces_outward() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(Vec3::from).to_vec();
        let mesh = TriangleMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
        let mirrored = mesh.scaled([-2.0, 1.0, 0.5]);
        let volume = |mesh: &TriangleMesh| -> f64 {
            (0..4).map(|t| mesh.corners(t)).map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum()
        };
        assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-15);
        assert!((volume(&mirrored) - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(mirrored.vertices.iter().map(|v| v.x).fold(0.0, f64::min), -2.0);
    }
}

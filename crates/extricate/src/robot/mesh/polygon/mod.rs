//! Triangulates single faces of many corners, also concave ones and ones with holes.
//!
//! Every corner and every side of a face stays one of a triangle, even if three corners lie on a
//! line. Neighbouring faces share them, and a mesh is only closed if sides meet sides.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use robust::{Coord, orient2d};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation};

use crate::math::Vec3;

/// The face crosses itself (perhaps only as seen along its normal, if it is far from flat), or its
/// holes cross it or lie outside.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Untriangulable;

/// Share of a face's area that rounding may take from or add to the area of its triangles.
const AREA_ROUNDING_SHARE: f64 = 1e-9;

/// Appends the triangles of a face, wound like its outline. `rings` are the outline and the holes,
/// wound either way, as indices into `vertices`. Rings of fewer than three corners are ignored.
///
/// A convex outline becomes a fan around its first corner. Other faces get a constrained Delaunay
/// triangulation, seen along the axis that is nearest to the normal. If that fails, each ring
/// becomes a fan, so that all sides exist.
///
/// # Source
/// The normal: I. E. Sutherland, R. F. Sproull and R. A. Schumacker, "A characterization of ten
/// hidden-surface algorithms", 1974, doi:10.1145/356625.356626 (Newell's method). Triangulation:
/// the crate `spade`.
pub(crate) fn triangulate(
    vertices: &[Vec3],
    rings: &[&[u32]],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), Untriangulable> {
    let Some((outline, holes)) = rings.split_first().filter(|(outline, _)| outline.len() >= 3) else { return Ok(()) };
    let holes: Vec<&[u32]> = holes.iter().copied().filter(|hole| hole.len() >= 3).collect();
    if let ([a, b, c], []) = (outline, &holes[..]) {
        triangles.push([*a, *b, *c]);
        return Ok(());
    }
    let seen = View::along_normal(vertices, outline);
    if holes.is_empty() && seen.is_convex(outline) {
        fan(outline, triangles);
        return Ok(());
    }
    let rings: Vec<&[u32]> = std::iter::once(*outline).chain(holes).collect();
    match seen.delaunay(&rings) {
        Some(found) => {
            triangles.extend(found);
            Ok(())
        }
        None => {
            rings.iter().for_each(|ring| fan(ring, triangles));
            Err(Untriangulable)
        }
    }
}

/// Appends the triangles of a fan around the first corner.
pub(crate) fn fan(ring: &[u32], triangles: &mut Vec<[u32; 3]>) {
    triangles.extend((2..ring.len()).map(|k| [ring[0], ring[k - 1], ring[k]]));
}

/// Points seen along an axis, which keeps their coordinates exact: corners on a line stay on a
/// line.
struct View<'a> {
    vertices: &'a [Vec3],
    axes: [usize; 2],
}

impl<'a> View<'a> {
    /// Returns the view in which `outline` runs counterclockwise.
    fn along_normal(vertices: &'a [Vec3], outline: &[u32]) -> Self {
        let at = |k: usize| &vertices[outline[k % outline.len()] as usize];
        let origin = at(0);
        let normal: Vec3 = (1..outline.len()).map(|k| (at(k) - origin).cross(&(at(k + 1) - origin))).sum();
        let axis = normal.iamax();
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        Self { vertices, axes: if normal[axis] < 0.0 { [axes[1], axes[0]] } else { axes } }
    }

    fn at(&self, index: u32) -> Coord<f64> {
        let point = &self.vertices[index as usize];
        Coord { x: point[self.axes[0]], y: point[self.axes[1]] }
    }

    /// Whether a ring never turns right, and goes around once.
    fn is_convex(&self, ring: &[u32]) -> bool {
        let corner = |k: usize| self.at(ring[k % ring.len()]);
        let turns_left = |k: usize| orient2d(corner(k), corner(k + 1), corner(k + 2)) >= 0.0;
        let goes_on = |k: usize| {
            let (a, b) = (corner(k), corner(k + 1));
            (a.x, a.y) < (b.x, b.y)
        };
        (0..ring.len()).all(turns_left) && (0..ring.len()).filter(|&k| goes_on(k) != goes_on(k + 1)).count() == 2
    }

    /// Twice the area within a ring, positive if it runs counterclockwise.
    fn area(&self, ring: &[u32]) -> f64 {
        let origin = self.at(ring[0]);
        let corner = |k: usize| {
            let Coord { x, y } = self.at(ring[k % ring.len()]);
            (x - origin.x, y - origin.y)
        };
        let part = |k: usize| {
            let ((a, b), (c, d)) = (corner(k), corner(k + 1));
            a * d - b * c
        };
        (0..ring.len()).map(part).sum()
    }

    fn delaunay(&self, rings: &[&[u32]]) -> Option<Vec<[u32; 3]>> {
        let mut outlines = Outlines { plane: Plane::new(), sides: HashSet::new(), bridges: Vec::new() };
        let mut handles: HashMap<u32, FixedVertexHandle> = HashMap::new();
        let mut first_at: Vec<u32> = Vec::new();
        for &index in rings.iter().copied().flatten() {
            if let Entry::Vacant(place) = handles.entry(index) {
                let Coord { x, y } = self.at(index);
                let handle = outlines.plane.insert(Corner { at: Point2::new(x, y), index }).ok()?;
                place.insert(handle);
                match first_at.get(handle.index()) {
                    None => first_at.push(index),
                    // Corners that coincide in the view must coincide in space.
                    Some(&first) if self.vertices[first as usize] == self.vertices[index as usize] => {}
                    Some(_) => return None,
                }
            }
        }
        for ring in rings {
            for k in 0..ring.len() {
                let (from, to) = (handles[&ring[k]], handles[&ring[(k + 1) % ring.len()]]);
                if from != to {
                    outlines.add_side(from, to)?;
                }
            }
        }
        let mut found = outlines.inside();
        let sum: f64 = found.iter().map(|triangle| self.area(triangle)).sum();
        let holes: f64 = rings[1..].iter().map(|ring| self.area(ring).abs()).sum();
        let expected = self.area(rings[0]) - holes;
        found.append(&mut outlines.bridges);
        ((sum - expected).abs() <= AREA_ROUNDING_SHARE * self.area(rings[0]) && expected > 0.0).then_some(found)
    }
}

/// A corner of the face in the plane.
struct Corner {
    at: Point2<f64>,
    index: u32,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// A triangulation that locates a corner in logarithmic time, even if successive ones are far
/// apart.
type Plane = ConstrainedDelaunayTriangulation<Corner, (), (), (), HierarchyHintGenerator<f64>>;

/// The sides of a face in a triangulation of its corners.
struct Outlines {
    plane: Plane,
    /// Edges of the triangulation that lie on an odd number of sides, so that one side of each is
    /// inside.
    sides: HashSet<[usize; 2]>,
    /// Flat triangles between a side and the corners that lie on it.
    bridges: Vec<[u32; 3]>,
}

impl Outlines {
    /// Adds a side; `None` if it crosses another one.
    fn add_side(&mut self, from: FixedVertexHandle, to: FixedVertexHandle) -> Option<()> {
        let edges = self.plane.try_add_constraint(from, to);
        let mut on_side = Vec::new();
        for edge in &edges {
            let ends = self.plane.directed_edge(*edge).vertices();
            let key = ends.map(|end| end.fix().index());
            let key = [key[0].min(key[1]), key[0].max(key[1])];
            if !self.sides.insert(key) {
                self.sides.remove(&key);
            }
            on_side.push(ends[1].fix());
        }
        on_side.pop()?;
        let index = |handle: FixedVertexHandle| self.plane.vertex(handle).data().index;
        let mut last = index(to);
        for &handle in on_side.iter().rev() {
            self.bridges.push([index(from), last, index(handle)]);
            last = index(handle);
        }
        Some(())
    }

    /// Returns the triangles inside: on a way in from the outer face, every side leads in or out.
    fn inside(&self) -> Vec<[u32; 3]> {
        let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); self.plane.num_all_faces()];
        for edge in self.plane.directed_edges() {
            let key = edge.vertices().map(|end| end.fix().index());
            let leads = self.sides.contains(&[key[0].min(key[1]), key[0].max(key[1])]);
            beside[edge.face().fix().index()].push((edge.rev().face().fix().index(), leads));
        }
        let mut inside: Vec<Option<bool>> = vec![None; beside.len()];
        let outer = self.plane.outer_face().fix().index();
        inside[outer] = Some(false);
        let mut stack = vec![outer];
        while let Some(face) = stack.pop() {
            for &(next, leads) in &beside[face] {
                if inside[next].is_none() {
                    inside[next] = inside[face].map(|here| here != leads);
                    stack.push(next);
                }
            }
        }
        let faces = self.plane.inner_faces().filter(|face| inside[face.fix().index()] == Some(true));
        faces.map(|face| face.vertices().map(|corner| corner.data().index)).collect()
    }
}

#[cfg(test)]
mod tests;

//! A small convex polytope of support points around the origin, which grows point by point. It does
//! not allocate.

use arrayvec::ArrayVec;

use super::horizon::Horizon;
use crate::collision::convex_distance::gjk::{nearest_on_triangle, normal_of_edges};
use crate::collision::convex_distance::minkowski::Vertex;
use crate::math::Vec3;

/// Most vertices: enough for the polytopes of a robot; curved cores stop here with the bounds
/// reached.
const MAX_VERTICES: usize = 128;
/// A closed triangulated surface has two faces a vertex, less four.
const MAX_FACES: usize = 2 * MAX_VERTICES;

/// A triangle of the surface, counterclockwise seen from outside.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    pub corners: [u8; 3],
    /// Outward unit normal; zero without area.
    pub normal: Vec3,
    /// Distance of the origin behind the plane \[m\].
    pub distance: f64,
    /// Rounding error of the normal's direction \[rad\].
    tilt: f64,
    /// Whether the face is not to be expanded, because of rounding or because it has no area.
    settled: bool,
}

/// A closed surface of triangles.
pub(crate) struct Polytope {
    vertices: ArrayVec<Vertex, MAX_VERTICES>,
    faces: ArrayVec<Face, MAX_FACES>,
    scale: f64,
    rounding: f64,
}

impl Polytope {
    /// Makes a polytope without a surface. `scale` and `rounding` \[m\] are those of the
    /// difference.
    #[inline(always)] // Inlined because it is large to move.
    pub fn empty(scale: f64, rounding: f64) -> Self {
        Self { vertices: ArrayVec::new(), faces: ArrayVec::new(), scale, rounding }
    }

    /// Starts from a tetrahedron whose last vertex lies behind the first three, seen
    /// counterclockwise.
    #[inline(always)]
    pub fn start(&mut self, corners: [Vertex; 4]) {
        self.vertices.extend(corners);
        for corners in [[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]] {
            self.push_face(corners);
        }
    }

    #[inline(always)]
    pub fn vertex(&self, index: u8) -> &Vertex {
        &self.vertices[index as usize]
    }

    pub fn face(&self, index: usize) -> &Face {
        &self.faces[index]
    }

    /// Returns the index of the unsettled face nearest to the origin.
    #[inline(always)]
    pub fn nearest_face(&self) -> Option<usize> {
        let (mut best, mut distance) = (None, f64::INFINITY);
        for (index, face) in self.faces.iter().enumerate() {
            if face.distance < distance && !face.settled {
                (best, distance) = (Some(index), face.distance);
            }
        }
        best
    }

    /// Returns a lower bound on the distance from the origin to the surface \[m\]. The surface is
    /// closed and lies in a convex set, so that the ball of this radius lies in it too, whatever
    /// rounding did to the planes.
    #[inline(always)]
    pub fn lower(&self) -> f64 {
        let mut lower = f64::INFINITY;
        for face in &self.faces {
            // The plane is a cheap bound; a triangle is measured only if its plane is below the
            // best. Slivers do not spoil that: a tilted normal changes the distance of the
            // projection, or its side of an edge, in second order only.
            if face.distance - face.tilt * self.scale - self.rounding < lower {
                let [a, b, c] = face.corners.map(|corner| &self.vertex(corner).point);
                let distance = nearest_on_triangle([a, b, c], [0, 1, 2]).square.sqrt();
                let shrink = (face.tilt * face.tilt).min(1.0) * distance;
                // The origin is outside the face, if only by what a touching start allows.
                let signed = if face.distance < 0.0 { -distance } else { distance };
                lower = lower.min(signed - shrink - self.rounding);
            }
        }
        lower
    }

    /// Takes a face out of the search.
    pub fn settle(&mut self, index: usize) {
        self.faces[index].settled = true;
    }

    pub fn is_full(&self) -> bool {
        self.vertices.is_full()
    }

    /// Adds a vertex that lies beyond `seed` and replaces all faces that it sees. Returns `false`
    /// and changes nothing if the vertex is known, sees no face or does not fit.
    #[inline(always)]
    pub fn add(&mut self, seed: usize, vertex: Vertex) -> bool {
        if self.vertices.iter().any(|known| known.point == vertex.point) {
            return false;
        }
        let mut horizon = Horizon::empty();
        let mut seen: ArrayVec<u16, MAX_FACES> = ArrayVec::new();
        for (index, face) in self.faces.iter().enumerate() {
            let height = vertex.point.dot(&face.normal) - face.distance;
            if index != seed && (height <= self.rounding || self.is_doubtful(face, &vertex, height)) {
                continue;
            }
            seen.push(index as u16);
            if !horizon.add(face.corners) {
                return false;
            }
        }
        if !horizon.is_one_loop() {
            let (grown, kept) = self.grow(seed, &mut seen);
            horizon = grown;
            seen.truncate(kept);
        }
        if seen.is_empty() || self.faces.len() - seen.len() + horizon.edges().len() > MAX_FACES {
            return false;
        }
        for &index in seen.iter().rev() {
            self.faces.swap_remove(usize::from(index));
        }
        let newest = self.vertices.len() as u8;
        self.vertices.push(vertex);
        for [from, to] in horizon.edges() {
            self.push_face([*from, *to, newest]);
        }
        true
    }

    /// Moves those seen faces around `seed` that one loop borders to the front, ascending, and
    /// returns the loop and their number. Faces in one plane may be seen in several patches because
    /// of rounding.
    #[cold]
    fn grow(&self, seed: usize, seen: &mut [u16]) -> (Horizon, usize) {
        let mut horizon = Horizon::empty();
        let (mut kept, mut next) = (0, seen.iter().position(|index| usize::from(*index) == seed));
        while let Some(found) = next {
            if !horizon.add(self.faces[usize::from(seen[found])].corners) {
                return (Horizon::empty(), 0);
            }
            seen.swap(kept, found);
            kept += 1;
            let grows = |index: &u16| horizon.can_grow(self.faces[usize::from(*index)].corners);
            next = seen[kept..].iter().position(grows).map(|offset| kept + offset);
        }
        seen[..kept].sort_unstable();
        (horizon, kept)
    }

    /// Returns whether the vertex may seem to lie above the face only because the normal is tilted.
    /// A face that is seen by error tears the surface; one that is missed leaves it a little
    /// dented.
    fn is_doubtful(&self, face: &Face, vertex: &Vertex, height: f64) -> bool {
        let lever = vertex.point - self.vertex(face.corners[0]).point;
        height <= self.rounding + face.tilt * lever.norm()
    }

    #[inline(always)]
    fn push_face(&mut self, corners: [u8; 3]) {
        let [a, b, c] = corners.map(|corner| self.vertices[corner as usize].point);
        let (normal, longest) = normal_of_edges(&(b - a), &(c - b), &(a - c));
        let area = normal.norm();
        let face = if area > 1e-12 * longest {
            let normal = normal / area;
            let distance = normal.dot(&(a + b + c)) / 3.0;
            let tilt = self.rounding * longest.sqrt() / area;
            Face { corners, normal, distance, tilt, settled: false }
        } else {
            // A triangle without area has no plane: nothing sees it, and its edges belong to its
            // neighbours too.
            Face { corners, normal: Vec3::zeros(), distance: 0.0, tilt: 0.0, settled: true }
        };
        self.faces.push(face);
    }
}

//! Triangles as files give them, before they are welded.

use crate::error::Result;
use crate::math::Vec3;
use crate::robot::mesh::polygon;

/// Nodes that may be gone through, and corners that they may place: a few kilobytes of nodes that
/// show each other twice would fill any memory.
const MOST_NODES: usize = 1_000_000;
const MOST_PLACED: usize = 1 << 25;

/// What a file says: vertices that may repeat, and triangles with valid indices into them.
#[derive(Default)]
pub(crate) struct Soup {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Which faces are not what they seem, and what they are taken for.
    pub faults: Vec<String>,
    /// Nodes of a scene graph that were gone through.
    nodes: usize,
}

impl Soup {
    /// Counts a node of a scene graph; what is wrong where there are too many.
    pub fn enter_node(&mut self) -> std::result::Result<(), String> {
        self.nodes += 1;
        if self.nodes > MOST_NODES {
            return Err(format!("got more than {MOST_NODES} nodes, those shown again counted, expected fewer"));
        }
        if self.nodes > 1 && self.vertices.len().max(self.triangles.len()) > MOST_PLACED {
            return Err(format!("got nodes that place more than {MOST_PLACED} corners, expected fewer"));
        }
        Ok(())
    }

    pub fn push_triangle(&mut self, corners: [Vec3; 3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// A fan around its first corner; points and lines are nothing.
    pub fn push_fan(&mut self, indices: &[u32]) {
        polygon::fan(indices, &mut self.triangles);
    }

    /// Triangles each of which takes two corners over from the one before.
    pub fn push_strip(&mut self, indices: &[u32]) {
        for k in 2..indices.len() {
            let (a, b) = if k % 2 == 0 { (k - 2, k - 1) } else { (k - 1, k - 2) };
            self.triangles.push([indices[a], indices[b], indices[k]]);
        }
    }

    /// A face: its outline, then its holes. `place` names it where it cannot be triangulated.
    pub fn push_face(&mut self, rings: &[&[u32]], place: impl FnOnce() -> String) {
        if polygon::triangulate(&self.vertices, rings, &mut self.triangles).is_err() {
            let corners: usize = rings.iter().map(|ring| ring.len()).sum();
            let kept = if rings.len() > 1 { "without its holes" } else { "as a fan around its first corner" };
            self.faults.push(format!(
                "{}: a face of {corners} corners crosses itself or is far from flat, and cannot be triangulated: it is \
                 taken {kept}",
                place()
            ));
        }
    }
}

/// Reads a file beside a mesh file, by the address that the mesh file has of it.
pub type Neighbour<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>>;

//! Triangles as files give them, before they are welded.

use crate::error::{MOST_LISTED, Result};
use crate::math::Vec3;
use crate::robot::mesh::polygon;
use crate::robot::{LoadLimit, LoadLimits};

/// What a file says: vertices that may repeat, and triangles with valid indices into them.
pub(crate) struct Soup {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Which faces are not what they seem, and what they are taken for: the first of them.
    pub faults: Vec<String>,
    /// Nodes of a scene graph that were gone through, and what else cost as much.
    nodes: usize,
    more_faults: usize,
    /// Corners that the bytes of the file can hold.
    held: usize,
    limits: LoadLimits,
}

/// Bytes that a corner takes in a file, at least: three numbers and what is between them.
const CORNER_BYTES: usize = 6;

impl Soup {
    /// Nothing, and how much may come.
    pub fn new(limits: &LoadLimits) -> Self {
        let (vertices, triangles, faults) = Default::default();
        Self { vertices, triangles, faults, nodes: 0, more_faults: 0, held: 0, limits: limits.clone() }
    }

    /// As [`Soup::new`], for what the nodes of a file of so many bytes show.
    pub fn shown(limits: &LoadLimits, bytes: usize) -> Self {
        Self { held: bytes / CORNER_BYTES, ..Self::new(limits) }
    }

    /// What is wrong where so many corners and triangles are too many for one more node to place.
    pub fn may_place(&self, vertices: usize, triangles: usize) -> std::result::Result<(), String> {
        let placed = self.vertices.len().saturating_add(vertices);
        self.within(LoadLimit::Placed, placed.saturating_sub(self.held))?;
        self.has_room(vertices, triangles)
    }

    /// Counts a node of a scene graph; what is wrong where there are too many.
    pub fn enter_node(&mut self) -> std::result::Result<(), String> {
        self.enter_nodes(1)
    }

    /// As [`Soup::enter_node`], for what costs as much as `count` nodes.
    pub fn enter_nodes(&mut self, count: usize) -> std::result::Result<(), String> {
        self.nodes += count;
        self.within(LoadLimit::MeshNodes, self.nodes)
    }

    /// What is wrong where so many corners and triangles more are too many.
    pub fn has_room(&self, vertices: usize, triangles: usize) -> std::result::Result<(), String> {
        self.within(LoadLimit::Vertices, self.vertices.len().saturating_add(vertices))?;
        self.within(LoadLimit::Triangles, self.triangles.len().saturating_add(triangles))
    }

    fn within(&self, limit: LoadLimit, found: usize) -> std::result::Result<(), String> {
        if found > self.limits.get(limit) { Err(self.limits.exceeded(limit, found)) } else { Ok(()) }
    }

    /// What is to be told of the faces.
    pub fn told(&self) -> impl Iterator<Item = String> + '_ {
        let more = (self.more_faults > 0).then(|| format!("{} more faces are taken so too", self.more_faults));
        self.faults.iter().cloned().chain(more)
    }

    /// Adds another one, its points moved by `place`; turned inside out where `mirrored`.
    pub fn add(
        &mut self,
        other: &Soup,
        place: impl Fn(&Vec3) -> Vec3,
        mirrored: bool,
    ) -> std::result::Result<(), String> {
        self.may_place(other.vertices.len(), other.triangles.len())?;
        let first = self.vertices.len() as u32;
        self.vertices.extend(other.vertices.iter().map(place));
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        self.triangles.extend(other.triangles.iter().map(|corners| turned(corners.map(|corner| first + corner))));
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
            if self.faults.len() == MOST_LISTED {
                self.more_faults += 1;
                return;
            }
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

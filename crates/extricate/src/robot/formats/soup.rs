//! Triangles as files give them, before they are welded.

use crate::error::{MOST_LISTED, Result};
use crate::math::Vec3;
use crate::robot::mesh::polygon;
use crate::robot::{LoadLimit, LoadLimits};

/// Contents of a mesh file: vertices that may repeat, and triangles with valid indices into them.
pub(crate) struct Soup {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// The first faces that could not be triangulated, and what they became instead.
    pub faults: Vec<String>,
    /// Nodes of a scene graph that were visited, and other work that cost as much.
    nodes: usize,
    more_faults: usize,
    /// Corners that the bytes of the file can hold.
    held: usize,
    limits: LoadLimits,
}

/// Fewest bytes of a corner in a file: three numbers and what is between them.
const MIN_CORNER_BYTES: usize = 6;

impl Soup {
    /// Returns an empty soup that may grow up to `limits`.
    pub fn new(limits: &LoadLimits) -> Self {
        let (vertices, triangles, faults) = Default::default();
        Self { vertices, triangles, faults, nodes: 0, more_faults: 0, held: 0, limits: limits.clone() }
    }

    /// As [`Soup::new`], for what nodes show in a file of so many bytes.
    pub fn shown(limits: &LoadLimits, bytes: usize) -> Self {
        Self { held: bytes / MIN_CORNER_BYTES, ..Self::new(limits) }
    }

    /// Returns the problem if one more node may not place so many corners and triangles.
    pub fn may_place(&self, vertices: usize, triangles: usize) -> std::result::Result<(), String> {
        let placed = self.vertices.len().saturating_add(vertices);
        self.within(LoadLimit::Placed, placed.saturating_sub(self.held))?;
        self.has_room(vertices, triangles)
    }

    /// Counts a node of a scene graph; returns the problem if there are too many.
    pub fn enter_node(&mut self) -> std::result::Result<(), String> {
        self.enter_nodes(1)
    }

    /// As [`Soup::enter_node`], for work that costs as much as `count` nodes.
    pub fn enter_nodes(&mut self, count: usize) -> std::result::Result<(), String> {
        self.nodes += count;
        self.within(LoadLimit::MeshNodes, self.nodes)
    }

    /// Returns the problem if so many more corners and triangles are too many.
    pub fn has_room(&self, vertices: usize, triangles: usize) -> std::result::Result<(), String> {
        self.within(LoadLimit::Vertices, self.vertices.len().saturating_add(vertices))?;
        self.within(LoadLimit::Triangles, self.triangles.len().saturating_add(triangles))
    }

    fn within(&self, limit: LoadLimit, found: usize) -> std::result::Result<(), String> {
        if found > self.limits.get(limit) { Err(self.limits.exceeded(limit, found)) } else { Ok(()) }
    }

    /// Returns the warnings about faces.
    pub fn told(&self) -> impl Iterator<Item = String> + '_ {
        let more = (self.more_faults > 0).then(|| format!("{} more faces are taken so too", self.more_faults));
        self.faults.iter().cloned().chain(more)
    }

    /// Adds another soup, its points moved by `place`, its triangles reversed if `mirrored`.
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

    /// Adds a fan around the first corner; points and lines add nothing.
    pub fn push_fan(&mut self, indices: &[u32]) {
        polygon::fan(indices, &mut self.triangles);
    }

    /// Adds a strip of triangles, each of which shares two corners with the one before.
    pub fn push_strip(&mut self, indices: &[u32]) {
        for k in 2..indices.len() {
            let (a, b) = if k % 2 == 0 { (k - 2, k - 1) } else { (k - 1, k - 2) };
            self.triangles.push([indices[a], indices[b], indices[k]]);
        }
    }

    /// Adds a face of an outline and holes; `place` names it in the warning if it cannot be
    /// triangulated.
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

/// Reads a file that a mesh file refers to, by the address in the mesh file.
pub type Neighbour<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>>;

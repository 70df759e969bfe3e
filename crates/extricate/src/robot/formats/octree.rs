//! Octrees of OctoMap, as the messages `octomap_msgs/Octomap` hold them, to their occupied cells.

use super::super::scenery::Voxels;
use super::super::{LoadLimit, LoadLimits};
use crate::error::{Error, Result, quoted};

/// Depth of the finest cells of a tree.
const DEPTH: u32 = 16;

/// An octree of OctoMap as bytes: the fields of a message `octomap_msgs/Octomap`.
#[derive(Debug, Clone, Copy)]
pub struct Octree<'a> {
    /// Kind of the nodes: `OcTree` or `ColorOcTree`.
    pub id: &'a str,
    /// Whether two bits a node say free or occupied. Otherwise nodes hold their log-odds.
    pub is_binary: bool,
    /// Side of the finest cells \[m\].
    pub resolution: f64,
    /// The nodes in depth-first order.
    pub data: &'a [u8],
}

impl Octree<'_> {
    /// Returns the occupied leaves, large ones cut to cells of the finest size. A leaf is occupied
    /// if its log-odds are 0 or more, which is OctoMap's default. No bytes are an empty tree.
    ///
    /// # Errors
    /// [`Error::Input`] of `element` in `file`: an unknown kind of nodes, a resolution that is not
    /// positive, bytes that are not exactly one tree, more cells than the limit `vertices`.
    ///
    /// # Source
    /// The formats that `writeBinaryData` and `writeData` of OctoMap 1.9 write; Hornung et al.,
    /// OctoMap, 2013, doi:10.1007/s10514-012-9321-0.
    pub fn voxels(&self, file: &str, element: &str, limits: &LoadLimits) -> Result<Voxels> {
        let colour_bytes = match self.id {
            "OcTree" => 0,
            "ColorOcTree" => 3,
            other => {
                let problem = format!("got `{}`, expected OcTree or ColorOcTree", quoted(other));
                return Err(Error::input(file, format!("{element}.id"), problem));
            }
        };
        let mut reader = Reader { file, element, data: self.data, at: 0, colour_bytes, limits, cells: Vec::new() };
        // The root is centred on the origin.
        let root = Cube { corner: [-(1 << (DEPTH - 1)); 3], depth: 0 };
        match (self.data.is_empty(), self.is_binary) {
            (true, _) => {}
            (false, true) => reader.read_binary(root)?,
            (false, false) => reader.read_full(root)?,
        }
        if reader.at < self.data.len() {
            return Err(reader.fault(format!("got {} bytes, expected {}", self.data.len(), reader.at)));
        }
        Voxels::new(file, &format!("{element}.resolution"), self.resolution, reader.cells)
    }
}

/// The cube of a node, in finest cells.
#[derive(Clone, Copy)]
struct Cube {
    corner: [i32; 3],
    depth: u32,
}

impl Cube {
    fn side(self) -> i32 {
        1 << (DEPTH - self.depth)
    }

    /// Returns a child; the bits of its number are the halves along x, y and z.
    fn child(self, number: u32) -> Self {
        let half = self.side() / 2;
        let mut corner = self.corner;
        for (axis, x) in corner.iter_mut().enumerate() {
            *x += half * (number >> axis & 1) as i32;
        }
        Self { corner, depth: self.depth + 1 }
    }
}

struct Reader<'a> {
    file: &'a str,
    element: &'a str,
    data: &'a [u8],
    at: usize,
    colour_bytes: usize,
    limits: &'a LoadLimits,
    cells: Vec<[i32; 3]>,
}

impl Reader<'_> {
    fn fault(&self, problem: String) -> Error {
        Error::input(self.file, format!("{}.data", self.element), problem)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        match self.data.get(self.at..).and_then(|rest| rest.first_chunk()) {
            Some(bytes) => {
                self.at += N;
                Ok(*bytes)
            }
            None => {
                let (found, at) = (self.data.len(), self.at);
                Err(self.fault(format!("got {found} bytes, expected a node of {N} bytes or more at byte {at}")))
            }
        }
    }

    fn check_depth(&self, node: Cube) -> Result<()> {
        if node.depth < DEPTH {
            return Ok(());
        }
        Err(self.fault(format!("got a node below depth {DEPTH} at byte {}, expected leaves there", self.at)))
    }

    /// Reads the children of a node: two bits each, then the children of those that have some.
    fn read_binary(&mut self, node: Cube) -> Result<()> {
        const OCCUPIED: u16 = 0b10;
        const INNER: u16 = 0b11;
        self.check_depth(node)?;
        let bits = u16::from_le_bytes(self.take()?);
        if bits == 0 && node.depth == 0 {
            return self.fill(node);
        }
        let of_kind = |kind: u16| (0..8).filter(move |number| bits >> (2 * number) & 0b11 == kind);
        of_kind(OCCUPIED).try_for_each(|number| self.fill(node.child(number)))?;
        of_kind(INNER).try_for_each(|number| self.read_binary(node.child(number)))
    }

    /// Reads a node: its log-odds, its colour, a bit for each child, then the children.
    fn read_full(&mut self, node: Cube) -> Result<()> {
        let log_odds = f32::from_le_bytes(self.take()?);
        if log_odds.is_nan() {
            return Err(self.fault(format!("got NaN at byte {}, expected log-odds", self.at - 4)));
        }
        for _ in 0..self.colour_bytes {
            self.take::<1>()?;
        }
        let [children] = self.take()?;
        if children == 0 {
            return if log_odds >= 0.0 { self.fill(node) } else { Ok(()) };
        }
        self.check_depth(node)?;
        (0..8).filter(|number| children >> number & 1 == 1).try_for_each(|number| self.read_full(node.child(number)))
    }

    fn fill(&mut self, leaf: Cube) -> Result<()> {
        let side = leaf.side();
        let more = usize::try_from(i64::from(side).pow(3)).unwrap_or(usize::MAX);
        let element = format!("{}.data", self.element);
        self.limits.check(LoadLimit::Vertices, self.cells.len().saturating_add(more), self.file, &element)?;
        let [x, y, z] = leaf.corner;
        for i in x..x + side {
            for j in y..y + side {
                self.cells.extend((z..z + side).map(|k| [i, j, k]));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn voxels(id: &str, is_binary: bool, data: &[u8]) -> Result<Voxels> {
        let limits = LoadLimits::default().with(LoadLimit::Vertices, 20);
        Octree { id, is_binary, resolution: 0.1, data }.voxels("m.json", "map", &limits)
    }

    /// Returns the bytes of inner nodes at the depths `0..count`, each with child 7 alone.
    fn binary_chain(count: usize) -> Vec<u8> {
        [0x00, 0xc0].repeat(count)
    }

    fn node(log_odds: f32, colour: &[u8], children: u8) -> Vec<u8> {
        [&log_odds.to_le_bytes(), colour, &[children]].concat()
    }

    #[test]
    fn binary_leaves_are_cells_and_large_ones_are_cut() {
        // Below the origin's octant: child 7 of the root, then child 0 down to the finest cell.
        let mut data = vec![0x00, 0xc0];
        data.extend([0x03, 0x00].repeat(14));
        // Children 0 (free), 1 and 6 (occupied) of a node of two cells a side.
        data.extend([0b0000_1001, 0b0010_0000]);
        assert_eq!(voxels("OcTree", true, &data).unwrap().cells(), [[0, 1, 1], [1, 0, 0]]);
        // An occupied leaf one level up has eight cells.
        let mut data = vec![0x00, 0xc0];
        data.extend([0x03, 0x00].repeat(13));
        data.extend([0b0000_1000, 0]);
        let large = voxels("ColorOcTree", true, &data).unwrap();
        assert_eq!((large.cells().len(), large.cells()[0], large.cells()[7]), (8, [2, 0, 0], [3, 1, 1]));
        assert!(voxels("OcTree", true, &[]).unwrap().cells().is_empty());
    }

    #[test]
    fn full_leaves_are_occupied_from_even_odds_on() {
        for (id, colour) in [("OcTree", &[][..]), ("ColorOcTree", &[9, 9, 9])] {
            let mut data = node(1.0, colour, 1 << 0);
            (0..14).for_each(|_| data.extend(node(1.0, colour, 1 << 7)));
            data.extend(node(1.0, colour, 0b1000_0101));
            [-0.1, 0.0, 2.5].into_iter().for_each(|odds| data.extend(node(odds, colour, 0)));
            assert_eq!(voxels(id, false, &data).unwrap().cells(), [[-2, -1, -2], [-1, -1, -1]], "{id}");
        }
        assert!(voxels("OcTree", false, &node(-1.0, &[], 0)).unwrap().cells().is_empty());
    }

    #[test]
    fn bytes_that_are_no_tree_are_refused() {
        let told = |id: &str, is_binary: bool, data: &[u8]| voxels(id, is_binary, data).unwrap_err().to_string();
        assert_eq!(told("Tree", true, &[]), "m.json: map.id: got `Tree`, expected OcTree or ColorOcTree");
        assert_eq!(
            told("OcTree", true, &[0, 0xc0, 1]),
            "m.json: map.data: got 3 bytes, expected a node of 2 bytes or more at byte 2"
        );
        assert_eq!(told("OcTree", true, &[1, 0, 0]), "m.json: map.data: got 3 bytes, expected 2");
        assert!(told("OcTree", true, &binary_chain(20)).contains("a node below depth 16 at byte 32, expected leaves"));
        let deep = node(1.0, &[], 1).repeat(20);
        assert!(told("OcTree", false, &deep).contains("a node below depth 16"));
        assert!(told("OcTree", false, &node(f32::NAN, &[], 0)).contains("got NaN at byte 0, expected log-odds"));
        // One occupied leaf as the whole tree, and one a few cells too large.
        assert!(told("OcTree", true, &[0, 0]).contains("corners, points or cells or more, expected at most 20"));
        let mut large = binary_chain(13);
        large.extend([0, 0x80]);
        assert!(told("OcTree", true, &large).contains("map.data: got 64 corners, points or cells"));
        let flat = Octree { id: "OcTree", is_binary: true, resolution: 0.0, data: &[] };
        let flat = flat.voxels("m.json", "map", &LoadLimits::default()).unwrap_err().to_string();
        assert!(flat.contains("map.resolution: size: got 0.0, expected a side > 0"), "{flat}");
    }
}

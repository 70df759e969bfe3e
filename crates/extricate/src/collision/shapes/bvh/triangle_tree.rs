//! A tree of boxes over the triangles of a mesh, and its nearest-point query. Eight children a
//! node, eight triangles a leaf; no pairs of trees.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::block::Block;
use super::boxes::{Boxes, Cuboid, below, rounded_up, rounding_at};
use crate::collision::narrow_phase::triangle::{Triangle, closest_on_triangle};
use crate::collision::shapes::bounds::Aabb;
use crate::math::simd::lanes_of;
use crate::math::{LANES, Vec3};

/// A node or a block of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ref(pub u32);

const BLOCK_BIT: u32 = 1 << 31;

impl Ref {
    pub(super) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    pub(super) fn block(index: usize) -> Self {
        Self(index as u32 | BLOCK_BIT)
    }

    pub fn is_block(self) -> bool {
        self.0 & BLOCK_BIT != 0
    }

    /// Index among the nodes or among the blocks.
    pub fn index(self) -> usize {
        (self.0 & !BLOCK_BIT) as usize
    }
}

/// A node with up to eight children.
#[derive(Debug, Clone)]
pub struct Node {
    /// Box around each child; lanes without one have no box.
    pub boxes: Boxes,
    pub bounds: Cuboid,
    pub children: [Ref; LANES],
}

/// Triangles that fill a subtree.
#[derive(Debug, Clone)]
pub struct Group {
    pub root: Ref,
    pub blocks: Range<usize>,
}

/// Grouping of the triangles of a tree, without their positions.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TreeLayout {
    /// Nodes and blocks, each node before its children. A block stores its number of triangles, 1
    /// to 8; a node stores 8 plus its number of children, 10 to 16.
    pub elements: Vec<u8>,
    /// Triangles of the blocks, as indices among those of all groups, group after group.
    pub order: Vec<u32>,
}

impl TreeLayout {
    pub(super) fn push_node(&mut self, children: usize) {
        self.elements.push((LANES + children) as u8);
    }

    pub(super) fn push_block(&mut self, triangles: impl ExactSizeIterator<Item = u32>) {
        self.elements.push(triangles.len() as u8);
        self.order.extend(triangles);
    }
}

/// Triangles sorted into a tree.
///
/// The number of a triangle is eight times its block plus its lane.
#[derive(Debug, Clone)]
pub struct Bvh {
    /// Root node, or the only block.
    pub root: Ref,
    pub bounds: Aabb,
    /// The box `bounds` in `f32`.
    pub cuboid: Cuboid,
    /// Nodes, each with at least two children.
    pub nodes: Vec<Node>,
    pub blocks: Vec<Block>,
    /// Subtree of every group.
    pub groups: Vec<Group>,
    /// Layout from which the tree was built.
    pub layout: TreeLayout,
}

/// Point of a triangle that is nearest to a query point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    pub point: Vec3,
    /// Number of the triangle that contains the point.
    pub triangle: u32,
    /// Squared distance [m^2] to the query point.
    pub squared: f64,
}

impl Bvh {
    #[inline(always)]
    pub fn bounds_of(&self, at: Ref) -> &Cuboid {
        if at.is_block() { &self.blocks[at.index()].bounds } else { &self.nodes[at.index()].bounds }
    }

    /// Triangle by number; `None` if there is none.
    pub fn triangle(&self, number: u32) -> Option<Triangle> {
        let (block, lane) = (number as usize / LANES, number as usize % LANES);
        self.blocks.get(block).filter(|block| lane < block.len()).map(|block| block.triangle(lane))
    }

    pub fn triangles(&self, blocks: Range<usize>) -> impl Iterator<Item = Triangle> {
        self.blocks[blocks].iter().flat_map(|block| (0..block.len()).map(|lane| block.triangle(lane)))
    }

    /// Point of the triangles below `root` that is nearest to `point`, if its squared distance is
    /// below `limit_squared`. Stops early at a point within `enough_squared`.
    pub fn closest_point(
        &self,
        root: Ref,
        point: &Vec3,
        limit_squared: f64,
        enough_squared: f64,
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<Nearest> {
        Arch::new().dispatch(ClosestPoint { tree: self, root, point, limit_squared, enough_squared, stack })
    }
}

struct ClosestPoint<'a> {
    tree: &'a Bvh,
    root: Ref,
    point: &'a Vec3,
    limit_squared: f64,
    enough_squared: f64,
    stack: &'a mut Vec<(f64, u32)>,
}

impl WithSimd for ClosestPoint<'_> {
    type Output = Option<Nearest>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Nearest> {
        let Self { tree, root, point, mut limit_squared, enough_squared, stack } = self;
        let place = [point.x as f32, point.y as f32, point.z as f32];
        let rounding = rounding_at(point, &tree.cuboid);
        let mut best = None;
        stack.clear();
        stack.push((0.0, root.0));
        while let Some((bound, at)) = stack.pop() {
            let at = Ref(at);
            if bound >= limit_squared {
                continue;
            }
            if at.is_block() {
                let block = &tree.blocks[at.index()];
                let bounds = block.boxes.distances_squared(simd, &place, rounding);
                for lane in lanes_of(below(&bounds, rounded_up(limit_squared))) {
                    if f64::from(bounds[lane]) >= limit_squared {
                        continue;
                    }
                    let near = closest_on_triangle(&block.triangle(lane), point);
                    let squared = (near - point).norm_squared();
                    if squared < limit_squared {
                        let triangle = (at.index() * LANES + lane) as u32;
                        (best, limit_squared) = (Some(Nearest { point: near, triangle, squared }), squared);
                    }
                }
                if limit_squared <= enough_squared {
                    break;
                }
            } else {
                let node = &tree.nodes[at.index()];
                let bounds = node.boxes.distances_squared(simd, &place, rounding);
                let start = stack.len();
                for lane in lanes_of(below(&bounds, rounded_up(limit_squared))) {
                    push_sorted(stack, start, (f64::from(bounds[lane]), node.children[lane].0), |entry| entry.0);
                }
            }
        }
        best
    }
}

/// Inserts an entry into `stack[start..]`, which descends by `key`, so that the least is popped
/// first.
#[inline(always)]
pub fn push_sorted<T: Copy, K: PartialOrd>(stack: &mut Vec<T>, start: usize, entry: T, key: impl Fn(&T) -> K) {
    stack.push(entry);
    let mut at = stack.len() - 1;
    while at > start && key(&stack[at - 1]) < key(&entry) {
        stack[at] = stack[at - 1];
        at -= 1;
    }
    stack[at] = entry;
}

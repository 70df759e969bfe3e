//! A tree of boxes over the triangles of a mesh, eight children a node and eight triangles a leaf,
//! and its nearest-point query. Not pairs of trees.

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

const BLOCK: u32 = 1 << 31;

impl Ref {
    pub(super) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    pub(super) fn block(index: usize) -> Self {
        Self(index as u32 | BLOCK)
    }

    /// Whether this is a block.
    pub fn is_block(self) -> bool {
        self.0 & BLOCK != 0
    }

    /// Place among the nodes or the blocks.
    pub fn index(self) -> usize {
        (self.0 & !BLOCK) as usize
    }
}

/// Up to eight children.
#[derive(Debug, Clone)]
pub struct Node {
    /// Around each child; nothing in lanes without one.
    pub boxes: Boxes,
    /// Around all of them.
    pub bounds: Cuboid,
    /// What is in them.
    pub children: [Ref; LANES],
}

/// Triangles that fill a subtree.
#[derive(Debug, Clone)]
pub struct Group {
    /// Of the subtree.
    pub root: Ref,
    /// All blocks of it.
    pub blocks: Range<usize>,
}

/// How the triangles of a tree are grouped, apart from where they are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TreeLayout {
    /// Every node before what is below it. Of a block the number of its triangles, 1 to 8; of a
    /// node 8 more than the number of its children, 10 to 16.
    pub elements: Vec<u8>,
    /// The triangles of the blocks, each a place among those of all groups, group after group.
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
/// A triangle is known by eight times its block plus its lane.
#[derive(Debug, Clone)]
pub struct Bvh {
    /// A node, or the only block.
    pub root: Ref,
    /// Around everything.
    pub bounds: Aabb,
    /// The same.
    pub cuboid: Cuboid,
    /// Nodes with more than one child.
    pub nodes: Vec<Node>,
    /// The triangles.
    pub blocks: Vec<Block>,
    /// Of every group its subtree.
    pub groups: Vec<Group>,
    /// What it was made of beside the triangles.
    pub layout: TreeLayout,
}

/// A point of a tree's triangles near a given one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The point.
    pub point: Vec3,
    /// The triangle that it lies on.
    pub triangle: u32,
    /// Its squared distance [m^2].
    pub squared: f64,
}

impl Bvh {
    /// The box around a node or block.
    #[inline(always)]
    pub fn bounds_of(&self, at: Ref) -> &Cuboid {
        if at.is_block() { &self.blocks[at.index()].bounds } else { &self.nodes[at.index()].bounds }
    }

    /// A triangle by its number.
    pub fn triangle(&self, number: u32) -> Option<Triangle> {
        let (block, lane) = (number as usize / LANES, number as usize % LANES);
        self.blocks.get(block).filter(|block| lane < block.len()).map(|block| block.triangle(lane))
    }

    /// All triangles of `blocks`.
    pub fn triangles(&self, blocks: Range<usize>) -> impl Iterator<Item = Triangle> {
        self.blocks[blocks].iter().flat_map(|block| (0..block.len()).map(|lane| block.triangle(lane)))
    }

    /// The point of the triangles below `root` that is nearest to `point`, if nearer than the root
    /// of `limit_squared`. Gives up where that falls to `enough_squared`.
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

/// Inserts an entry into `stack[start..]`, which is kept descending by `key`: the least comes off
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

//! Builds a tree from its layout and its triangles. Finding a layout is most of the work of
//! building a tree, so model files store it.

use std::mem::replace;
use std::ops::Range;

use super::block::Block;
use super::boxes::{Boxes, Cuboid};
use super::triangle_tree::{Bvh, Group, Node, Ref, TreeLayout};
use crate::collision::shapes::bounds::{Aabb, EMPTY};
use crate::math::{LANES, Vec3};

/// A node or block with the data that its parent needs.
struct Below {
    at: Ref,
    lower: Vec3,
    upper: Vec3,
    /// Group of all its triangles; `None` if they belong to several groups.
    group: Option<u32>,
    triangles: usize,
    blocks: Range<usize>,
}

impl Below {
    fn bounds(&self) -> Aabb {
        Aabb::between(&self.lower, &self.upper)
    }

    /// Makes the node `at` over at least two children.
    fn over(at: Ref, children: &[Self]) -> Self {
        let (lower, upper) = children.iter().fold(EMPTY, |(l, u), child| (l.inf(&child.lower), u.sup(&child.upper)));
        let [first, .., last] = children else { unreachable!("a node has two children at least") };
        Self {
            at,
            lower,
            upper,
            group: first.group.filter(|_| children.iter().all(|child| child.group == first.group)),
            triangles: children.iter().map(|child| child.triangles).sum(),
            blocks: first.blocks.start..last.blocks.end,
        }
    }
}

impl Bvh {
    /// Builds the tree of `groups` of triangles from `layout`. Returns `None` unless every triangle
    /// is in one block, every block within one group, and every group a subtree.
    pub fn with_layout(groups: &[Vec<[Vec3; 3]>], layout: TreeLayout) -> Option<Self> {
        let blocks = blocks(groups, &layout)?;
        let is_node = |element: &&u8| usize::from(**element) > LANES;
        let mut next_node = layout.elements.iter().filter(is_node).count();
        let mut next_block = blocks.len();
        let mut nodes = Vec::with_capacity(next_node);
        let mut of_groups = vec![None; groups.len()];
        // Elements run backward, so that children are known before their node. The stack holds
        // those without a parent, with the first child of the next node on top.
        let mut orphans: Vec<Below> = Vec::new();
        let mut children: Vec<Below> = Vec::new();
        for element in layout.elements.iter().rev().map(|element| usize::from(*element)) {
            let below = if element <= LANES {
                next_block -= 1;
                below_block(next_block, &blocks[next_block])
            } else {
                children.clear();
                let first = orphans.len().checked_sub(element - LANES)?;
                children.extend(orphans.drain(first..).rev());
                next_node -= 1;
                let below = Below::over(Ref::node(next_node), &children);
                nodes.push(node(&below, &children));
                below
            };
            if let Some(group) = below.group.filter(|g| groups[*g as usize].len() == below.triangles) {
                of_groups[group as usize] = Some(Group { root: below.at, blocks: below.blocks.clone() });
            }
            orphans.push(below);
        }
        nodes.reverse();
        let [root] = &orphans[..] else { return None };
        let (bounds, groups) = (root.bounds(), of_groups.into_iter().collect::<Option<_>>()?);
        Some(Self { root: root.at, bounds, cuboid: Cuboid::around(&bounds), nodes, blocks, groups, layout })
    }
}

/// Builds the blocks of `layout`; `None` unless they contain every triangle of `groups` once, and
/// each block those of one group.
fn blocks(groups: &[Vec<[Vec3; 3]>], layout: &TreeLayout) -> Option<Vec<Block>> {
    let starts: Vec<usize> = groups.iter().scan(0, |next, group| Some(replace(next, *next + group.len()))).collect();
    let mut is_placed = vec![false; groups.iter().map(Vec::len).sum()];
    let mut order = &layout.order[..];
    let mut blocks = Vec::with_capacity(layout.order.len().div_ceil(LANES));
    let mut triangles = Vec::with_capacity(LANES);
    for element in layout.elements.iter().map(|element| usize::from(*element)) {
        match element {
            1..=LANES => {}
            _ if (LANES + 2..=2 * LANES).contains(&element) => continue,
            _ => return None,
        }
        let (numbers, others) = order.split_at_checked(element)?;
        let group = starts.partition_point(|start| *start <= numbers[0] as usize) - 1;
        triangles.clear();
        for number in numbers.iter().map(|number| *number as usize) {
            let is_second = replace(is_placed.get_mut(number)?, true);
            let triangle = number.checked_sub(starts[group]).and_then(|within| groups[group].get(within))?;
            triangles.push(*triangle);
            if is_second {
                return None;
            }
        }
        blocks.push(Block::new(&triangles, group as u32));
        order = others;
    }
    (order.is_empty() && layout.order.len() == is_placed.len()).then_some(blocks)
}

fn below_block(index: usize, block: &Block) -> Below {
    let corners = (0..block.len()).flat_map(|lane| block.triangle(lane).points);
    let (lower, upper) = corners.fold(EMPTY, |(lower, upper), p| (lower.inf(&p), upper.sup(&p)));
    let (group, triangles) = (Some(block.group), block.len());
    Below { at: Ref::block(index), lower, upper, group, triangles, blocks: index..index + 1 }
}

fn node(below: &Below, children: &[Below]) -> Node {
    let boxes: Vec<Aabb> = children.iter().map(Below::bounds).collect();
    let mut refs = [Ref::block(0); LANES];
    for (lane, child) in children.iter().enumerate() {
        refs[lane] = child.at;
    }
    Node { boxes: Boxes::new(&boxes), bounds: Cuboid::around(&below.bounds()), children: refs }
}

#[cfg(test)]
mod tests {
    use super::super::build::{build, sorted};
    use super::*;

    /// Triangles in a row; triangle `k` begins at `k`.
    fn row(from: usize, count: usize) -> Vec<[Vec3; 3]> {
        let at = |k: usize| Vec3::new(k as f64, 0.0, 0.0);
        (from..from + count).map(|k| [at(k), at(k) + Vec3::x(), at(k) + Vec3::y()]).collect()
    }

    /// Three groups, one of which is a single block.
    fn groups() -> Vec<Vec<[Vec3; 3]>> {
        vec![row(0, 90), row(200, 5), row(300, 17)]
    }

    #[test]
    fn a_layout_makes_the_same_tree_once_more() {
        let layout = sorted(&groups());
        let (built, again) = (build(&groups()), Bvh::with_layout(&groups(), layout.clone()).unwrap());
        assert_eq!(built.layout, layout);
        assert_eq!(format!("{built:?}"), format!("{again:?}"));
        assert_eq!(layout.order.len(), 112);
        assert_eq!(built.groups[1].blocks.len(), 1);
    }

    #[test]
    fn layouts_of_other_trees_are_refused() {
        let layout = sorted(&groups());
        let refused = |spoil: &dyn Fn(&mut TreeLayout)| {
            let mut spoiled = layout.clone();
            spoil(&mut spoiled);
            Bvh::with_layout(&groups(), spoiled).is_none()
        };
        assert!(!refused(&|_| ()));
        assert!(Bvh::with_layout(&groups()[..2], layout.clone()).is_none(), "fewer triangles");
        assert!(Bvh::with_layout(&[groups(), vec![row(900, 3)]].concat(), layout.clone()).is_none(), "more triangles");
        let regrouped = vec![row(0, 91), row(200, 4), row(300, 17)];
        assert!(Bvh::with_layout(&regrouped, layout.clone()).is_none(), "other groups");
        assert!(refused(&|layout| layout.order[7] = layout.order[8]), "one twice");
        assert!(refused(&|layout| layout.order[7] = 112), "one that is not there");
        assert!(refused(&|layout| layout.order[7] = u32::MAX));
        assert!(refused(&|layout| layout.order.swap(0, 111)), "blocks of several groups");
        assert!(refused(&|layout| layout.order.truncate(100)));
        assert!(refused(&|layout| layout.order.push(3)));
        for (k, element) in layout.elements.iter().enumerate() {
            for other in (0..=17).chain([u8::MAX]).filter(|other| other != element) {
                assert!(refused(&|layout| layout.elements[k] = other), "element {k}, {element}: {other}");
            }
            assert!(refused(&|layout| layout.elements.truncate(k)), "{k} elements");
            assert!(refused(&|layout| layout.elements.insert(k, 10)), "a node more at {k}");
        }
        assert!(refused(&|layout| layout.elements.push(10)));
        // A group in two halves without a common node.
        let halves = [row(0, 8), row(8, 8)].concat();
        let split = TreeLayout { elements: vec![11, 8, 8, 8], order: (0..24).collect() };
        assert!(Bvh::with_layout(&[halves, row(16, 8)], split).is_none());
    }

    /// As deep as a file can make a tree. Neither building nor searching recurses.
    #[test]
    fn a_chain_of_a_million_nodes_is_a_tree() {
        let count = 1_000_000;
        let elements = [10, 1].repeat(count - 1).into_iter().chain([1]).collect();
        let tree = Bvh::with_layout(&[row(0, count)], TreeLayout { elements, order: (0..count as u32).collect() });
        let tree = tree.unwrap();
        let near = tree.closest_point(tree.root, &Vec3::new(7e5, 0.0, 3.0), f64::INFINITY, 0.0, &mut Vec::new());
        assert_eq!(near.unwrap().squared, 9.0);
    }
}

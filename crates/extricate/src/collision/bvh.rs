//! A binary tree of boxes over the triangles of a mesh: how it is built, and its nearest-point query. Not pairs of trees.

use super::bounds::{Aabb, EMPTY};
use super::triangle::{Triangle, closest_on_triangle};
use crate::math::Vec3;
use std::ops::Range;

/// A node; its children stand side by side.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Around all triangles below.
    pub bounds: Aabb,
    /// First child, or first triangle of a leaf.
    pub first: u32,
    /// Number of triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

/// Triangles sorted into a tree; those of one group (a connected component) fill a subtree.
#[derive(Debug, Clone)]
pub struct Bvh {
    /// The root is the first.
    pub nodes: Vec<Node>,
    /// In the order of the leaves.
    pub triangles: Vec<Triangle>,
    /// Of every group its subtree and its triangles.
    pub groups: Vec<(u32, Range<u32>)>,
    /// Which group each triangle belongs to.
    pub group_of: Vec<u32>,
}

/// Most triangles of a leaf. Instructions of labels, distances and contacts near the boundary (links of some hundred
/// triangles and a ring of 4,600) with 1, 2 and 4: 79, 52, 45; 287, 240, 276; 389, 277, 231 millions.
const LEAF: usize = 4;
const BINS: usize = 16;

struct Item {
    lower: Vec3,
    upper: Vec3,
    id: u32,
}

impl Bvh {
    /// Builds the tree of `groups` of triangles; none of them may be empty.
    ///
    /// # Source
    /// I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007, doi:10.1109/RT.2007.4342588.
    pub fn new(groups: &[Vec<[Vec3; 3]>]) -> Self {
        let mut items: Vec<Item> = groups.iter().enumerate().map(|(id, g)| item(g.as_flattened(), id)).collect();
        let count = groups.iter().map(Vec::len).sum();
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * count),
            triangles: Vec::with_capacity(count),
            groups: vec![(0, 0..0); groups.len()],
            group_of: Vec::with_capacity(count),
        };
        tree.nodes.push(Node { bounds: bounds(&items), first: 0, count: 0 });
        tree.split_groups(0, &mut items, groups);
        tree
    }

    fn split_groups(&mut self, node: usize, items: &mut [Item], groups: &[Vec<[Vec3; 3]>]) {
        if let [Item { id, .. }] = items {
            let group = &groups[*id as usize];
            let mut triangles: Vec<Item> = group.iter().enumerate().map(|(k, t)| item(t, k)).collect();
            let start = self.triangles.len() as u32;
            self.split_triangles(node, &mut triangles, group);
            self.group_of.resize(self.triangles.len(), *id);
            self.groups[*id as usize] = (node as u32, start..self.triangles.len() as u32);
        } else {
            let middle = partition(items);
            let (left, right) = items.split_at_mut(middle);
            let child = self.open(node, left, right);
            self.split_groups(child, left, groups);
            self.split_groups(child + 1, right, groups);
        }
    }

    fn split_triangles(&mut self, node: usize, items: &mut [Item], group: &[[Vec3; 3]]) {
        if items.len() <= LEAF {
            (self.nodes[node].first, self.nodes[node].count) = (self.triangles.len() as u32, items.len() as u32);
            self.triangles.extend(items.iter().map(|item| Triangle::new(group[item.id as usize])));
        } else {
            let middle = partition(items);
            let (left, right) = items.split_at_mut(middle);
            let child = self.open(node, left, right);
            self.split_triangles(child, left, group);
            self.split_triangles(child + 1, right, group);
        }
    }

    fn open(&mut self, node: usize, left: &[Item], right: &[Item]) -> usize {
        let child = self.nodes.len();
        self.nodes[node].first = child as u32;
        self.nodes.extend([left, right].map(|items| Node { bounds: bounds(items), first: 0, count: 0 }));
        child
    }

    /// Triangles of a leaf.
    pub fn leaf(&self, node: &Node) -> Range<usize> {
        node.first as usize..(node.first + node.count) as usize
    }

    /// The point of the triangles below `root` that is nearest to `point`, if nearer than the root of `limit_squared`;
    /// with the triangle it lies on and the squared distance. Gives up where that falls to `enough_squared`.
    pub fn closest_point(
        &self,
        root: u32,
        point: &Vec3,
        mut limit_squared: f64,
        enough_squared: f64,
        stack: &mut Vec<(f64, u32)>,
    ) -> Option<(Vec3, u32, f64)> {
        let mut best = None;
        stack.clear();
        stack.push((self.nodes[root as usize].bounds.distance_squared(point), root));
        while let Some((bound, index)) = stack.pop() {
            if bound >= limit_squared {
                continue;
            }
            let node = &self.nodes[index as usize];
            for k in self.leaf(node) {
                let near = closest_on_triangle(&self.triangles[k], point);
                let squared = (near - point).norm_squared();
                if squared < limit_squared {
                    (best, limit_squared) = (Some((near, k as u32, squared)), squared);
                }
            }
            if limit_squared <= enough_squared {
                break;
            }
            if node.count == 0 {
                let child = |k| (self.nodes[k as usize].bounds.distance_squared(point), k);
                let (a, b) = (child(node.first), child(node.first + 1));
                stack.extend(if a.0 < b.0 { [b, a] } else { [a, b] });
            }
        }
        best
    }
}

fn item(points: &[Vec3], id: usize) -> Item {
    let (lower, upper) = points.iter().fold(EMPTY, |(lower, upper), p| (lower.inf(p), upper.sup(p)));
    Item { lower, upper, id: id as u32 }
}

fn corners(items: &[Item]) -> (Vec3, Vec3) {
    items.iter().fold(EMPTY, |(lower, upper), item| (lower.inf(&item.lower), upper.sup(&item.upper)))
}

fn bounds(items: &[Item]) -> Aabb {
    let (lower, upper) = corners(items);
    Aabb::between(&lower, &upper)
}

fn area(lower: &Vec3, upper: &Vec3) -> f64 {
    let side = upper - lower;
    if side.x < 0.0 { 0.0 } else { side.x * side.y + side.y * side.z + side.z * side.x }
}

/// Sorts `items` (two at least) into two halves by the surface-area heuristic; returns where the second one starts.
fn partition(items: &mut [Item]) -> usize {
    let middle = |item: &Item| item.lower + item.upper;
    let (lower, upper) = items.iter().fold(EMPTY, |(l, u), item| (l.inf(&middle(item)), u.sup(&middle(item))));
    let mut best = (f64::INFINITY, 0, 0);
    for axis in 0..3 {
        let scale = BINS as f64 / (upper[axis] - lower[axis]);
        if !scale.is_finite() {
            continue;
        }
        let mut bins = [(EMPTY.0, EMPTY.1, 0usize); BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(middle(item)[axis], lower[axis], scale)];
            *bin = (bin.0.inf(&item.lower), bin.1.sup(&item.upper), bin.2 + 1);
        }
        let join = |a: &(Vec3, Vec3, usize), b: &(Vec3, Vec3, usize)| (a.0.inf(&b.0), a.1.sup(&b.1), a.2 + b.2);
        let mut right = [(EMPTY.0, EMPTY.1, 0usize); BINS + 1];
        for k in (0..BINS).rev() {
            right[k] = join(&bins[k], &right[k + 1]);
        }
        let mut left = (EMPTY.0, EMPTY.1, 0);
        for k in 1..BINS {
            left = join(&left, &bins[k - 1]);
            let cost = area(&left.0, &left.1) * left.2 as f64 + area(&right[k].0, &right[k].1) * right[k].2 as f64;
            if left.2 > 0 && right[k].2 > 0 && cost < best.0 {
                best = (cost, axis, k);
            }
        }
    }
    let (cost, axis, split) = best;
    if cost.is_infinite() {
        return items.len() / 2; // all middles coincide
    }
    let scale = BINS as f64 / (upper[axis] - lower[axis]);
    items.sort_by_key(|item| bin_of(middle(item)[axis], lower[axis], scale) >= split);
    items.partition_point(|item| bin_of(middle(item)[axis], lower[axis], scale) < split)
}

fn bin_of(value: f64, lower: f64, scale: f64) -> usize {
    (((value - lower) * scale) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn every_triangle_is_in_one_leaf_and_in_all_boxes_above() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut triangle = || {
            let origin = Vec3::from_fn(|_, _| rng.random::<f64>());
            [0; 3].map(|_| origin + Vec3::from_fn(|_, _| 0.1 * rng.random::<f64>()))
        };
        let same = triangle();
        let groups = [(0..300).map(|_| triangle()).collect(), vec![same; 50], (0..7).map(|_| triangle()).collect()];
        let tree = Bvh::new(&groups);
        let mut seen = vec![0; 357];
        for (group, (root, range)) in tree.groups.iter().enumerate() {
            let mut inside = 0;
            let mut stack = vec![*root];
            while let Some(node) = stack.pop().map(|k| tree.nodes[k as usize]) {
                for k in tree.leaf(&node) {
                    seen[k] += 1;
                    inside += 1;
                    assert!(range.contains(&(k as u32)) && tree.group_of[k] == group as u32);
                    assert!(tree.triangles[k].points.iter().all(|p| node.bounds.contains(p)));
                }
                for child in node.first..node.first + if node.count == 0 { 2 } else { 0 } {
                    let b = &tree.nodes[child as usize].bounds;
                    assert!(node.bounds.contains(&(b.center + b.half * 0.999)));
                    assert!(node.bounds.contains(&(b.center - b.half * 0.999)));
                    stack.push(child);
                }
            }
            assert_eq!(inside, groups[group].len());
        }
        assert!(seen.iter().all(|count| *count == 1));
    }

    #[test]
    fn closest_point_equals_a_scan() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut point = |scale: f64| Vec3::from_fn(|_, _| scale * rng.random::<f64>());
        let group: Vec<[Vec3; 3]> =
            (0..200).map(|_| point(1.0)).collect::<Vec<_>>().iter().map(|o| [0; 3].map(|_| o + point(0.2))).collect();
        let tree = Bvh::new(&[group]);
        let mut stack = Vec::new();
        for _ in 0..500 {
            let p = point(2.0);
            let scan = tree.triangles.iter().map(|t| (closest_on_triangle(t, &p) - p).norm_squared());
            let expected = scan.fold(f64::INFINITY, f64::min);
            let (near, _, squared) = tree.closest_point(0, &p, f64::INFINITY, 0.0, &mut stack).unwrap();
            assert_eq!(squared, expected);
            assert_eq!((near - p).norm_squared(), expected);
            assert!(tree.closest_point(0, &p, expected, 0.0, &mut stack).is_none());
        }
    }
}

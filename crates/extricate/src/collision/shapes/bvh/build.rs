//! Sorts triangles into a tree by the surface-area heuristic, eight children at a time.

use super::triangle_tree::{Bvh, TreeLayout};
use crate::collision::shapes::bounds::{Aabb, EMPTY};
use crate::math::{LANES, Vec3};

const BINS: usize = 16;
/// Ranges of fewer items are sorted along each axis and split after a multiple of eight, so that
/// blocks are full. Larger ranges are binned.
const MIN_BINNED_ITEMS: usize = 256;

#[derive(Clone, Copy)]
struct Item {
    lower: Vec3,
    upper: Vec3,
    id: u32,
}

impl Item {
    fn around(points: &[Vec3], id: usize) -> Self {
        let (lower, upper) = points.iter().fold(EMPTY, |(lower, upper), p| (lower.inf(p), upper.sup(p)));
        Self { lower, upper, id: id as u32 }
    }

    /// Twice the middle along an axis.
    fn middle(&self, axis: usize) -> f64 {
        self.lower[axis] + self.upper[axis]
    }
}

/// Builds the tree of at least one nonempty group of triangles; each group fills a subtree.
pub fn build(groups: &[Vec<[Vec3; 3]>]) -> Bvh {
    Bvh::with_layout(groups, sorted(groups)).expect("every triangle is sorted into one block of its group")
}

/// Finds a layout that makes searches fast.
///
/// # Source
/// I. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007,
/// doi:10.1109/RT.2007.4342588. Deviation: up to eight ranges become the children of one node; the
/// one with the largest surface is split next.
pub(super) fn sorted(groups: &[Vec<[Vec3; 3]>]) -> TreeLayout {
    let mut items: Vec<Item> = groups.iter().enumerate().map(|(id, g)| Item::around(g.as_flattened(), id)).collect();
    let starts = groups.iter().scan(0, |next, group| Some(std::mem::replace(next, *next + group.len()))).collect();
    let mut sorting = Sorting { groups, starts, layout: TreeLayout::default() };
    sorting.add_groups(&mut items);
    sorting.layout
}

struct Sorting<'a> {
    groups: &'a [Vec<[Vec3; 3]>],
    /// Number of the first triangle of each group.
    starts: Vec<usize>,
    layout: TreeLayout,
}

impl Sorting<'_> {
    fn add_groups(&mut self, items: &mut [Item]) {
        let [Item { id, .. }] = items else {
            return self.add_node(items, 1, &|sorting, items| sorting.add_groups(items));
        };
        let (group, start) = (&self.groups[*id as usize], self.starts[*id as usize]);
        let mut triangles: Vec<Item> = group.iter().zip(start..).map(|(t, number)| Item::around(t, number)).collect();
        self.add_triangles(&mut triangles);
    }

    fn add_triangles(&mut self, items: &mut [Item]) {
        if items.len() > LANES {
            return self.add_node(items, LANES, &|sorting, items| sorting.add_triangles(items));
        }
        self.layout.push_block(items.iter().map(|item| item.id));
    }

    /// Adds a node over more than `whole` items. Ranges of at most `whole` items are not split.
    fn add_node(&mut self, items: &mut [Item], whole: usize, add: &dyn Fn(&mut Self, &mut [Item])) {
        let mut ranges = vec![(area(&bounds(items)), items)];
        while ranges.len() < LANES {
            let splits = ranges.iter().enumerate().filter(|(_, (_, items))| items.len() > whole);
            let Some((widest, _)) = splits.max_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b)) else { break };
            let (_, items) = ranges.swap_remove(widest);
            let middle = partition(items);
            let (left, right) = items.split_at_mut(middle);
            ranges.push((area(&bounds(left)), left));
            ranges.push((area(&bounds(right)), right));
        }
        self.layout.push_node(ranges.len());
        for (_, items) in ranges {
            add(self, items);
        }
    }
}

fn bounds(items: &[Item]) -> Aabb {
    let (lower, upper) = items.iter().fold(EMPTY, |(l, u), item| (l.inf(&item.lower), u.sup(&item.upper)));
    Aabb::between(&lower, &upper)
}

fn area(bounds: &Aabb) -> f64 {
    half_area(&(bounds.half * 2.0))
}

fn half_area(side: &Vec3) -> f64 {
    if side.x < 0.0 { 0.0 } else { side.x * side.y + side.y * side.z + side.z * side.x }
}

/// Sorts at least two `items` into two halves by the surface-area heuristic. Returns the start of
/// the second half.
fn partition(items: &mut [Item]) -> usize {
    if items.len() < MIN_BINNED_ITEMS { sorted_partition(items) } else { binned_partition(items) }
}

/// Tries all splits after a multiple of eight along all axes. With at most eight items, every split
/// is tried.
fn sorted_partition(items: &mut [Item]) -> usize {
    let step = if items.len() > LANES { LANES } else { 1 };
    let mut best = (f64::INFINITY, items.len() / 2);
    let [mut order, mut chosen] = [0, 1].map(|_| Vec::with_capacity(items.len()));
    let mut behind = vec![0.0; items.len()];
    for axis in 0..3 {
        sort(items, axis, &mut order);
        if axis == 0 {
            chosen.clone_from(&order);
        }
        let ordered = order.iter().map(|(_, _, k)| &items[*k]);
        let (mut lower, mut upper) = EMPTY;
        for (k, item) in ordered.clone().enumerate().rev() {
            (lower, upper) = (lower.inf(&item.lower), upper.sup(&item.upper));
            behind[k] = half_area(&(upper - lower)) * (items.len() - k) as f64;
        }
        let (mut lower, mut upper) = EMPTY;
        let mut is_best = false;
        for (k, item) in ordered.enumerate() {
            let cost = half_area(&(upper - lower)) * k as f64 + behind[k];
            if k > 0 && k % step == 0 && cost < best.0 {
                best = (cost, k);
                is_best = true;
            }
            (lower, upper) = (lower.inf(&item.lower), upper.sup(&item.upper));
        }
        if is_best {
            std::mem::swap(&mut order, &mut chosen);
        }
    }
    let sorted: Vec<Item> = chosen.iter().map(|(_, _, k)| items[*k]).collect();
    items.copy_from_slice(&sorted);
    best.1
}

/// Sorts the items along an axis by their middles, then by number. Only keys are sorted, since
/// items are large.
fn sort(items: &[Item], axis: usize, order: &mut Vec<(f64, u32, usize)>) {
    order.clear();
    order.extend(items.iter().enumerate().map(|(k, item)| (item.middle(axis), item.id, k)));
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
}

/// Tries the splits between the slices along all axes.
fn binned_partition(items: &mut [Item]) -> usize {
    let mut best = (f64::INFINITY, 0, 0);
    let (lower, upper) = items.iter().fold(EMPTY, |(l, u), item| {
        let middle = item.lower + item.upper;
        (l.inf(&middle), u.sup(&middle))
    });
    for axis in 0..3 {
        let scale = BINS as f64 / (upper[axis] - lower[axis]);
        if !scale.is_finite() {
            continue;
        }
        let mut bins = [(EMPTY.0, EMPTY.1, 0usize); BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(item.middle(axis), lower[axis], scale)];
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
            let cost = half_area(&(left.1 - left.0)) * left.2 as f64
                + half_area(&(right[k].1 - right[k].0)) * right[k].2 as f64;
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
    split_by(items, |item| bin_of(item.middle(axis), lower[axis], scale) >= split)
}

/// Moves the items of the second half behind the others and keeps the order in both. Returns the
/// start of the second half.
fn split_by(items: &mut [Item], is_second: impl Fn(&Item) -> bool) -> usize {
    let (mut second, mut at) = (Vec::new(), 0);
    for k in 0..items.len() {
        if is_second(&items[k]) {
            second.push(items[k]);
        } else {
            items[at] = items[k];
            at += 1;
        }
    }
    items[at..].copy_from_slice(&second);
    at
}

fn bin_of(value: f64, lower: f64, scale: f64) -> usize {
    (((value - lower) * scale) as usize).min(BINS - 1)
}

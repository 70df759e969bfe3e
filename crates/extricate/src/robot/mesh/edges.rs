//! Edges of triangles: which triangles they connect, and how many triangles share one.

use rayon::prelude::*;

/// Groups items whose triangles (which `triangle` returns) are connected by edges. Groups come in
/// the order of their first items.
pub fn edge_connected<T>(all: Vec<T>, triangle: impl Fn(&T) -> [u32; 3]) -> Vec<Vec<T>> {
    connected(all, triangle, |_| true)
}

/// As [`edge_connected`], but an edge only connects if `joins` returns true for its sides.
pub fn connected<T>(all: Vec<T>, triangle: impl Fn(&T) -> [u32; 3], joins: impl Fn(&[Side]) -> bool) -> Vec<Vec<T>> {
    let mut parent: Vec<u32> = (0..all.len() as u32).collect();
    let triangles: Vec<[u32; 3]> = all.iter().map(triangle).collect();
    for ring in sorted_sides(&triangles).chunk_by(same_edge).filter(|ring| joins(ring)) {
        for side in &ring[1..] {
            let (root, other) = (find(&mut parent, ring[0].triangle), find(&mut parent, side.triangle));
            // The smaller index becomes the root, so that groups come in the order of their first
            // items.
            parent[root.max(other) as usize] = root.min(other);
        }
    }
    let mut place = vec![usize::MAX; all.len()];
    let mut groups: Vec<Vec<T>> = Vec::new();
    for (number, one) in all.into_iter().enumerate() {
        let root = find(&mut parent, number as u32) as usize;
        if place[root] == usize::MAX {
            place[root] = groups.len();
            groups.push(Vec::new());
        }
        groups[place[root]].push(one);
    }
    groups
}

pub fn find(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

/// A side of a triangle between `low` and `high`, with `low < high`; the winding runs from `low` to
/// `high` if it is `forward`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    pub low: u32,
    pub high: u32,
    pub triangle: u32,
    /// Number (0 to 2) of the triangle's corner at which the side begins.
    pub edge: u8,
    pub forward: bool,
}

pub fn sorted_sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (index, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (t[k], t[(k + 1) % 3]);
            let (low, high) = (from.min(to), from.max(to));
            sides.push(Side { low, high, triangle: index as u32, edge: k as u8, forward: from < to });
        }
    }
    sides.par_sort_unstable();
    sides
}

pub fn same_edge(a: &Side, b: &Side) -> bool {
    (a.low, a.high) == (b.low, b.high)
}

/// Edges that an odd number of triangles share.
pub fn odd_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = sorted_sides(triangles);
    let rings = sides.chunk_by(same_edge).filter(|ring| !ring.len().is_multiple_of(2));
    rings.map(|ring| [ring[0].low, ring[0].high]).collect()
}

/// Edges of one triangle alone, ascending.
pub fn single_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = sorted_sides(triangles);
    sides.chunk_by(same_edge).filter(|ring| ring.len() == 1).map(|ring| [ring[0].low, ring[0].high]).collect()
}

pub fn all_edges_even(triangles: &[[u32; 3]]) -> bool {
    sorted_sides(triangles).chunk_by(same_edge).all(|ring| ring.len().is_multiple_of(2))
}

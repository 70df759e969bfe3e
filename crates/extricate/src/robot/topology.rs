//! Connected components of triangles, whether they are closed, and which way they face. Not welding.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use robust::{Coord, orient2d};

use super::mesh::Component;
use super::seams::Welding;
use super::{cavities, seams};
use crate::math::Vec3;

/// Triangles around an edge closer than this \[rad\] lie in one plane: files in f32 say no more.
const SAME_ANGLE: f64 = 1e-6;

/// A connected part of a mesh: triangles that hang together by edges.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// Of a closed part such that they face outward, as far as they can be oriented.
    pub triangles: Vec<[u32; 3]>,
    /// Whether it bounds a solid.
    pub closed: bool,
    /// Whether all triangles of a closed part were wound to face into it.
    pub was_inward: bool,
}

impl Part {
    /// Drops triangles that repeat another, and turns what is closed outward.
    pub fn new(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> Self {
        let Boundary { mut triangles, closed, says_its_side } = boundary(triangles);
        let was_inward = closed && orient(vertices, &mut triangles) && says_its_side;
        Self { triangles, closed, was_inward }
    }
}

/// Sorts triangles (of three different vertices each) into components in order of appearance,
/// cavities behind the solids that they are in, drops those that repeat another and those without
/// area, and turns closed components outward, cavities into the cavity. Says what was welded to
/// close some.
pub(super) fn components(
    vertices: &[Vec3],
    triangles: Vec<[u32; 3]>,
) -> (Vec<[u32; 3]>, Vec<Component>, Option<Welding>) {
    let groups = edge_connected(triangles, |triangle| *triangle);
    let solids = groups.into_iter().flat_map(closed_patches);
    let mut parts: Vec<Part> = solids.map(|group| Part::new(vertices, group)).collect();
    let welding = if parts.iter().all(|part| part.closed) { None } else { seams::close(vertices, &mut parts) };
    cavities::turn(vertices, &mut parts);
    let mut sorted = Vec::new();
    let mut components = Vec::new();
    for Part { triangles, closed, .. } in parts {
        let start = sorted.len();
        sorted.extend(triangles.into_iter().filter(|t| !on_a_line(t.map(|index| &vertices[index as usize]))));
        if sorted.len() > start {
            components.push(Component { triangles: start..sorted.len(), closed });
        }
    }
    (sorted, components, welding)
}

/// The solids of an edge-connected group that only touch the rest along edges, and that rest.
///
/// Where four triangles share an edge, nothing says which two belong together if solids overlap
/// there: their walls may lie in one plane. So a solid is what edges of two triangles hold together,
/// if that is closed; the winding of each is then its own matter.
fn closed_patches(group: Vec<[u32; 3]>) -> Vec<Vec<[u32; 3]>> {
    if sorted_sides(&group).chunk_by(same_edge).all(|ring| ring.len() == 2) {
        return vec![group];
    }
    let patches = connected(group, |triangle| *triangle, |ring| ring.len() == 2);
    // Two triangles back to back are a fold, not a solid.
    let is_solid = |patch: &Vec<[u32; 3]>| patch.len() > 3 && all_edges_even(patch);
    let (mut solids, others): (Vec<_>, Vec<_>) = patches.into_iter().partition(is_solid);
    if !others.is_empty() {
        solids.push(others.concat());
    }
    solids
}

/// Groups in order of appearance of what hangs together by edges of the triangles that `triangle`
/// gives.
pub(super) fn edge_connected<T>(all: Vec<T>, triangle: impl Fn(&T) -> [u32; 3]) -> Vec<Vec<T>> {
    connected(all, triangle, |_| true)
}

/// The same by those edges alone of whose sides `joins` says so.
fn connected<T>(all: Vec<T>, triangle: impl Fn(&T) -> [u32; 3], joins: impl Fn(&[Side]) -> bool) -> Vec<Vec<T>> {
    let mut parent: Vec<u32> = (0..all.len() as u32).collect();
    let triangles: Vec<[u32; 3]> = all.iter().map(triangle).collect();
    for ring in sorted_sides(&triangles).chunk_by(same_edge).filter(|ring| joins(ring)) {
        for side in &ring[1..] {
            let (root, other) = (find(&mut parent, ring[0].triangle), find(&mut parent, side.triangle));
            // The earlier one leads, so that groups come in the order of their first.
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

fn find(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

/// What to keep of a component in which triangles may be repeated.
struct Boundary {
    triangles: Vec<[u32; 3]>,
    closed: bool,
    /// Whether all copies of a triangle are wound alike.
    says_its_side: bool,
}

/// Whether that is closed, too.
///
/// Double-sided files repeat each triangle: one copy says it all. But where two solids share a wall, both copies are
/// needed to make every edge even; they are kept if more than repeated triangles makes up the component.
fn boundary(triangles: Vec<[u32; 3]>) -> Boundary {
    let key = |t: &[u32; 3]| {
        let mut key = *t;
        key.sort_unstable();
        key
    };
    let mut copies: HashMap<[u32; 3], usize> = HashMap::with_capacity(triangles.len());
    triangles.iter().for_each(|t| *copies.entry(key(t)).or_default() += 1);
    if copies.len() == triangles.len() {
        let closed = all_edges_even(&triangles);
        return Boundary { triangles, closed, says_its_side: true };
    }
    let mut seen = HashSet::with_capacity(copies.len());
    let single: Vec<_> = triangles.iter().filter(|t| seen.insert(key(t))).copied().collect();
    if all_edges_even(&single) {
        let turned = |t: &[u32; 3]| {
            let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
        };
        let kinds: HashSet<[u32; 3]> = triangles.iter().map(turned).collect();
        return Boundary { says_its_side: kinds.len() == single.len(), triangles: single, closed: true };
    }
    if copies.values().any(|count| count % 2 == 1) && all_edges_even(&triangles) {
        return Boundary { triangles, closed: true, says_its_side: true };
    }
    Boundary { triangles: single, closed: false, says_its_side: false }
}

/// A triangle's side, in the direction of its winding or (`forward == false`) against it; `low < high`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    low: u32,
    high: u32,
    triangle: u32,
    forward: bool,
}

fn sorted_sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (index, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (t[k], t[(k + 1) % 3]);
            let (low, high) = (from.min(to), from.max(to));
            sides.push(Side { low, high, triangle: index as u32, forward: from < to });
        }
    }
    sides.sort_unstable();
    sides
}

fn same_edge(a: &Side, b: &Side) -> bool {
    (a.low, a.high) == (b.low, b.high)
}

/// Edges that an odd number of triangles share.
pub(super) fn odd_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = sorted_sides(triangles);
    let rings = sides.chunk_by(same_edge).filter(|ring| !ring.len().is_multiple_of(2));
    rings.map(|ring| [ring[0].low, ring[0].high]).collect()
}

fn all_edges_even(triangles: &[[u32; 3]]) -> bool {
    sorted_sides(triangles).chunk_by(same_edge).all(|ring| ring.len().is_multiple_of(2))
}

/// Turns the triangles of a closed component to face outward, as far as they can be oriented;
/// whether all of them faced inward before.
///
/// Two triangles that are neighbours around an edge bound one wedge, so they run along the edge in opposite directions;
/// that holds for edges of more than two triangles too, taken in order of angle. Each set of triangles that hangs
/// together by edges is then turned as a whole to have a positive volume. A component that contradicts itself (a Klein
/// bottle, walls that overlap in part) is turned as a whole only: the file may know better.
fn orient(vertices: &[Vec3], triangles: &mut [[u32; 3]]) -> bool {
    let neighbours = neighbours_around_edges(vertices, triangles);
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    let mut sets: Vec<Vec<u32>> = Vec::new();
    let mut consistent = true;
    for seed in 0..triangles.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut set = vec![seed as u32];
        let mut next = 0;
        while next < set.len() {
            let own = turned[set[next] as usize] == Some(true);
            for &(other, turn) in &neighbours[set[next] as usize] {
                match turned[other as usize] {
                    None => {
                        turned[other as usize] = Some(own != turn);
                        set.push(other);
                    }
                    Some(there) => consistent &= there == (own != turn),
                }
            }
            next += 1;
        }
        sets.push(set);
    }
    if !consistent {
        turned.fill(Some(false));
        sets = vec![(0..triangles.len() as u32).collect()];
    }
    let mut was_inward = consistent && turned.iter().all(|turn| *turn == Some(false));
    for set in sets {
        let origin = vertices[triangles[set[0] as usize][0] as usize];
        let mut volume = 0.0;
        for &t in &set {
            let [a, b, c] = triangles[t as usize].map(|index| vertices[index as usize] - origin);
            let part = a.cross(&b).dot(&c);
            volume += if turned[t as usize] == Some(true) { -part } else { part };
        }
        was_inward &= volume < 0.0;
        for &t in &set {
            if (turned[t as usize] == Some(true)) != (volume < 0.0) {
                triangles[t as usize].swap(1, 2);
            }
        }
    }
    was_inward
}

/// For each triangle of a closed component those next to it around its edges, and whether one of the two has to be
/// turned for both to face the same way.
fn neighbours_around_edges(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec<(u32, bool)>> {
    let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::with_capacity(3); triangles.len()];
    let mut link = |a: &Side, b: &Side| {
        let turn = a.forward == b.forward;
        neighbours[a.triangle as usize].push((b.triangle, turn));
        neighbours[b.triangle as usize].push((a.triangle, turn));
    };
    let mut sides = sorted_sides(triangles);
    let mut single = Vec::new();
    for ring in sides.chunk_by_mut(same_edge) {
        if let [a, b] = ring {
            link(a, b);
            continue;
        }
        // Triangles at one angle are a wall of no thickness: they cancel in pairs, and the rest does not notice.
        single.clear();
        let angles = sort_by_angle(vertices, triangles, ring);
        let mut pair = None;
        for (k, side) in ring.iter().enumerate() {
            match pair.take() {
                Some(first) if angles[k] - angles[k - 1] < SAME_ANGLE => {
                    link(first, side);
                    single.pop();
                }
                _ => {
                    pair = Some(side);
                    single.push(*side);
                }
            }
        }
        for k in 0..single.len() {
            link(&single[k], &single[(k + 1) % single.len()]);
        }
    }
    neighbours
}

/// Sorts the sides of one edge by the angle of their triangles around it, and gives these angles \[rad\].
fn sort_by_angle(vertices: &[Vec3], triangles: &[[u32; 3]], ring: &mut [Side]) -> Vec<f64> {
    let (low, high) = (ring[0].low, ring[0].high);
    let base = vertices[low as usize];
    let axis = vertices[high as usize] - base;
    let arm = |side: &Side| {
        let apex = triangles[side.triangle as usize].into_iter().find(|&v| v != low && v != high).unwrap_or(low);
        vertices[apex as usize] - base
    };
    let x = axis.cross(&arm(&ring[0])).cross(&axis).normalize();
    let y = axis.cross(&x).normalize();
    // Shifted by a hair, so that no two at one angle end up on both sides of a full turn.
    let angle = |side: &Side| (y.dot(&arm(side)).atan2(x.dot(&arm(side))) + SAME_ANGLE).rem_euclid(TAU);
    ring.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    ring.iter().map(angle).collect()
}

/// Whether three points lie exactly on a line (so do their three projections, and only then).
fn on_a_line([a, b, c]: [&Vec3; 3]) -> bool {
    let flat = |i: usize, j: usize| {
        let at = |p: &Vec3| Coord { x: p[i], y: p[j] };
        orient2d(at(a), at(b), at(c)) == 0.0
    };
    flat(0, 1) && flat(1, 2) && flat(2, 0)
}

#[cfg(test)]
mod tests;

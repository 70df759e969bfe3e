//! Connected triangles: whether they bound a solid, and which way they face.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use super::edges::{Side, all_edges_even, same_edge, sorted_sides};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};

/// Angle \[rad\] around an edge below which two triangles lie in one plane: files in f32 resolve no
/// smaller ones.
pub(super) const COPLANAR_ANGLE_RAD: f64 = 1e-6;

/// A part of a mesh: triangles that edges connect.
#[derive(Debug, Clone)]
pub struct Part {
    /// Triangles; those of a closed part face outward if they can be oriented.
    pub triangles: Vec<[u32; 3]>,
    pub closed: bool,
    /// Whether all triangles of a closed part were wound to face into it.
    pub was_inward: bool,
    /// Whether the file's windings of a closed part agree with the order of triangles around edges:
    /// false if some triangles had to be reversed and none is repeated.
    pub agrees: bool,
    /// Number of triangles inside it that are left out.
    pub walls: usize,
}

impl Part {
    /// Drops repeated triangles, and orients a closed part outward.
    pub fn new(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> Self {
        let Boundary { mut triangles, closed, says_its_side, is_repeated } = boundary(triangles);
        let mut part = Self { triangles: Vec::new(), closed, was_inward: false, agrees: true, walls: 0 };
        if closed {
            let turned = orient(vertices, &mut triangles);
            part.was_inward = turned == Turned::All && says_its_side;
            part.agrees = turned != Turned::Some || is_repeated;
        }
        Self { triangles, ..part }
    }
}

/// The triangles to keep of a component that may repeat some.
struct Boundary {
    triangles: Vec<[u32; 3]>,
    closed: bool,
    /// Whether all copies of a triangle are wound alike.
    says_its_side: bool,
    is_repeated: bool,
}

/// The triangles that had to be reversed to face outward.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Turned {
    None,
    Some,
    All,
}

/// Drops triangles that repeat another, however wound.
pub(super) fn distinct(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut seen = HashSet::with_capacity(triangles.len());
    triangles.iter().filter(|t| seen.insert(sorted(t))).copied().collect()
}

pub(super) fn sorted(triangle: &[u32; 3]) -> [u32; 3] {
    let mut key = *triangle;
    key.sort_unstable();
    key
}

/// Decides which copies of repeated triangles to keep, and whether the rest is closed.
///
/// Double-sided files repeat every triangle, and one copy is enough. If two solids share a wall,
/// both copies are needed to make every edge even; they are kept if some triangle occurs an odd
/// number of times.
fn boundary(triangles: Vec<[u32; 3]>) -> Boundary {
    let mut copies: HashMap<[u32; 3], usize> = HashMap::with_capacity(triangles.len());
    triangles.iter().for_each(|t| *copies.entry(sorted(t)).or_default() += 1);
    if copies.len() == triangles.len() {
        let closed = all_edges_even(&triangles);
        return Boundary { triangles, closed, says_its_side: true, is_repeated: false };
    }
    let single = distinct(&triangles);
    if all_edges_even(&single) {
        let turned = |t: &[u32; 3]| {
            let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
        };
        let kinds: HashSet<[u32; 3]> = triangles.iter().map(turned).collect();
        let says_its_side = kinds.len() == single.len();
        return Boundary { says_its_side, triangles: single, closed: true, is_repeated: true };
    }
    if copies.values().any(|count| count % 2 == 1) && all_edges_even(&triangles) {
        return Boundary { triangles, closed: true, says_its_side: true, is_repeated: true };
    }
    Boundary { triangles: single, closed: false, says_its_side: false, is_repeated: true }
}

/// Orients the triangles of a closed component outward, as far as possible, and returns which were
/// reversed.
///
/// Two triangles that are neighbours around an edge bound one wedge, so they run along the edge in
/// opposite directions. That holds for edges of more than two triangles too, taken in order of
/// angle. Each connected set of triangles is then oriented as a whole to have a positive volume. A
/// component that contradicts itself (a Klein bottle, walls that overlap in part) is reversed as a
/// whole or not at all: the file may know better.
fn orient(vertices: &[Vec3], triangles: &mut [[u32; 3]]) -> Turned {
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
    let as_wound = consistent && turned.iter().all(|turn| *turn == Some(false));
    let (mut was_inward, mut was_outward) = (as_wound, as_wound);
    for set in sets {
        let origin = vertices[triangles[set[0] as usize][0] as usize];
        let mut volume = 0.0;
        for &t in &set {
            let [a, b, c] = triangles[t as usize].map(|index| vertices[index as usize] - origin);
            let part = a.cross(&b).dot(&c);
            volume += if turned[t as usize] == Some(true) { -part } else { part };
        }
        was_inward &= volume < 0.0;
        was_outward &= volume >= 0.0;
        for &t in &set {
            if (turned[t as usize] == Some(true)) != (volume < 0.0) {
                triangles[t as usize].swap(1, 2);
            }
        }
    }
    match (was_inward, was_outward) {
        (true, _) => Turned::All,
        (false, true) => Turned::None,
        (false, false) => Turned::Some,
    }
}

/// For each triangle of a closed component, its neighbours around its edges, and whether one of the
/// two must be reversed for both to face the same way.
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
        // Two triangles at one angle are a wall without thickness: they pair up, and the others
        // ignore them.
        single.clear();
        let angles = sort_by_angle(vertices, triangles, ring);
        let mut pair = None;
        for (k, side) in ring.iter().enumerate() {
            match pair.take() {
                Some(first) if angles[k] - angles[k - 1] < COPLANAR_ANGLE_RAD => {
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

/// Sorts the sides of one edge by the angle of their triangles around it, and returns these angles
/// \[rad\].
pub(super) fn sort_by_angle(vertices: &[Vec3], triangles: &[[u32; 3]], ring: &mut [Side]) -> Vec<f64> {
    let (low, high) = (ring[0].low, ring[0].high);
    let base = vertices[low as usize];
    let axis = vertices[high as usize] - base;
    let arm = |side: &Side| {
        let apex = triangles[side.triangle as usize].into_iter().find(|&v| v != low && v != high).unwrap_or(low);
        vertices[apex as usize] - base
    };
    let x = axis.cross(&arm(&ring[0])).cross(&axis).normalize();
    let y = axis.cross(&x).normalize();
    // A small shift keeps equal angles together, which rounding could put at both ends of the
    // range.
    let angle = |side: &Side| (y.dot(&arm(side)).atan2(x.dot(&arm(side))) + COPLANAR_ANGLE_RAD).rem_euclid(TAU);
    ring.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    ring.iter().map(angle).collect()
}

/// Triangles of a mesh that edges connect.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Component {
    /// Range in the triangles of the mesh.
    pub triangles: std::ops::Range<usize>,
    /// Whether it bounds a solid: every edge has two triangles, or an even number if the surface
    /// touches itself. So every ray from afar crosses it an even number of times.
    pub closed: bool,
}

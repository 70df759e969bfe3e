//! Connected components of triangles, whether they are closed, and which way they face. Not welding.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use robust::{Coord, orient2d};

use super::mesh::Component;
use crate::math::Vec3;

/// Triangles around an edge closer than this \[rad\] lie in one plane: files in f32 say no more.
const SAME_ANGLE: f64 = 1e-6;

/// Sorts triangles (of three different vertices each) into components in order of appearance, drops those that repeat
/// another and those without area, and turns closed components outward.
pub(super) fn components(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, Vec<Component>) {
    let mut parent: Vec<u32> = (0..vertices.len() as u32).collect();
    for [a, b, c] in &triangles {
        let root = find(&mut parent, *a);
        for other in [b, c] {
            let other = find(&mut parent, *other);
            parent[other as usize] = root;
        }
    }
    let mut groups: Vec<Vec<[u32; 3]>> = Vec::new();
    let mut group_of_root = HashMap::new();
    for triangle in triangles {
        let group = *group_of_root.entry(find(&mut parent, triangle[0])).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(triangle);
    }
    let mut sorted = Vec::new();
    let mut components = Vec::new();
    for group in groups {
        let (mut group, closed) = boundary(group);
        if closed {
            orient(vertices, &mut group);
        }
        let start = sorted.len();
        sorted.extend(group.into_iter().filter(|t| !on_a_line(t.map(|index| &vertices[index as usize]))));
        if sorted.len() > start {
            components.push(Component { triangles: start..sorted.len(), closed });
        }
    }
    (sorted, components)
}

fn find(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

/// What to keep of a component in which triangles may be repeated, and whether that is closed.
///
/// Double-sided files repeat each triangle: one copy says it all. But where two solids share a wall, both copies are
/// needed to make every edge even; they are kept if more than repeated triangles makes up the component.
fn boundary(triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, bool) {
    let key = |t: &[u32; 3]| {
        let mut key = *t;
        key.sort_unstable();
        key
    };
    let mut copies: HashMap<[u32; 3], usize> = HashMap::with_capacity(triangles.len());
    triangles.iter().for_each(|t| *copies.entry(key(t)).or_default() += 1);
    if copies.len() == triangles.len() {
        let closed = all_edges_even(&triangles);
        return (triangles, closed);
    }
    let mut seen = HashSet::with_capacity(copies.len());
    let single: Vec<_> = triangles.iter().filter(|t| seen.insert(key(t))).copied().collect();
    if all_edges_even(&single) {
        return (single, true);
    }
    if copies.values().any(|count| count % 2 == 1) && all_edges_even(&triangles) {
        return (triangles, true);
    }
    (single, false)
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

fn all_edges_even(triangles: &[[u32; 3]]) -> bool {
    sorted_sides(triangles).chunk_by(same_edge).all(|ring| ring.len().is_multiple_of(2))
}

/// Turns the triangles of a closed component to face outward, as far as they can be oriented.
///
/// Two triangles that are neighbours around an edge bound one wedge, so they run along the edge in opposite directions;
/// that holds for edges of more than two triangles too, taken in order of angle. Each set of triangles that hangs
/// together by edges is then turned as a whole to have a positive volume. A component that contradicts itself (a Klein
/// bottle, walls that overlap in part) is turned as a whole only: the file may know better.
fn orient(vertices: &[Vec3], triangles: &mut [[u32; 3]]) {
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
    for set in sets {
        let origin = vertices[triangles[set[0] as usize][0] as usize];
        let mut volume = 0.0;
        for &t in &set {
            let [a, b, c] = triangles[t as usize].map(|index| vertices[index as usize] - origin);
            let part = a.cross(&b).dot(&c);
            volume += if turned[t as usize] == Some(true) { -part } else { part };
        }
        for &t in &set {
            if (turned[t as usize] == Some(true)) != (volume < 0.0) {
                triangles[t as usize].swap(1, 2);
            }
        }
    }
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
mod tests {
    use super::super::mesh::TriangleMesh;
    use super::*;

    fn volume(mesh: &TriangleMesh, component: &Component) -> f64 {
        component.triangles.clone().map(|t| mesh.corners(t)).map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum()
    }

    /// Unit cube with a corner at `corner`, as soup; `faces` lists those of -x, +x, -y, +y, -z, +z that are there.
    fn cube(corner: [f64; 3], faces: &[usize]) -> Vec<Vec3> {
        let mut soup = Vec::new();
        for &face in faces {
            let (axis, side) = (face / 2, (face % 2) as f64);
            let (u, v) =
                if face % 2 == 1 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            let at = |p: f64, q: f64| {
                let mut point = Vec3::from(corner);
                point[axis] += side;
                point[u] += p;
                point[v] += q;
                point
            };
            soup.extend([at(0., 0.), at(1., 0.), at(1., 1.), at(0., 0.), at(1., 1.), at(0., 1.)]);
        }
        soup
    }

    fn mesh(soup: Vec<Vec3>) -> TriangleMesh {
        let triangles = (0..soup.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        TriangleMesh::new(soup, triangles)
    }

    const ALL: &[usize] = &[0, 1, 2, 3, 4, 5];

    #[test]
    fn closed_components_face_outward_whatever_the_file_says() {
        let mut soup = cube([0.; 3], ALL);
        let first = soup.len();
        soup.extend(cube([3., 0., 0.], ALL));
        soup[first..].reverse();
        soup.swap(0, 1);
        soup.extend(cube([6., 0., 0.], &[0, 1, 2]));
        let mesh = mesh(soup);
        assert_eq!(mesh.components.iter().map(|c| c.closed).collect::<Vec<_>>(), [true, true, false]);
        assert!(!mesh.is_closed());
        assert!((volume(&mesh, &mesh.components[0]) - 1.0).abs() < 1e-12);
        assert!((volume(&mesh, &mesh.components[1]) - 1.0).abs() < 1e-12);
        assert_eq!(mesh.components[2].triangles, 24..30);
    }

    #[test]
    fn solids_that_touch_at_an_edge_a_corner_or_a_wall_are_closed() {
        for (corner, faces) in [([1., 1., 0.], ALL), ([1., 1., 1.], ALL), ([1., 0., 0.], ALL)] {
            let mut soup = cube([0.; 3], ALL);
            let mut second = cube(corner, faces);
            second.reverse();
            soup.extend(second);
            let mesh = mesh(soup);
            assert_eq!((mesh.components.len(), mesh.triangles.len()), (1, 24));
            assert!(mesh.is_closed());
            assert!((volume(&mesh, &mesh.components[0]) - 2.0).abs() < 1e-12, "{corner:?}");
        }
    }

    #[test]
    fn double_sided_files_say_each_triangle_once() {
        let two_sided = |faces: &[usize]| {
            let mut soup = cube([0.; 3], faces);
            let mut back = soup.clone();
            back.reverse();
            soup.extend(back);
            mesh(soup)
        };
        let solid = two_sided(ALL);
        assert!(solid.is_closed());
        assert_eq!(solid.triangles.len(), 12);
        let open = two_sided(&[0, 2, 4]);
        assert!(!open.is_closed());
        assert_eq!(open.triangles.len(), 6);
    }

    #[test]
    fn a_flat_triangle_bridges_a_t_junction() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0.5, 0., 0.]].map(Vec3::from).to_vec();
        let split = vec![[0, 2, 1], [0, 4, 3], [4, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!(!TriangleMesh::new(points.clone(), split.clone()).is_closed());
        let bridged = TriangleMesh::new(points, [split, vec![[0, 1, 4]]].concat());
        assert!(bridged.is_closed());
        assert_eq!(bridged.triangles.len(), 5);
        assert!((volume(&bridged, &bridged.components[0]) - 1.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn slivers_stay_and_a_moebius_strip_does_no_harm() {
        let sliver = [[0., 0., 0.], [1., 0., 0.], [0.5, 1e-8, 0.]].map(Vec3::from).to_vec();
        assert_eq!(TriangleMesh::new(sliver, vec![[0, 1, 2]]).triangles.len(), 1);
        // The projective plane: closed, cannot be oriented.
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1], [1, 2, 4], [2, 3, 5], [3, 4, 1], [4, 5, 2]];
        let points = (0..6).map(|k| Vec3::new((k as f64).cos(), (k as f64).sin(), (k * k) as f64)).collect();
        let plane = TriangleMesh::new(points, [faces.to_vec(), vec![[5, 1, 3]]].concat());
        assert!(plane.is_closed());
        assert!(plane.triangles[0] == [0, 1, 2] || plane.triangles[0] == [0, 2, 1]);
    }
}

//! How wide the openings of a mesh are. `seams` closes narrow ones.

use super::edges::{same_edge, single_edges, sorted_sides};
use crate::math::Vec3;
use crate::robot::TriangleMesh;

/// Largest number of open edges to measure, spread evenly over all.
const MAX_EDGES: usize = 256;
/// Largest number of edge pairs to compare: with many open edges, fewer are measured.
const MAX_EDGE_PAIRS: usize = 20_000_000;
/// Smallest number of open edges to measure, however many there are.
const MIN_EDGES: usize = 8;
/// Largest cosine of the angle between edges that run against each other. It is above -0.5, so that
/// the sides of a regular triangle do.
const MAX_OPPOSING_COSINE: f64 = -0.25;

/// Counts the edges of open components with three triangles or more: walls inside, or sheets that
/// meet.
pub fn branches(mesh: &TriangleMesh) -> usize {
    let open = mesh.components.iter().filter(|component| !component.closed);
    let of = |triangles: &[[u32; 3]]| sorted_sides(triangles).chunk_by(same_edge).filter(|ring| ring.len() > 2).count();
    open.map(|component| of(&mesh.triangles[component.triangles.clone()])).sum()
}

/// Width of the widest opening \[m\], from up to 256 of the open edges. It is the largest distance
/// from one of them to the nearest that runs against it, as across a slit or a hole. `None` if no
/// edge is open.
pub fn widest_gap(mesh: &TriangleMesh) -> Option<f64> {
    let mut edges: Vec<[Vec3; 2]> = Vec::new();
    for component in mesh.components.iter().filter(|component| !component.closed) {
        let triangles = &mesh.triangles[component.triangles.clone()];
        let open: Vec<[u32; 2]> = single_edges(triangles);
        // Edges keep the direction in which their triangles run along them.
        for t in triangles {
            for (from, to) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                if open.binary_search(&[from.min(to), from.max(to)]).is_ok() {
                    edges.push([from, to].map(|index| mesh.vertices[index as usize]));
                }
            }
        }
    }
    let compared_edges = (MAX_EDGE_PAIRS / edges.len().max(1)).clamp(MIN_EDGES, MAX_EDGES);
    let step = edges.len().div_ceil(compared_edges).max(1);
    (0..edges.len()).step_by(step).map(|k| gap(&edges, k)).reduce(f64::max)
}

/// Distance from the middle of an edge to the nearest one that runs against it; the length of the
/// edge if none does.
fn gap(edges: &[[Vec3; 2]], at: usize) -> f64 {
    let [from, to] = edges[at];
    let (middle, along) = ((from + to) * 0.5, to - from);
    let against = |[a, b]: &&[Vec3; 2]| (b - a).dot(&along) < MAX_OPPOSING_COSINE * (b - a).norm() * along.norm();
    let distance = |[a, b]: &[Vec3; 2]| {
        let edge = b - a;
        let share = ((middle - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        (a + edge * share - middle).norm()
    };
    let others = edges.iter().enumerate().filter(|(k, _)| *k != at).map(|(_, edge)| edge);
    others.filter(against).map(distance).reduce(f64::min).unwrap_or_else(|| along.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of side 1 without its top, or with a separate top at a height of `shift` above the
    /// rim.
    fn cube(shift: Option<f64>) -> TriangleMesh {
        let corner = |k: u32, up: f64| Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2) + up);
        let mut vertices: Vec<Vec3> = (0..8).map(|k| corner(k, 0.0)).collect();
        vertices.extend((4..8).map(|k| corner(k, shift.unwrap_or(0.0))));
        let mut faces = vec![[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        faces.extend(shift.map(|_| [8, 9, 11, 10]));
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        TriangleMesh::new(vertices, faces.into_iter().flat_map(halves).collect())
    }

    #[test]
    fn gaps_are_as_wide_as_what_is_missing() {
        assert!((widest_gap(&cube(None)).unwrap() - 1.0).abs() < 1e-12);
        for shift in [1e-2, 1e-5] {
            assert!((widest_gap(&cube(Some(shift))).unwrap() / shift - 1.0).abs() < 1e-6, "{shift}");
        }
        let closed = cube(Some(0.0));
        assert!(closed.is_closed() && widest_gap(&closed).is_none());
        let triangle = TriangleMesh::new(vec![Vec3::zeros(), Vec3::x(), Vec3::y()], vec![[0, 1, 2]]);
        let gap = widest_gap(&triangle).unwrap();
        assert!((0.3..=1.5).contains(&gap), "{gap}");
    }

    /// The book has three pages on one spine: it has open edges, and the spine is none of them.
    #[test]
    fn edges_of_three_triangles_are_not_open() {
        let vertices = vec![Vec3::zeros(), Vec3::z(), Vec3::x(), Vec3::y(), -Vec3::x()];
        let book = TriangleMesh::new(vertices, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]);
        assert_eq!((branches(&book), branches(&cube(None)), branches(&cube(Some(0.0)))), (1, 0, 0));
        assert!(widest_gap(&book).unwrap() > 0.1);
    }
}

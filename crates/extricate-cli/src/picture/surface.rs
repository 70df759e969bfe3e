//! The surfaces of a scene at a configuration, as small triangles in world coordinates, each with a
//! look.

use std::collections::BTreeMap;

use extricate::Scene;
use extricate::geometry::{TriangleMesh, Vec3};
use extricate::internals::kinematics::forward;

/// Segments around a round shape.
const SEGMENTS: usize = 16;
/// Longest edge of a facet as a share of the scene's size: facets are sorted by their middle, which
/// is right only for small ones.
const LONGEST_EDGE: f64 = 0.11;
/// Halvings of one triangle at most: a floor of a kilometre gets 4,096 facets and no more.
const MOST_SPLITS: u32 = 12;

/// Edges between faces that turn more than this are drawn: its cosine (30 degrees).
const SHARP: f64 = 0.866;

/// How a body is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// As it is.
    Plain,
    /// Part of a colliding pair.
    Hit,
    /// Where the robot was.
    Ghost,
}

/// A triangle of a body.
#[derive(Debug, Clone)]
pub struct Facet {
    /// World coordinates \[m\], counterclockwise seen from outside.
    pub corners: [Vec3; 3],
    /// Index of the body, for a colour of its own.
    pub body: usize,
    /// Whether the body is an obstacle, shown translucent.
    pub obstacle: bool,
    /// How it is shown.
    pub look: Look,
}

/// Facets of some bodies, and the sharp edges of obstacles, which translucent faces do not show.
#[derive(Debug, Clone, Default)]
pub struct Surface {
    /// In the order of bodies.
    pub facets: Vec<Facet>,
    /// World coordinates \[m\].
    pub edges: Vec<[Vec3; 2]>,
}

impl Facet {
    /// Unit normal, outward; zero where the triangle is degenerate.
    pub fn normal(&self) -> Vec3 {
        let [a, b, c] = &self.corners;
        (b - a).cross(&(c - a)).try_normalize(1e-300).unwrap_or_else(Vec3::zeros)
    }

    /// The middle.
    pub fn middle(&self) -> Vec3 {
        (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0
    }
}

impl Surface {
    /// All bodies at `q` (length `nq`).
    pub fn new(scene: &Scene, q: &[f64], look: &dyn Fn(usize) -> Look) -> Self {
        let mut surface = Self::default();
        (0..scene.bodies.len()).for_each(|body| surface.append(scene, q, body, look(body)));
        surface.split_long_edges();
        surface
    }

    /// Only bodies that move.
    pub fn robots(scene: &Scene, q: &[f64], look: Look) -> Self {
        let mut surface = Self::default();
        for body in (0..scene.bodies.len()).filter(|&body| scene.bodies[body].frame != 0) {
            surface.append(scene, q, body, look);
        }
        surface
    }

    fn append(&mut self, scene: &Scene, q: &[f64], index: usize, look: Look) {
        let mut poses = Vec::new();
        forward(scene, q, &mut poses);
        let body = &scene.bodies[index];
        for part in &body.parts {
            let pose = poses[body.frame].then(&part.pose_frame_part);
            let mesh = part.geometry.tessellate(SEGMENTS);
            let world: Vec<Vec3> = mesh.vertices.iter().map(|v| pose.point(v)).collect();
            for triangle in &mesh.triangles {
                let corners = triangle.map(|i| world[i as usize]);
                self.facets.push(Facet { corners, body: index, obstacle: body.robot.is_none(), look });
            }
            if body.robot.is_none() {
                self.edges.extend(sharp_edges(&mesh).into_iter().map(|ends| ends.map(|i| world[i as usize])));
            }
        }
    }

    fn split_long_edges(&mut self) {
        let robot = self.facets.iter().filter(|f| !f.obstacle).flat_map(|f| f.corners);
        let (low, high) = bounds(robot);
        let longest = LONGEST_EDGE * (high - low).norm();
        if !(longest > 0.0 && longest.is_finite()) {
            return;
        }
        let mut split = Vec::with_capacity(2 * self.facets.len());
        for facet in self.facets.drain(..) {
            split_into(facet, longest, MOST_SPLITS, &mut split);
        }
        self.facets = split;
        let edges = std::mem::take(&mut self.edges);
        for [from, to] in edges {
            let pieces = ((to - from).norm() / longest).ceil().clamp(1.0, f64::from(1 << (MOST_SPLITS / 2)));
            let at = |k: f64| from + (to - from) * (k / pieces);
            self.edges.extend((0..pieces as usize).map(|k| [at(k as f64), at(k as f64 + 1.0)]));
        }
    }
}

/// Corners of the axis-aligned box about `points`; infinite where there are none.
pub fn bounds(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    points.fold(none, |(low, high), p| (low.inf(&p), high.sup(&p)))
}

/// Edges where the surface turns sharply or ends, as pairs of vertices.
fn sharp_edges(mesh: &TriangleMesh) -> Vec<[u32; 2]> {
    let mut normals: BTreeMap<[u32; 2], Vec<Vec3>> = BTreeMap::new();
    for &[i, j, k] in &mesh.triangles {
        let [a, b, c] = [i, j, k].map(|v| mesh.vertices[v as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-300).unwrap_or_else(Vec3::zeros);
        for [from, to] in [[i, j], [j, k], [k, i]] {
            normals.entry([from.min(to), from.max(to)]).or_default().push(normal);
        }
    }
    let is_sharp = |normals: &[Vec3]| match normals {
        [one, other] => one.dot(other) < SHARP,
        _ => true,
    };
    normals.into_iter().filter(|(_, normals)| is_sharp(normals)).map(|(edge, _)| edge).collect()
}

/// Halves the longest edge until none exceeds `longest`, at most `left` times.
fn split_into(facet: Facet, longest: f64, left: u32, out: &mut Vec<Facet>) {
    let [a, b, c] = facet.corners;
    let edges = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
    let k = (0..3).max_by(|&i, &j| edges[i].total_cmp(&edges[j])).expect("three edges");
    if left == 0 || edges[k] <= longest {
        out.push(facet);
        return;
    }
    let (from, to, apex) = [(a, b, c), (b, c, a), (c, a, b)][k];
    let middle = 0.5 * (from + to);
    for corners in [[from, middle, apex], [middle, to, apex]] {
        split_into(Facet { corners, ..facet }, longest, left - 1, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facet(corners: [[f64; 3]; 3]) -> Facet {
        Facet { corners: corners.map(Vec3::from), body: 0, obstacle: true, look: Look::Plain }
    }

    #[test]
    fn splitting_keeps_area_and_orientation() {
        let whole = facet([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]]);
        let mut parts = Vec::new();
        split_into(whole, 0.2, 20, &mut parts);
        let area: f64 =
            parts.iter().map(|f| 0.5 * (f.corners[1] - f.corners[0]).cross(&(f.corners[2] - f.corners[0])).z).sum();
        assert!((area - 0.25).abs() < 1e-12);
        assert!(parts.iter().all(|f| f.normal() == Vec3::z()));
        assert!(parts.iter().all(|f| (f.corners[1] - f.corners[0]).norm() <= 0.2));
    }

    #[test]
    fn a_box_has_twelve_sharp_edges() {
        let half_extents = Vec3::new(0.1, 0.2, 0.3);
        let mesh = extricate::geometry::Geometry::Box { half_extents }.tessellate(8);
        assert_eq!(sharp_edges(&mesh).len(), 12);
    }

    #[test]
    fn splitting_ends_for_huge_triangles() {
        let mut parts = Vec::new();
        split_into(facet([[0.0; 3], [1e9, 0.0, 0.0], [0.0, 1e9, 0.0]]), 1e-3, 6, &mut parts);
        assert_eq!(parts.len(), 64);
    }
}

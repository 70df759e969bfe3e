//! The slow reference: all pairs of triangles of two meshes in f64, and containment by winding
//! numbers. It shares no code with the checker: it has its own distances, crossing test and inside
//! test.

use extricate::geometry::{Pose, TriangleMesh};
use extricate::internals::math::Vec3;

type Corners = [Vec3; 3];

/// Reference result for two placed meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Least distance of two triangles \[m\]: 0 if any cross, infinite if it exceeds `reach`.
    pub distance: f64,
    /// Whether an edge passes through a triangle, and would still do so if anything moved by the
    /// tolerance.
    pub crosses_clearly: bool,
    /// Whether a component of one mesh lies in a closed component of the other, judged by one
    /// vertex. Not evaluated if the triangles decide.
    pub contained: bool,
}

/// Compares every triangle of `a` with every one of `b`, which `pose` places in the frame of `a`.
///
/// Triangles are skipped if their bounding balls are farther apart than `reach` \[m\] or the least
/// distance so far. The comparison ends at a pair that crosses clearly or is nearer than `enough`
/// \[m\].
pub fn truth(a: &TriangleMesh, b: &TriangleMesh, pose: &Pose, [enough, reach]: [f64; 2], tolerance: f64) -> Truth {
    let moved = moved(b, pose);
    let first: Vec<(Corners, Vec3, f64)> = (0..a.triangles.len()).map(|t| with_ball(a.corners(t))).collect();
    let second: Vec<(Corners, Vec3, f64)> = (0..moved.triangles.len()).map(|t| with_ball(moved.corners(t))).collect();
    let mut truth = Truth { distance: f64::INFINITY, crosses_clearly: false, contained: false };
    for (s, middle_s, radius_s) in &first {
        for (t, middle_t, radius_t) in &second {
            let far = radius_s + radius_t + reach.min(truth.distance);
            if (middle_s - middle_t).norm_squared() > far * far {
                continue;
            }
            let (distance, clearly) = triangles(s, t, tolerance);
            truth.distance = truth.distance.min(distance);
            truth.crosses_clearly |= clearly;
            if truth.crosses_clearly || truth.distance < enough {
                return truth;
            }
        }
    }
    truth.contained = holds(a, &moved) || holds(&moved, a);
    truth
}

fn moved(mesh: &TriangleMesh, pose: &Pose) -> TriangleMesh {
    let mut moved = mesh.clone();
    moved.vertices.iter_mut().for_each(|v| *v = pose.point(v));
    moved
}

fn with_ball(corners: Corners) -> (Corners, Vec3, f64) {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let radius = corners.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    (corners, middle, radius * (1.0 + 1e-12))
}

/// Distance of two triangles, 0 if they cross, and whether they cross clearly.
///
/// The minimum is at two edges, at a corner over a face, or 0 at an edge through a face. Edges are
/// compared as clamped segments, so degenerate triangles (segments, points) need no special case.
pub fn triangles(s: &Corners, t: &Corners, tolerance: f64) -> (f64, bool) {
    let mut crossing = Crossing::No;
    for k in 0..3 {
        crossing = crossing.max(edge_through(s, t[k], t[(k + 1) % 3], tolerance));
        crossing = crossing.max(edge_through(t, s[k], s[(k + 1) % 3], tolerance));
    }
    if crossing != Crossing::No {
        return (0.0, crossing == Crossing::Clearly);
    }
    let mut squared = f64::INFINITY;
    for i in 0..3 {
        for j in 0..3 {
            squared = squared.min(segments(s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]));
        }
        squared = squared.min(corner_over(s, &t[i])).min(corner_over(t, &s[i]));
    }
    (squared.sqrt(), false)
}

#[derive(PartialEq, PartialOrd, Clone, Copy)]
enum Crossing {
    No,
    Barely,
    Clearly,
}

impl Crossing {
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

/// Unit normal; `None` for a triangle of negligible area.
fn normal(t: &Corners) -> Option<Vec3> {
    let cross = (t[1] - t[0]).cross(&(t[2] - t[0]));
    let longest = (0..3).map(|k| (t[(k + 1) % 3] - t[k]).norm_squared()).fold(0.0, f64::max);
    (cross.norm() > 1e-12 * longest).then(|| cross.normalize())
}

/// Least distance \[m\] of a point of the plane from the three edges, positive inside.
fn inward(t: &Corners, normal: &Vec3, p: &Vec3) -> f64 {
    let side = |k: usize| {
        let edge = t[(k + 1) % 3] - t[k];
        normal.cross(&edge).dot(&(p - t[k])) / edge.norm()
    };
    side(0).min(side(1)).min(side(2))
}

fn edge_through(face: &Corners, from: Vec3, to: Vec3, tolerance: f64) -> Crossing {
    let Some(normal) = normal(face) else { return Crossing::No };
    let (above, below) = (normal.dot(&(from - face[0])), normal.dot(&(to - face[0])));
    if above * below >= 0.0 {
        return Crossing::No;
    }
    let point = from + (to - from) * (above / (above - below));
    let inside = inward(face, &normal, &point);
    // If a slanting edge moves, its crossing point moves farther, by the inverse of its slope.
    let slope = (above - below).abs() / (to - from).norm();
    if inside * slope > 4.0 * tolerance && above.abs().min(below.abs()) > tolerance {
        Crossing::Clearly
    } else if inside >= 0.0 {
        Crossing::Barely
    } else {
        Crossing::No
    }
}

/// Squared distance of a corner from the interior of a face; infinite if its projection lies
/// outside, because edges cover that case.
fn corner_over(face: &Corners, p: &Vec3) -> f64 {
    let Some(normal) = normal(face) else { return f64::INFINITY };
    let height = normal.dot(&(p - face[0]));
    if inward(face, &normal, &(p - normal * height)) >= 0.0 { height * height } else { f64::INFINITY }
}

/// Squared distance of two segments: C. Ericson, Real-Time Collision Detection, 2005, section
/// 5.1.9. The four distances of the ends are compared too, because clamping loses digits for nearly
/// parallel segments.
fn segments(p: Vec3, p_end: Vec3, q: Vec3, q_end: Vec3) -> f64 {
    let ends = [(p, q, q_end), (p_end, q, q_end), (q, p, p_end), (q_end, p, p_end)];
    let mut best = ends.iter().map(|(x, a, b)| point_segment(x, a, b)).fold(f64::INFINITY, f64::min);
    let (u, v, w) = (p_end - p, q_end - q, p - q);
    let (a, b, e) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let (c, f) = (u.dot(&w), v.dot(&w));
    let area = u.cross(&v).norm_squared();
    if area > 1e-24 * a * e {
        let (s, t) = ((b * f - c * e) / area, (a * f - b * c) / area);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            best = best.min((w + u * s - v * t).norm_squared());
        }
    }
    best
}

fn point_segment(x: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let edge = b - a;
    let squared = edge.norm_squared();
    let s = if squared > 0.0 { ((x - a).dot(&edge) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (a + edge * s - x).norm_squared()
}

/// Whether some component of `inner` has its first vertex inside `outer`. Closed components count
/// by their winding numbers, and cavities wind the other way.
fn holds(outer: &TriangleMesh, inner: &TriangleMesh) -> bool {
    let probes =
        inner.components.iter().filter(|c| !c.triangles.is_empty()).map(|c| inner.corners(c.triangles.start)[0]);
    let winds = |p: &Vec3| {
        let solids = outer.components.iter().filter(|c| c.closed);
        solids.map(|c| winding(outer, c.triangles.clone(), p)).sum::<f64>()
    };
    probes.into_iter().any(|p| winds(&p) > 0.5)
}

/// Winding number: sum of the solid angles over 4 pi. A. Van Oosterom and J. Strackee, 1983,
/// doi:10.1109/TBME.1983.325207.
fn winding(mesh: &TriangleMesh, triangles: std::ops::Range<usize>, p: &Vec3) -> f64 {
    let angle = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|x| x - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    triangles.map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(z: f64) -> Corners {
        [Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)]
    }

    #[test]
    fn distances_that_are_known() {
        let ground = at(0.0);
        assert_eq!(triangles(&ground, &at(0.25), 1e-9), (0.25, false));
        let pin = [Vec3::new(0.2, 0.2, 0.5), Vec3::new(0.2, 0.2, 2.0), Vec3::new(0.3, 0.2, 2.0)];
        assert_eq!(triangles(&ground, &pin, 1e-9), (0.5, false));
        let through = pin.map(|p| p - Vec3::z());
        assert_eq!(triangles(&ground, &through, 1e-9), (0.0, true));
        let point = [Vec3::new(0.2, 0.2, 0.125); 3];
        assert_eq!(triangles(&point, &ground, 1e-9).0, 0.125);
        let beside = [Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 1.0, 0.0), Vec3::new(3.0, 0.0, 0.0)];
        assert_eq!(triangles(&ground, &beside, 1e-9), (1.0, false));
        let standing = [Vec3::new(0.75, 0.75, -1.0), Vec3::new(0.75, 0.75, 1.0), Vec3::new(2.0, 2.0, 0.0)];
        assert!((triangles(&ground, &standing, 1e-9).0 - 0.125f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn edges_that_barely_cross_are_not_clear() {
        let ground = at(0.0);
        let edge = |x: f64, low: f64| [Vec3::new(x, 0.2, low), Vec3::new(x, 0.2, 1.0), Vec3::new(x, 0.3, 1.0)];
        assert_eq!(triangles(&ground, &edge(0.2, -1e-10), 1e-9), (0.0, false));
        assert_eq!(triangles(&ground, &edge(1e-10, -1.0), 1e-9), (0.0, false));
        assert_eq!(triangles(&ground, &edge(0.2, -1e-3), 1e-9), (0.0, true));
    }
}

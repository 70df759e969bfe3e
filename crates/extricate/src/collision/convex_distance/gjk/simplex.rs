//! The point of a simplex of at most four vertices that is nearest to the origin, by Voronoi
//! regions.
//!
//! Barycentric coordinates come from in-plane edge normals and directions from feature normals
//! rather than from the nearest point itself, whose direction is lost to cancellation when the
//! origin is close.
//!
//! Source: C. Ericson, *Real-Time Collision Detection* (2005), sections 5.1 and 9.5.2.

use crate::collision::convex_distance::minkowski::Vertex;
use crate::math::Vec3;

/// A triangle is a sliver, which rounding spoils, if its squared double area is below this times
/// its longest edge to the fourth.
const SLIVER_RATIO: f64 = 1e-8;

/// The face of a simplex that holds its point nearest to the origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Feature {
    /// Indices of the vertices of the face; the first `count` hold.
    pub indices: [usize; 3],
    pub count: usize,
    /// Barycentric coordinates of the nearest point; they sum to 1.
    pub weights: [f64; 3],
    /// Direction from the origin to the nearest point, not unit; for a triangle its normal.
    pub direction: Vec3,
    /// Squared distance [m2].
    pub square: f64,
}

/// At most four affinely independent vertices, the newest last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Simplex {
    pub vertices: [Vertex; 4],
    pub count: usize,
}

impl Simplex {
    pub fn new(vertex: Vertex) -> Self {
        Self { vertices: [vertex; 4], count: 1 }
    }

    #[inline(always)]
    pub fn contains(&self, point: &Vec3) -> bool {
        self.vertices[..self.count].iter().any(|vertex| vertex.point == *point)
    }

    /// Adds a vertex; the simplex must have at most three.
    #[inline(always)]
    pub fn push(&mut self, vertex: Vertex) {
        self.vertices[self.count] = vertex;
        self.count += 1;
    }

    pub fn pop(&mut self) {
        self.count -= 1;
    }

    /// Keeps only the vertices of `feature`, in its order.
    #[inline(always)]
    pub fn keep(&mut self, feature: &Feature) {
        let kept = feature.indices.map(|index| self.vertices[index]);
        self.vertices[..3].copy_from_slice(&kept);
        self.count = feature.count;
    }

    /// Returns the nearest feature; `None` if a tetrahedron holds the origin. `flat` is the height
    /// \[m\] below which a tetrahedron counts as flat.
    #[inline(always)]
    pub fn nearest(&self, flat: f64) -> Option<Feature> {
        let p = |index: usize| &self.vertices[index].point;
        match self.count {
            1 => Some(Feature::vertex(0, p(0))),
            2 => Some(nearest_on_segment([p(0), p(1)], [0, 1])),
            3 => Some(nearest_on_triangle([p(0), p(1), p(2)], [0, 1, 2])),
            _ => self.nearest_on_tetrahedron(flat),
        }
    }

    /// The origin lies on the newest vertex's side of the opposite face, from which that vertex was
    /// sought. Only the other three faces can part it from the inside, unless the tetrahedron is
    /// flat.
    #[inline(always)]
    fn nearest_on_tetrahedron(&self, flat: f64) -> Option<Feature> {
        let p = |index: usize| &self.vertices[index].point;
        let mut best: Option<Feature> = None;
        let (mut seen, mut count, mut is_flat) = ([[0; 3]; 4], 0, false);
        for [i, j, k, opposite] in [[3, 0, 1, 2], [3, 1, 2, 0], [3, 2, 0, 1]] {
            let normal = (p(j) - p(i)).cross(&(p(k) - p(i)));
            let side = normal.dot(&(p(opposite) - p(i)));
            let side_origin = -normal.dot(p(i));
            let is_flat_here = side * side <= flat * flat * normal.norm_squared();
            is_flat |= is_flat_here;
            if is_flat_here || side * side_origin < 0.0 {
                seen[count] = [i, j, k];
                count += 1;
            }
        }
        if is_flat {
            seen[count] = [0, 1, 2];
            count += 1;
        }
        for [i, j, k] in &seen[..count] {
            let feature = nearest_on_triangle([p(*i), p(*j), p(*k)], [*i, *j, *k]);
            if best.is_none_or(|best| feature.square < best.square) {
                best = Some(feature);
            }
        }
        best
    }
}

impl Feature {
    #[inline(always)]
    fn vertex(index: usize, point: &Vec3) -> Self {
        let square = point.norm_squared();
        Self { indices: [index; 3], count: 1, weights: [1.0, 0.0, 0.0], direction: *point, square }
    }

    /// Returns whether the nearest point depends on vertex `index`.
    #[inline(always)]
    pub fn uses(&self, index: usize) -> bool {
        self.indices[..self.count].contains(&index)
    }
}

#[inline(always)]
fn nearest_on_segment([a, b]: [&Vec3; 2], [i, j]: [usize; 2]) -> Feature {
    let edge = b - a;
    let (along, length_squared) = (-a.dot(&edge), edge.norm_squared());
    if along <= 0.0 {
        return Feature::vertex(i, a);
    }
    if along >= length_squared {
        return Feature::vertex(j, b);
    }
    let share = along / length_squared;
    let point = if share < 0.5 { a + edge * share } else { b - edge * (b.dot(&edge) / length_squared) };
    // The direction is made perpendicular once more: the length of the edge would multiply an error
    // along it.
    let direction = point - edge * (point.dot(&edge) / length_squared);
    let square = direction.norm_squared();
    Feature { indices: [i, j, j], count: 2, weights: [1.0 - share, share, 0.0], direction, square }
}

/// Returns the nearest point of a triangle, which may be a sliver or have no area.
#[inline(always)]
pub(crate) fn nearest_on_triangle([a, b, c]: [&Vec3; 3], [i, j, k]: [usize; 3]) -> Feature {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let (normal, longest) = normal_of_edges(&ab, &bc, &ca);
    let area = normal.norm_squared();
    let weights = [bc.cross(&normal).dot(b), ca.cross(&normal).dot(c), ab.cross(&normal).dot(a)];
    // A normal with a relative error above 1e-3 is no direction; the edges are then as near as the
    // inside.
    let has_area = area > 1e-26 * longest * longest;
    if has_area && weights.iter().all(|&weight| weight >= 0.0) {
        let sum = weights[0] + weights[1] + weights[2];
        let mut weights = weights.map(|weight| weight / sum);
        if area < SLIVER_RATIO * longest * longest {
            sharpen_sliver([a, b, c], &normal, &mut weights);
        }
        let height = normal.dot(a) * weights[0] + normal.dot(b) * weights[1] + normal.dot(c) * weights[2];
        let direction = if height < 0.0 { -normal } else { normal };
        return Feature { indices: [i, j, k], count: 3, weights, direction, square: height * height / area };
    }
    let mut best: Option<Feature> = None;
    for (weight, points, indices) in
        [(weights[0], [b, c], [j, k]), (weights[1], [c, a], [k, i]), (weights[2], [a, b], [i, j])]
    {
        if !has_area || weight < 0.0 {
            let feature = nearest_on_segment(points, indices);
            if best.is_none_or(|best| feature.square < best.square) {
                best = Some(feature);
            }
        }
    }
    best.unwrap_or_else(|| Feature::vertex(i, a))
}

/// Corrects the barycentric coordinates of the origin's projection onto a sliver. It first moves
/// the projection along the longest edge, where rounding errors have most effect. It then takes the
/// nearest point on the edges if that is nearer still.
#[cold]
fn sharpen_sliver(corners: [&Vec3; 3], normal: &Vec3, weights: &mut [f64; 3]) {
    let [a, b, c] = corners;
    let squares = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
    let from = longest_edge(&squares);
    let to = (from + 1) % 3;
    let point = |weights: &[f64; 3]| a * weights[0] + b * weights[1] + c * weights[2];
    let off = point(weights);
    let beside = off - normal * (off.dot(normal) / normal.norm_squared());
    let share = beside.dot(&(corners[to] - corners[from])) / squares[from];
    let share = share.clamp(-weights[from], weights[to]);
    weights[from] += share;
    weights[to] -= share;
    let mut square = point(weights).norm_squared();
    for (points, indices) in [([b, c], [1, 2]), ([c, a], [2, 0]), ([a, b], [0, 1])] {
        let feature = nearest_on_segment(points, indices);
        if feature.square < square {
            square = feature.square;
            *weights = [0.0; 3];
            weights[feature.indices[0]] = feature.weights[0];
            weights[feature.indices[1]] += feature.weights[1];
        }
    }
}

/// Returns the normal of the triangle with edges `ab`, `bc`, `ca` (of length twice its area) and
/// its longest squared edge.
#[inline(always)]
pub(crate) fn normal_of_edges(ab: &Vec3, bc: &Vec3, ca: &Vec3) -> (Vec3, f64) {
    let (ab2, bc2, ca2) = (ab.norm_squared(), bc.norm_squared(), ca.norm_squared());
    let longest = ab2.max(bc2).max(ca2);
    let normal = ca.cross(ab);
    if normal.norm_squared() > SLIVER_RATIO * longest * longest {
        return (normal, longest);
    }
    (normal_of_sliver([ab, bc, ca], [ab2, bc2, ca2]), longest)
}

/// Computes the normal from the two shorter edges, which keeps the error relative to it, and makes
/// it perpendicular to the longest edge. The remaining error turns it about that edge, where only
/// the sliver's width multiplies it.
#[cold]
fn normal_of_sliver(edges: [&Vec3; 3], squares: [f64; 3]) -> Vec3 {
    let longest = longest_edge(&squares);
    let normal = edges[(longest + 1) % 3].cross(edges[(longest + 2) % 3]);
    if squares[longest] > 0.0 {
        normal - edges[longest] * (normal.dot(edges[longest]) / squares[longest])
    } else {
        normal
    }
}

fn longest_edge(squares: &[f64; 3]) -> usize {
    if squares[0] >= squares[1] && squares[0] >= squares[2] { 0 } else { 1 + usize::from(squares[2] > squares[1]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn nearest_of(points: &[Vec3]) -> Option<f64> {
        let mut simplex = Simplex::new(Vertex { point: points[0], first: points[0] });
        for &point in &points[1..] {
            simplex.push(Vertex { point, first: point });
        }
        simplex.nearest(1e-14).map(|feature| {
            let kept: Vec3 = (0..feature.count).map(|k| points[feature.indices[k]] * feature.weights[k]).sum();
            assert!((kept.norm() - feature.square.sqrt()).abs() < 1e-12);
            assert!((kept.normalize() - feature.direction.normalize()).norm() < 1e-9 || kept.norm() < 1e-6);
            feature.square.sqrt()
        })
    }

    #[test]
    fn nearest_points_satisfy_the_optimality_condition() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for n in 0..20_000 {
            let count = 1 + n % 3;
            let shift = Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5);
            let points: Vec<Vec3> =
                (0..count).map(|_| Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5) + shift).collect();
            let mut simplex = Simplex::new(Vertex { point: points[0], first: points[0] });
            points[1..].iter().for_each(|&point| simplex.push(Vertex { point, first: point }));
            let feature = simplex.nearest(1e-14).unwrap();
            // No vertex lies below the plane through the nearest point, at a right angle to it.
            let direction = feature.direction.normalize();
            let lowest = points.iter().map(|p| p.dot(&direction)).fold(f64::INFINITY, f64::min);
            assert!((lowest - feature.square.sqrt()).abs() < 1e-11, "{points:?} {feature:?}");
            nearest_of(&points);
        }
    }

    #[test]
    fn a_tetrahedron_holds_the_origin_or_shows_a_face() {
        let corners = [Vec3::new(1.0, 0.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, -1.0), Vec3::z()];
        assert_eq!(nearest_of(&corners), None);
        let moved = corners.map(|corner| corner + Vec3::new(2.0, 0.0, 0.0));
        assert!(nearest_of(&moved).unwrap() > 0.5);
    }

    #[test]
    fn slivers_and_points_in_a_line_are_measured() {
        let flat = [Vec3::new(-1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.3, 0.0, 1.0)];
        assert!((nearest_of(&flat).unwrap() - 1.0).abs() < 1e-15);
        let sliver = [Vec3::new(-1.0, -1e-9, 1e-6), Vec3::new(1.0, -1e-9, 1e-6), Vec3::new(0.3, 1e-9, 1e-6)];
        assert!((nearest_of(&sliver).unwrap() - 1e-6).abs() < 1e-15);
    }
}

//! Distances between points, segments and triangles, with the points that realise them. One pair at
//! a time, no trees.

use crate::math::{Pose, Vec3};

/// A triangle with its unit normal.
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    /// Corners \[m\].
    pub points: [Vec3; 3],
    /// Unit, by the right-hand rule; zero if the triangle is as thin as a segment.
    pub normal: Vec3,
}

/// Triangles thinner than this share of their length count as segments, since rounding destroys
/// their normal. Ignoring the thickness and using a wrong normal then cost the same, about 1e-9 of
/// the length.
const MIN_THICKNESS_SHARE: f64 = 1e-9;

/// Nearest points of two sets.
#[derive(Debug, Clone, Copy)]
pub struct Witness {
    /// Squared distance [m^2].
    pub squared: f64,
    pub first: Vec3,
    pub second: Vec3,
}

impl Triangle {
    /// Computes the normal from the two shortest edges, which round least.
    pub fn new(points: [Vec3; 3]) -> Self {
        let edges = [points[1] - points[0], points[2] - points[1], points[0] - points[2]];
        let lengths = edges.map(|e| e.norm_squared());
        let longest =
            if lengths[0] >= lengths[1].max(lengths[2]) { 0 } else { 1 + usize::from(lengths[2] > lengths[1]) };
        let cross = edges[(longest + 1) % 3].cross(&edges[(longest + 2) % 3]);
        let norm = cross.norm();
        let normal = if norm > MIN_THICKNESS_SHARE * lengths[longest] { cross / norm } else { Vec3::zeros() };
        Self { points, normal }
    }

    /// Maps the triangle by `pose`.
    pub fn moved(&self, pose: &Pose) -> Self {
        let [a, b, c] = &self.points;
        Self { points: [pose.point(a), pose.point(b), pose.point(c)], normal: pose.vector(&self.normal) }
    }

    /// Signed distance \[m\] of `point` from the plane, positive on the side of the normal.
    pub fn height(&self, point: &Vec3) -> f64 {
        self.normal.dot(&(point - self.points[0]))
    }

    fn heights(&self, [a, b, c]: &[Vec3; 3]) -> [f64; 3] {
        [self.height(a), self.height(b), self.height(c)]
    }

    fn is_thin(&self) -> bool {
        self.normal == Vec3::zeros()
    }

    /// Whether the projection of `point` onto the plane falls into the triangle.
    fn is_over(&self, point: &Vec3) -> bool {
        (0..3).all(|k| self.side(k, point) >= 0.0)
    }

    fn side(&self, k: usize, point: &Vec3) -> f64 {
        let (a, b) = (&self.points[k], &self.points[(k + 1) % 3]);
        (b - a).cross(&(point - a)).dot(&self.normal)
    }
}

pub fn closest_on_segment(a: &Vec3, b: &Vec3, point: &Vec3) -> Vec3 {
    let edge = b - a;
    let squared = edge.norm_squared();
    if squared == 0.0 { *a } else { a + edge * ((point - a).dot(&edge) / squared).clamp(0.0, 1.0) }
}

/// Point of `triangle` that is nearest to `point`.
///
/// The unit normal decides on which side of an edge the point lies. Barycentric quotients would
/// fail for needles.
pub fn closest_on_triangle(triangle: &Triangle, point: &Vec3) -> Vec3 {
    let (mut best, mut best_squared) = (*point, f64::INFINITY);
    for k in 0..3 {
        if triangle.is_thin() || triangle.side(k, point) < 0.0 {
            let near = closest_on_segment(&triangle.points[k], &triangle.points[(k + 1) % 3], point);
            let squared = (near - point).norm_squared();
            if squared < best_squared {
                (best, best_squared) = (near, squared);
            }
        }
    }
    if best_squared == f64::INFINITY { point - triangle.normal * triangle.height(point) } else { best }
}

/// Nearest points of two triangles in one frame, if their squared distance is below
/// `limit_squared`.
///
/// Triangles that pass through each other have squared distance 0; they are reported for a limit of
/// 0 too.
///
/// # Guarantee
/// Both points lie on their triangles to rounding. The distance exceeds the true one by rounding
/// only, about 1e-15 of the triangles' size, or 1e-9 for needles. By convexity the minimum lies at
/// a corner over a face, at two edges, or at a crossing.
pub fn closest(first: &Triangle, second: &Triangle, limit_squared: f64) -> Option<Witness> {
    search::<false>(first, second, limit_squared)
}

/// Whether two triangles cross, or are nearer than `limit` \[m\].
pub fn nearer(first: &Triangle, second: &Triangle, limit: f64) -> bool {
    search::<true>(first, second, limit * limit).is_some()
}

/// Finds the minimum, or with `ANY` any distance below the limit.
fn search<const ANY: bool>(first: &Triangle, second: &Triangle, limit_squared: f64) -> Option<Witness> {
    let over_first = first.heights(&second.points);
    let over_second = second.heights(&first.points);
    if clear(&over_first, limit_squared) || clear(&over_second, limit_squared) {
        return None;
    }
    if let Some(point) = crossing(first, second, &over_second).or_else(|| crossing(second, first, &over_first)) {
        return Some(Witness { squared: 0.0, first: point, second: point });
    }
    let mut best = Witness { squared: limit_squared, first: Vec3::zeros(), second: Vec3::zeros() };
    let mut found = false;
    for k in 0..3 {
        if over_second[k] * over_second[k] < best.squared {
            let p = first.points[k];
            found |= best.improve(&p, &closest_on_triangle(second, &p));
        }
        if over_first[k] * over_first[k] < best.squared {
            let p = second.points[k];
            found |= best.improve(&closest_on_triangle(first, &p), &p);
        }
        if ANY && found {
            return Some(best);
        }
    }
    if found && best.is_proved(first, second) {
        return Some(best);
    }
    for i in 0..3 {
        let (a, u) = (&first.points[i], first.points[(i + 1) % 3] - first.points[i]);
        for j in 0..3 {
            let (b, v) = (&second.points[j], second.points[(j + 1) % 3] - second.points[j]);
            if let Some((s, t)) = lines(a, &u, b, &v, best.squared) {
                found |= best.improve(&(a + u * s), &(b + v * t));
                if ANY && found {
                    return Some(best);
                }
            }
        }
    }
    found.then_some(best)
}

impl Witness {
    /// Whether the planes through the two points, across the line between them, separate the
    /// triangles. If so, no points are nearer.
    fn is_proved(&self, first: &Triangle, second: &Triangle) -> bool {
        let across = self.first - self.second;
        let slack = 1e-13 * self.squared;
        first.points.iter().all(|p| (p - self.first).dot(&across) >= -slack)
            && second.points.iter().all(|p| (p - self.second).dot(&across) <= slack)
    }

    fn improve(&mut self, first: &Vec3, second: &Vec3) -> bool {
        let squared = (first - second).norm_squared();
        let better = squared < self.squared;
        if better {
            *self = Witness { squared, first: *first, second: *second };
        }
        better
    }
}

/// Whether all three heights are on one side of a plane, at least the limit away.
fn clear(heights: &[f64; 3], limit_squared: f64) -> bool {
    let (low, high) = (heights[0].min(heights[1]).min(heights[2]), heights[0].max(heights[1]).max(heights[2]));
    (low > 0.0 && low * low >= limit_squared) || (high < 0.0 && high * high >= limit_squared)
}

/// Point at which an edge of `edges` passes through `face`; `heights` are those of its corners
/// above the plane of the face.
fn crossing(edges: &Triangle, face: &Triangle, heights: &[f64; 3]) -> Option<Vec3> {
    (0..3).find_map(|k| {
        let (from, to) = (heights[k], heights[(k + 1) % 3]);
        if (from > 0.0) == (to > 0.0) || (from < 0.0) == (to < 0.0) {
            return None;
        }
        let (a, b) = (&edges.points[k], &edges.points[(k + 1) % 3]);
        let point = a + (b - a) * (from / (from - to));
        face.is_over(&point).then_some(point)
    })
}

/// Parameters of the nearest points of the lines `a + s u` and `b + t v`. `None` unless both lie
/// within the segments and their squared distance is below `limit_squared`, and for parallel
/// segments, whose ends decide.
fn lines(a: &Vec3, u: &Vec3, b: &Vec3, v: &Vec3, limit_squared: f64) -> Option<(f64, f64)> {
    let normal = u.cross(v);
    let squared = normal.norm_squared();
    let w = b - a;
    let height = w.dot(&normal);
    // Angles below 1e-12 are rounding, and the ends are then as near as the interiors.
    if height * height >= limit_squared * squared || squared <= 1e-24 * u.norm_squared() * v.norm_squared() {
        return None;
    }
    let within = 0.0..=squared;
    let (s, t) = (w.cross(v).dot(&normal), w.cross(u).dot(&normal));
    (within.contains(&s) && within.contains(&t)).then(|| (s / squared, t / squared))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Slow twin: minimises the exact distance to the second triangle over a grid on the first,
    /// zooming in.
    fn dense(first: &[Vec3; 3], second: &Triangle) -> f64 {
        let at = |u: f64, v: f64| first[0] * (1.0 - u - v) + first[1] * u + first[2] * v;
        let (mut center, mut width, mut best) = ((0.5, 0.5), 0.5, f64::INFINITY);
        // The distance to a convex set is convex over a triangle, so zooming loses at most a cell
        // of the minimum.
        for _ in 0..40 {
            let from = center;
            for i in -8..=8 {
                for j in -8..=8 {
                    let u = (from.0 + width * i as f64 / 8.0).clamp(0.0, 1.0);
                    let v = (from.1 + width * j as f64 / 8.0).clamp(0.0, 1.0 - u);
                    let p = at(u, v);
                    let distance = (p - closest_on_triangle(second, &p)).norm();
                    if distance < best {
                        (best, center) = (distance, (u, v));
                    }
                }
            }
            width *= 0.6;
        }
        best
    }

    fn check(a: [Vec3; 3], b: [Vec3; 3]) {
        let (first, second) = (Triangle::new(a), Triangle::new(b));
        let found = closest(&first, &second, f64::INFINITY).unwrap();
        let swapped = closest(&second, &first, f64::INFINITY).unwrap();
        let (distance, expected) = (found.squared.sqrt(), dense(&a, &second));
        assert!((distance - expected).abs() < 2e-6 && distance < expected + 1e-12, "{distance} {expected} {a:?} {b:?}");
        assert!((swapped.squared.sqrt() - distance).abs() < 1e-12);
        assert!((closest_on_triangle(&first, &found.first) - found.first).norm() < 1e-9);
        assert!((closest_on_triangle(&second, &found.second) - found.second).norm() < 1e-9);
        assert!((found.first - found.second).norm() - distance < 1e-12);
        for limit in [0.5 * distance, distance - 1e-9, distance + 1e-9, 2.0 * distance + 1e-9] {
            if limit > 0.0 {
                assert_eq!(nearer(&first, &second, limit), distance < limit || distance == 0.0, "{distance} {limit}");
                assert_eq!(closest(&first, &second, limit * limit).is_some(), distance < limit || distance == 0.0);
            }
        }
    }

    fn random(rng: &mut ChaCha8Rng, spread: f64, shift: f64) -> [Vec3; 3] {
        let origin = Vec3::from_fn(|_, _| shift * (rng.random::<f64>() - 0.5));
        [0; 3].map(|_| origin + Vec3::from_fn(|_, _| spread * (rng.random::<f64>() - 0.5)))
    }

    #[test]
    fn distance_equals_the_dense_minimum() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for i in 0..400 {
            let shift = [0.0, 1.0, 3.0][i % 3];
            check(random(&mut rng, 1.0, shift), random(&mut rng, 1.0, shift));
        }
    }

    #[test]
    fn flat_thin_and_touching_triangles() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for i in 0..200 {
            let (mut a, mut b) = (random(&mut rng, 1.0, 1.0), random(&mut rng, 1.0, 1.0));
            match i % 5 {
                0 => a.iter_mut().chain(&mut b).for_each(|p| p.z = 0.25), // coplanar
                1 => a.iter_mut().for_each(|p| p.z = 0.0),
                2 => a[2] = a[0] + (a[1] - a[0]) * 0.3, // a segment
                3 => a = [a[0]; 3],                     // a point
                _ => b[0] = a[0],                       // a shared corner
            }
            check(a, b);
        }
        let a = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        check(a, a);
        check(a, a.map(|p| p + Vec3::new(0.1, 0.1, 0.0)));
        check(a, a.map(|p| p + Vec3::new(0.1, 0.1, 1e-4)));
        check(a, [Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 0.0)]);
    }

    #[test]
    fn needles_keep_nine_digits() {
        let needle = Triangle::new([Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.5, 1e-7, 0.0)]);
        let p = Vec3::new(0.25, 2e-8, 0.125);
        assert!((closest_on_triangle(&needle, &p) - Vec3::new(0.25, 2e-8, 0.0)).norm() < 1e-9);
        let other = Triangle::new([p, p + Vec3::x(), p + Vec3::z()]);
        assert!((closest(&needle, &other, 1.0).unwrap().squared.sqrt() - 0.125).abs() < 1e-9);
    }

    #[test]
    fn crossing_triangles_are_near_at_limit_zero() {
        let a = Triangle::new([Vec3::zeros(), Vec3::x(), Vec3::y()]);
        let b = Triangle::new([Vec3::new(0.2, 0.2, -1.0), Vec3::new(0.2, 0.2, 1.0), Vec3::new(0.2, 3.0, 1.0)]);
        assert!(nearer(&a, &b, 0.0) && nearer(&b, &a, 0.0));
        assert!(!nearer(&a, &b.moved(&Pose::translation(Vec3::new(0.0, 0.0, 1.0 + 1e-12))), 0.0));
    }
}

//! Measures how deep the origin lies in a convex set of six dimensions, given its support function.
//!
//! No maintained library does this: those that build hulls build the whole hull of all points. Here
//! only its nearest facets count, and round cones have no last point.

use std::collections::{BinaryHeap, HashMap};

/// A force and a moment, three numbers each.
pub type Wrench = [f64; DIMENSIONS];

const DIMENSIONS: usize = 6;
/// Relative error up to which the radius is computed.
const RELATIVE_ERROR: f64 = 1e-3;
/// Lengths up to this count as 0: the set holds unit forces, with arms of about 1.
const ZERO_LENGTH: f64 = 1e-9;
/// Maximum number of points that the polytope grows by.
const MAX_POINTS: usize = 3000;

/// Returns a lower bound on the radius of the largest ball around the origin in a convex set; 0 if
/// the origin is not inside. `support` returns a point of the set that is farthest along a
/// direction, or `None` for an empty set.
///
/// # Source
/// Y. Zheng, "An efficient algorithm for a grasp quality measure", IEEE Transactions on Robotics
/// 29(2), 2013, doi:10.1109/TRO.2012.2222274. A polytope inside the set grows by the support point
/// of its facet nearest to the origin, until that facet is one of the set. Deviation: the polytope
/// need not hold the origin at first. Facets that leave it outside have negative distances, and
/// count as the nearest.
pub fn least_support(support: impl Fn(&Wrench) -> Option<Wrench>) -> f64 {
    let Some(mut polytope) = Polytope::simplex(&support) else { return 0.0 };
    for _ in 0..MAX_POINTS {
        let Some(facet) = polytope.nearest() else { return 0.0 };
        let Facet { normal, offset, .. } = polytope.facets[facet];
        let Some(point) = support(&normal) else { return 0.0 };
        let ahead = dot(&normal, &point);
        if ahead <= ZERO_LENGTH {
            return 0.0;
        }
        if offset > ZERO_LENGTH && ahead - offset <= RELATIVE_ERROR * ahead || !polytope.grow(facet, point) {
            return if offset > ZERO_LENGTH { offset } else { 0.0 };
        }
    }
    // The points are spent; the polytope so far still gives a lower bound.
    polytope.nearest().map_or(0.0, |facet| polytope.facets[facet].offset.max(0.0))
}

#[derive(Clone, Copy)]
struct Facet {
    vertices: [usize; DIMENSIONS],
    /// Facet across the ridge opposite to each vertex.
    neighbors: [usize; DIMENSIONS],
    /// Unit outward normal of its plane.
    normal: Wrench,
    /// Distance of its plane from the origin, negative if the origin is outside.
    offset: f64,
    is_gone: bool,
}

/// A convex polytope whose facets are simplices.
struct Polytope {
    points: Vec<Wrench>,
    center: Wrench,
    facets: Vec<Facet>,
    queue: BinaryHeap<Nearer>,
}

impl Polytope {
    /// Makes a simplex of seven points of the set; `None` if the set is flat.
    fn simplex(support: impl Fn(&Wrench) -> Option<Wrench>) -> Option<Self> {
        let mut points = vec![support(&unit(0))?];
        let mut spanned: Vec<Wrench> = Vec::new();
        while points.len() <= DIMENSIONS {
            let direction = across(&spanned);
            let first = points[0];
            let height = |point: &Wrench| dot(&direction, point) - dot(&direction, &first);
            let candidates = [support(&direction)?, support(&direction.map(|x| -x))?];
            let farthest = candidates.into_iter().max_by(|a, b| height(a).abs().total_cmp(&height(b).abs()))?;
            if height(&farthest).abs() < ZERO_LENGTH {
                return None;
            }
            spanned.push(normalized(orthogonal(&difference(&farthest, &first), &spanned))?);
            points.push(farthest);
        }
        let center = std::array::from_fn(|k| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64);
        let mut polytope = Self { points, center, facets: Vec::new(), queue: BinaryHeap::new() };
        for left_out in 0..=DIMENSIONS {
            let vertices = std::array::from_fn(|k| k + usize::from(k >= left_out));
            // Facet number i is the one without point i.
            polytope.add(vertices, vertices);
        }
        Some(polytope)
    }

    fn add(&mut self, vertices: [usize; DIMENSIONS], neighbors: [usize; DIMENSIONS]) {
        let (normal, offset) = self.plane(&vertices);
        self.queue.push(Nearer { offset, facet: self.facets.len() });
        self.facets.push(Facet { vertices, neighbors, normal, offset, is_gone: false });
    }

    /// Returns the outward normal and the offset of the plane through the vertices. If they span no
    /// plane, the offset is infinite, so that no point lies beyond.
    fn plane(&self, vertices: &[usize; DIMENSIONS]) -> (Wrench, f64) {
        let first = self.points[vertices[0]];
        let mut spanned: Vec<Wrench> = Vec::with_capacity(DIMENSIONS);
        for vertex in &vertices[1..] {
            let edge = orthogonal(&difference(&self.points[*vertex], &first), &spanned);
            match normalized(edge) {
                Some(edge) => spanned.push(edge),
                None => return (unit(0), f64::INFINITY),
            }
        }
        let normal = across(&spanned);
        let outward = dot(&normal, &difference(&first, &self.center));
        let normal = if outward < 0.0 { normal.map(|x| -x) } else { normal };
        (normal, dot(&normal, &first))
    }

    /// Returns the facet of least offset, which is negative on the wrong side of the origin.
    fn nearest(&mut self) -> Option<usize> {
        while let Some(Nearer { facet, .. }) = self.queue.peek() {
            if !self.facets[*facet].is_gone {
                return Some(*facet);
            }
            self.queue.pop();
        }
        None
    }

    /// Adds a point if it lies beyond a facet; returns whether it does.
    fn grow(&mut self, facet: usize, point: Wrench) -> bool {
        let beyond = |facet: &Facet| dot(&facet.normal, &point) > facet.offset + 1e-12;
        if !beyond(&self.facets[facet]) {
            return false;
        }
        let vertex = self.points.len();
        self.points.push(point);
        self.facets[facet].is_gone = true;
        let (mut seen, mut at, mut horizon) = (vec![facet], 0, Vec::new());
        while at < seen.len() {
            let Facet { vertices, neighbors, .. } = self.facets[seen[at]];
            for (k, other) in neighbors.into_iter().enumerate() {
                if self.facets[other].is_gone {
                    continue;
                }
                if beyond(&self.facets[other]) {
                    self.facets[other].is_gone = true;
                    seen.push(other);
                } else {
                    horizon.push((vertices, k, seen[at], other));
                }
            }
            at += 1;
        }
        // Ridges of new facets that lack their second facet, by vertices: the first facet, and the
        // index of the missing neighbour.
        let mut open: HashMap<[usize; DIMENSIONS - 1], (usize, usize)> = HashMap::new();
        for (mut vertices, k, old, other) in horizon {
            let new = self.facets.len();
            vertices[k] = vertex;
            let across = self.facets[other].neighbors.iter().position(|neighbor| *neighbor == old);
            across.into_iter().for_each(|across| self.facets[other].neighbors[across] = new);
            let mut neighbors = [other; DIMENSIONS];
            for j in (0..DIMENSIONS).filter(|j| *j != k) {
                let mut ridge = std::array::from_fn(|i| vertices[i + usize::from(i >= j)]);
                ridge.sort_unstable();
                match open.remove(&ridge) {
                    Some((first, side)) => {
                        self.facets[first].neighbors[side] = new;
                        neighbors[j] = first;
                    }
                    None => {
                        open.insert(ridge, (new, j));
                    }
                }
            }
            self.add(vertices, neighbors);
        }
        true
    }
}

/// Entry of the queue: the greatest is the facet of least offset.
struct Nearer {
    offset: f64,
    facet: usize,
}

impl Ord for Nearer {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.offset.total_cmp(&self.offset).then(other.facet.cmp(&self.facet))
    }
}

impl PartialOrd for Nearer {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Nearer {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Nearer {}

fn unit(axis: usize) -> Wrench {
    std::array::from_fn(|k| f64::from(k == axis))
}

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn difference(a: &Wrench, b: &Wrench) -> Wrench {
    std::array::from_fn(|k| a[k] - b[k])
}

/// Returns the part of a vector orthogonal to `others`, which are orthonormal. The second pass
/// removes what rounding left in the first.
fn orthogonal(vector: &Wrench, others: &[Wrench]) -> Wrench {
    let mut rest = *vector;
    for other in others.iter().chain(others) {
        let along = dot(&rest, other);
        rest.iter_mut().zip(other).for_each(|(x, o)| *x -= along * o);
    }
    rest
}

fn normalized(vector: Wrench) -> Option<Wrench> {
    let length = dot(&vector, &vector).sqrt();
    (length > ZERO_LENGTH).then(|| vector.map(|x| x / length))
}

/// Returns a unit vector orthogonal to `others`, which are orthonormal and fewer than six.
fn across(others: &[Wrench]) -> Wrench {
    let rests = (0..DIMENSIONS).map(|axis| orthogonal(&unit(axis), others));
    let longest = rests.max_by(|a, b| dot(a, a).total_cmp(&dot(b, b)));
    longest.and_then(normalized).unwrap_or_else(|| unit(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn of_points(points: &[Wrench]) -> f64 {
        least_support(|direction| points.iter().copied().max_by(|a, b| dot(a, direction).total_cmp(&dot(b, direction))))
    }

    /// The cross-polytope is 1 / sqrt(6) deep, the box 1, the ellipsoid its shortest half axis.
    #[test]
    fn known_depths() {
        let crosses: Vec<Wrench> = (0..6).flat_map(|k| [unit(k), unit(k).map(|x| -x)]).collect();
        assert!((of_points(&crosses) - 1.0 / 6.0_f64.sqrt()).abs() < 1e-9);
        let corners: Vec<Wrench> =
            (0..64).map(|bits| std::array::from_fn(|k| if bits >> k & 1 == 1 { 1.0 } else { -1.0 })).collect();
        assert!((of_points(&corners) - 1.0).abs() < 2e-3, "{}", of_points(&corners));
        let ellipsoid = |direction: &Wrench| {
            let axes = [2.0, 0.5, 3.0, 1.0, 1.0, 4.0];
            let scaled: Wrench = std::array::from_fn(|k| axes[k] * direction[k]);
            let length = dot(&scaled, &scaled).sqrt();
            Some(std::array::from_fn(|k| axes[k] * scaled[k] / length))
        };
        let depth = least_support(ellipsoid);
        assert!(depth <= 0.5 + 1e-9 && depth > 0.499, "{depth}");
    }

    #[test]
    fn outside_and_flat_are_zero() {
        let mut moved: Vec<Wrench> = (0..6).flat_map(|k| [unit(k), unit(k).map(|x| -x)]).collect();
        moved.iter_mut().for_each(|point| point[0] += 1.5);
        assert_eq!(of_points(&moved), 0.0);
        let flat: Vec<Wrench> = (0..5).flat_map(|k| [unit(k), unit(k).map(|x| -x)]).collect();
        assert_eq!(of_points(&flat), 0.0);
        assert_eq!(of_points(&[]), 0.0);
    }

    /// Compares with a slow twin: the least support over random directions, each improved by random
    /// steps. It is never below the true depth.
    #[test]
    fn no_direction_has_less_support() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut number = || rng.random::<f64>() - 0.5;
        for round in 0..20 {
            let points: Vec<Wrench> = (0..8 + 4 * round).map(|_| std::array::from_fn(|_| number())).collect();
            let depth = of_points(&points);
            let ahead = |direction: &Wrench| points.iter().map(|p| dot(p, direction)).fold(f64::MIN, f64::max);
            let mut least = f64::INFINITY;
            for _ in 0..200 {
                let mut best = normalized(std::array::from_fn(|_| number())).unwrap();
                for step in 0..60 {
                    let scale = 0.5_f64.powi(step / 6);
                    let near: Wrench = std::array::from_fn(|k| best[k] + scale * number());
                    let near = normalized(near).unwrap();
                    if ahead(&near) < ahead(&best) {
                        best = near;
                    }
                }
                least = least.min(ahead(&best));
            }
            assert!(depth <= least.max(0.0) + 1e-9, "{round}: {depth} {least}");
            assert!(depth > 0.7 * least - 0.02, "{round}: {depth} {least}");
        }
    }
}

//! Finds the few nearest points of some lists, by rounded distances first. Exact points lie far
//! apart in memory, and waiting for them takes longer than all else, so only candidates are read.

use pulp::{Simd, WithSimd};

use super::inverted_lists::Lists;
use super::scan::{ListDistances, Query, least_of_lanes, square_list, up_to};
use crate::math::LANES;
use crate::math::simd::lanes_of;

/// Writes the distances of points beside their ids.
pub type Exact<'a> = dyn FnMut(&mut [(u32, f64)]) + 'a;

/// Points that may be among the `k` nearest.
#[derive(Debug, Clone, Default)]
pub struct Shortlist {
    k: usize,
    /// No farther point is among the `k` nearest; at first the limit of the search.
    pub radius: f64,
    found: Vec<BoundedPoint>,
    /// Length of `found` at which it is pruned: twice what the last pruning left, so that thousands
    /// of equal distances do not take quadratic time.
    most: usize,
    distances: ListDistances,
}

/// A point, with bounds on its distance.
#[derive(Debug, Clone, Copy)]
struct BoundedPoint {
    nearest: f64,
    farthest: f64,
    place: u32,
}

/// Bounds on the error of a computed distance.
#[derive(Clone, Copy)]
struct Rounding {
    /// Relative error of the squared distance.
    error: f64,
    /// How far the point itself may be off.
    moved: f64,
}

impl Rounding {
    /// Largest computed squared distance of a point within `radius`.
    fn limit(self, radius: f64) -> f32 {
        ((radius + self.moved).powi(2) * (1.0 + self.error)) as f32
    }

    fn farthest(self, squared: f32) -> f64 {
        (f64::from(squared) * (1.0 + self.error)).sqrt() + self.moved
    }

    fn nearest(self, squared: f32) -> f64 {
        (f64::from(squared) * (1.0 - self.error)).sqrt() - self.moved
    }
}

impl Shortlist {
    /// Empties the list, to find `k` points no farther than `within`.
    pub fn reset(&mut self, k: usize, within: f64) {
        (self.k, self.most, self.radius) = (k, 2 * k, within);
        self.found.clear();
    }

    /// Reduces the radius to what the points so far prove, and drops points beyond it.
    #[inline(never)]
    fn tighten(&mut self) {
        if self.found.len() < self.k {
            return;
        }
        let by_farthest = |a: &BoundedPoint, b: &BoundedPoint| a.farthest.total_cmp(&b.farthest);
        let (_, kth, _) = self.found.select_nth_unstable_by(self.k - 1, by_farthest);
        self.radius = self.radius.min(kth.farthest);
        self.found.retain(|found| found.nearest <= self.radius);
        self.most = 2 * self.found.len().max(self.k);
    }

    /// Writes the `k` nearest points to `out`, nearest first and ties by id, with the distances
    /// that `exact` writes; none is beyond `within`.
    pub fn finish(&mut self, lists: &Lists, within: f64, exact: &mut Exact, out: &mut Vec<(u32, f64)>) {
        self.tighten();
        out.clear();
        out.extend(self.found.iter().map(|found| (lists.ids[found.place as usize], 0.0)));
        exact(out);
        out.retain(|(_, distance)| *distance <= within);
        out.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        out.truncate(self.k);
    }
}

/// Adds the points of one list that may be among the nearest to a shortlist.
pub struct ShowList<'a> {
    /// The lists of the index.
    pub lists: &'a Lists,
    /// Index of the list.
    pub list: usize,
    /// The query, exact and rounded.
    pub query: Query<'a>,
    /// The shortlist that gets the points.
    pub shortlist: &'a mut Shortlist,
}

impl WithSimd for ShowList<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lists, list, query, shortlist } = self;
        let first = lists.starts[list] as usize;
        let moved = square_list(simd, lists, list, query.exact, &mut shortlist.distances);
        let rounding = Rounding { error: lists.relative_error(), moved };
        if shortlist.k == 1 {
            let least = least_of_lanes(simd, &shortlist.distances.squared).into_iter().fold(f32::INFINITY, f32::min);
            shortlist.radius = shortlist.radius.min(rounding.farthest(least));
        }
        let mut limit = rounding.limit(shortlist.radius);
        for b in 0..shortlist.distances.squared.len() {
            for lane in lanes_of(up_to(simd, &shortlist.distances.squared[b], limit)) {
                // Padded places are at infinity.
                let squared = shortlist.distances.squared[b][lane];
                if squared < f32::INFINITY {
                    let (nearest, farthest) = (rounding.nearest(squared), rounding.farthest(squared));
                    shortlist.found.push(BoundedPoint {
                        nearest,
                        farthest,
                        place: ((first + b) * LANES + lane) as u32,
                    });
                }
            }
            if shortlist.found.len() >= shortlist.most {
                shortlist.tighten();
                limit = rounding.limit(shortlist.radius);
            }
        }
        shortlist.tighten();
    }
}

//! The few nearest points of some lists, told by rounded distances first. What knows the points
//! exactly lies far apart in memory, and waiting for it takes longer than all else; only those that
//! may be among the few are asked for.

use pulp::{Simd, WithSimd};

use super::inverted_lists::Lists;
use super::scan::{ListRoom, Query, least_of_lanes, square_list, up_to};
use crate::math::LANES;
use crate::math::simd::lanes_of;

/// Writes the distances of points beside their ids.
pub type Exact<'a> = dyn FnMut(&mut [(u32, f64)]) + 'a;

/// Points that may be among the `k` nearest.
#[derive(Debug, Clone, Default)]
pub struct Shortlist {
    k: usize,
    /// No farther point is among them; the first points leave it infinite.
    pub radius: f64,
    found: Vec<Found>,
    /// How many are kept before they are looked through: twice what is left of them, so that equals
    /// by the thousand take no square of time.
    most: usize,
    room: ListRoom,
}

/// A point, no nearer and no farther than this.
#[derive(Debug, Clone, Copy)]
struct Found {
    nearest: f64,
    farthest: f64,
    place: u32,
}

/// How far a point can be from what is computed of it.
#[derive(Clone, Copy)]
struct Rounding {
    /// Of its squared distance, as a share of it.
    error: f64,
    /// Of the point itself.
    moved: f64,
}

impl Rounding {
    /// What a computed squared distance is not above where the point is within `radius`.
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
    /// Begins anew, with nothing farther than `within`.
    pub fn reset(&mut self, k: usize, within: f64) {
        (self.k, self.most, self.radius) = (k, 2 * k, within);
        self.found.clear();
    }

    /// Lessens the radius to what the points so far prove, and drops those beyond it.
    #[inline(never)]
    fn tighten(&mut self) {
        if self.found.len() < self.k {
            return;
        }
        let by_farthest = |a: &Found, b: &Found| a.farthest.total_cmp(&b.farthest);
        let (_, kth, _) = self.found.select_nth_unstable_by(self.k - 1, by_farthest);
        self.radius = self.radius.min(kth.farthest);
        self.found.retain(|found| found.nearest <= self.radius);
        self.most = 2 * self.found.len().max(self.k);
    }

    /// The `k` nearest of what was shown, nearest first, by id where they are equally far, with
    /// what `exact` writes beside them as their distances; none beyond `within`.
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

/// Shows the points of one list to a shortlist.
pub struct ShowList<'a> {
    /// All lists.
    pub lists: &'a Lists,
    /// Which.
    pub list: usize,
    /// What is searched for.
    pub query: Query<'a>,
    /// What keeps the nearest.
    pub shortlist: &'a mut Shortlist,
}

impl WithSimd for ShowList<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lists, list, query, shortlist } = self;
        let first = lists.starts[list] as usize;
        let moved = square_list(simd, lists, list, query.exact, &mut shortlist.room);
        let rounding = Rounding { error: lists.relative_error(), moved };
        if shortlist.k == 1 {
            let least = least_of_lanes(simd, &shortlist.room.squared).into_iter().fold(f32::INFINITY, f32::min);
            shortlist.radius = shortlist.radius.min(rounding.farthest(least));
        }
        let mut limit = rounding.limit(shortlist.radius);
        for b in 0..shortlist.room.squared.len() {
            for lane in lanes_of(up_to(simd, &shortlist.room.squared[b], limit)) {
                // Padded places are at infinity.
                let squared = shortlist.room.squared[b][lane];
                if squared < f32::INFINITY {
                    let (nearest, farthest) = (rounding.nearest(squared), rounding.farthest(squared));
                    shortlist.found.push(Found { nearest, farthest, place: ((first + b) * LANES + lane) as u32 });
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

//! The few nearest points of some lists, told by rounded distances first. What knows the points exactly lies far apart in memory, and waiting
//! for it takes longer than all else; only those that may be among the few are asked for.

use pulp::{Simd, WithSimd};

use super::lists::Lists;
use super::scan::{Query, least_of_lanes, square_list, up_to};
use crate::math::LANES;
use crate::math::register::lanes_of;

/// Writes the distances of points beside their ids.
pub type Exact<'a> = dyn FnMut(&mut [(u32, f64)]) + 'a;

/// Points that may be among the `k` nearest.
#[derive(Debug, Clone, Default)]
pub struct Shortlist {
    k: usize,
    /// No farther point is among them; the first points leave it infinite.
    pub radius: f64,
    /// What a rounded squared distance is not above where the point is within the radius: with what rounding of points, of the query and of
    /// the sum can add to it.
    limit: f32,
    /// Rounded squared distance and place of each.
    found: Vec<(f32, u32)>,
    /// How many are kept before they are looked through: twice what is left of them, so that equals by the thousand take no square of time.
    most: usize,
    /// Of the query to the points of one list.
    squared: Vec<[f32; LANES]>,
}

impl Shortlist {
    /// Begins anew, with nothing farther than `within`.
    pub fn reset(&mut self, k: usize, within: f64, lists: &Lists, moved: f64) {
        (self.k, self.most) = (k, 2 * k);
        self.found.clear();
        self.lessen(within, lists, moved);
    }

    fn lessen(&mut self, radius: f64, lists: &Lists, moved: f64) {
        self.radius = radius;
        self.limit = ((radius + moved).powi(2) * (1.0 + lists.relative_error())) as f32;
    }

    /// Lessens the radius to what a point at this rounded squared distance proves of the nearest.
    fn lessen_to(&mut self, squared: f32, lists: &Lists, moved: f64) {
        let proved = (f64::from(squared) * (1.0 + lists.relative_error())).sqrt() + moved;
        self.lessen(self.radius.min(proved), lists, moved);
    }

    /// Lessens the radius to what the points so far prove, and drops those beyond it.
    #[inline(never)]
    fn tighten(&mut self, lists: &Lists, moved: f64) {
        if self.found.len() < self.k {
            return;
        }
        let (_, (farthest, _), _) = self.found.select_nth_unstable_by(self.k - 1, |a, b| a.0.total_cmp(&b.0));
        let farthest = *farthest;
        self.lessen_to(farthest, lists, moved);
        self.found.retain(|(squared, _)| *squared <= self.limit);
        self.most = 2 * self.found.len().max(self.k);
    }

    /// The `k` nearest of what was shown, nearest first, by id where they are equally far, with what `exact` writes beside them as their distances; none
    /// beyond `within`.
    pub fn finish(&mut self, lists: &Lists, moved: f64, within: f64, exact: &mut Exact, out: &mut Vec<(u32, f64)>) {
        self.tighten(lists, moved);
        out.clear();
        out.extend(self.found.iter().map(|(_, place)| (lists.ids[*place as usize], 0.0)));
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
        let Query { rounded, moved, .. } = query;
        let first = lists.starts[list] as usize;
        square_list(simd, lists, list, rounded, &mut shortlist.squared);
        if shortlist.k == 1 {
            let least = least_of_lanes(simd, &shortlist.squared).into_iter().fold(f32::INFINITY, f32::min);
            shortlist.lessen_to(least, lists, moved);
        }
        for b in 0..shortlist.squared.len() {
            for lane in lanes_of(up_to(simd, &shortlist.squared[b], shortlist.limit)) {
                // Padded places are at infinity.
                let squared = shortlist.squared[b][lane];
                if squared < f32::INFINITY {
                    shortlist.found.push((squared, ((first + b) * LANES + lane) as u32));
                }
            }
            if shortlist.found.len() >= shortlist.most {
                shortlist.tighten(lists, moved);
            }
        }
        shortlist.tighten(lists, moved);
    }
}

//! The few nearest points of some lists, told by rounded distances first. What knows the points exactly lies far apart in memory, and waiting
//! for it takes longer than all else; only those that may be among the few are asked for.

use pulp::{Simd, WithSimd};

use super::lists::Lists;
use super::scan::{Query, add_squares, squared_distances, up_to};
use crate::math::LANES;
use crate::math::register::{F32s, lanes_of, negative};

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
    /// Of the query to the centres of the balls of one list, squared.
    to_balls: Vec<[f32; LANES]>,
    /// Room to order the blocks of one list.
    reaches: Vec<(f32, u32)>,
    /// One bit a block of that list, eight a number: those that were shown first.
    shown: Vec<u32>,
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

    /// Lessens the radius to what the points so far prove, and drops those beyond it.
    #[inline(never)]
    fn tighten(&mut self, lists: &Lists, moved: f64) {
        if self.found.len() < self.k {
            return;
        }
        let (_, (farthest, _), _) = self.found.select_nth_unstable_by(self.k - 1, |a, b| a.0.total_cmp(&b.0));
        let proved = (f64::from(*farthest) * (1.0 + lists.relative_error())).sqrt() + moved;
        self.lessen(self.radius.min(proved), lists, moved);
        self.found.retain(|(squared, _)| *squared <= self.limit);
        self.most = 2 * self.found.len().max(self.k);
    }

    /// The `k` nearest of what was shown, nearest first, by id where they are equally far, with what `exact` says are their distances; none
    /// beyond `within`.
    pub fn finish(
        &mut self,
        lists: &Lists,
        moved: f64,
        within: f64,
        exact: &mut dyn FnMut(u32) -> f64,
        out: &mut Vec<(u32, f64)>,
    ) {
        self.tighten(lists, moved);
        out.clear();
        for (_, place) in &self.found {
            let id = lists.ids[*place as usize];
            out.push((id, exact(id)));
        }
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
        let balls = &lists.balls;
        let (first, last) = (lists.starts[list] as usize, lists.starts[list + 1] as usize);
        let groups = balls.starts[list] as usize..balls.starts[list + 1] as usize;
        shortlist.to_balls.resize(groups.len(), [0.0; LANES]);
        // A loop: what is given to functions of a vector is not compiled for the registers.
        for (squared, centres) in shortlist.to_balls.iter_mut().zip(balls.centres.blocks(groups.start, groups.end)) {
            *squared = squared_distances(simd, centres, rounded);
        }
        shortlist.shown.clear();
        shortlist.shown.resize(groups.len(), 0);
        let radii = &balls.radii[groups];
        if shortlist.radius == f64::INFINITY {
            order_by_reach(simd, (last - first).saturating_sub(1), radii, shortlist);
            for at in 0..shortlist.reaches.len().min(shortlist.k.div_ceil(LANES)) {
                let b = shortlist.reaches[at].1 as usize;
                shortlist.shown[b / LANES] |= 1 << (b % LANES);
                show_block(simd, lists, first + b, query, shortlist);
            }
            shortlist.tighten(lists, moved);
        }
        // The second factor covers the roundings of what is done with it.
        let kept = F32s::splat(simd, (1.0 - lists.relative_error()) as f32 * (1.0 - 1e-6));
        for (g, radii) in radii.iter().enumerate() {
            let mut room = [0.0; LANES];
            for part in 0..F32s::<S>::COUNT {
                let reach = F32s::splat(simd, (shortlist.radius + moved) as f32) + F32s::load(simd, radii, part);
                (reach * reach - F32s::load(simd, &shortlist.to_balls[g], part) * kept).store(&mut room, part);
            }
            let begin = first + g * LANES;
            let blocks_here = (1_u32 << (last - begin).min(LANES)) - 1;
            for b in lanes_of(!negative(&room) & blocks_here & !shortlist.shown[g]).map(|lane| begin + lane) {
                show_block(simd, lists, b, query, shortlist);
            }
        }
        shortlist.tighten(lists, moved);
    }
}

/// Shows the points of one block.
#[inline(always)]
fn show_block<S: Simd>(simd: S, lists: &Lists, b: usize, query: Query, shortlist: &mut Shortlist) {
    let Some(block) = lists.points.blocks(b, b + 1).next() else { return };
    let half = lists.dimensions.div_ceil(2);
    let (first, other) = query.rounded.split_at(half);
    // Half of the coordinates rule out most blocks.
    let squared = squared_distances(simd, &block[..half], first);
    if up_to(simd, &squared, shortlist.limit) == 0 {
        return;
    }
    let squared = add_squares(simd, &block[half..], other, squared);
    for lane in lanes_of(up_to(simd, &squared, shortlist.limit)) {
        // Padded places are at infinity.
        if squared[lane] < f32::INFINITY {
            shortlist.found.push((squared[lane], (b * LANES + lane) as u32));
        }
    }
    if shortlist.found.len() >= shortlist.most {
        shortlist.tighten(lists, query.moved);
    }
}

/// Orders the first blocks of a list, by how far the farthest point of each may be.
#[inline(always)]
fn order_by_reach<S: Simd>(simd: S, blocks: usize, radii: &[[f32; LANES]], shortlist: &mut Shortlist) {
    let Shortlist { k, to_balls, reaches, .. } = shortlist;
    reaches.clear();
    for (g, (squared, radii)) in to_balls.iter().zip(radii).enumerate() {
        let mut reach = [0.0; LANES];
        for part in 0..F32s::<S>::COUNT {
            (F32s::load(simd, squared, part).sqrt() + F32s::load(simd, radii, part)).store(&mut reach, part);
        }
        reaches.extend(reach.iter().enumerate().map(|(lane, reach)| (*reach, (g * LANES + lane) as u32)));
    }
    reaches.truncate(blocks);
    let first = k.div_ceil(LANES);
    if first < reaches.len() {
        reaches.select_nth_unstable_by(first, |a, b| a.0.total_cmp(&b.0));
    }
}

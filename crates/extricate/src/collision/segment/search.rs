//! Steps that every search along a segment shares: placing configurations, and finding the pairs
//! that are not proved apart along a stretch.

use super::stretches::{SegmentScratch, Stretch};
use crate::collision::checker::{CheckScratch, Checker};
use crate::kinematics::ball_speeds;

/// Finest resolution of segments \[m\]; below it, the errors of the exact tests would matter.
pub const LEAST_RESOLUTION: f64 = 1e-5;

/// Share of the resolution down to which stretches are halved. Contacts at an oblique angle end the
/// last proved stretch several stretch lengths early; this leaves room for sixteen.
pub const MIN_STRETCH_SHARE: f64 = 1.0 / 16.0;

/// Stretches after which a proof is given up. Motions of metres take some thousands; motions of
/// bodies as large as a million kilometres would take years.
pub const MAX_STRETCHES: usize = 1 << 18;

/// Margin \[m\] above the error of the exact tests, so that they never call a proved configuration
/// colliding.
const TEST_MARGIN_M: f64 = 2e-7;

/// Limits of a proof.
pub struct SegmentBudget<'a> {
    /// Number of stretches after which the proof is given up.
    pub stretches: usize,
    /// Returns whether the caller's budget is spent, given the number of configurations evaluated
    /// so far.
    pub is_spent: &'a dyn Fn(usize) -> bool,
}

impl SegmentBudget<'_> {
    /// No limit but that of the stretches.
    pub const UNLIMITED: Self = Self { stretches: MAX_STRETCHES, is_spent: &|_| false };
}

pub struct Search<'a> {
    pub checker: &'a Checker,
    pub from: &'a [f64],
    pub to: &'a [f64],
    pub scratch: &'a mut CheckScratch,
    pub own: &'a mut SegmentScratch,
    pub budget: &'a SegmentBudget<'a>,
}

impl Search<'_> {
    pub fn is_spent(&self) -> bool {
        (self.budget.is_spent)(self.own.checks)
    }

    /// Starts with one stretch and all pairs.
    pub fn begin(&mut self) {
        let SegmentScratch { stretches, pairs, .. } = &mut *self.own;
        pairs.clear();
        pairs.extend(0..self.checker.pairs.len() as u32);
        stretches.clear();
        stretches.push(Stretch { from: 0.0, to: 1.0, first: 0, last: pairs.len() });
    }

    /// Places all bodies at the middle of a stretch, and appends the pairs that are not proved
    /// apart along it to the list of pairs. Returns the pair of them that may move fastest, and its
    /// speed \[m per segment\].
    pub fn unproved(&mut self, stretch: &Stretch) -> Option<(usize, f64)> {
        let checker = self.checker;
        let half = 0.5 * (stretch.to - stretch.from);
        self.place(0.5 * (stretch.from + stretch.to));
        let SegmentScratch { rates, speeds, pairs, .. } = &mut *self.own;
        let placement = &self.scratch.placement;
        speeds.clear();
        for (body, center) in checker.bodies.bodies.iter().zip(&placement.centers) {
            let ball = (body.frame, center, body.ball.1.max(0.0));
            ball_speeds(&checker.scene, &placement.poses, rates, half, ball, speeds);
        }
        let mut fastest: Option<(usize, f64)> = None;
        for at in stretch.first..stretch.last {
            let index = pairs[at] as usize;
            let [a, b] = checker.paths.pairs[index];
            let speed = speeds[a] + speeds[b];
            // If the two do not move relative to each other, the middle decides for the whole
            // stretch.
            let need = if speed > 0.0 { half * speed + TEST_MARGIN_M } else { 0.0 };
            let limit = checker.clearance_of(index) + need;
            let pair = &checker.pairs[index];
            let centers = &self.scratch.placement.centers;
            let reach = pair.radii + limit;
            let far = reach < 0.0 || (centers[pair.first] - centers[pair.second]).norm_squared() > reach * reach;
            if far || !checker.pair_nearer(index, limit, self.scratch) {
                continue;
            }
            pairs.push(index as u32);
            if fastest.is_none_or(|(_, most)| speed > most) {
                fastest = Some((index, speed));
            }
        }
        fastest
    }

    fn place(&mut self, at: f64) {
        self.own.checks += 1;
        self.checker.scene.space.interpolate(self.from, self.to, at, &mut self.own.q);
        self.checker.place(&self.own.q, self.scratch);
    }

    /// Finds a pair that collides at a fraction of the segment.
    pub fn colliding(&mut self, at: f64) -> Option<usize> {
        self.place(at);
        self.checker.find_near(self.checker.most_clearance, self.scratch);
        // Check pairs in order, so that the pair named does not depend on earlier checks.
        let mut near = std::mem::take(&mut self.scratch.broad.pairs);
        near.sort_unstable();
        let found = near.iter().map(|&p| p as usize).find(|&pair| self.checker.pair_collides(pair, self.scratch));
        self.scratch.broad.pairs = near;
        found
    }
}

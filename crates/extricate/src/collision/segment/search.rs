//! What every search along a segment does: it places configurations, and tells which pairs are
//! proved apart all along a stretch.

use super::stretches::{SegmentScratch, Stretch};
use crate::collision::checker::{CheckScratch, Checker};
use crate::kinematics::ball_speeds;

/// Finest resolution of segments \[m\]: below it, what exact tests err by counts.
pub const LEAST_RESOLUTION: f64 = 1e-5;

/// Least part of the resolution that stretches are cut to. A contact is met at an angle, so the
/// last proved stretch ends some lengths of a stretch before it: there is room for sixteen.
pub const FINEST: f64 = 1.0 / 16.0;

/// Stretches after which a proof is given up. Motions of metres take some thousands; bodies of a
/// million kilometres would take years.
pub const MOST_STRETCHES: usize = 1 << 18;

/// More than exact tests err by \[m\]: what is proved here is not called colliding there.
const SLACK: f64 = 2e-7;

/// How long a proof goes on.
pub struct SegmentBudget<'a> {
    /// Stretches after which it is given up.
    pub stretches: usize,
    /// Whether the caller's budget is spent, if the proof has evaluated so many configurations.
    pub is_spent: &'a dyn Fn(usize) -> bool,
}

impl SegmentBudget<'_> {
    /// As long as a proof takes.
    pub const UNLIMITED: Self = Self { stretches: MOST_STRETCHES, is_spent: &|_| false };
}

/// One search along a segment.
pub struct Search<'a> {
    pub checker: &'a Checker,
    pub from: &'a [f64],
    pub to: &'a [f64],
    pub scratch: &'a mut CheckScratch,
    pub own: &'a mut SegmentScratch,
    pub budget: &'a SegmentBudget<'a>,
}

impl Search<'_> {
    /// Whether the caller's budget ends the proof here.
    pub fn is_spent(&self) -> bool {
        (self.budget.is_spent)(self.own.checks)
    }

    /// One stretch, and all pairs.
    pub fn begin(&mut self) {
        let SegmentScratch { stretches, pairs, .. } = &mut *self.own;
        pairs.clear();
        pairs.extend(0..self.checker.pairs.len() as u32);
        stretches.clear();
        stretches.push(Stretch { from: 0.0, to: 1.0, first: 0, last: pairs.len() });
    }

    /// Puts the pairs that are not proved apart all along a stretch behind all others, and
    /// everything in its middle; gives the one of them that may move fastest, and its speed [m per
    /// segment].
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
            // Where the two do not move against each other, the middle stands for all.
            let need = if speed > 0.0 { half * speed + SLACK } else { 0.0 };
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

    /// A pair that collides at a fraction of the segment.
    pub fn colliding(&mut self, at: f64) -> Option<usize> {
        self.place(at);
        self.checker.find_near(self.checker.most_clearance, self.scratch);
        // In order of the pairs: which one is named does not depend on what was asked before.
        let mut near = std::mem::take(&mut self.scratch.broad.pairs);
        near.sort_unstable();
        let found = near.iter().map(|&p| p as usize).find(|&pair| self.checker.pair_collides(pair, self.scratch));
        self.scratch.broad.pairs = near;
        found
    }
}

//! Points moved back toward the old path, and those removed that are not needed.

use super::old_path::Point;
use super::repairer::Repairer;

/// Shares of the way back to the old path that are tried, the whole of it first.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// How often all points are tried.
const PASSES: usize = 2;

impl Repairer<'_> {
    /// The same path nearer to the old one, where edges are proved: its ends stay.
    pub(super) fn pull(&mut self, mut points: Vec<Point>) -> Vec<Point> {
        self.drop_points(&mut points);
        for _ in 0..PASSES {
            for at in 1..points.len().saturating_sub(1) {
                self.pull_point(&mut points, at);
            }
        }
        self.drop_points(&mut points);
        points
    }

    fn pull_point(&mut self, points: &mut [Point], at: usize) {
        let (place, q) = &points[at];
        let old = self.old.at(*place);
        if *q == old {
            return;
        }
        let mut moved = q.clone();
        for share in SHARES {
            self.context.checker.scene().space.interpolate(q, &old, share, &mut moved);
            if self.prover.is_spent() {
                return;
            }
            let is_proved =
                self.prover.proves(&points[at - 1].1, &moved) && self.prover.proves(&points[at + 1].1, &moved);
            if is_proved {
                points[at].1 = moved;
                return;
            }
        }
    }

    /// Removes points whose neighbours a proved edge joins that is no farther from the old path
    /// than they are.
    fn drop_points(&mut self, points: &mut Vec<Point>) {
        let mut at = 1;
        while at + 1 < points.len() && !self.prover.is_spent() {
            let (before, after) = (&points[at - 1], &points[at + 1]);
            let share = (points[at].0 - before.0) / (after.0 - before.0).max(1e-12);
            let mut between = before.1.clone();
            self.context.checker.scene().space.interpolate(&before.1, &after.1, share, &mut between);
            let is_nearer = self.deviation(&(points[at].0, between)) <= self.deviation(&points[at]);
            if is_nearer && self.prover.proves(&before.1, &after.1) {
                points.remove(at);
            } else {
                at += 1;
            }
        }
    }
}

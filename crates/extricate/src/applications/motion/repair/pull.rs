//! Points moved back toward the old path, and those removed that are not needed.

use rand::RngExt;

use super::old_path::Point;
use super::repairer::Repairer;

/// Shares of the way back to the old path that are tried, the whole of it first.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// How often all points are tried.
const PASSES: usize = 2;
/// Edges that are tried between other points of a path of trees, for each of its points.
const ATTEMPTS_A_POINT: usize = 2;

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

    /// Removes points that trees made and that are not needed.
    pub(super) fn shortcut(&mut self, points: &mut Vec<Point>) {
        for _ in 0..ATTEMPTS_A_POINT * points.len() {
            if points.len() < 3 || self.prover.is_spent() {
                return;
            }
            let first = self.rng.random_range(0..points.len() - 2);
            let last = self.rng.random_range(first + 2..points.len());
            let [before, after] = [first, last].map(|at| &points[at]);
            let farthest = points[first + 1..last].iter().map(|point| self.deviation(point)).fold(0.0, f64::max);
            let between = points[first + 1..last].iter().map(|(place, _)| self.between(before, after, *place));
            let is_near = between.into_iter().all(|point| self.deviation(&point) <= farthest);
            if is_near && self.prover.proves(&before.1, &after.1) {
                points.drain(first + 1..last);
            }
        }
    }

    /// The point of an edge that stands for a place.
    fn between(&self, before: &Point, after: &Point, place: f64) -> Point {
        let share = (place - before.0) / (after.0 - before.0).max(1e-12);
        let mut q = before.1.clone();
        self.context.checker.scene().space.interpolate(&before.1, &after.1, share, &mut q);
        (place, q)
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
            let between = self.between(before, after, points[at].0);
            let is_nearer = self.deviation(&between) <= self.deviation(&points[at]);
            if is_nearer && self.prover.proves(&before.1, &after.1) {
                points.remove(at);
            } else {
                at += 1;
            }
        }
    }
}

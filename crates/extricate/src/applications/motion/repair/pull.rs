//! Moves points back toward the old path, and removes those that are not needed.

use rand::RngExt;

use super::old_path::Point;
use super::repairer::Repairer;

/// Shares of the way back to the old path that are tried, the whole of it first.
const PULL_SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Passes in which all points are tried.
const PULL_PASSES: usize = 3;
/// Edges tried between random points of a path of trees, for each of its points.
const ATTEMPTS_PER_POINT: usize = 2;

impl Repairer<'_> {
    /// Moves the path nearer to the old one, as far as edges are proved; its ends stay.
    pub(super) fn pull(&mut self, mut points: Vec<Point>) -> Vec<Point> {
        self.spread(&mut points);
        self.drop_points(&mut points);
        for _ in 0..PULL_PASSES {
            self.split(&mut points);
            for at in 1..points.len().saturating_sub(1) {
                self.pull_point(&mut points, at);
            }
            self.spread(&mut points);
        }
        self.drop_points(&mut points);
        points
    }

    /// Removes points of trees that are not needed.
    pub(super) fn shortcut(&mut self, points: &mut Vec<Point>) {
        for _ in 0..ATTEMPTS_PER_POINT * points.len() {
            if points.len() < 3 || self.prover.is_spent() {
                return;
            }
            let first = self.rng.random_range(0..points.len() - 2);
            let last = self.rng.random_range(first + 2..points.len());
            if self.is_no_farther(&points[first..=last]) && self.prover.proves(&points[first].1, &points[last].1) {
                points.drain(first + 1..last);
            }
        }
    }

    /// Whether the edge from the first of some points to the last is no farther from the old path
    /// than the points are, at every place between where either bends.
    fn is_no_farther(&self, points: &[Point]) -> bool {
        let (before, after) = (&points[0], &points[points.len() - 1]);
        let inner = &points[1..points.len() - 1];
        let places: Vec<f64> = inner.iter().map(|(place, _)| *place).collect();
        let rows = points.iter().zip(&points[1..]).map(|(a, b)| self.farthest_on(a, b, &[]));
        let farthest = inner.iter().map(|point| self.deviation(point)).chain(rows).fold(0.0, f64::max);
        self.farthest_on(before, after, &places) <= farthest
    }

    /// Gives points other places, if the path is then nearer to the old one: trees know no places,
    /// and a path that is pushed aside may stand still and then hurry. A new place is the mean of
    /// two: the one that the point's share of the length has, which ascends, and the nearest one.
    fn spread(&self, points: &mut [Point]) {
        if self.prover.is_spent() {
            return;
        }
        let Some((from, to)) = points.first().zip(points.last()).map(|(a, b)| (a.0, b.0)) else { return };
        let metric = self.context.metric;
        let steps = points.iter().zip(points.iter().skip(1)).map(|(a, b)| metric.distance(&a.1, &b.1));
        let lengths: Vec<f64> = steps
            .scan(0.0, |sum, step| {
                Some({
                    *sum += step;
                    *sum
                })
            })
            .collect();
        let Some(all) = lengths.last().copied().filter(|all| *all > 0.0) else { return };
        let (mut spread, mut nearest) = (points.to_vec(), from);
        for (point, length) in spread.iter_mut().skip(1).zip(&lengths[..lengths.len() - 1]) {
            nearest = self.old.nearest_place(&point.1, nearest, to);
            point.0 = 0.5 * (nearest + from + (to - from) * length / all);
        }
        if self.farthest(&spread) < self.farthest(points) {
            points.clone_from_slice(&spread);
        }
    }

    /// Adds points where the path is farthest from the old one: near a corner, points can only be
    /// moved back if the path bends there.
    fn split(&self, points: &mut Vec<Point>) {
        let (mut worst, mut row_at, mut edge) = (0.0, None, 0);
        for at in 0..points.len().saturating_sub(1) {
            let (before, after) = (&points[at], &points[at + 1]);
            let rows = self.old.rows_between(before.0, after.0).map(|row| row as f64);
            let on_edge = rows.map(|place| (self.deviation(&self.between(before, after, place)), Some(place)));
            let at_point = (at > 0).then(|| (self.deviation(before), None));
            for (deviation, place) in on_edge.chain(at_point) {
                if deviation > worst {
                    (worst, row_at, edge) = (deviation, place, at);
                }
            }
        }
        let middle = |points: &[Point], at: usize| {
            self.between(&points[at], &points[at + 1], 0.5 * (points[at].0 + points[at + 1].0))
        };
        match row_at {
            Some(place) => points.insert(edge + 1, self.between(&points[edge], &points[edge + 1], place)),
            None if worst > 0.0 => {
                points.insert(edge + 1, middle(points, edge));
                points.insert(edge, middle(points, edge - 1));
            }
            None => {}
        }
    }

    fn pull_point(&mut self, points: &mut [Point], at: usize) {
        let (place, q) = &points[at];
        let old = self.old.at(*place);
        if *q == old {
            return;
        }
        let mut moved = q.clone();
        for share in PULL_SHARES {
            self.context.checker.scene().space.interpolate(q, &old, share, &mut moved);
            if self.prover.is_spent() {
                return;
            }
            // A projected point may be farther from the old path than before.
            let is_near = self.prover.keeps(&moved)
                || self.prover.project(&mut moved)
                    && self.deviation(&(points[at].0, moved.clone())) < self.deviation(&points[at]);
            let is_proved = is_near
                && self.prover.proves(&points[at - 1].1, &moved)
                && self.prover.proves(&points[at + 1].1, &moved);
            if is_proved {
                points[at].1 = moved;
                return;
            }
        }
    }

    /// Removes a point if a proved edge joins its neighbours and is no farther from the old path.
    fn drop_points(&mut self, points: &mut Vec<Point>) {
        let mut at = 1;
        while at + 1 < points.len() && !self.prover.is_spent() {
            let three = &points[at - 1..=at + 1];
            if self.is_no_farther(three) && self.prover.proves(&three[0].1, &three[2].1) {
                points.remove(at);
            } else {
                at += 1;
            }
        }
    }
}

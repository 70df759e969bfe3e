//! Brings configurations of a stretch to free ones beside it.

use super::old_path::Point;
use super::repairer::Repairer;
use crate::query::{QueryOptions, nearest_exit_under};

/// Largest distance between configurations of a stretch, as a share of the metric's diameter.
pub const STEP_SHARE: f64 = 0.02;
/// Minimum number of steps along a stretch.
const MIN_STEPS: usize = 2;
/// Times that an unproved edge is halved, and its middle pushed out.
const HALVING_LEVELS: usize = 4;

/// New points of a stretch, and for each whether the edge from the one before is proved.
pub struct PushedStretch {
    pub points: Vec<Point>,
    pub is_joined: Vec<bool>,
}

impl Repairer<'_> {
    /// Returns points from one place to another; the ends stay if they are free. Returns `None` if
    /// an end leads to no free configuration, or if the budget is spent.
    pub(super) fn push(&mut self, from: f64, to: f64) -> Option<PushedStretch> {
        let length = self.old.length_between(from, to);
        let steps = (length / (STEP_SHARE * self.context.metric.diameter())).ceil() as usize;
        let count = if to > from { steps.max(MIN_STEPS) } else { 0 };
        let place = |k: usize| if k == count { to } else { from + (to - from) * k as f64 / count as f64 };
        let mut places: Vec<f64> = (0..=count).map(place).collect();
        if self.prover.is_held() {
            // Rows may keep links between which straight edges do not.
            places.extend(self.old.rows_between(from, to).map(|row| row as f64));
            places.sort_by(f64::total_cmp);
            places.dedup();
        }
        self.stream.restart();
        let mut pushed = PushedStretch { points: Vec::new(), is_joined: Vec::new() };
        for (k, place) in places.iter().copied().enumerate() {
            let is_end = k == 0 || k + 1 == places.len();
            let Some(q) = self.beside(place, is_end) else {
                // Trees can replace what lies between two free ends, but not an end.
                if is_end || self.prover.is_spent() {
                    return None;
                }
                continue;
            };
            match pushed.points.last().cloned() {
                None => pushed.add((place, q), true),
                Some(last) => self.join(last, (place, q), HALVING_LEVELS, &mut pushed),
            }
        }
        Some(pushed)
    }

    /// Returns the old configuration if it is free, or one nearby that keeps the links; else the
    /// one that the stream leads to.
    fn beside(&mut self, place: f64, is_end: bool) -> Option<Vec<f64>> {
        let q = self.old.at(place);
        if self.prover.is_spent() {
            return None;
        }
        if self.prover.holds(&q) {
            if !is_end {
                self.stream.restart();
            }
            return Some(q);
        }
        let mut near = q.clone();
        if self.prover.is_held() && self.prover.project(&mut near) && self.prover.holds(&near) {
            return Some(near);
        }
        let config = self.context.checker.scene().space.config(&q).ok()?;
        self.next_beside(&config)
    }

    /// Adds a point. If the edge to it is not proved, first adds what its middle is pushed out to.
    fn join(&mut self, last: Point, next: Point, levels: usize, pushed: &mut PushedStretch) {
        if let Some(way) = self.prover.join(&last.1, &next.1) {
            let edges = way.len();
            let place = |k: usize| last.0 + (next.0 - last.0) * k as f64 / edges as f64;
            way.into_iter().take(edges - 1).enumerate().for_each(|(k, q)| pushed.add((place(k + 1), q), true));
            return pushed.add(next, true);
        }
        if levels == 0 || self.prover.is_spent() {
            return pushed.add(next, false);
        }
        let mut middle = last.1.clone();
        self.context.checker.scene().space.interpolate(&last.1, &next.1, 0.5, &mut middle);
        let middle = if self.prover.holds(&middle) { Some(middle) } else { self.nearest(&middle) };
        let Some(middle) = middle else { return pushed.add(next, false) };
        let place = 0.5 * (last.0 + next.0);
        self.join(last, (place, middle.clone()), levels - 1, pushed);
        self.join((place, middle), next, levels - 1, pushed);
    }

    /// Returns the exit that one start finds: it lies on the side of the edge.
    fn nearest(&mut self, q: &[f64]) -> Option<Vec<f64>> {
        let config = self.context.checker.scene().space.config(q).ok()?;
        let aim = Some(self.options.aim_over(self.context));
        let options =
            QueryOptions { starts: Some(1), clearance: aim, termination: self.left(), ..QueryOptions::default() };
        let answer = nearest_exit_under(self.context, &config, &options, true, &mut self.query);
        self.prover.checks += self.query.checks();
        answer.map(|answer| Vec::from(answer.witness))
    }
}

impl PushedStretch {
    fn add(&mut self, point: Point, is_joined: bool) {
        self.points.push(point);
        self.is_joined.push(is_joined);
    }
}

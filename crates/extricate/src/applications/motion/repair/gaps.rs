//! Closes gaps between pushed points by trees near the old path.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::old_path::Point;
use super::push_stretch::PushedStretch;
use super::repairer::Repairer;
use crate::applications::motion::rrt_connect::RrtConnect;
use crate::cspace::sampling::uniform;

/// Checks of the first round of trees; each further round doubles them, and the tube's radius.
const FIRST_ROUND_CHECKS: usize = 500;
/// Radius of the first tube, as a share of the metric's diameter.
const TUBE_RADIUS_SHARE: f64 = 0.05;
/// Longest edge of a tree, as the same share.
const MAX_EDGE_SHARE: f64 = 0.1;
/// Share of samples that are pushed points between two gaps, if there are any.
const PUSHED_SAMPLE_SHARE: f64 = 0.25;

/// PushedStretch points: those that proved edges join to the first, those joined to the last, and
/// others.
struct Parts<'a> {
    first: &'a [Point],
    between: &'a [Point],
    last: &'a [Point],
}

impl Repairer<'_> {
    /// Returns the points if all edges between them are proved. Else it returns a path that leaves
    /// them before the first gap and comes back behind the last, or `None` if none is found.
    pub(super) fn close(&mut self, pushed: PushedStretch) -> Option<Vec<Point>> {
        let PushedStretch { points, is_joined } = pushed;
        let gaps: Vec<usize> = (1..points.len()).filter(|at| !is_joined[*at]).collect();
        let (Some(&first), Some(&last)) = (gaps.first(), gaps.last()) else { return Some(points) };
        self.gaps += gaps.len();
        let parts = Parts { first: &points[..first], between: &points[first..last], last: &points[last..] };
        let mut closed = self.bridge(&parts)?;
        self.shortcut(&mut closed);
        Some(closed)
    }

    /// Returns a path from the first point to the last, by trees in a widening tube.
    fn bridge(&mut self, parts: &Parts) -> Option<Vec<Point>> {
        let metric = self.context.metric;
        let roots = [parts.first, parts.last].map(|points| points.iter().map(|(_, q)| q.clone()).collect::<Vec<_>>());
        let (from, to) = (parts.first[0].0, parts.last[parts.last.len() - 1].0);
        let (mut radius, mut round) = (TUBE_RADIUS_SHARE * metric.diameter(), FIRST_ROUND_CHECKS);
        let mut trees = RrtConnect::new(metric, [&roots[0], &roots[1]], MAX_EDGE_SHARE * metric.diameter());
        while !self.prover.is_spent() {
            let (old, space, mut far) = (&self.old, &metric.scene().space, vec![0.0; roots[0][0].len()]);
            let mut sample = |rng: &mut ChaCha8Rng, out: &mut [f64]| {
                if !parts.between.is_empty() && rng.random::<f64>() < PUSHED_SAMPLE_SHARE {
                    out.copy_from_slice(&parts.between[rng.random_range(0..parts.between.len())].1);
                    return;
                }
                let middle = old.at(from + (to - from) * rng.random::<f64>());
                uniform(space, rng, &mut far);
                let share = (radius / metric.distance(&middle, &far)).min(1.0);
                space.interpolate(&middle, &far, share * rng.random::<f64>(), out);
            };
            let limited = self.prover.limited(round);
            let path = trees.grow(&mut self.prover, &mut sample, &mut self.rng);
            self.prover.unlimit(limited);
            if let Some(path) = path {
                return joined(parts, path);
            }
            (radius, round) = (2.0 * radius, 2 * round);
        }
        None
    }
}

/// Puts a path of trees between the points up to its first root and those from its last root on.
fn joined(parts: &Parts, path: Vec<Vec<f64>>) -> Option<Vec<Point>> {
    let first = parts.first.iter().position(|(_, q)| *q == path[0])?;
    let last = parts.last.iter().position(|(_, q)| *q == path[path.len() - 1])?;
    let (from, to) = (parts.first[first].0, parts.last[last].0);
    let edges = (path.len() - 1).max(1) as f64;
    // Rounding must not put a place beyond the last one.
    let place = |k: usize| (from + (to - from) * k as f64 / edges).min(to);
    let inner = path.len().saturating_sub(2);
    let new = path.into_iter().enumerate().skip(1).take(inner).map(|(k, q)| (place(k), q));
    let (before, after) = (&parts.first[..=first], &parts.last[last..]);
    Some(before.iter().cloned().chain(new).chain(after.iter().cloned()).collect())
}

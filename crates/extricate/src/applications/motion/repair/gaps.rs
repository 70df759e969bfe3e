//! Gaps between pushed points: closed by trees near the old path.

use rand::RngExt;

use super::old_path::Point;
use super::push::Pushed;
use super::repairer::Repairer;
use crate::applications::motion::rrt_connect::RrtConnect;
use crate::cspace::sampling::uniform;

/// Checks of the first round of trees; each further one has twice as many, and a tube twice as
/// wide.
const FIRST_ROUND: usize = 500;
/// Radius of the first tube, as a share of the metric's diameter, and longest edge in a tube, as a
/// share of its radius.
const TUBE: f64 = 0.05;
const RANGE: f64 = 1.0;

impl Repairer<'_> {
    /// The same points with paths between those whose edge is not proved; `None` where one is not
    /// found.
    pub(super) fn close(&mut self, pushed: Pushed) -> Option<Vec<Point>> {
        let Pushed { points, is_joined } = pushed;
        let mut closed: Vec<Point> = Vec::new();
        let mut at = 0;
        while at < points.len() {
            if at == 0 || is_joined[at] {
                closed.push(points[at].clone());
                at += 1;
                continue;
            }
            // Points on their own between two gaps are no help.
            let mut last = at;
            while last + 1 < points.len() && !is_joined[last + 1] {
                last += 1;
            }
            self.gaps += 1;
            let from = closed[closed.len() - 1].clone();
            closed.extend(self.bridge(&from, &points[last])?.into_iter().skip(1));
            at = last + 1;
        }
        Some(closed)
    }

    /// A path between two points, by trees in a tube around the old path that grows.
    fn bridge(&mut self, from: &Point, to: &Point) -> Option<Vec<Point>> {
        let (metric, space) = (self.context.metric, &self.context.checker.scene().space);
        let ends = [vec![from.1.clone()], vec![to.1.clone()]];
        let (mut radius, mut round) = (TUBE * metric.diameter(), FIRST_ROUND);
        while !self.prover.is_spent() {
            let (old, mut far) = (&self.old, vec![0.0; space.nq()]);
            let mut sample = |rng: &mut rand_chacha::ChaCha8Rng, out: &mut [f64]| {
                let middle = old.at(from.0 + (to.0 - from.0) * rng.random::<f64>());
                uniform(space, rng, &mut far);
                let share = (radius / metric.distance(&middle, &far)).min(1.0);
                space.interpolate(&middle, &far, share * rng.random::<f64>(), out);
            };
            let range = RANGE * radius;
            let mut trees = RrtConnect::new(metric, [&ends[0], &ends[1]], range);
            let limited = self.prover.limited(round);
            let path = trees.grow(&mut self.prover, &mut sample, &mut self.rng);
            self.prover.unlimit(limited);
            if let Some(path) = path {
                let last = (path.len() - 1) as f64;
                let place = |k: usize| from.0 + (to.0 - from.0) * k as f64 / last;
                return Some(path.into_iter().enumerate().map(|(k, q)| (place(k), q)).collect());
            }
            (radius, round) = (2.0 * radius, 2 * round);
        }
        None
    }
}

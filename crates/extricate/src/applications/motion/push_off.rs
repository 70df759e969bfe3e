//! Pushes the points of a path off what they are near.

use super::prover::Prover;
use crate::metric::Anchor;
use crate::query::constraints::push_nearby;
use crate::query::{Context, Deadline, QueryScratch};

/// Longest edge of a path before its points are pushed, as a share of the metric's diameter.
const MAX_EDGE_SHARE: f64 = 0.02;

/// Divides the edges of a path, and moves each point between the ends to one nearby that keeps
/// `clearance` \[m\], or as much of it as halving its excess finds. A point stays if the edges
/// beside it would not be proved.
///
/// # Guarantee
/// Every edge of the result is proved if all edges of the path are. The ends stay.
pub fn push_off(prover: &mut Prover, context: &Context, points: &mut Vec<Vec<f64>>, clearance: f64) {
    let old = divided(prover, context, points);
    let (mut new, mut memory, mut anchor) = (vec![old[0].clone()], QueryScratch::default(), Anchor::default());
    for (at, point) in old.iter().enumerate().skip(1) {
        if at + 1 == old.len() || prover.is_spent() {
            new.push(point.clone());
            continue;
        }
        context.metric.anchor(point, &mut anchor);
        memory.evaluator.begin(Deadline::of(&prover.left()));
        let pushed = push_nearby(context, &anchor, point, (clearance, false), &mut memory);
        prover.checks += memory.checks();
        // The edge from the last new point to this old one is proved.
        let is_joined =
            |pushed: &Vec<f64>| prover.proves(&new[new.len() - 1], pushed) && prover.proves(pushed, &old[at + 1]);
        let pushed = pushed.map(|(_, pushed)| pushed).filter(is_joined);
        new.push(pushed.unwrap_or_else(|| point.clone()));
    }
    *points = new;
}

/// Returns the path with its edges divided into pieces that are proved again; an edge stays whole
/// if one of its pieces is not.
fn divided(prover: &mut Prover, context: &Context, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let space = &context.checker.scene().space;
    let longest = MAX_EDGE_SHARE * context.metric.diameter();
    let mut new = vec![points[0].clone()];
    for edge in points.windows(2) {
        let pieces = (context.metric.distance(&edge[0], &edge[1]) / longest).ceil().max(1.0) as usize;
        let at = |piece: usize| {
            let mut q = vec![0.0; space.nq()];
            space.interpolate(&edge[0], &edge[1], piece as f64 / pieces as f64, &mut q);
            q
        };
        let inner: Vec<Vec<f64>> = (0..=pieces)
            .map(|k| {
                if k == 0 {
                    edge[0].clone()
                } else if k == pieces {
                    edge[1].clone()
                } else {
                    at(k)
                }
            })
            .collect();
        let is_proved = inner.windows(2).all(|piece| prover.proves(&piece[0], &piece[1]));
        new.extend(if is_proved { inner[1..].to_vec() } else { vec![edge[1].clone()] });
    }
    new
}

//! Queries beyond the joint limits: not free, and measured from as they are; witnesses are within.

use crate::cspace::{ConfigSpace, Factor, Manifold};
use crate::query::answer::Answer;
use crate::query::search::Search;
use crate::scene::MetricKind;

/// Moves a query onto the limits, and notes what collides there; whether that is the answer.
///
/// # Guarantee
/// Under the metric of the joints no configuration within the limits is nearer than that one: each
/// coordinate is as near as it can be. Where it is free, it is the nearest free one.
pub fn begin(search: &mut Search, answer: &mut Answer) -> bool {
    let (context, space) = (search.context, &search.context.checker.scene().space);
    let mut within = search.known.anchor.q.clone();
    space.clamp(&mut within);
    search.evaluator.checks += 1;
    search.known.colliding_within.clear();
    let colliding = &mut search.known.colliding_within;
    context.checker.colliding_pairs(&within, &mut search.evaluator.check, colliding);
    if context.metric.kind() != MetricKind::Joint || !search.known.colliding_within.is_empty() {
        return false;
    }
    let depth = search.evaluator.distance(context, &search.known.anchor, &within);
    search.known.take(depth, &within, true);
    answer.unseen = Some(0.0);
    true
}

/// Proved: no configuration within the limits is nearer to the query than this, in metric units; 0
/// under the metrics of bodies.
pub fn lower_bound(kind: MetricKind, space: &ConfigSpace, q: &[f64]) -> f64 {
    if kind != MetricKind::Joint {
        return 0.0;
    }
    let beyond = |factor: &Factor| match factor.manifold {
        Manifold::Interval { lower, upper } => factor.weight * (q[factor.q] - q[factor.q].clamp(lower, upper)).powi(2),
        Manifold::Circle | Manifold::Rotation => 0.0,
    };
    space.factors().iter().map(beyond).sum::<f64>().sqrt()
}

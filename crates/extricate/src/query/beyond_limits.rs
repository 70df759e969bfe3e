//! Queries beyond the joint limits. They are not free; distances are from the query as it is, and
//! witnesses are within the limits.

use crate::cspace::{ConfigSpace, Factor, Manifold};
use crate::query::answer::Answer;
use crate::query::context::Context;
use crate::query::search::scratch::QueryScratch;
use crate::scene::{MetricKind, PairId};

/// Lists the pairs that have to part at the query moved onto the limits.
pub fn pairs_at_rest(context: &Context, answer: &Answer, scratch: &mut QueryScratch, pairs: &mut Vec<PairId>) {
    pairs.clear();
    if answer.outside.is_empty() {
        return pairs.extend_from_slice(&answer.colliding);
    }
    let QueryScratch { evaluator, known, .. } = scratch;
    evaluator.checks += 1;
    context.checker.colliding_pairs(&known.rest, &mut evaluator.check, pairs);
}

/// Returns whether the query moved onto the limits, at which these pairs collide, is the nearest
/// exit.
///
/// # Guarantee
/// Under the metric of the joints no configuration within the limits is nearer than that one: each
/// coordinate is as near as it can be. If that one is free, it is the nearest free one.
pub fn is_rest_nearest(context: &Context, pairs: &[PairId]) -> bool {
    pairs.is_empty() && !context.is_held() && context.metric.kind() == MetricKind::Joint
}

/// Returns a proved bound \[metric units\]: no configuration within the limits is nearer to the
/// query. 0 under the metrics of bodies.
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

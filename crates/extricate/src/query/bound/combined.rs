//! Combines all bounds of a query: balls, overlaps of convex shapes, and directions.

use super::directional::{DirectionalScratch, directional, promise};
use super::{BoundEffort, raise, raise_by_overlap};
use crate::collision::{CheckScratch, ConvexOverlap};
use crate::metric::Anchor;
use crate::metric::motion_bound::MotionPath;
use crate::query::context::Context;
use crate::query::groups::Groups;
use crate::scene::{MetricKind, PairId};

/// Memory that [`lower_bound`] reuses.
#[derive(Default)]
pub struct BoundScratch {
    path: MotionPath,
    overlaps: Vec<ConvexOverlap>,
    directional: DirectionalScratch,
    groups: Groups,
    pairs: Vec<PairId>,
    /// An estimate of the bound of each pair of convex sets, with the number of the pair.
    promises: Vec<(f64, usize)>,
}

/// Work that a bound by directions may take.
#[derive(Debug, Clone, Copy)]
pub struct Splits {
    /// Number of pairs of convex sets that are bounded, those that promise most.
    pub pairs: usize,
    /// Most splits and close bounds of cells for each of these pairs.
    pub each: usize,
}

/// A pair is bounded by directions only if it promises more than this times the present bound.
const MIN_PROMISE_RATIO: f64 = 1.1;

/// Returns a distance (metric units), at most `ceiling`, such that no free configuration is nearer
/// to the anchor. Uses only a few balls of each body if `splits` is `None`.
///
/// # Guarantee
/// Proved: at every configuration within the bound one of the pairs in `colliding` still overlaps;
/// see [`super`] and `directional`. Pairs that have no joint in common part independently, so under
/// the joint metric the squares of their bounds add.
pub fn lower_bound(
    context: &Context,
    anchor: &Anchor,
    colliding: &[PairId],
    (splits, ceiling): (Option<Splits>, f64),
    scratch: &mut BoundScratch,
    check: &mut CheckScratch,
) -> f64 {
    if context.metric.kind() != MetricKind::Joint {
        return of_group(context, anchor, colliding, (splits, ceiling), scratch, check).min(ceiling);
    }
    let (mut groups, mut pairs) = (std::mem::take(&mut scratch.groups), std::mem::take(&mut scratch.pairs));
    groups.split(context, colliding.iter().copied());
    let mut squared: f64 = 0.0;
    // A pair that no joint moves has no root. It goes to the first group, as it never parts.
    let root_of = |pair: &PairId| groups.root_of(context.checker.scene(), *pair).unwrap_or(0);
    let roots = groups.roots().chain((groups.roots().next() != Some(0)).then_some(0));
    for root in roots {
        pairs.clear();
        pairs.extend(colliding.iter().filter(|pair| root_of(pair) == root));
        squared += of_group(context, anchor, &pairs, (splits, ceiling), scratch, check).powi(2);
    }
    (scratch.groups, scratch.pairs) = (groups, pairs);
    squared.sqrt().min(ceiling)
}

fn of_group(
    context: &Context,
    anchor: &Anchor,
    pairs: &[PairId],
    (splits, ceiling): (Option<Splits>, f64),
    scratch: &mut BoundScratch,
    check: &mut CheckScratch,
) -> f64 {
    let BoundScratch { path, overlaps, directional: memory, promises, .. } = scratch;
    let (scene, poses) = (context.checker.scene(), &anchor.poses);
    let mut bound = 0.0;
    overlaps.clear();
    if splits.is_some() {
        context.checker.convex_overlaps(&anchor.q, pairs, check, overlaps);
    }
    for overlap in overlaps.iter() {
        bound = raise_by_overlap(context, overlap, poses, bound, ceiling, path);
    }
    let look = if splits.is_some() { BoundEffort::Close } else { BoundEffort::Quick };
    for &index in pairs {
        let (pair, clearance) = (scene.pairs[index.index()], context.checker.clearance_of(index.index()));
        for roles in [[pair.first, pair.second], [pair.second, pair.first]] {
            bound = raise(context, (roles, clearance), poses, bound, (look, ceiling), path, check);
        }
    }
    let Some(splits) = splits else { return bound };
    promises.clear();
    context.checker.inner_pairs(&anchor.q, pairs, check, &mut |pair| {
        promises.push((promise(context, poses, pair, ceiling, memory), promises.len()));
    });
    promises.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    for &(promise, chosen) in promises.iter().take(splits.pairs) {
        if bound >= ceiling || promise <= MIN_PROMISE_RATIO * bound {
            break;
        }
        let mut number = 0;
        context.checker.inner_pairs(&anchor.q, pairs, check, &mut |pair| {
            if number == chosen {
                bound = bound.max(directional(context, poses, pair, ceiling, splits.each, memory));
            }
            number += 1;
        });
    }
    bound
}

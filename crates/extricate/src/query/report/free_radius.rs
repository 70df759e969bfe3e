//! The free radius: how far around a witness nothing touches, proved from its clearance.

use std::collections::BTreeMap;

use crate::collision::{ContactQuery, ContactSearch};
use crate::math::Pose;
use crate::metric::motion_bound::{BoundedPoint, MotionPath};
use crate::query::bound::{BoundEffort, distance_along};
use crate::query::context::Context;
use crate::query::evaluate::Evaluator;

/// Distances of pairs are measured up to this beyond the clearance \[m\]; pairs farther apart count
/// as that far.
const MARGIN_M: f64 = 0.05;
/// Margin for the rounding of measured distances \[m\].
const ROUNDING_M: f64 = 1e-9;

/// Returns a distance from `q` \[metric units\] within which no two bodies of a checked pair touch.
///
/// # Guarantee
/// Proved pair by pair: two bodies at distance `d` do not meet while no point of one moves by `d`
/// as seen from the other. The motion bound is a convex function of the point, so over a shape it
/// is largest at a corner of the box around it.
pub fn free_radius(context: &Context, q: &[f64], evaluator: &mut Evaluator, path: &mut MotionPath) -> f64 {
    let (checker, scene) = (context.checker, context.checker.scene());
    let query = ContactQuery { margin: context.clearance + MARGIN_M, search: ContactSearch::Exact };
    evaluator.contacts_at(context, q, query);
    // Only the smallest distance between a body and a frame counts: scenes have many obstacles and
    // few frames.
    let mut nearest: BTreeMap<[usize; 2], f64> = BTreeMap::new();
    let mut apart = vec![f64::NAN; scene.pairs.len()];
    for contact in &evaluator.contacts {
        let distance = contact.distance + checker.excess(contact.pair.index());
        apart[contact.pair.index()] = apart[contact.pair.index()].min(distance);
    }
    for (index, pair) in scene.pairs.iter().enumerate() {
        let far = checker.clearance_of(index) + MARGIN_M;
        let distance = if apart[index].is_nan() { far } else { apart[index].min(far) };
        let [a, b] = [pair.first, pair.second];
        let carried = if scene.bodies[a].frame == 0 { [b, 0] } else { [a, scene.bodies[b].frame] };
        nearest.entry(carried).and_modify(|least| *least = least.min(distance)).or_insert(distance);
    }
    let poses = evaluator.check.poses().to_vec();
    let mut radius = context.scale;
    for ([body, seen_from], distance) in nearest {
        let needed = (distance - ROUNDING_M).max(0.0);
        radius = keeps(context, &poses, [body, seen_from], needed, radius, path);
    }
    radius
}

/// Returns the largest distance, at most `ceiling`, within which no point of a body moves by
/// `needed` \[m\] as seen from a frame.
fn keeps(
    context: &Context,
    poses: &[Pose],
    [body, relative_to]: [usize; 2],
    needed: f64,
    mut ceiling: f64,
    path: &mut MotionPath,
) -> f64 {
    let of = context.checker.scene().bodies[body].frame;
    if of == relative_to {
        return ceiling;
    }
    context.metric.motion_between(poses, of, relative_to, path);
    context.checker.corners_of(body, poses, &mut |position| {
        let point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: false };
        context.metric.motion_of(poses, &point, path);
        if ceiling > 0.0 && path.bound(ceiling) >= needed {
            let least = 1e-9 * ceiling;
            let low = (least, path.bound(least));
            ceiling = distance_along(path, low, ceiling, needed, BoundEffort::Close).unwrap_or(0.0);
        }
    });
    ceiling
}

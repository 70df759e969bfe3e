//! The report on a witness, once it is chosen: bounds, contacts, gradient and other exits.

pub mod free_radius;

use super::answer::{Answer, Exit, StraightSegment, TOUCHING, Unproved};
use super::beyond_limits;
use super::context::Context;
use super::evaluate::Evaluator;
use super::exits::End;
use super::options::QueryOptions;
use super::search::known::Known;
use super::search::scratch::{QueryScratch, ReportScratch};
use crate::collision::{CheckScratch, SegmentOptions, SegmentOutcome};
use crate::cspace::Config;
use crate::metric::{Anchor, MetricScratch};
use crate::scene::{MetricKind, PairId};
use free_radius::{Keeps, free_radius};

/// Step of central differences \[rad or m\]: truncation and rounding errors are then both about
/// 1e-10.
const DIFFERENCE_STEP: f64 = 1e-5;

/// Fills in all fields but the witness and the depth.
pub fn report(context: &Context, options: &QueryOptions, scratch: &mut QueryScratch, answer: &mut Answer) {
    let QueryScratch { evaluator, known, report: memory, .. } = scratch;
    let ReportScratch { far_anchor, .. } = memory;
    if options.tells_contacts() {
        let margin = context.clearance + TOUCHING;
        answer.contacts.extend_from_slice(evaluator.touching(context, &answer.witness, margin));
        // The checker lessens distances by what a pair keeps beyond the clearance; report them
        // whole.
        answer.contacts.iter_mut().for_each(|contact| contact.distance += context.checker.excess(contact.pair.index()));
        answer.touching.extend(answer.contacts.iter().map(|contact| contact.pair));
        answer.touching.dedup();
    }
    // The contacts may have been cached; the checker's poses are then those of another
    // configuration.
    context.metric.anchor(&answer.witness, far_anchor);
    answer.kept.extend(context.kept.iter().map(|link| link.error(&far_anchor.poses)));
    if context.touching.are_required {
        let beyond = context.touching.most - context.clearance;
        for pair in context.touching.pairs {
            let position = evaluator.gap(context, &answer.witness, *pair) + beyond;
            answer.push_gap(position);
        }
    }
    let (anchor, proof) = (&known.anchor, &mut known.proof);
    answer.max_displacement = context.metric.max_displacement_at(anchor, &far_anchor.poses);
    let bound = proof.bound(context, anchor, answer.depth, &mut evaluator.check);
    let beyond = beyond_limits::lower_bound(context.metric.kind(), &context.checker.scene().space, &anchor.q);
    answer.lower_bound = bound.max(beyond).min(answer.depth);
    answer.gap = if answer.depth > 0.0 { 1.0 - answer.lower_bound / answer.depth } else { 0.0 };
    if answer.lower_bound == 0.0 {
        answer.unproved = Some(why_unproved(context, &anchor.q, answer, &mut evaluator.check));
    }
    gradient(context, anchor, memory, &mut evaluator.metric, (answer.depth, &mut answer.gradient));
    if options.exits > 1 {
        report_exits(context, options.exits, known, evaluator, answer);
    }
    if answer.verified {
        let space = &context.checker.scene().space;
        answer.unique = !known.exits.rival(space, &mut known.local, (answer.depth, &answer.witness));
    }
    if options.free_radius {
        let sought = (Keeps::Apart, context.scale);
        answer.free_radius = Some(free_radius(context, &answer.witness, sought, evaluator, &mut memory.motion));
    }
    if options.segment {
        answer.segment = Some(segment(context, &known.anchor.q, evaluator, answer));
    }
    answer.checks = evaluator.checks;
}

fn why_unproved(context: &Context, q: &[f64], answer: &Answer, check: &mut CheckScratch) -> Unproved {
    if answer.colliding.is_empty() && !answer.off.is_empty() {
        return Unproved::Off;
    }
    let mut has_inside = false;
    context.checker.inner_pairs(q, &answer.colliding, check, &mut |_| has_inside = true);
    if has_inside { Unproved::Shallow } else { Unproved::Surfaces }
}

/// Writes the gradient of the distance to the witness, the memory's `far_anchor`, from the anchor,
/// which is at this distance. It is that of the depth too while the witness stays the best, since
/// moving it then changes the distance by nothing to first order.
pub fn gradient(
    context: &Context,
    anchor: &Anchor,
    memory: &mut ReportScratch,
    metric_scratch: &mut MetricScratch,
    (distance, out): (f64, &mut [f64]),
) {
    // A kept link may be off though the witness is no farther than the query.
    if distance == 0.0 {
        return;
    }
    let ReportScratch { far_anchor, quadratic, moved, step, .. } = memory;
    let metric = context.metric;
    // The distance is symmetric: half the squared distance from the witness has this gradient at
    // the query, times the depth.
    match metric.kind() {
        MetricKind::Joint => {
            metric.joint_gradient(far_anchor, &anchor.q, out);
            return out.iter_mut().for_each(|slope| *slope /= distance);
        }
        MetricKind::ObjectNorm => {
            metric.quadratic_model(far_anchor, &anchor.q, &anchor.poses, quadratic);
            let slopes = quadratic.gradient.iter().map(|slope| slope / distance);
            return out.iter_mut().zip(slopes).for_each(|(out, slope)| *out = slope);
        }
        MetricKind::MaxDisplacement => {}
    }
    // Differences are needed here: the model has a few points of each body, and may lack the
    // farthest.
    let space = &context.checker.scene().space;
    step.clear();
    step.resize(space.nv(), 0.0);
    moved.resize(space.nq(), 0.0);
    for k in 0..space.nv() {
        let mut change = 0.0;
        for sign in [1.0, -1.0] {
            step[k] = sign * DIFFERENCE_STEP;
            space.integrate(&anchor.q, step, moved);
            change += sign * metric.distance_from(far_anchor, moved, metric_scratch);
        }
        step[k] = 0.0;
        out[k] = change / (2.0 * DIFFERENCE_STEP);
    }
}

fn report_exits(context: &Context, wanted: usize, known: &Known, evaluator: &mut Evaluator, answer: &mut Answer) {
    let margin = context.clearance + TOUCHING;
    for End { distance: depth, config: witness, .. } in known.exits.iter().filter(|end| end.is_verified).take(wanted) {
        let mut touching: Vec<PairId> = evaluator.touching(context, witness, margin).iter().map(|c| c.pair).collect();
        touching.dedup();
        answer.exits.push(Exit { depth: *depth, witness: Config::trusted(witness), touching });
    }
    if answer.exits.is_empty() {
        let (witness, touching) = (answer.witness.clone(), answer.touching.clone());
        answer.exits.push(Exit { depth: answer.depth, witness, touching });
    }
}

fn segment(context: &Context, q: &[f64], evaluator: &mut Evaluator, answer: &Answer) -> StraightSegment {
    evaluator.checks += 1;
    match context.checker.segment(&answer.witness, q, &SegmentOptions::default(), &mut evaluator.check) {
        // A query beyond its limits need not collide; the answer then claims the least.
        SegmentOutcome::Free => StraightSegment { colliding_until: 1.0, free_from: 1.0 },
        SegmentOutcome::Contact { free_until, colliding_at: at, .. }
        | SegmentOutcome::Undecided { free_until, near_at: at, .. } => {
            StraightSegment { colliding_until: 1.0 - at, free_from: 1.0 - free_until }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::{ContactQuery, ContactSearch};
    use crate::query::prepared::Prepared;
    use crate::query::prepared::tests::colliding;
    use crate::query::query;
    use crate::scene::builtin;

    /// Contacts cached by the last descent must equal freshly computed ones.
    #[test]
    fn contacts_are_those_of_a_look_at_the_witness_alone() {
        for name in ["planar-arm", "hand"] {
            let prepared = Prepared::new(builtin::scene(name).unwrap());
            let (context, mut scratch, mut seen) = (prepared.context(), QueryScratch::default(), 0);
            for q in colliding(&prepared, 100) {
                let answer = query(&context, &q, &QueryOptions::default(), &mut scratch).unwrap();
                let margin = prepared.scene().clearance + TOUCHING;
                let look = ContactQuery { margin, search: ContactSearch::Exact };
                let mut contacts = Vec::new();
                prepared.checker().contacts(&answer.witness, look, &mut CheckScratch::default(), &mut contacts);
                contacts.sort_by_key(|contact| contact.pair);
                assert_eq!(contacts.len(), answer.contacts.len(), "{name} {q:?}");
                for (told, found) in answer.contacts.iter().zip(&contacts) {
                    assert_eq!(told.pair, found.pair);
                    assert!((told.distance - found.distance).abs() < 1e-9, "{name} {q:?}: {told:?} {found:?}");
                    // On round shapes, points 0.1 mm apart are found up to 1e-9 m off, depending on
                    // where the search for them began.
                    assert!((told.normal - found.normal).norm() < 1e-4, "{name} {q:?}: {told:?} {found:?}");
                }
                seen += contacts.len();
            }
            assert!(seen > 100, "{name}: {seen}");
        }
    }
}

//! The steps of a query, which [`super`] explains.

use super::answer::{Answer, free_answer};
use super::beyond_limits;
use super::bound::branch_and_bound::Branches;
use super::constraints::under;
use super::context::Context;
use super::exits::{End, Exits};
use super::groups::is_held;
use super::options::{Effort, QueryOptions, Toward};
use super::plan::Plan;
use super::report::report;
use super::search::grouped::{Pairs, search_groups};
use super::search::prove::prove;
use super::search::scratch::QueryScratch;
use super::search::{Hint, Search};
use super::termination::Deadline;
use crate::cspace::{Config, Label};
use crate::samples::{Probes, SampleQuery};

/// Stored samples that effort `nearest` checks in a scene other than the learned one.
const MAX_CHECKED_SAMPLES: usize = 16;

/// Returns the nearest free configuration to `q` that the effort finds; `None` only if nothing free
/// was found, or if the search was stopped.
///
/// # Guarantee
/// `lower_bound <= depth`, and `lower_bound` is proved. The witness is free: by the exact checker
/// during this call if `verified` is set, otherwise when the model was learned.
pub fn query(context: &Context, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
    let mut answer = under(context, q, options, scratch, |context, options, mut hint, scratch| {
        let mut answer = find(context, q, options, &mut hint, scratch)?;
        if !answer.is_free() {
            report(context, options, scratch, &mut answer);
        }
        Some(answer)
    })?;
    answer.checks = scratch.checks();
    Some(answer)
}

/// Searches as [`query`], for a caller who wants the witness alone: the answer has no report, and
/// the search proves only what the options request.
pub fn nearest_exit(
    context: &Context,
    q: &Config,
    options: &QueryOptions,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    find(context, q, options, &mut Hint { is_unproved: true, ..Hint::default() }, scratch)
}

/// Searches as [`nearest_exit`], under the constraints of the options. With `looks_nowhere_else`,
/// returns `None` also if descents find nothing, for callers that have no use for other free
/// configurations.
pub(crate) fn nearest_exit_under(
    context: &Context,
    q: &Config,
    options: &QueryOptions,
    looks_nowhere_else: bool,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    under(context, q, options, scratch, |context, options, hint, scratch| {
        let looks_nowhere_else = hint.looks_nowhere_else || looks_nowhere_else;
        find(context, q, options, &mut Hint { looks_nowhere_else, is_unproved: true, ..hint }, scratch)
    })
}

/// Runs steps 1 to 6 of a query.
pub(crate) fn find(
    context: &Context,
    q: &Config,
    options: &QueryOptions,
    hint: &mut Hint,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    let (scene, degrees) = (context.checker.scene(), context.checker.scene().space.nv());
    let QueryScratch { evaluator, known, .. } = &mut *scratch;
    evaluator.begin(Deadline::of(&options.termination));
    let mut answer = free_answer(q, degrees, options.effort, context.clearance);
    if options.tells_contacts() {
        context.checker.colliding_pairs(q, &mut evaluator.check, &mut answer.colliding);
    } else {
        answer.colliding.extend(context.checker.colliding_pair(q, &mut evaluator.check));
    }
    answer.outside.extend(scene.space.outside(q));
    let poses = evaluator.check.poses();
    answer.off.extend((0..context.kept.len()).filter(|at| context.kept[*at].excess(poses) > 1.0));
    if context.touching.are_required {
        let apart = (0..).zip(context.touching.pairs).filter(|(_, pair)| evaluator.gap(context, q, **pair) > 0.0);
        answer.off.extend(apart.map(|(at, _)| context.kept.len() + at));
    }
    if answer.is_free() {
        return Some(answer);
    }
    if !context.locked.is_empty() && nothing_may_part(context, &answer) {
        return None;
    }
    context.metric.anchor_at(q, evaluator.check.poses(), &mut known.anchor);
    known.begin(context, options.wanted());
    known.looks_anywhere = !hint.looks_nowhere_else;
    known.proof.begin(options.effort, options.first_gap(hint.is_unproved));
    if options.effort == Effort::Nearest && take_nearest_sample(context, &mut answer, scratch) {
        return Some(answer);
    }
    match hint.turn {
        Some(_) => hint.followed = Search::whole(context, Plan::of(options, context), scratch).follow(hint.config),
        None => scratch.known.hint.extend_from_slice(hint.config),
    }
    answer.unseen = Some(search_all(context, options, &answer, hint, scratch)?);
    scratch.known.proof.set_colliding(answer.colliding.iter().copied());
    if options.effort == Effort::Proved {
        prove(&mut Search::whole(context, Plan::of(options, context), scratch));
    }
    let QueryScratch { evaluator, known, .. } = scratch;
    let nearest = known.exits.nearest()?;
    let chosen =
        options.toward.as_ref().map_or(nearest, |toward| nearest_to_goal(context, toward, &known.exits, nearest));
    (answer.depth, answer.verified) = (chosen.distance, chosen.is_verified);
    answer.witness.set(&chosen.config);
    answer.cut_short = evaluator.is_cut();
    Some(answer)
}

/// Runs steps 2 to 5, first of a refined query, then of an exhaustive one if that was requested. So
/// more effort never ends farther away. Returns the estimated share of starts that would lead to
/// unmet exits; `None` if nothing free was found.
fn search_all(
    context: &Context,
    options: &QueryOptions,
    answer: &Answer,
    hint: &mut Hint,
    scratch: &mut QueryScratch,
) -> Option<f64> {
    let plan = Plan::of(options, context);
    let mut at_rest = std::mem::take(&mut scratch.at_rest);
    beyond_limits::pairs_at_rest(context, answer, scratch, &mut at_rest);
    let pairs = Pairs { at_query: &answer.colliding, at_rest: &at_rest };
    let unseen = if beyond_limits::is_rest_nearest(context, pairs.at_rest) {
        Search::whole(context, plan, scratch).take_rest();
        Some(0.0)
    } else {
        // Stored samples may all collide here, even if they were free when they were stored.
        let unlearned = Context { stored: None, ..*context };
        search_with_plans(context, options, pairs, hint, scratch).or_else(|| {
            let goes_on = context.stored.is_some() && !scratch.evaluator.is_stopped();
            goes_on.then(|| search_with_plans(&unlearned, options, pairs, &mut Hint::default(), scratch))?
        })
    };
    scratch.at_rest = at_rest;
    unseen
}

/// Runs the searches of [`search_all`] if the query moved onto the limits is not the answer.
fn search_with_plans(
    context: &Context,
    options: &QueryOptions,
    pairs: Pairs,
    hint: &mut Hint,
    scratch: &mut QueryScratch,
) -> Option<f64> {
    let plan = Plan::of(options, context);
    let unseen = search_groups(context, plan, pairs, hint, scratch);
    // If branch and bound cannot run, only a longer search is left to close the gap.
    let is_all = options.effort == Effort::Proved && !Branches::can_search(context);
    scratch.known.proof.set_colliding(pairs.at_query.iter().copied());
    if matches!(options.effort, Effort::Exhaustive | Effort::Proved) {
        scratch.known.proof.look_closely(options.last_gap());
    }
    if options.effort != Effort::Exhaustive && !is_all || Search::whole(context, plan, scratch).is_over() {
        return unseen;
    }
    let found: Vec<Vec<f64>> = scratch.known.exits.iter().map(|end| end.config.clone()).collect();
    if let Some(nearest) = found.first() {
        scratch.known.hint.clone_from(nearest);
    }
    scratch.known.has_earlier = !found.is_empty();
    let longer = search_groups(context, plan.exhaustive(context, options), pairs, &mut Hint::default(), scratch);
    let mut whole = Search::whole(context, plan, scratch);
    if longer.is_none() {
        whole.known.exits.clear();
    }
    found.iter().take(whole.known.wanted).for_each(|config| whole.offer(config, true, false));
    longer.or(unseen)
}

/// Takes the answer of effort `nearest`: the nearest stored sample, free as of learning, or in
/// another scene the first of a few that is free there. Returns whether there is one.
fn take_nearest_sample(context: &Context, answer: &mut Answer, scratch: &mut QueryScratch) -> bool {
    let Some(stored) = context.stored.filter(|_| !context.is_constrained()) else { return false };
    let QueryScratch { evaluator, known, boundary, near, .. } = scratch;
    let is_here = stored.holding.is_none();
    let (wanted, count) = match is_here {
        true => (SampleQuery { care: Probes::Glance, ..SampleQuery::NEAREST }, 1),
        false => (SampleQuery::NEAREST, MAX_CHECKED_SAMPLES),
    };
    stored.samples.nearest(wanted, context.metric, &known.anchor, count, boundary, near);
    for &(id, depth) in near.iter() {
        let config = stored.samples.config(id);
        if is_here || evaluator.label(context, config) == Label::Free {
            (answer.depth, answer.verified) = (depth, !is_here);
            answer.witness.set(config);
            scratch.known.proof.set_colliding(answer.colliding.iter().copied());
            return true;
        }
    }
    false
}

/// Returns the exit nearest to the goal among those that are verified and near enough.
fn nearest_to_goal<'a>(context: &Context, toward: &Toward, exits: &'a Exits, nearest: &'a End) -> &'a End {
    let from_goal = |end: &&End| context.metric.distance(&end.config, &toward.goal);
    let most = nearest.distance * (1.0 + toward.share);
    let near = exits.iter().filter(|end| end.is_verified && end.distance <= most);
    near.min_by(|a, b| from_goal(a).total_cmp(&from_goal(b))).unwrap_or(nearest)
}

/// Returns whether locked joints exclude an answer: one is beyond its limits, or a colliding pair
/// depends on them alone.
fn nothing_may_part(context: &Context, answer: &Answer) -> bool {
    let factors = context.checker.scene().space.factors();
    let is_locked = |q: &usize| factors.iter().any(|f| f.coordinates().contains(q) && context.is_locked(f.v));
    answer.outside.iter().any(is_locked) || answer.colliding.iter().any(|pair| is_held(context, *pair))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::CheckScratch;
    use crate::cspace::Label;
    use crate::cspace::sampling::Halton;
    use crate::query::context::Stored;
    use crate::query::index_samples;
    use crate::query::prepared::Prepared;
    use crate::query::termination::Termination;
    use crate::scene::builtin;

    /// A model file may hold anything: no verified answer rests on its samples alone.
    #[test]
    fn stored_samples_that_collide_make_no_answer() {
        let prepared = Prepared::new(builtin::scene("planar-arm").unwrap());
        let (checker, space) = (prepared.checker(), &prepared.scene().space);
        let (halton, mut q, mut scratch) = (Halton::new(space.nv(), 8), vec![0.0; space.nq()], CheckScratch::default());
        let drawn = (0..).filter_map(|index| {
            halton.config(space, index, &mut q);
            (checker.label(&q, &mut scratch) == Label::Colliding).then(|| q.clone())
        });
        let colliding: Vec<Vec<f64>> = drawn.take(400).collect();
        let samples = index_samples(checker, prepared.metric(), colliding.concat(), 200, 0);
        let crafted = prepared.with(Some(Stored { samples: &samples, holding: None }));
        for q in colliding.iter().step_by(20).map(|q| space.config(q).unwrap()) {
            for effort in [Effort::Refined, Effort::Exhaustive, Effort::Proved] {
                for termination in [Termination::after_checks(1), Termination::after_checks(300)] {
                    let options = QueryOptions { effort, termination, ..QueryOptions::default() };
                    let answer = query(&crafted, &q, &options, &mut QueryScratch::default()).unwrap();
                    assert!(answer.verified && answer.depth > 0.0, "{effort:?}: {answer:?}");
                    assert_eq!(checker.label(&answer.witness, &mut scratch), Label::Free);
                    assert!(answer.lower_bound <= answer.depth);
                }
            }
        }
    }
}

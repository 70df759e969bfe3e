//! The query: from a colliding configuration to the nearest free one, verified and bounded.
//!
//! Read in this order: `mod` (the steps), `plan`, `search`, `run`, `directions`, `starts`, `prune`,
//! `descent`, `around`, `parts`, `polish`, `prove`, `report`.
//!
//! 1. *Check*: the pairs that collide at `q`; none: depth 0.
//! 2. *Split* the joints into independent parts (`parts`).
//! 3. *Starts*: the stored samples nearest to `q`, no two alike (`starts`).
//! 4. *Incumbent*: the nearest of them; without a model, the first that 5 finds (`first_witness`).
//!    Effort `nearest` ends here.
//! 5. *Directions* in which colliding bodies part, each the start of a descent (`directions`).
//! 6. *Descents* from one stored start after the other (`run`): *prune* what cannot beat the
//!    incumbent (`prune`), *descend* toward `q` along the contacts ([`descent`]), *keep* what is
//!    nearer; until no further exit is to be expected.
//! 7. *Around the query*: descents from configurations around it, which see what samples miss
//!    (`around`).
//! 8. *Polish* the incumbent with exact contacts, and verify it (`polish`).
//! 9. *Bound*: how near any free configuration can be ([`bound`]); with effort `proved`,
//!    until that is near enough (`prove`).
//! 10. *Report* (`report`).

pub mod answer;
pub mod batch;
pub mod bound;
mod contact_planes;
pub mod context;
pub mod descent;
pub mod options;
pub(crate) mod plan;
pub mod report;
pub(crate) mod search;
mod starts;
pub mod stream;
pub mod worlds;

pub use answer::{Answer, Exit, StraightSegment, Unproved};
pub use batch::Answered;
pub use contact_planes::index_samples;
pub use context::{Context, Held, Learned, StartsPerDof};
pub use options::{DEFAULT_GAP, Effort, QueryOptions, Toward};
pub use search::Ranks;
pub use search::parts::IndependentParts;
pub use search::scratch::QueryScratch;
pub(crate) use search::termination::Deadline;
pub use search::termination::{Stop, Termination};
pub use stream::{Stream, StreamOptions};
pub use worlds::World;
pub use worlds::changed::ChangedScene;
pub use worlds::view::{Solver, View};

use crate::cspace::Config;
use crate::samples::SampleQuery;
use answer::free_answer;
use bound::branch_and_bound::Branches;
use plan::Plan;
use report::report;
use search::Search;
use search::lead::Lead;
use search::parts::search_parts;
use search::polish::polish;
use search::prove::prove;
use search::run::run;
use starts::begins_among;
use starts::first_witness::first_witness;
use worlds::constraints::under;

/// The nearest free configuration to `q` that the effort finds; `None` only where the samples are
/// stale and nothing free was found, or looking for it was stopped.
///
/// # Guarantee
/// `lower_bound <= depth`, and `lower_bound` is proved. The witness is free: by the exact checker
/// during this call where `verified` is set, otherwise when the model was learned.
pub fn query(context: &Context, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
    let mut answer = under(context, q, options, scratch, |context, options, scratch| {
        let mut answer = nearest_exit(context, q, options, scratch)?;
        if !answer.is_free() {
            report(context, options, scratch, &mut answer);
        }
        Some(answer)
    })?;
    answer.checks = scratch.checks();
    Some(answer)
}

/// As [`query`], for a caller who wants the witness alone: nothing is proved or said of it.
pub fn nearest_exit(
    context: &Context,
    q: &Config,
    options: &QueryOptions,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    let plan = Plan::of(options, context);
    find(context, q, (options, plan), None, scratch)
}

/// The same under the constraints of the options, as [`query`] has them; `None` also if descents
/// find nothing, for who has no use for any other free configuration.
pub(crate) fn nearest_exit_under(
    context: &Context,
    q: &Config,
    options: &QueryOptions,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    scratch.known.resort = Some(Vec::new());
    let answer =
        under(context, q, options, scratch, |context, options, scratch| nearest_exit(context, q, options, scratch));
    scratch.known.resort = None;
    answer
}

/// How late starts find the nearest exit of `q`, of each part, and the checks that it took to tell.
pub fn measure_ranks(context: &Context, q: &Config, scratch: &mut QueryScratch) -> (Vec<Ranks>, usize) {
    let options = QueryOptions::default();
    let plan = Plan::of(&options, context).to_calibrate();
    find(context, q, (&options, plan), None, scratch);
    (std::mem::take(&mut scratch.known.ranks), scratch.evaluator.checks)
}

/// Steps 1 to 8. A stream's lead is tried before the stored samples. If all that is found collides,
/// stored samples do that were said to be free: then it is searched anew as without a model.
fn find(
    context: &Context,
    q: &Config,
    asked: (&QueryOptions, Plan),
    lead: Option<&mut Lead>,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    let answer = find_once(context, q, asked, lead, scratch)?;
    let believes = answer.is_free() || answer.verified || asked.0.effort == Effort::Nearest;
    let (false, Some(unlearned)) = (believes, context.without_samples()) else { return Some(answer) };
    let checks = scratch.evaluator.checks;
    let options = QueryOptions { termination: scratch.evaluator.limit.left(checks), ..asked.0.clone() };
    let plan = Plan::of(&options, &unlearned);
    let answer = find_once(&unlearned, q, (&options, plan), None, scratch);
    scratch.evaluator.checks += checks;
    answer
}

fn find_once(
    context: &Context,
    q: &Config,
    (options, plan): (&QueryOptions, Plan),
    lead: Option<&mut Lead>,
    scratch: &mut QueryScratch,
) -> Option<Answer> {
    let QueryScratch { evaluator, descent, boundary, known, parts, .. } = scratch;
    let (scene, degrees) = (context.checker.scene(), context.checker.scene().space.nv());
    evaluator.begin(Deadline::of(&options.termination));
    let mut answer = free_answer(q, degrees, options.effort, context.clearance);
    if options.tells_contacts() {
        context.checker.colliding_pairs(q, &mut evaluator.check, &mut answer.colliding);
    } else {
        answer.colliding.extend(context.checker.colliding_pair(q, &mut evaluator.check));
    }
    answer.outside.extend(scene.space.outside(q));
    if answer.is_free() {
        return Some(answer);
    }
    if !context.locked.is_empty() && nothing_may_part(context, &answer) {
        return None;
    }
    let unlearned = context.unlearned_for(&answer.colliding);
    let (context, plan) = match &unlearned {
        Some(unlearned) => (unlearned, Plan::of(options, unlearned)),
        None => (context, plan),
    };
    context.metric.anchor_at(q, evaluator.check.poses(), &mut known.anchor);
    known.begin(context, options.wanted());
    known.proof.begin(options.effort, &answer.colliding, options.wanted_gap());
    let mut search =
        Search { context, plan, known, evaluator, descent, boundary, believes: false, turn: None, part: None };
    let is_done = !answer.outside.is_empty() && worlds::beyond_limits::begin(&mut search, &mut answer);
    if !is_done {
        if context.begins_without_samples() {
            parts.split(scene, search.known.colliding_of(&answer));
        }
        answer.coverage = first_witness(&mut search, parts)?;
        search.take_resort();
    }
    search.known.note_fallback();
    if options.effort != Effort::Nearest && !is_done {
        let mut lead = lead.filter(|lead| !lead.is_empty());
        lead.iter_mut().for_each(|lead| lead.follow(&mut search));
        parts.split(scene, search.known.colliding_of(&answer));
        search_all(&mut search, parts);
        lead.iter_mut().for_each(|lead| lead.advance(&search));
        // Where displacements do not add, nothing but a longer search is left to close a gap.
        let is_all = options.effort == Effort::Proved && !Branches::can_search(context);
        let goes_on = options.effort == Effort::Exhaustive || is_all;
        if goes_on && !search.is_proved() {
            // After all that a refined query does, so that more effort never ends farther away.
            search.plan = plan.exhaustive(context, options);
            search.known.starts.reset();
            search.known.directions.reset();
            parts.split(scene, search.known.colliding_of(&answer));
            search_all(&mut search, parts);
        }
        answer.unseen = Some(search.known.unseen());
    }
    if options.effort == Effort::Proved {
        prove(&mut search);
    }
    if let Some(toward) = &options.toward {
        known.choose_toward(context, toward);
    }
    answer.cut_short = evaluator.is_cut();
    answer.depth = known.incumbent.depth;
    answer.verified = known.incumbent.verified;
    answer.witness.copy_from_slice(&known.incumbent.config);
    Some(answer)
}

/// Whether joints that stay leave no answer: one is beyond its limits, or a pair that collides
/// depends on them alone.
fn nothing_may_part(context: &Context, answer: &Answer) -> bool {
    let factors = context.checker.scene().space.factors();
    let is_locked = |q: &usize| factors.iter().any(|f| f.coordinates().contains(q) && context.is_locked(f.v));
    answer.outside.iter().any(is_locked) || IndependentParts::hold_some(context, &answer.colliding)
}

/// Steps 5 to 8, from an incumbent.
fn search_all(search: &mut Search, parts: &mut IndependentParts) {
    search.believes = !search.context.checker.all_convex();
    if parts.are_independent() || !search.context.locked.is_empty() {
        search_parts(search, parts);
    } else {
        let ranks = run(search);
        search.known.ranks.push(ranks);
    }
    polish(search);
}

/// What a refined query begins with, whose distance its coverage is told by: the nearest solved
/// sample where it starts from those alone, otherwise the nearest sample, and how sure it has to be
/// of it.
pub fn begins_with(context: &Context) -> SampleQuery {
    let plan = Plan::of(&QueryOptions::default(), context);
    SampleQuery { among: begins_among(context, plan.starts), care: plan.care, ..SampleQuery::NEAREST }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::{CheckScratch, Checker};
    use crate::cspace::Label;
    use crate::cspace::sampling::Halton;
    use crate::learning::LearnOptions;
    use crate::metric::Metric;
    use crate::model::Model;
    use crate::scene::builtin;

    /// A model file may hold anything: no answer that is to be verified rests on its samples.
    #[test]
    fn stored_samples_that_collide_make_no_answer() {
        let options = LearnOptions { labels: 3_000, seconds: None, ..LearnOptions::default() };
        let model = Model::learn(builtin::scene("planar-arm").unwrap(), &options).unwrap();
        let (scene, space) = (model.checker().scene_arc(), &model.scene().space);
        let (halton, mut q, mut scratch) = (Halton::new(space.nv(), 8), vec![0.0; space.nq()], CheckScratch::default());
        let drawn = (0..).filter_map(|index| {
            halton.config(space, index, &mut q);
            (model.checker().label(&q, &mut scratch) == Label::Colliding).then(|| q.clone())
        });
        let colliding: Vec<Vec<f64>> = drawn.take(400).collect();
        let statistics = crate::model::Statistics { solved_samples: 200, ..model.statistics().clone() };
        let (checker, metric) = (Checker::new(scene.clone()), Metric::new(scene.clone()));
        let crafted =
            Model::from_parts(checker, metric, colliding.concat(), None, model.coverage().clone(), statistics);
        for q in colliding.iter().step_by(20).map(|q| space.config(q).unwrap()) {
            for effort in [Effort::Refined, Effort::Exhaustive, Effort::Proved] {
                for termination in [Termination::after_checks(1), Termination::after_checks(300)] {
                    let options = QueryOptions { effort, termination, ..QueryOptions::default() };
                    let answer = crafted.view().query_with(&q, &options, &mut QueryScratch::default()).unwrap();
                    assert!(answer.verified && answer.depth > 0.0, "{effort:?}: {answer:?}");
                    assert_eq!(model.checker().label(&answer.witness, &mut scratch), Label::Free);
                    assert!(answer.lower_bound <= answer.depth);
                }
            }
        }
    }
}

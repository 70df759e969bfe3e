//! The query: from a colliding configuration to the nearest free one, verified and bounded.
//!
//! Candidates make it global (the nearest boundary samples, spread out), refinement makes it tight, the exact checker makes it
//! true, the certificate says how much better any answer could be.

pub mod answer;
pub mod batch;
pub mod certificate;
pub mod change;
pub mod changed;
mod choose;
pub mod coverage;
mod dense;
mod describe;
mod ending;
mod exits;
mod hope;
mod limit;
mod local_metric;
pub mod options;
mod plan;
pub mod qp;
pub mod refine;
pub mod scatter;
mod search;
pub mod stream;
mod tangents;
mod turns;
mod wander;
pub mod width;
mod witness;

pub use answer::{Answer, Exit, Way};
pub use batch::Answered;
pub use changed::ChangedScene;
pub use options::{Effort, QueryBudget, QueryOptions, Stop};
pub use plan::{FEW_EXITS, MANY_EXITS};
pub use search::QueryScratch;
pub use stream::{Stream, StreamOptions};
pub use tangents::index_samples;
pub use width::Width;

use crate::boundary::{Among, SampleSet, Wanted};
use crate::collision::Checker;
use crate::cspace::{Config, Label};
use crate::metric::Metric;
use crate::scene::MetricSpec;
use certificate::InteriorBalls;
use change::Change;
use coverage::Coverage;
use plan::Plan;

/// What a query stands on; borrowed from a model.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The exact checker.
    pub checker: &'a Checker,
    /// The scene's metric.
    pub metric: &'a Metric,
    /// Verified boundary samples; at least one.
    pub boundary: &'a SampleSet,
    /// For the lower bound.
    pub balls: &'a InteriorBalls,
    /// What the distance to the nearest sample is compared with.
    pub coverage: &'a Coverage,
    /// Least distance \[m\] of a free pair.
    pub clearance: f64,
    /// A typical length of the configuration space in metric units.
    pub scale: f64,
    /// How widely refined queries search.
    pub width: Width,
    /// Whether queries leave out what makes up for exits that are missing, as they do while these are looked for.
    pub is_lean: bool,
    /// Set where the samples were verified in another scene: they may collide, and be far from any boundary.
    pub change: Option<&'a Change>,
}

impl Ground<'_> {
    /// Whether samples have to be verified anew.
    pub fn is_stale(&self) -> bool {
        self.change.is_some()
    }

    /// Whether exits are so many that refined queries in turn start from them alone, with samples only to make up for those that are missing.
    pub fn relies_on_exits(&self) -> bool {
        let least = match self.metric.kind() {
            MetricSpec::Joint if self.is_lean => plan::RELIED_ON_TO_SOLVE,
            MetricSpec::Joint => plan::RELIED_ON,
            MetricSpec::ObjectNorm | MetricSpec::MaxDisplacement => FEW_EXITS,
        };
        self.boundary.exits() >= least
    }

    /// Whether descents of a refined query run in turn, as many as the width says, instead of being compared with each other before they are carried on:
    /// under the metric of the joints, and under the object norm where there are exits enough to start from. What is largest is not smooth, and
    /// bends too much for it.
    pub fn takes_turns(&self) -> bool {
        match self.metric.kind() {
            MetricSpec::Joint => true,
            MetricSpec::ObjectNorm => self.relies_on_exits(),
            MetricSpec::MaxDisplacement => false,
        }
    }
}

/// What a refined query begins with, whose distance its coverage is told by: the nearest exit where it starts from exits alone, otherwise the nearest
/// sample, and how sure it has to be of it.
pub fn begins_with(ground: &Ground) -> Wanted {
    let plan = Plan::of(&QueryOptions::default(), ground, &[]);
    let among = if plan.begins_at_exits() { Among::Exits } else { Among::Samples };
    Wanted { among, care: plan.care, ..Wanted::NEAREST }
}

/// The nearest free configuration to `q` that the effort finds; `None` only where the samples are stale and nothing free was found, or
/// looking for it was stopped.
///
/// # Guarantee
/// `lower_bound <= depth`, and `lower_bound` is proved. The witness is free: by the exact checker during this call where
/// `verified` is set, otherwise when the model was learned.
pub fn query(ground: &Ground, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
    let mut answer = nearest_exit(ground, q, options, scratch)?;
    if !answer.colliding.is_empty() {
        scratch.describe(ground, options, &mut answer);
    }
    Some(answer)
}

/// As [`query`], for a caller who wants the witness alone: nothing is proved or said of it.
pub fn nearest_exit(ground: &Ground, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
    let mut answer = scratch.begin(ground, q, options);
    if answer.colliding.is_empty() {
        return Some(answer);
    }
    let plan = Plan::of(options, ground, &answer.colliding);
    if !scratch.first_witness(ground, &plan, &mut answer) {
        return None;
    }
    if options.effort != Effort::Nearest {
        search_all(ground, &plan, options, scratch, &mut answer);
    }
    Some(answer)
}

/// All descents of a refined or exhaustive query, from a first witness.
fn search_all(ground: &Ground, plan: &Plan, options: &QueryOptions, scratch: &mut QueryScratch, answer: &mut Answer) {
    // Where descents in turn find nothing nearer, it is checked in the end.
    if !answer.verified && (plan.in_turn.is_none() || options.exits > 1) {
        answer.verified = scratch.refine.label(ground, &answer.witness) == Label::Free;
    }
    scratch.look_around(ground);
    if options.effort == Effort::Exhaustive {
        // First all that a refined query does, so that more effort never ends farther away.
        let first = QueryOptions { effort: Effort::Refined, ..options.clone() };
        let first = Plan::of(&first, ground, &answer.colliding);
        scratch.choose(ground, &first);
        scratch.refine_all(ground, &first, options, answer);
    }
    scratch.choose(ground, plan);
    scratch.refine_all(ground, plan, options, answer);
}

//! What an adapting run has found, and where the last whole unit of work ended.

use serde::{Deserialize, Serialize};

use crate::cspace::ConfigSpace;
use crate::learning::budget::Spent;
use crate::learning::exploration::Exploration;
pub use crate::model::evaluate::figures::ClassifierAccuracy;
use crate::model::run::checks::{check_solved, check_spent, check_traced};
use crate::model::run::work::{Stage, StageKind};
use crate::model::solve::SolvePlace;
use crate::model::statistics::{EndedBy, check_count, check_share};
use crate::samples::trace::TracePlace;

/// Lists of configurations, row major. Within a unit of work they only grow: so their beginnings
/// are the state at its end.
#[derive(Debug, Clone, Default)]
pub struct AdaptState {
    /// Boundary samples: those that were kept, and new ones; while solving, exits after them.
    pub samples: Vec<f64>,
    /// Exits that were kept; none once solving has begun.
    pub exits: Vec<f64>,
    /// Stored configurations that a changed pair comes near, until they are labelled.
    pub doubtful: Vec<f64>,
    /// Labelled configurations.
    pub known: Exploration,
    /// Uniform colliding configurations, which are solved, and where their sequence stands.
    pub fresh: Exploration,
    /// What is not a list.
    pub place: AdaptPlace,
    /// Where the last whole unit of work ended.
    pub mark: AdaptMark,
}

/// How far a run has come, but for its lists.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptPlace {
    /// Stored samples and exits that were looked at.
    pub verified: usize,
    /// How right the old classifier is in the new scene.
    pub judged: ClassifierAccuracy,
    /// Of the samples, how many were kept.
    pub kept: usize,
    /// Labels that tracing leaves to solving.
    pub kept_back: usize,
    /// Whether colliding configurations are solved.
    pub solves: bool,
    /// How far solving has come.
    pub solved: SolvePlace,
}

/// Where a unit of work ended.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptMark {
    /// The stage of the unit to come.
    pub stage: AdaptStage,
    /// Numbers in the lists, as [`AdaptState::lists`] has them.
    pub lengths: [usize; LISTS.len()],
    /// Indices of the next low-discrepancy points: those labelled, and those solved.
    pub next: [u64; 2],
    /// Labels and seconds until then.
    pub spent: Spent,
    /// The rest.
    pub place: AdaptPlace,
}

/// What a unit of work belongs to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub enum AdaptStage {
    /// Stored samples and exits are looked at in the new scene.
    #[default]
    Verifying,
    /// What a change came near is labelled, and the classifier judged.
    Judging,
    /// The boundary where the scene changed; before the first pass it stands nowhere.
    Tracing(Option<TracePlace>),
    /// The nearest exits of colliding configurations.
    Solving,
    /// What came of it is measured; the run has ended for this reason.
    Measuring(EndedBy),
}

impl AdaptStage {
    /// As progress reports name it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Verifying | Self::Judging => "verifying samples",
            Self::Tracing(_) => "tracing what changed",
            Self::Solving => "solving",
            Self::Measuring(_) => "measuring",
        }
    }
}

impl Stage for AdaptStage {
    fn measuring(why: EndedBy) -> Self {
        Self::Measuring(why)
    }

    fn kind(&self) -> StageKind<Self> {
        match self {
            // What is not looked at would be lost. The classifier is judged all the same, which
            // takes little.
            Self::Verifying | Self::Judging => StageKind::Whole(Self::Judging),
            Self::Tracing(_) => StageKind::Limited,
            Self::Solving => StageKind::Solving,
            Self::Measuring(why) => StageKind::Measuring(*why),
        }
    }

    fn name(&self) -> &'static str {
        self.name()
    }
}

/// The names of the lists.
pub const LISTS: [&str; 6] = ["samples", "exits", "doubtful", "free", "colliding", "fresh"];

impl AdaptState {
    /// The lists, in the order of their names.
    pub fn lists(&self) -> [&Vec<f64>; LISTS.len()] {
        let Self { samples, exits, doubtful, known, fresh, .. } = self;
        [samples, exits, doubtful, &known.free, &known.colliding, &fresh.colliding]
    }

    /// The lists as they were at the mark.
    pub fn lists_at_mark(&self) -> [&[f64]; LISTS.len()] {
        let (lists, lengths) = (self.lists(), self.mark.lengths);
        std::array::from_fn(|i| &lists[i][..lengths[i].min(lists[i].len())])
    }

    /// Sets the mark here.
    pub fn set_mark(&mut self, stage: AdaptStage, spent: Spent) {
        let lengths = self.lists().map(Vec::len);
        let next = [self.known.next, self.fresh.next];
        self.mark = AdaptMark { stage, lengths, next, spent, place: self.place.clone() };
    }

    /// The state at a mark.
    pub fn at(mark: AdaptMark, lists: [Vec<f64>; LISTS.len()]) -> Self {
        let [samples, exits, doubtful, free, colliding, fresh] = lists;
        let known = Exploration { free, colliding, next: mark.next[0] };
        let fresh = Exploration { free: Vec::new(), colliding: fresh, next: mark.next[1] };
        Self { samples, exits, doubtful, known, fresh, place: mark.place.clone(), mark }
    }

    /// Whether a state that was read as bytes can be one of a run in this space; `stored` is how
    /// many samples and exits the old model has.
    ///
    /// # Errors
    /// The element, its value, and what was expected.
    pub fn check(&self, space: &ConfigSpace, stored: usize) -> Result<(), String> {
        let Self { mark, place, .. } = self;
        for ((name, list), length) in LISTS.iter().zip(self.lists()).zip(mark.lengths) {
            if list.len() != length {
                return Err(format!("`{name}`: got {} numbers, expected {length}", list.len()));
            }
            space.check_rows(list).map_err(|problem| format!("`{name}`: {problem}"))?;
        }
        let [samples, exits, _, free, colliding, fresh] = mark.lengths.map(|length| length / space.nq());
        check_spent(&mark.spent, &mark.next)?;
        if let AdaptStage::Tracing(Some(traced)) = &mark.stage {
            check_traced(traced, [free, samples, colliding])?;
        }
        check_solved(&place.solved, samples, fresh)?;
        if place.solved.exits > 0 && exits > 0 {
            return Err(format!("`exits`: got {exits} rows beside {} solved ones, expected none", place.solved.exits));
        }
        for (name, count, most) in [("verified", place.verified, stored), ("kept", place.kept, samples)] {
            if count > most {
                return Err(format!("{name}: got {count}, expected at most {most}"));
            }
        }
        check_count("kept_back", place.kept_back)?;
        let ClassifierAccuracy { accuracy, held_out, colliding_share } = &place.judged;
        held_out.iter().try_for_each(|count| check_count("held_out", *count))?;
        let shares = accuracy.iter().flatten().chain([colliding_share]);
        shares.copied().try_for_each(|share| check_share("accuracy", share))
    }
}

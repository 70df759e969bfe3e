//! What a learning run has found, and where the last whole unit of work ended.

use serde::{Deserialize, Serialize};

use super::checks::{check_solved, check_spent, check_traced};
use super::work::{self, StageKind};
use crate::learning::active_learning::Classified;
use crate::learning::budget::Spent;
use crate::learning::exploration::Exploration;
use crate::model::solve::SolvePlace;
use crate::model::statistics::{EndedBy, check_count, check_share};
use crate::samples::trace::TracePlace;
use crate::scene::Scene;

/// What a run has found. Within a unit of work the lists only grow (but for free configurations
/// that no pass will use), and the rest is as the last unit left it: so their beginnings are the
/// state at its end.
#[derive(Debug, Clone, Default)]
pub struct RunState {
    /// Labelled configurations.
    pub known: Exploration,
    /// Boundary samples, row major: traced ones, then exits.
    pub samples: Vec<f64>,
    /// The trained classifier, after the stage of training.
    pub classified: Classified,
    /// Share of uniform configurations that collide, after exploration.
    pub colliding_share: f64,
    /// What was looked at to tell whether the run may end.
    pub checks_of_quality: QualityChecks,
    /// How far solving has come.
    pub solved: SolvePlace,
    /// Where the last whole unit of work ended.
    pub mark: UnitEnd,
}

/// Where a unit of work ended.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UnitEnd {
    /// The stage of the unit to come.
    pub stage: Stage,
    /// Numbers in the lists of free configurations, of colliding ones, and of boundary samples.
    pub lengths: [usize; 3],
    /// Index of the next low-discrepancy point.
    pub next: u64,
    /// Labels and seconds until then.
    pub spent: Spent,
    /// Looks until then.
    pub checks_of_quality: QualityChecks,
    /// Where solving stood.
    pub solved: SolvePlace,
}

/// Checks of whether the queries are as good as was requested.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct QualityChecks {
    /// Boundary samples at the last one.
    pub samples: usize,
    /// Checks that all took.
    pub checks: usize,
}

/// What a unit of work belongs to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub enum Stage {
    /// Labels of low-discrepancy configurations.
    #[default]
    Exploring,
    /// The classifier.
    Training,
    /// The boundary.
    Tracing(TracePlace),
    /// The nearest exits of colliding configurations.
    Solving,
    /// What was learned is measured; learning has ended for this reason.
    Measuring(EndedBy),
}

impl Stage {
    /// As progress reports name it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Exploring => "exploring",
            Self::Training => "training",
            Self::Tracing(_) => "tracing the boundary",
            Self::Solving => "solving",
            Self::Measuring(_) => "measuring",
        }
    }
}

impl work::Stage for Stage {
    fn measuring(why: EndedBy) -> Self {
        Self::Measuring(why)
    }

    fn kind(&self) -> StageKind<Self> {
        match self {
            Self::Exploring => StageKind::First,
            Self::Training | Self::Tracing(_) => StageKind::Limited,
            Self::Solving => StageKind::Solving,
            Self::Measuring(why) => StageKind::Measuring(*why),
        }
    }

    fn name(&self) -> &'static str {
        self.name()
    }
}

impl QualityChecks {
    fn check(&self) -> Result<(), String> {
        check_count("checks of quality: samples", self.samples)?;
        check_count("checks of quality: checks", self.checks)
    }
}

impl RunState {
    /// Whether a state that was read as bytes can be one of a run in this scene, whose parts are
    /// decided about by `width` numbers.
    ///
    /// # Errors
    /// The element, its value, and what was expected.
    pub fn check(&self, scene: &Scene, width: usize) -> Result<(), String> {
        let Self { known, samples, mark, .. } = self;
        let space = &scene.space;
        let lists = [("free", &known.free), ("colliding", &known.colliding), ("samples", samples)];
        for ((name, list), length) in lists.into_iter().zip(mark.lengths) {
            if list.len() != length {
                return Err(format!("`{name}`: got {} numbers, expected {length}", list.len()));
            }
            space.check_rows(list).map_err(|problem| format!("`{name}`: {problem}"))?;
        }
        let [free, colliding, samples] = mark.lengths.map(|length| length / space.nq());
        check_spent(&mark.spent, &[mark.next])?;
        self.checks_of_quality.check()?;
        mark.checks_of_quality.check()?;
        check_share("colliding_share", self.colliding_share)?;
        if let Stage::Tracing(place) = &mark.stage {
            check_traced(place, [free, samples, colliding])?;
        }
        check_solved(&mark.solved, samples, colliding)?;
        let classified = self.classified.check(space, scene.pairs.len(), width);
        classified.map_err(|problem| format!("classifier: {problem}"))
    }

    /// The lists as they were at the mark: free, colliding, boundary samples.
    pub fn lists_at_mark(&self) -> [&[f64]; 3] {
        let lists = [&self.known.free, &self.known.colliding, &self.samples];
        std::array::from_fn(|i| &lists[i][..self.mark.lengths[i].min(lists[i].len())])
    }

    /// Sets the mark here.
    pub fn set_mark(&mut self, stage: Stage, spent: Spent) {
        let lengths = [self.known.free.len(), self.known.colliding.len(), self.samples.len()];
        self.mark = UnitEnd {
            stage,
            lengths,
            next: self.known.next,
            spent,
            checks_of_quality: self.checks_of_quality.clone(),
            solved: self.solved.clone(),
        };
    }
}

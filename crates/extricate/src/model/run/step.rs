//! One unit of a run after the other, until it has ended.

use super::Run;
use super::ending::end;
use super::memory::bytes;
use super::work::{Report, Stage, StageKind, Work, spent};
use crate::learning::Budget;
use crate::learning::budget::BudgetEnd;
use crate::model::statistics::EndedBy;

impl<W: Work> Run<W> {
    /// Does one unit of work; whether there is more to do.
    pub fn step(&mut self, report: &mut Report) -> bool {
        if self.end.is_none() {
            let pool = self.pool.clone();
            pool.install(|| self.unit(report));
            if self.end.is_none() && bytes(self) > self.ground.options.memory {
                let next = match self.work.stage().kind() {
                    StageKind::Whole(next) => next,
                    StageKind::Measuring(_) => return true,
                    _ => Stage::measuring(EndedBy::Memory),
                };
                self.work.enter(next, self.spent.clone(), self.ground.nq());
            }
        }
        self.end.is_none()
    }

    fn unit(&mut self, report: &mut Report) {
        let stage = self.work.stage().clone();
        let kind = stage.kind();
        if let StageKind::Measuring(why) = kind {
            return end(self, why, report);
        }
        let mut budget = Budget::resumed(&self.ground.options, &self.spent, report);
        let found = self.work.found();
        budget.note(found.samples.len() / self.ground.nq(), found.accuracy);
        if !matches!(kind, StageKind::First) || budget.left() == 0 {
            budget.stage(stage.name());
        }
        let is_whole = matches!(kind, StageKind::Whole(_));
        let next = match kind {
            StageKind::Solving => self.solve(&mut budget).map_or(stage, Stage::measuring),
            _ => self.work.unit(&self.ground, &mut self.tracer, &mut budget),
        };
        self.spent = budget.spent_so_far();
        let next = match (budget.end(), next.kind()) {
            (Some(BudgetEnd::Interrupted), _) => {
                self.end = Some(EndedBy::Interruption);
                return;
            }
            // What has ended for another reason did so before it ran out.
            (Some(_), kind) if !is_whole && !matches!(kind, StageKind::Measuring(_)) => {
                Stage::measuring(spent(&budget))
            }
            _ => next,
        };
        self.work.enter(next, self.spent.clone(), self.ground.nq());
    }

    /// A pass of solving; why it was the last one.
    fn solve(&mut self, budget: &mut Budget) -> Option<EndedBy> {
        // What tracing held is not needed any more.
        self.tracer = None;
        let Self { ground, work, solver, .. } = self;
        let to_solve = ground.to_solve(work.solving(ground));
        let (known, samples, place) = work.to_solve();
        let paid = to_solve.pass(known, samples, place, solver, &|configs| ground.label(configs), budget);
        if !paid {
            return Some(spent(budget));
        }
        (budget.end().is_none() && work.is_good_enough(ground, budget)).then_some(EndedBy::Quality)
    }
}

//! Uniform sampling as a learner: what learning is measured against, and nothing that a query is
//! better off with.

use std::sync::Arc;

use super::evaluate::calibrate::unmeasured;
use super::evaluate::{EvaluationBudget, measure_starts};
use super::learned::Model;
use super::run::labels;
use super::run::work::Report;
use super::statistics::{EndedBy, Statistics};
use crate::collision::Checker;
use crate::cspace::sampling::Halton;
use crate::error::{Error, Result};
use crate::learning::budget::BudgetEnd;
use crate::learning::exploration::{BATCH, Exploration};
use crate::learning::{Budget, LearnOptions};
use crate::metric::Metric;
use crate::query::report::coverage::Coverage;
use crate::scene::Scene;

/// A model whose labels all went to a low-discrepancy sequence, and whose samples are the free
/// configurations among them: the published way with uniform samples. There is no classifier, and
/// no sample is known to be near the boundary.
///
/// Of `options`, labels, seconds, seed and threads count. Nothing is measured afterwards but how
/// widely queries have to search.
///
/// # Guarantee
/// Every sample was labelled free. Without a limit in seconds the model depends on scene, labels
/// and seed alone.
///
/// # Errors
/// [`Error::Option`] for an option that makes no sense; [`Error::NothingFree`] where no free
/// configuration was found.
pub fn learn_uniform(scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    let pool = options.pool()?;
    pool.install(|| learn_here(scene, options, report))
}

fn learn_here(scene: Scene, options: &LearnOptions, report: &mut Report) -> Result<Model> {
    let scene = Arc::new(scene);
    let (checker, metric) = (Checker::new(scene.clone()), Metric::new(scene.clone()));
    let label = |configs: &[f64]| labels(&checker, configs);
    let halton = Halton::new(scene.space.nv(), options.seed);
    let mut budget = Budget::new(options, report);
    let mut known = Exploration::default();
    let mut colliding = 0;
    while budget.end().is_none() && budget.left() > 0 {
        known.extend(&scene.space, &halton, BATCH, &label, &mut budget);
        // Counted, then let go: they are no answers.
        colliding += known.colliding.len() / scene.space.nq();
        known.colliding.clear();
    }
    if known.free.is_empty() {
        return Err(Error::NothingFree { labels: budget.spent(), advice: "uniform sampling found none".into() });
    }
    let statistics = Statistics {
        labels: budget.spent(),
        seed: options.seed,
        boundary_samples: known.free.len() / scene.space.nq(),
        solved_samples: 0,
        stand_ins: known.free.len() / scene.space.nq(),
        support_vectors: 0,
        colliding_share: colliding as f64 / budget.spent().max(1) as f64,
        accuracy_free: None,
        accuracy_free_interval: None,
        accuracy_colliding: None,
        accuracy_colliding_interval: None,
        boundary_gap: None,
        density: None,
        excess: None,
        gap: None,
        starts_per_dof: unmeasured(),
        measuring_checks: 0,
        ended_by: match budget.end() {
            Some(BudgetEnd::Interrupted) => EndedBy::Interruption,
            Some(BudgetEnd::Seconds) => EndedBy::Seconds,
            Some(BudgetEnd::Labels) | None => EndedBy::Labels,
        },
        adapted: None,
    };
    let mut model = Model::from_parts(checker, metric, known.free, None, Coverage::default(), statistics);
    let extent = EvaluationBudget::after(model.statistics.labels, options.seed);
    let mut go_on = || budget.end() != Some(BudgetEnd::Interrupted);
    if let Some((starts, checks)) = measure_starts(&model.context(), &extent, &mut go_on) {
        (model.statistics.starts_per_dof, model.statistics.measuring_checks) = (starts, checks);
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::cspace::Label;
    use crate::scene::builtin;

    #[test]
    fn samples_are_the_free_ones_of_all_labels() {
        let options = LearnOptions { labels: 5000, seconds: None, seed: 3, ..LearnOptions::default() };
        let learn = |threads| {
            let options = LearnOptions { threads, ..options.clone() };
            learn_uniform(builtin::scene("planar-arm").unwrap(), &options, &mut |_| ControlFlow::Continue(())).unwrap()
        };
        let model = learn(1);
        let (statistics, nq) = (model.statistics(), model.scene().space.nq());
        let share = 1.0 - model.boundary().len() as f64 / 5000.0;
        assert_eq!(statistics.labels, 5000);
        assert!((statistics.colliding_share - share).abs() < 1e-12, "{share} {}", statistics.colliding_share);
        let mut labels = vec![Label::Colliding; model.boundary().len()];
        model.checker().label_batch(model.boundary().configs(), &mut labels);
        assert!(labels.iter().all(|label| *label == Label::Free) && !labels.is_empty());
        assert_eq!(learn(2).boundary().configs(), model.boundary().configs());
        assert!(model.boundary().configs().len() % nq == 0);
    }
}

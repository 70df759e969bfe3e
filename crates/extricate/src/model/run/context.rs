//! What the units of a run stand on: nothing of it changes meanwhile.

use std::sync::{Arc, OnceLock};

use crate::collision::Checker;
use crate::cspace::Label;
use crate::cspace::sampling::Halton;
use crate::learning::{LabelBatch, LearnOptions};
use crate::metric::Metric;
use crate::model::solve::SolveGround;
use crate::model::solve::policy::Solving;
use crate::query::bound::inner_spheres::InnerBalls;
use crate::query::report::coverage::Coverage;
use crate::query::{Context, Learned, StartsPerDof, World, index_samples};
use crate::samples::SampleSet;
use crate::samples::trace::TraceGround;
use crate::scene::Scene;

/// Boundary samples have a colliding configuration within this share of the space's diameter.
const GAP_SHARE: f64 = 1.0 / 2000.0;

pub struct RunContext {
    pub options: LearnOptions,
    pub checker: Checker,
    pub metric: Metric,
    pub halton: Halton,
    /// Metric units.
    pub gap: f64,
    balls: OnceLock<InnerBalls>,
    /// Of nothing: held-out queries need none.
    no_coverage: Coverage,
}

impl RunContext {
    /// For a run whose low-discrepancy configurations have the seed `stream`.
    pub fn new(scene: Arc<Scene>, options: &LearnOptions, stream: u64) -> Self {
        let metric = Metric::new(scene.clone());
        Self {
            options: options.clone(),
            halton: Halton::new(scene.space.nv(), stream),
            gap: GAP_SHARE * metric.diameter(),
            checker: Checker::new(scene),
            metric,
            balls: OnceLock::new(),
            no_coverage: Coverage::default(),
        }
    }

    pub fn scene(&self) -> &Scene {
        self.checker.scene()
    }

    pub fn nq(&self) -> usize {
        self.scene().space.nq()
    }

    pub fn label(&self, configs: &[f64]) -> Vec<Label> {
        labels(&self.checker, configs)
    }

    pub fn index(&self, configs: Vec<f64>, exits: usize) -> SampleSet {
        index_samples(&self.checker, &self.metric, configs, exits, self.options.seed)
    }

    pub fn to_trace<'a>(&'a self, label: &'a LabelBatch<'a>, draws_seeds: bool) -> TraceGround<'a> {
        let Self { metric, gap, options, .. } = self;
        TraceGround { space: &self.scene().space, metric, label, gap: *gap, seed: options.seed, draws_seeds }
    }

    pub fn to_solve(&self, solving: Solving) -> SolveGround<'_> {
        SolveGround {
            checker: &self.checker,
            metric: &self.metric,
            balls: self.balls(),
            no_coverage: &self.no_coverage,
            halton: &self.halton,
            gap: self.gap,
            seed: self.options.seed,
            solving,
        }
    }

    /// What queries stand on, with the samples so far.
    pub fn to_query<'a>(&'a self, boundary: &'a SampleSet, starts: StartsPerDof) -> Context<'a> {
        let learned = Learned { boundary, coverage: &self.no_coverage, starts };
        Context::new((&self.checker, &self.metric, self.balls()), learned, None)
    }

    /// What of it a model keeps.
    pub fn into_world(self) -> World {
        let balls = self.balls.into_inner().unwrap_or_else(|| InnerBalls::new(&self.checker, None));
        World::of_parts(self.checker, self.metric.into(), balls)
    }

    fn balls(&self) -> &InnerBalls {
        self.balls.get_or_init(|| InnerBalls::new(&self.checker, None))
    }
}

/// The labels of many configurations, row major.
pub fn labels(checker: &Checker, configs: &[f64]) -> Vec<Label> {
    let mut labels = vec![Label::Free; configs.len() / checker.scene().space.nq()];
    checker.label_batch(configs, &mut labels);
    labels
}

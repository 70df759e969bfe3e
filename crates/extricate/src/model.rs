//! What is learned of a scene, and the two things to do with it: learn it, ask it.

use std::ops::ControlFlow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::boundary::SampleSet;
use crate::boundary::trace::{TraceGround, trace};
use crate::collision::{Checker, always_colliding};
use crate::cspace::sampling::Halton;
use crate::cspace::{Config, Label};
use crate::error::{Error, Result};
use crate::learning::active::{Classified, classify, surprising_first};
use crate::learning::budget::BudgetEnd;
use crate::learning::classifier::Classifier;
use crate::learning::explore::{BATCH, Exploration};
use crate::learning::{Budget, LearnOptions, LearnProgress};
use crate::metric::{Metric, MetricScratch};
use crate::penetration::batch::in_blocks;
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::{Answer, Answered, ChangedScene, Ground, QueryOptions, QueryScratch, Stream, query};
use crate::scene::{MetricSpec, Scene};

/// All that a query needs: the scene with its geometry, verified boundary samples, their index, the classifier.
///
/// Immutable; share it between threads.
pub struct Model {
    checker: Checker,
    metric: Metric,
    boundary: SampleSet,
    classifier: Option<Classifier>,
    balls: InteriorBalls,
    statistics: Statistics,
}

/// How a model was learned and how good it measured itself to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Exact checks spent.
    pub labels: usize,
    /// Seed.
    pub seed: u64,
    /// Verified free boundary samples stored.
    pub boundary_samples: usize,
    /// Support vectors of the classifier.
    pub support_vectors: usize,
    /// Share of uniform configurations that collide.
    pub colliding_share: f64,
    /// Held-out accuracy on free configurations; `None` where there was no classifier or none to hold out.
    pub accuracy_free: Option<f64>,
    /// Held-out accuracy on colliding configurations.
    pub accuracy_colliding: Option<f64>,
    /// Every boundary sample has a colliding configuration within this distance, in the scene's metric. `None` where no
    /// boundary was found and any free configurations stand in for its samples.
    pub boundary_gap: Option<f64>,
    /// What ended learning. With a limit in seconds, the model depends on the speed of the machine.
    pub ended_by: EndedBy,
}

/// What ended a learning run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndedBy {
    /// The budget of labels.
    Labels,
    /// The budget of seconds.
    Seconds,
    /// The caller.
    Interruption,
}

/// Share of the budget, labels or seconds, spent on exploration before the boundary is traced.
const EXPLORATION_SHARE: f64 = 0.2;
/// Labels that exploration spends at most; tracing draws what it needs beyond them.
const MOST_EXPLORATION: usize = 200_000;
/// Configurations below which "collides every time" says nothing.
const FEW: usize = 100;

/// Seeds looked at for surprises for every second of the limit: a share of the time that is small on any robot.
const SURPRISES_A_SECOND: f64 = 1000.0;

/// Boundary samples have a colliding configuration within this share of the space's diameter.
const GAP_SHARE: f64 = 1.0 / 2000.0;

impl Model {
    /// Learns `scene` from nothing. `progress` is called after every batch of labels and may stop the run, which keeps what is
    /// learned by then.
    ///
    /// Without a limit in seconds the result depends on scene, labels and seed alone, whatever the number of threads, unless the
    /// caller ended it.
    ///
    /// # Errors
    /// [`Error::NothingFree`] where no free configuration was found; [`Error::Interrupted`] where the caller stopped before one
    /// was.
    pub fn learn(
        scene: Scene,
        options: &LearnOptions,
        progress: &mut (dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send),
    ) -> Result<Model> {
        if options.labels == 0 {
            return Err(Error::Option { name: "labels", value: "0".into(), expected: "at least 1" });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build().map_err(|e| Error::Option {
            name: "threads",
            value: format!("{} ({e})", options.threads),
            expected: "a number of threads that the system can start",
        })?;
        pool.install(|| learn(Arc::new(scene), options, progress))
    }

    /// Puts a model together from its stored parts.
    pub(crate) fn from_parts(
        checker: Checker,
        metric: Metric,
        configs: Vec<f64>,
        classifier: Option<Classifier>,
        statistics: Statistics,
    ) -> Self {
        let boundary = SampleSet::new(&metric, checker.scene().space.nq(), configs, statistics.seed);
        let balls = InteriorBalls::new(&checker);
        Self { checker, metric, boundary, classifier, balls, statistics }
    }

    /// The scene it was learned for.
    pub fn scene(&self) -> &Scene {
        self.checker.scene()
    }

    /// The exact checker of its scene.
    pub fn checker(&self) -> &Checker {
        &self.checker
    }

    /// The metric of its scene.
    pub fn metric(&self) -> &Metric {
        &self.metric
    }

    /// Its verified boundary samples.
    pub fn boundary(&self) -> &SampleSet {
        &self.boundary
    }

    /// The classifier of the obstacle region; `None` where only one label was ever seen.
    pub fn classifier(&self) -> Option<&Classifier> {
        self.classifier.as_ref()
    }

    /// How it was learned.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The nearest free configuration to `q`, see [`query`].
    pub fn query(&self, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Answer {
        query(&self.ground(), q, options, scratch).expect("a model holds a free sample")
    }

    /// As [`Model::query`], in a scene that differs from the one that was learned. Stored samples are verified anew as they are needed;
    /// `checks` counts that. `None` where nothing free was found, not even among 20,000 configurations beside the samples.
    ///
    /// # Guarantee
    /// That of [`query`]: the witness is free in `scene`, verified during this call, and the bound holds there. How near the
    /// witness is to the nearest way out depends on what the samples still say: far from what changed, as much as before.
    pub fn query_in(
        &self,
        scene: &ChangedScene,
        q: &Config,
        options: &QueryOptions,
        scratch: &mut QueryScratch,
    ) -> Option<Answer> {
        scene.query(&self.boundary, q, options, scratch)
    }

    /// [`Model::query_batch`] in a changed scene.
    pub fn query_batch_in(
        &self,
        scene: &ChangedScene,
        queries: impl IntoIterator<Item = Config>,
        options: &QueryOptions,
        threads: usize,
        each: &mut dyn FnMut(Answered<Option<Answer>>) -> ControlFlow<()>,
    ) -> usize {
        scene.query_batch(&self.boundary, &mut queries.into_iter(), options, threads, each)
    }

    /// The answer for the next frame of a stream of queries that are near each other: warm-started from the last one, see [`Stream`].
    ///
    /// # Guarantee
    /// That of [`query`]; but the answer also depends on the frames before.
    pub fn query_next(&self, q: &Config, stream: &mut Stream) -> Answer {
        stream.query(&self.ground(), q).expect("a model holds a free sample")
    }

    /// Gives the answers to many queries, in order, to `each`, which may end it; returns how many were given. Works on `threads` threads
    /// (0: one a core).
    ///
    /// # Guarantee
    /// Each answer is that of [`Model::query`] alone (unless a budget of seconds ends it), whatever the number of threads. At most
    /// 4096 answers are kept at a time.
    pub fn query_batch(
        &self,
        queries: impl IntoIterator<Item = Config>,
        options: &QueryOptions,
        threads: usize,
        each: &mut dyn FnMut(Answered) -> ControlFlow<()>,
    ) -> usize {
        in_blocks(&mut queries.into_iter(), threads, &|q, scratch| self.query(q, options, scratch), each)
    }

    fn ground(&self) -> Ground<'_> {
        Ground {
            checker: &self.checker,
            metric: &self.metric,
            boundary: &self.boundary,
            balls: &self.balls,
            clearance: self.scene().clearance,
            scale: self.metric.diameter(),
            stale: false,
        }
    }
}

fn learn(
    scene: Arc<Scene>,
    options: &LearnOptions,
    progress: &mut dyn FnMut(&LearnProgress) -> ControlFlow<()>,
) -> Result<Model> {
    let checker = Checker::new(scene.clone());
    let metric = Metric::new(scene.clone());
    let nq = scene.space.nq();
    let label = |configs: &[f64]| -> Vec<Label> {
        let mut labels = vec![Label::Free; configs.len() / nq];
        checker.label_batch(configs, &mut labels);
        labels
    };
    let mut budget = Budget::new(options, progress);
    let halton = Halton::new(scene.space.nv(), options.seed);
    let mut known = Exploration::default();
    let first = ((options.labels as f64 * EXPLORATION_SHARE) as usize).clamp(1, MOST_EXPLORATION);
    while budget.end().is_none() {
        let to_come = first.saturating_sub(budget.spent());
        let enough = to_come == 0 || budget.fraction() >= EXPLORATION_SHARE;
        if enough && !known.free.is_empty() {
            break;
        }
        known.extend(&scene.space, &halton, if enough { BATCH } else { to_come.min(BATCH) }, &label, &mut budget);
    }
    if known.free.is_empty() {
        return Err(nothing_free(&checker, &known, &budget));
    }
    let colliding_share = known.colliding.len() as f64 / (known.colliding.len() + known.free.len()) as f64;

    budget.stage("training");
    // The kernel sees the bodies' displacement, whatever the metric: on joint angles it learns far less.
    let feature_metric = Metric::of_kind(scene.clone(), MetricSpec::ObjectNorm);
    let features = |q: &[f64]| {
        let mut out = vec![0.0; feature_metric.embedding_len()];
        feature_metric.embed(q, &mut MetricScratch::default(), &mut out);
        out
    };
    let Classified { classifier, accuracy_free, accuracy_colliding } =
        classify(&scene.space, &features, &mut known, &label, options.seed, &mut budget);
    if let Some(classifier) = &classifier {
        let by_time = budget.seconds().map_or(usize::MAX, |limit| (limit * SURPRISES_A_SECOND) as usize);
        surprising_first(classifier, &features, nq, by_time.min(budget.left() / 8), &mut known.colliding);
    }

    budget.stage("tracing the boundary");
    let gap = GAP_SHARE * metric.diameter();
    let ground = TraceGround { space: &scene.space, metric: &metric, label: &label, gap, seed: options.seed };
    let mut samples = trace(&ground, &mut known, &halton, &mut budget);
    let traced = !samples.is_empty();
    if !traced {
        // Nothing collided, or nothing was traced in time: free configurations are answers too, only far ones.
        samples.extend_from_slice(&known.free[..known.free.len().min(1024 * nq)]);
    }
    let statistics = Statistics {
        labels: budget.spent(),
        seed: options.seed,
        boundary_samples: samples.len() / nq,
        support_vectors: classifier.as_ref().map_or(0, Classifier::support_vectors),
        colliding_share,
        accuracy_free,
        accuracy_colliding,
        boundary_gap: traced.then_some(gap),
        ended_by: match budget.end() {
            Some(BudgetEnd::Seconds) => EndedBy::Seconds,
            Some(BudgetEnd::Interrupted) => EndedBy::Interruption,
            _ => EndedBy::Labels,
        },
    };
    budget.stage("indexing");
    Ok(Model::from_parts(checker, metric, samples, classifier, statistics))
}

fn nothing_free(checker: &Checker, known: &Exploration, budget: &Budget) -> Error {
    if budget.end() == Some(BudgetEnd::Interrupted) {
        return Error::Interrupted;
    }
    let scene = checker.scene();
    let tried: Vec<Vec<f64>> = known.colliding.chunks_exact(scene.space.nq()).take(1000).map(<[f64]>::to_vec).collect();
    let named = |pair: usize| format!("[\"{}\", \"{}\"]", scene.pair_names(pair)[0], scene.pair_names(pair)[1]);
    let always: Vec<String> = always_colliding(checker, &tried).into_iter().map(named).collect();
    let advice = if tried.len() < FEW {
        "too few to tell why; spend more labels or seconds".into()
    } else if always.is_empty() {
        "no single pair is to blame; widen the limits, lower the clearance or spend more labels".into()
    } else {
        format!(
            "these pairs collide every time; if by design, add to the scene: [pairs] disable = [{}]",
            always.join(", ")
        )
    };
    Error::NothingFree { labels: budget.spent(), advice }
}

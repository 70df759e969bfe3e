//! What is learned of a scene, and the two things to do with it: learn it, ask it.

pub mod adapt;
pub mod calibrate;
pub mod learner;
pub mod measure;
pub mod near_miss;
pub mod quality;
mod recombine;
mod run;
pub mod run_state;
pub mod scene_change;
pub mod solve;
mod solving;
pub mod uniform;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::boundary::SampleSet;
use crate::collision::Checker;
use crate::cspace::Config;
use crate::cspace::sampling::Halton;
use crate::error::Result;
use crate::learning::union::UnionClassifier;
use crate::learning::{LearnOptions, LearnProgress};
use crate::metric::Metric;
use crate::penetration::batch::in_blocks;
use crate::penetration::certificate::InteriorBalls;
use crate::penetration::coverage::Coverage;
use crate::penetration::{
    Answer, Answered, ChangedScene, Context, Learned, QueryOptions, QueryScratch, StartsPerDof, Stream, World,
    index_samples, query,
};
use crate::scene::Scene;
use learner::Learner;
use quality::{Density, Excess, Gap};

/// All that a query needs: the scene with its geometry, verified boundary samples, their index, the classifier.
///
/// Immutable; share it between threads.
pub struct Model {
    world: World,
    boundary: SampleSet,
    classifier: Option<UnionClassifier>,
    coverage: Coverage,
    statistics: Statistics,
}

/// How a model was learned and how good it measured itself to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Exact checks spent, those of solving and its evaluations of contacts included.
    pub labels: usize,
    /// Seed.
    pub seed: u64,
    /// Verified free boundary samples stored.
    pub boundary_samples: usize,
    /// How many of them, the last, are exits: ways out of configurations that were solved while learning, the nearest and, while exits were
    /// few, others.
    pub exits: usize,
    /// How many of them, the first, are any free configurations, which stand in where fewer than 128 samples were found.
    pub stand_ins: usize,
    /// Support vectors of the classifier, of the machines of all pairs together.
    pub support_vectors: usize,
    /// Share of uniform configurations that collide.
    pub colliding_share: f64,
    /// Held-out accuracy on free configurations; `None` where there was no classifier or none to hold out.
    pub accuracy_free: Option<f64>,
    /// Its 95 % confidence interval (Wilson).
    pub accuracy_free_interval: Option<[f64; 2]>,
    /// Held-out accuracy on colliding configurations.
    pub accuracy_colliding: Option<f64>,
    /// Its 95 % confidence interval.
    pub accuracy_colliding_interval: Option<[f64; 2]>,
    /// Every boundary sample that is not a stand-in has a colliding configuration within this distance, in the scene's metric. `None`
    /// where all are stand-ins.
    pub boundary_gap: Option<f64>,
    /// How densely the boundary is sampled; `None` where nothing held out collided, or the run was interrupted.
    pub density: Option<Density>,
    /// How good refined queries are on held-out colliding configurations: 64 of them, fewer where a check for every four labels does
    /// not pay for so many. `None` where none was asked, as with less than 10,000 labels.
    pub excess: Option<Excess>,
    /// How much of the depth the same queries leave unproved; `None` also of models of versions that
    /// did not measure it.
    #[serde(default)]
    pub gap: Option<Gap>,
    /// Starts of a refined query for each degree of freedom, see [`crate::model::calibrate`].
    #[serde(alias = "width", deserialize_with = "calibrate::read")]
    pub starts_per_dof: StartsPerDof,
    /// Collision and distance evaluations spent on these three, and on telling whether the run may end: beside `labels`.
    pub measuring_checks: usize,
    /// What ended learning. With a limit in seconds, the model depends on the speed of the machine.
    pub ended_by: EndedBy,
    /// Where the model was adapted: from what. `None` where it was learned from nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adapted: Option<Adapted>,
}

/// Where an adapted model comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Adapted {
    /// Labels of the model at the beginning, which was learned from nothing.
    pub learned_labels: usize,
    /// How many times it was adapted since.
    pub times: usize,
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
    /// The limit on memory.
    Memory,
    /// The quality that was asked for.
    Quality,
}

impl Model {
    /// Learns `scene` from nothing. `progress` is called after every batch of labels and may stop the run, which keeps what is
    /// learned by then.
    ///
    /// Without a limit in seconds the result depends on scene, labels and seed alone, whatever the number of threads, unless the
    /// caller ended it.
    ///
    /// # Errors
    /// [`NothingFree`](crate::Error::NothingFree) where no free configuration was found;
    /// [`Interrupted`](crate::Error::Interrupted) where the caller stopped before one was.
    pub fn learn(
        scene: Scene,
        options: &LearnOptions,
        progress: &mut (dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send),
    ) -> Result<Model> {
        let mut learner = Learner::new(scene, options)?;
        while learner.step(progress) {}
        learner.finish(progress)
    }

    /// A model of `scene`, a changed variant of this model's, from what is known of the old one; see [`adapt::adapt`].
    ///
    /// # Errors
    /// [`crate::Error::Adapt`] where robots, limits or metric differ, and those of [`Model::learn`].
    pub fn adapt(
        &self,
        scene: Scene,
        options: &LearnOptions,
        progress: &mut (dyn FnMut(&LearnProgress) -> ControlFlow<()> + Send),
    ) -> Result<Model> {
        adapt::adapt(self, scene, options, progress)
    }

    /// Puts a model together from its stored parts, and makes anew what can be.
    pub(crate) fn from_parts(
        checker: Checker,
        metric: Metric,
        configs: Vec<f64>,
        classifier: Option<UnionClassifier>,
        coverage: Coverage,
        statistics: Statistics,
    ) -> Self {
        let boundary = index_samples(&checker, &metric, configs, statistics.exits, statistics.seed);
        Self::with_boundary(checker, metric, boundary, classifier, coverage, statistics)
    }

    /// Puts a model together, with what was kept that could be made anew.
    pub(crate) fn with_boundary(
        checker: Checker,
        metric: Metric,
        boundary: SampleSet,
        classifier: Option<UnionClassifier>,
        coverage: Coverage,
        statistics: Statistics,
    ) -> Self {
        let balls = InteriorBalls::new(&checker, None);
        let world = World::of_parts(checker, metric.into(), balls);
        Self { world, boundary, classifier, coverage, statistics }
    }

    /// Its scene, ready to be asked without what was learned of it.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The scene it was learned for.
    pub fn scene(&self) -> &Scene {
        self.world.scene()
    }

    /// The exact checker of its scene.
    pub fn checker(&self) -> &Checker {
        self.world.checker()
    }

    /// The metric of its scene.
    pub fn metric(&self) -> &Metric {
        self.world.metric()
    }

    /// Its verified boundary samples.
    pub fn boundary(&self) -> &SampleSet {
        &self.boundary
    }

    /// The classifier of the obstacle region, with a machine for every pair that was seen to collide; its parts are indices into
    /// [`Scene::pairs`]. `None` where only one label was ever seen.
    pub fn classifier(&self) -> Option<&UnionClassifier> {
        self.classifier.as_ref()
    }

    /// The configurations that are support vectors, row major: of the machines in their order, one after the other; what two
    /// machines share comes twice. They lie on both sides of the boundary.
    pub fn support_configs(&self) -> Vec<f64> {
        self.classifier
            .iter()
            .flat_map(UnionClassifier::machines)
            .flat_map(|machine| &machine.support)
            .copied()
            .collect()
    }

    /// What distances of queries to their nearest samples are compared with.
    pub fn coverage(&self) -> &Coverage {
        &self.coverage
    }

    /// How it was learned.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The nearest free configuration to `q`, see [`query`]. `None` only where joints were locked
    /// or a clearance was asked for, and nothing free was found.
    pub fn query(&self, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
        query(&self.context(), q, options, scratch)
    }

    /// Asks configurations that nobody wants to know, spread over the whole space, for about as long as `duration`, so that the first query that counts
    /// takes as long as those that follow. Of a program that has just loaded a model the first hundred take up to twice as long: code and samples
    /// are not yet near the processor, branches not yet foreseen, and `scratch` has no memory. 30 ms are enough.
    ///
    /// # Guarantee
    /// Answers stay the same.
    pub fn warm_up(&self, options: &QueryOptions, scratch: &mut QueryScratch, duration: Duration) {
        let (space, started) = (&self.scene().space, Instant::now());
        let (halton, mut q) = (Halton::new(space.nv(), 1), vec![0.0; space.nq()]);
        let configs = (0..).map_while(|index| {
            halton.config(space, index, &mut q);
            (started.elapsed() < duration).then(|| space.config(&q))
        });
        configs.flatten().for_each(|q| {
            self.query(&q, options, scratch);
        });
    }

    /// As [`Model::query`], in a scene that differs from the one that was learned. Stored samples are verified anew as they are needed;
    /// `checks` counts that. Where nothing that changed collides at `q`, it costs about as much as in the learned scene, else several times that.
    /// `None` where nothing free was found, not even among 20,000 configurations beside the samples, or where looking for it was stopped.
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
        scene.query(&self.learned(), q, options, scratch)
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
        scene.query_batch(&self.learned(), &mut queries.into_iter(), options, threads, each)
    }

    /// The answer for the next frame of a stream of queries that are near each other: warm-started from the last one, see [`Stream`].
    ///
    /// # Guarantee
    /// That of [`query`]; but the answer also depends on the frames before.
    pub fn query_next(&self, q: &Config, stream: &mut Stream) -> Option<Answer> {
        stream.query(&self.context(), q)
    }

    /// [`Model::query_next`] in a changed scene, which may be another one in every frame, as where obstacles move.
    ///
    /// # Guarantee
    /// That of [`Model::query_in`]; but the answer also depends on the frames before.
    pub fn query_next_in(&self, scene: &ChangedScene, q: &Config, stream: &mut Stream) -> Option<Answer> {
        scene.query_next(&self.learned(), q, stream)
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
        each: &mut dyn FnMut(Answered<Option<Answer>>) -> ControlFlow<()>,
    ) -> usize {
        in_blocks(&mut queries.into_iter(), threads, &|q, scratch| self.query(q, options, scratch), each)
    }

    fn learned(&self) -> Learned<'_> {
        Learned { boundary: &self.boundary, coverage: &self.coverage, starts: self.statistics.starts_per_dof }
    }

    pub(crate) fn context(&self) -> Context<'_> {
        self.world.with(&self.learned(), None)
    }
}

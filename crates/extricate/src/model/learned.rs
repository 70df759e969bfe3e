//! The learned model of a scene: what it holds, and how it is asked. Not how it is learned.

use super::statistics::Statistics;
use crate::collision::Checker;
use crate::cspace::Config;
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::metric::Metric;
use crate::query::inner_balls::InnerBalls;
use crate::query::{Answer, ChangedScene, Context, QueryOptions, Solver, Stored, View, World, index_samples};
use crate::samples::SampleSet;
use crate::scene::Scene;

/// All that a query needs: the scene with its geometry, verified boundary samples, their index, the
/// classifier.
///
/// Immutable; share it between threads.
pub struct Model {
    pub(super) world: World,
    pub(super) boundary: SampleSet,
    pub(super) classifier: Option<ObstacleClassifier>,
    pub(super) statistics: Statistics,
}

impl Model {
    /// Puts a model together from its stored parts, and makes anew what can be.
    pub(crate) fn from_parts(
        checker: Checker,
        metric: Metric,
        configs: Vec<f64>,
        classifier: Option<ObstacleClassifier>,
        statistics: Statistics,
    ) -> Self {
        let boundary = index_samples(&checker, &metric, configs, statistics.solved_samples, statistics.seed);
        Self::with_boundary(checker, metric, boundary, classifier, statistics)
    }

    /// Puts a model together, with what was kept that could be made anew.
    pub(crate) fn with_boundary(
        checker: Checker,
        metric: Metric,
        boundary: SampleSet,
        classifier: Option<ObstacleClassifier>,
        statistics: Statistics,
    ) -> Self {
        let balls = InnerBalls::new(&checker, None);
        let world = World::of_parts(checker, metric.into(), balls);
        Self { world, boundary, classifier, statistics }
    }

    /// Its scene, ready to be queried without what was learned of it.
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

    /// The classifier of the obstacle region, with an SVM for every pair that was seen to collide;
    /// its parts are indices into [`Scene::pairs`]. Pairs of a body with many that never move share
    /// one, that of the first of them. `None` where only one label was ever seen.
    pub fn classifier(&self) -> Option<&ObstacleClassifier> {
        self.classifier.as_ref()
    }

    /// The configurations that are support vectors, row major: of the svms in their order, one
    /// after the other; what two svms share comes twice. They lie on both sides of the boundary.
    pub fn support_configs(&self) -> Vec<f64> {
        self.classifier.iter().flat_map(ObstacleClassifier::svms).flat_map(|svm| &svm.support).copied().collect()
    }

    /// How it was learned.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// What its queries are answered from, in the scene that was learned.
    pub fn view(&self) -> View<'_> {
        View::new(self.context())
    }

    /// The same in a scene that differs from the one that was learned: what was stored is a start
    /// of descents like any other there.
    ///
    /// # Guarantee
    /// That of a query without a model in that scene.
    pub fn in_scene<'a>(&'a self, scene: &'a ChangedScene) -> View<'a> {
        View::new(scene.context(self.stored()))
    }

    /// The nearest free configuration to `q`, with default options; see [`View::query`].
    pub fn query(&self, q: &Config) -> Option<Answer> {
        self.view().query(q)
    }

    /// Answers with these options, and keeps memory between queries. One for each thread.
    pub fn solver(&self, options: QueryOptions) -> Solver<'_> {
        self.view().solver(options)
    }

    fn stored(&self) -> Stored<'_> {
        Stored { samples: &self.boundary, holding: None }
    }

    pub(crate) fn context(&self) -> Context<'_> {
        self.world.with(Some(self.stored()))
    }
}

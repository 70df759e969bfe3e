//! Queries of a scene of which nothing was learned.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::batch::{Answered, in_blocks};
use super::certificate::InteriorBalls;
use super::change::Change;
use super::context::{Context, Learned};
use super::coverage::Coverage;
use super::plan::UNLEARNED;
use super::{Answer, QueryOptions, QueryScratch, Stream, query};
use crate::boundary::SampleSet;
use crate::collision::Checker;
use crate::cspace::Config;
use crate::metric::Metric;
use crate::scene::Scene;

/// A scene that is ready to be asked: nothing has to be learned.
///
/// A model of the scene takes fewer checks; the guarantees are the same. Immutable; share it
/// between threads.
///
/// ```
/// use extricate::{QueryOptions, QueryScratch, World, scene::builtin};
/// let world = World::new(builtin::scene("planar-arm")?);
/// let q = world.scene().space.config(&[0.0, 0.0, 0.0])?;
/// let answer = world.query(&q, &QueryOptions::default(), &mut QueryScratch::default()).unwrap();
/// assert!(answer.verified || answer.depth == 0.0);
/// # extricate::Result::Ok(())
/// ```
pub struct World {
    checker: Checker,
    metric: Arc<Metric>,
    balls: InteriorBalls,
    samples: SampleSet,
    coverage: Coverage,
}

impl World {
    /// Prepares a scene: the exact checker, the metric, what bounds stand on.
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        let checker = Checker::new(scene.into());
        let metric = Metric::new(checker.scene_arc().clone());
        let balls = InteriorBalls::new(&checker, None);
        Self::of_parts(checker, metric.into(), balls)
    }

    /// Prepares another scene, such as one in which an obstacle moved ([`Scene::moved`]), and
    /// shares what this one has prepared of equal bodies: it takes as long as what differs.
    ///
    /// # Guarantee
    /// Answers are those of [`World::new`].
    pub fn with_scene(&self, scene: impl Into<Arc<Scene>>) -> Self {
        let checker = self.checker.for_scene(scene.into());
        let scene = checker.scene_arc();
        let metric = match self.metric.is_of(scene) {
            true => Arc::clone(&self.metric),
            false => Metric::new(scene.clone()).into(),
        };
        let balls = InteriorBalls::new(&checker, Some((&self.checker, &self.balls)));
        Self::of_parts(checker, metric, balls)
    }

    /// Of what is prepared already.
    pub(crate) fn of_parts(checker: Checker, metric: Arc<Metric>, balls: InteriorBalls) -> Self {
        let samples = SampleSet::new(&metric, checker.scene().space.nq(), Vec::new(), 0);
        Self { checker, metric, balls, samples, coverage: Coverage::default() }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        self.checker.scene()
    }

    /// Its exact checker.
    pub fn checker(&self) -> &Checker {
        &self.checker
    }

    /// Its metric.
    pub fn metric(&self) -> &Metric {
        &self.metric
    }

    /// The nearest free configuration to `q`; see [`query`]. `None` where nothing free was found,
    /// not even among 20,000 configurations, or where looking for it was stopped. `coverage` of the
    /// answer is `None`.
    ///
    /// # Guarantee
    /// That of [`query`], for every effort: the witness was verified during this call.
    pub fn query(&self, q: &Config, options: &QueryOptions, scratch: &mut QueryScratch) -> Option<Answer> {
        query(&self.context(), q, options, scratch)
    }

    /// [`crate::Model::query_batch`] where nothing was learned.
    pub fn query_batch(
        &self,
        queries: impl IntoIterator<Item = Config>,
        options: &QueryOptions,
        threads: usize,
        each: &mut dyn FnMut(Answered<Option<Answer>>) -> ControlFlow<()>,
    ) -> usize {
        in_blocks(&mut queries.into_iter(), threads, &|q, scratch| self.query(q, options, scratch), each)
    }

    /// The answer for the next frame of a stream; see [`crate::Model::query_next`].
    ///
    /// # Guarantee
    /// That of [`World::query`]; but the answer also depends on the frames before.
    pub fn query_next(&self, q: &Config, stream: &mut Stream) -> Option<Answer> {
        stream.query(&self.context(), q)
    }

    /// The same from what a model has learned, of this scene or another one.
    pub(crate) fn with<'a>(&'a self, learned: &Learned<'a>, change: Option<&'a Change>) -> Context<'a> {
        let context = Context::new((&self.checker, &self.metric, &self.balls), *learned, change);
        Context { unlearned: change.map(|_| self.unlearned()), ..context }
    }

    fn unlearned(&self) -> Learned<'_> {
        Learned { boundary: &self.samples, coverage: &self.coverage, starts: UNLEARNED }
    }

    pub(super) fn context(&self) -> Context<'_> {
        self.with(&self.unlearned(), None)
    }
}

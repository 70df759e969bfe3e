//! Queries of a scene of which nothing was learned.

pub mod changed;
pub mod view;

use std::sync::Arc;

use super::answer::Answer;
use super::context::{Context, Stored};
use super::inner_balls::InnerBalls;
use super::options::QueryOptions;
use crate::collision::Checker;
use crate::cspace::Config;
use crate::metric::Metric;
use crate::scene::Scene;
use view::{Solver, View};

/// A scene that is ready to be queried: nothing has to be learned.
///
/// A model of the scene stores further starts; the guarantees are the same. Immutable; share it
/// between threads.
///
/// ```
/// use extricate::{World, builtin};
/// let world = World::new(builtin::scene("planar-arm")?);
/// let q = world.scene().config(&[0.0, 0.0, 0.0])?;
/// let answer = world.query(&q).expect("something is free");
/// assert!(answer.verified || answer.depth == 0.0);
/// # extricate::Result::Ok(())
/// ```
pub struct World {
    checker: Checker,
    metric: Arc<Metric>,
    balls: InnerBalls,
}

impl World {
    /// Prepares a scene: the exact checker, the metric, what bounds stand on. Convex pieces of its
    /// meshes are made by the first [`World::view`].
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        let checker = Checker::new(scene.into());
        let metric = Metric::new(checker.scene_arc().clone());
        let balls = InnerBalls::new(&checker, None);
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
        let balls = InnerBalls::new(&checker, Some((&self.checker, &self.balls)));
        Self::of_parts(checker, metric, balls)
    }

    /// Of what is prepared already.
    pub(crate) fn of_parts(checker: Checker, metric: Arc<Metric>, balls: InnerBalls) -> Self {
        Self { checker, metric, balls }
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

    /// What queries are answered from: this scene, and nothing learned.
    ///
    /// # Cost
    /// The first call makes the convex pieces of all meshes, on all threads of the current pool:
    /// some tenths of a second for a robot of raw meshes. Later ones cost nothing.
    pub fn view(&self) -> View<'_> {
        View::new(self.context())
    }

    /// The nearest free configuration to `q`, with default options. `None` where nothing free was
    /// found, not even among 20,000 configurations.
    ///
    /// # Guarantee
    /// That of [`View::query`].
    pub fn query(&self, q: &Config) -> Option<Answer> {
        self.view().query(q)
    }

    /// Answers with these options, and keeps memory between queries. One for each thread.
    pub fn solver(&self, options: QueryOptions) -> Solver<'_> {
        self.view().solver(options)
    }

    /// What queries stand on, with what a model has stored. All that queries need of meshes is made
    /// by then: no answer depends on what was asked before, and no query spends its time on it.
    pub(crate) fn with<'a>(&'a self, stored: Option<Stored<'a>>) -> Context<'a> {
        self.checker.prepare_proposals();
        Context::new(&self.checker, &self.metric, &self.balls, stored)
    }

    pub(crate) fn context(&self) -> Context<'_> {
        self.with(None)
    }
}

//! A scene prepared for queries: its checker, metric and inner balls.

use std::sync::Arc;

use super::context::{Context, Stored};
use super::inner_balls::InnerBalls;
use crate::collision::Checker;
use crate::metric::Metric;
use crate::scene::Scene;

/// The exact checker of a scene, its metric, and the balls inside its bodies.
pub struct Prepared {
    checker: Checker,
    metric: Arc<Metric>,
    balls: InnerBalls,
}

impl Prepared {
    /// Prepares a scene. Convex pieces of its meshes are made by the first [`Prepared::with`].
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        let checker = Checker::new(scene.into());
        let metric = Metric::new(checker.scene_arc().clone());
        Self::from_parts(checker, metric)
    }

    /// Prepares the scene of a checker and a metric that were restored from a model file.
    pub fn from_parts(checker: Checker, metric: Metric) -> Self {
        let balls = InnerBalls::new(&checker, None);
        Self { checker, metric: metric.into(), balls }
    }

    /// Prepares another scene, and reuses the data of equal bodies. Answers equal those of
    /// [`Prepared::new`].
    pub fn with_scene(&self, scene: impl Into<Arc<Scene>>) -> Self {
        let checker = self.checker.for_scene(scene.into());
        let scene = checker.scene_arc();
        let metric = match self.metric.is_of(scene) {
            true => Arc::clone(&self.metric),
            false => Metric::new(scene.clone()).into(),
        };
        let balls = InnerBalls::new(&checker, Some((&self.checker, &self.balls)));
        Self { checker, metric, balls }
    }

    /// Returns the prepared scene.
    pub fn scene(&self) -> &Arc<Scene> {
        self.checker.scene_arc()
    }

    /// Returns the exact checker of the scene.
    pub fn checker(&self) -> &Checker {
        &self.checker
    }

    /// Returns the metric of the scene.
    pub fn metric(&self) -> &Arc<Metric> {
        &self.metric
    }

    /// Returns the shared data of a query, with the stored samples of a model. Completes the convex
    /// pieces of meshes first, so that answers do not depend on earlier queries and no query spends
    /// its time on them.
    pub fn with<'a>(&'a self, stored: Option<Stored<'a>>) -> Context<'a> {
        self.checker.prepare_proposals();
        Context::new(&self.checker, &self.metric, &self.balls, stored)
    }

    /// Returns the shared data of a query without a model.
    pub fn context(&self) -> Context<'_> {
        self.with(None)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::cspace::sampling::uniform;
    use crate::cspace::{Config, Label};

    /// Draws uniform colliding configurations with a seed that nothing else uses.
    pub fn colliding(prepared: &Prepared, count: usize) -> Vec<Config> {
        let space = &prepared.scene().space;
        let (mut rng, mut q) = (ChaCha8Rng::seed_from_u64(4711), vec![0.0; space.nq()]);
        let all = std::iter::repeat_with(|| {
            uniform(space, &mut rng, &mut q);
            space.config(&q).unwrap()
        });
        all.filter(|q| prepared.checker().label(q, &mut Default::default()) == Label::Colliding).take(count).collect()
    }
}

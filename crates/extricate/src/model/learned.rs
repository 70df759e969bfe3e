//! The learned model of a scene: what it holds, and how it is asked. Not how it is learned.

use std::fmt;
use std::sync::Arc;

use super::statistics::Statistics;
use crate::collision::Checker;
use crate::learning::obstacle_classifier::ObstacleClassifier;
use crate::metric::Metric;
use crate::query::prepared::Prepared;
use crate::query::{Stored, index_samples};
use crate::samples::SampleSet;
use crate::scene::Scene;

/// All that a query needs: the scene with its geometry, verified boundary samples, their index, the
/// classifier.
///
/// Immutable; share it between threads.
pub struct Model {
    pub(super) prepared: Arc<Prepared>,
    pub(super) boundary: SampleSet,
    pub(super) classifier: Option<ObstacleClassifier>,
    pub(super) statistics: Statistics,
}

impl fmt::Debug for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Model").field("statistics", &self.statistics).finish_non_exhaustive()
    }
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
        let prepared = Prepared::from_parts(checker, metric).into();
        Self { prepared, boundary, classifier, statistics }
    }

    /// The scene it was learned for.
    pub fn scene(&self) -> &Arc<Scene> {
        self.prepared.scene()
    }

    pub(crate) fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
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

    /// What queries start from, in the scene that was learned.
    pub(crate) fn stored(&self) -> Stored<'_> {
        Stored { samples: &self.boundary, holding: None }
    }
}

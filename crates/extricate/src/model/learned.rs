//! The learned model of a scene: its parts and how to read them. Learning it is elsewhere.

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

/// A learned model: the scene with its geometry, verified boundary samples, their index and the
/// classifier.
///
/// It is immutable; threads can share it.
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
    /// Builds a model from its stored parts, and computes the index of its samples.
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

    /// Builds a model from its stored parts, the index of its samples included.
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

    /// The scene that the model was learned for.
    pub fn scene(&self) -> &Arc<Scene> {
        self.prepared.scene()
    }

    pub(crate) fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// The verified boundary samples of the model.
    pub fn boundary(&self) -> &SampleSet {
        &self.boundary
    }

    /// The classifier of the obstacle region, with an SVM for every pair that was seen to collide;
    /// its parts are indices into [`Scene::pairs`]. Pairs of one body with many that never move
    /// share an SVM, under the index of the first. `None` if none was trained, for instance because
    /// only one label was seen.
    pub fn classifier(&self) -> Option<&ObstacleClassifier> {
        self.classifier.as_ref()
    }

    /// The configurations of the support vectors, row major, SVM after SVM; one that two SVMs share
    /// comes twice. They lie on both sides of the boundary.
    pub fn support_configs(&self) -> Vec<f64> {
        self.classifier.iter().flat_map(ObstacleClassifier::svms).flat_map(|svm| &svm.support).copied().collect()
    }

    /// How the model was learned, and how good it measured itself to be.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The samples that queries start from, in the learned scene.
    pub(crate) fn stored(&self) -> Stored<'_> {
        Stored { samples: &self.boundary, holding: None }
    }
}

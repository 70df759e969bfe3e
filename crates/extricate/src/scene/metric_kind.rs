//! Names of the metrics, which module `metric` computes.

use crate::interface::words;
use serde::{Deserialize, Serialize};

/// The metric that measures distances between configurations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum MetricKind {
    /// `sqrt(sum w_j delta_j^2)`; the weights are in [`crate::ConfigSpace`].
    Joint,
    /// Root mean square displacement of the moving volume \[m\].
    ObjectNorm,
    /// Largest displacement of any point of the moving geometry \[m\].
    MaxDisplacement,
}

words! {
    MetricKind as "metric" {
        Joint = "joint",
        ObjectNorm = "object-norm",
        MaxDisplacement = "max-displacement",
    }
}

//! How a model was learned and how good it measured itself to be: figures alone, nothing measures
//! here.

use serde::{Deserialize, Serialize};

use super::evaluate::figures::{Density, Excess, Gap};
use crate::query::StartsPerDof;

/// How a model was learned and how good it measured itself to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Exact checks spent, those of solving and its evaluations of contacts included.
    pub labels: usize,
    /// Seed.
    pub seed: u64,
    /// Verified free boundary samples stored.
    pub boundary_samples: usize,
    /// How many of them, the last, are exits: exits of configurations that were solved while
    /// learning, the nearest and, while exits were few, others.
    #[serde(alias = "exits")]
    pub solved_samples: usize,
    /// How many of them, the first, are any free configurations, which stand in where fewer than
    /// 128 samples were found.
    pub stand_ins: usize,
    /// Support vectors of the classifier, of the svms of all pairs together.
    pub support_vectors: usize,
    /// Share of uniform configurations that collide.
    pub colliding_share: f64,
    /// Held-out accuracy on free configurations; `None` where there was no classifier or none to
    /// hold out.
    pub accuracy_free: Option<f64>,
    /// Its 95 % confidence interval (Wilson).
    pub accuracy_free_interval: Option<[f64; 2]>,
    /// Held-out accuracy on colliding configurations.
    pub accuracy_colliding: Option<f64>,
    /// Its 95 % confidence interval.
    pub accuracy_colliding_interval: Option<[f64; 2]>,
    /// Every boundary sample that is not a stand-in has a colliding configuration within this
    /// distance, in the scene's metric. `None` where all are stand-ins.
    pub boundary_gap: Option<f64>,
    /// How densely the boundary is sampled; `None` where nothing held out collided, or the run was
    /// interrupted.
    pub density: Option<Density>,
    /// How good refined queries are on held-out colliding configurations: 64 of them, fewer where a
    /// check for every four labels does not pay for so many. `None` where none was queried, as with
    /// less than 10,000 labels.
    pub excess: Option<Excess>,
    /// How much of the depth the same queries leave unproved; `None` also of models of versions
    /// that did not measure it.
    #[serde(default)]
    pub gap: Option<Gap>,
    /// Starts of a refined query for each degree of freedom, see [`super::evaluate::calibrate`].
    #[serde(alias = "width", deserialize_with = "super::evaluate::calibrate::read")]
    pub starts_per_dof: StartsPerDof,
    /// Collision and distance evaluations spent on these three, and on telling whether the run may
    /// end: beside `labels`.
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
    /// The quality that was requested.
    Quality,
}

//! What is asked of a release.

use crate::interface::{setters, words};
use crate::query::QueryOptions;

/// Options of [`crate::Solver::release`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReleaseOptions {
    /// What is to stay.
    pub keep: Keep,
    /// A link touches the object where it is nearer than this \[m\] beyond the clearance.
    pub touch: f64,
    /// Coefficient of friction, for [`super::GraspQuality`]; `None` does not measure it.
    pub friction: Option<f64>,
    /// A configuration with open fingers: from there each closes on its side of the object; of
    /// length `nq`. `None` takes 0 for every joint, or the limit nearest to it.
    pub open: Option<Vec<f64>>,
    /// Clearance, locked joints and budget; the rest has no effect.
    pub query: QueryOptions,
}

/// What of a grasp is to stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Keep {
    /// The links that touched.
    #[default]
    Contacts,
    /// The pose alone: the nearest free configuration, whatever it touches.
    Pose,
}

words! { Keep as "keep" { Contacts = "contacts", Pose = "pose" } }

setters! {
    ReleaseOptions {
        keep: Keep,
        touch: f64,
        friction: f64 = Some,
        open: Vec<f64> = Some,
        query: QueryOptions,
    }
}

impl Default for ReleaseOptions {
    /// Contacts are kept; 2 mm are a touch; friction 0.8.
    fn default() -> Self {
        let query = QueryOptions::default();
        Self { keep: Keep::Contacts, touch: 2e-3, friction: Some(0.8), open: None, query }
    }
}

//! Options of a release.

use crate::interface::{setters, words};
use crate::query::QueryOptions;

/// Options of a release, see [`crate::Solver::release`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReleaseOptions {
    /// Part of the grasp that the release keeps.
    pub keep: Keep,
    /// Distance beyond the clearance up to which a link touches the object \[m\].
    pub touch: f64,
    /// Coefficient of friction, for [`super::GraspQuality`]; with `None` quality is not measured.
    pub friction: Option<f64>,
    /// Configuration with open fingers, of length `nq`, from which each finger closes on its side
    /// of the object. With `None` every joint is at 0, or at the limit nearest to 0.
    pub open: Option<Vec<f64>>,
    /// Only its clearance, locked joints and budget have an effect.
    pub query: QueryOptions,
}

/// Part of a grasp that a release keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Keep {
    /// Keeps the contacts of the links that touched.
    #[default]
    Contacts,
    /// Keeps the pose alone: the answer is the nearest free configuration, whatever it touches.
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
    /// Keeps contacts; links touch up to 2 mm, and friction is 0.8.
    fn default() -> Self {
        let query = QueryOptions::default();
        Self { keep: Keep::Contacts, touch: 2e-3, friction: Some(0.8), open: None, query }
    }
}

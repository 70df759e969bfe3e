//! Memory that reports reuse.

use crate::metric::Anchor;
use crate::metric::motion_bound::MotionPath;
use crate::metric::quadratic::Quadratic;

/// Memory that reports reuse.
#[derive(Default)]
pub struct ReportScratch {
    /// Of the free radius.
    pub motion: MotionPath,
    /// Of the witness, for the gradient.
    pub far_anchor: Anchor,
    /// From the witness, for the same.
    pub quadratic: Quadratic,
    /// A configuration beside the query.
    pub moved: Vec<f64>,
    /// The step to it.
    pub step: Vec<f64>,
}

//! The search for the point of a difference nearest to the origin (Gilbert, Johnson and Keerthi).
//!
//! Source: E. G. Gilbert, D. W. Johnson, S. S. Keerthi, *A fast procedure for computing the
//! distance between complex objects in three-dimensional space*, IEEE J. Robotics and Automation
//! 4(2), 1988, doi:10.1109/56.2083; the support-plane bound as in G. van den Bergen, *A fast and
//! robust GJK implementation*, J. Graphics Tools 4(2), 1999, doi:10.1080/10867651.1999.10487502.

mod descent;
mod simplex;

pub(crate) use descent::{EarlyEnd, Outcome, Settled, descend, descend_from};
pub(crate) use simplex::{Simplex, nearest_on_triangle, normal_of_edges};

//! Applications of queries, one folder each.

pub mod grasp;
pub mod motion;
pub mod signed_distance;
pub mod stream;

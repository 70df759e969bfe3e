//! Applications of queries, one folder each.

pub mod grasp;
pub mod motion;
pub mod stream;

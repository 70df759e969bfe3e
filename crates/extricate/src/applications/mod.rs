//! What queries are used for: one folder an application.

pub mod grasp;
pub mod motion;

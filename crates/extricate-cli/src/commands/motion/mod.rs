//! Commands that answer with paths: out of collision, between free configurations, and from one
//! that collides.

pub mod escape;
pub mod plan;
pub mod repair;

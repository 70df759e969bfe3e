//! Commands that answer with paths: out of collision, between free configurations, and in place of
//! a path that collides.

pub mod escape;
pub mod plan;
pub mod repair;

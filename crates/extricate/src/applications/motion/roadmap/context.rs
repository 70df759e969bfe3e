//! What a roadmap grows in.

use crate::query::Context;

/// What a roadmap grows in.
#[derive(Clone, Copy)]
pub struct RoadmapContext<'a> {
    /// What queries stand on.
    pub query: Context<'a>,
    /// Of the smallest moving body \[m\]: what lengths are shares of.
    pub radius: f64,
    /// Of the proofs of edges \[m\].
    pub resolution: f64,
}

impl<'a> RoadmapContext<'a> {
    /// Of a scene.
    pub fn new(query: &Context<'a>, resolution: f64) -> Self {
        Self { query: *query, radius: query.checker.moving_radius(), resolution }
    }
}

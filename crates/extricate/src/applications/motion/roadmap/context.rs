//! The context in which a roadmap grows.

use crate::query::Context;

/// Context of a growing roadmap: that of its queries, and two lengths.
#[derive(Clone, Copy)]
pub struct RoadmapContext<'a> {
    /// Scene, metric and samples of its queries.
    pub query: Context<'a>,
    /// Radius of the smallest moving body \[m\], of which other lengths are shares.
    pub radius: f64,
    /// Resolution of the proofs of edges \[m\].
    pub resolution: f64,
}

impl<'a> RoadmapContext<'a> {
    /// Makes the context for queries in `query`.
    pub fn new(query: &Context<'a>, resolution: f64) -> Self {
        Self { query: *query, radius: query.checker.moving_radius(), resolution }
    }
}

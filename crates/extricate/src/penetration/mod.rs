//! The query: from a colliding configuration to the nearest free one, verified and bounded.

use serde::Serialize;

/// How hard a query tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// The nearest stored boundary sample; free as of learning.
    Nearest,
    /// Diverse candidates, pulled in, slid along the contact surface, verified.
    #[default]
    Refined,
    /// Many starts and long refinement.
    Exhaustive,
}

/// Options of a query.
#[derive(Debug, Clone, Default)]
pub struct QueryOptions {
    /// How hard to try.
    pub effort: Effort,
}

/// The nearest free configuration found, and what is known about it.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// Distance from the query to the witness, in the scene's metric; 0 where the query is free.
    pub depth: f64,
    /// Proved: no free configuration is nearer than this.
    pub lower_bound: f64,
    /// A free configuration at distance `depth`.
    pub witness: Vec<f64>,
    /// What was asked for.
    pub effort: Effort,
    /// Collision checks and distance evaluations spent.
    pub checks: usize,
    /// Largest displacement [m] of any point of the moving geometry between the query and the witness.
    pub max_displacement: f64,
    /// Indices of the scene's pairs that collide at the query.
    pub colliding: Vec<usize>,
    /// Indices of the scene's pairs that touch (within a tenth of a millimetre beyond the clearance) at the witness.
    pub touching: Vec<usize>,
    /// Whether the exact checker called the witness free during this query; otherwise it did when the model was learned.
    pub verified: bool,
}

/// Memory that queries reuse; one per thread.
#[derive(Default)]
pub struct QueryScratch {}

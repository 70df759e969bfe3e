//! A run in units of work: learning and adapting differ only in what their units do.

pub mod checks;
mod context;
pub mod ending;
mod memory;
pub mod state;
mod step;
pub mod work;

use std::sync::Arc;

use super::evaluate::Evaluation;
use super::statistics::EndedBy;
use crate::learning::budget::Spent;
use crate::samples::SampleSet;
use crate::samples::trace::Tracer;
pub use context::{RunContext, labels};
pub use memory::bytes;
use work::Work;

/// A run between two units of work.
pub struct Run<W> {
    pub ground: RunContext,
    /// What is its own, and what it has found.
    pub work: W,
    /// All threads that it may use.
    pub pool: Arc<rayon::ThreadPool>,
    /// Made when needed: it holds indices over what was found.
    pub tracer: Option<Tracer>,
    /// The samples that solving starts from, made when needed.
    pub solver: Option<SampleSet>,
    /// What was spent, the unit that was stopped included.
    pub spent: Spent,
    /// Why it has ended, if it has.
    pub end: Option<EndedBy>,
    /// After the last unit.
    pub ready: Option<Ready>,
}

/// What the last unit makes of the run.
pub struct Ready {
    /// With what stands in for missing samples.
    pub boundary: SampleSet,
    /// `None` where the caller stopped it.
    pub measured: Option<Evaluation>,
}

impl<W: Work> Run<W> {
    /// A run that has spent as much on what `work` holds.
    pub fn new(pool: rayon::ThreadPool, ground: RunContext, work: W, spent: Spent) -> Self {
        let (tracer, solver, end, ready) = (None, None, None, None);
        Self { ground, work, pool: pool.into(), tracer, solver, spent, end, ready }
    }
}

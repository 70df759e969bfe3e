//! What handles hold. To the header they are opaque.

use std::sync::Arc;

use extricate::{CheckScratch, QueryScratch, Stream};

use crate::abi::types::{ExtricateContact, ExtricateExit, ExtricatePair, ExtricateSummary};
use crate::asked::Asked;
use crate::options::Wanted;

/// A scene, or a model in its scene or in another one. Immutable; may be shared between threads.
pub struct ExtricateScene(pub(crate) Arc<Asked>);

/// Options of queries of one scene, and memory. One for each thread.
pub struct ExtricateSolver {
    pub(crate) asked: Arc<Asked>,
    pub(crate) wanted: Wanted,
    pub(crate) scratch: QueryScratch,
    pub(crate) check_scratch: CheckScratch,
}

/// Queries that follow each other closely. One for each thread.
pub struct ExtricateStream {
    pub(crate) asked: Arc<Asked>,
    pub(crate) wanted: Wanted,
    pub(crate) hysteresis: f64,
    pub(crate) starts_per_frame: usize,
    /// None after a fault of this library, which may have left it half written.
    pub(crate) stream: Option<Stream>,
}

/// An answer. Immutable; may be shared between threads.
pub struct ExtricateAnswer {
    pub(crate) summary: ExtricateSummary,
    pub(crate) witness: Vec<f64>,
    pub(crate) gradient: Vec<f64>,
    pub(crate) colliding: Vec<ExtricatePair>,
    pub(crate) touching: Vec<ExtricatePair>,
    pub(crate) outside: Vec<usize>,
    pub(crate) contacts: Vec<ExtricateContact>,
    pub(crate) exits: Vec<ExtricateExit>,
    /// What the exits point to.
    pub(crate) _exit_witnesses: Vec<Vec<f64>>,
}

//! The query: from a colliding configuration to the nearest free one, verified and bounded.
//!
//! Read in this order: `nearest_exit` (the steps); in `search`, `grouped`, `run`, `sources`,
//! `directions` and `polish`; `groups`, `exits`, [`descent`], [`bound`], `report`.
//!
//! 1. *Check* which pairs collide at `q`; if none does, the depth is 0.
//! 2. *Group* the joints that these pairs connect (`groups`). Each group is searched alone, while
//!    all other joints keep their values of the query.
//! 3. *Search* a group: starts come from one source after another (`sources`), namely directions in
//!    which colliding bodies part, stored samples of a model, and random starts around the query.
//!    Each start is *pruned* if it cannot beat the nearest exit so far; otherwise it *descends*
//!    toward `q` along the contacts. The search ends once the depth is proved up to the gap, or if
//!    no further exit is expected. If nothing is found, any free configuration is taken.
//! 4. *Combine* the exits of the groups. Groups that then collide with each other become one group,
//!    and are searched again.
//! 5. *Polish* the nearest exit with exact contacts, and verify it.
//! 6. *Prove*: with effort `proved`, branch and bound until the gap is closed.
//! 7. *Report* the properties of the witness.

pub mod answer;
mod beyond_limits;
pub mod bound;
pub(crate) mod constraints;
mod contact_planes;
pub mod context;
pub mod descent;
pub(crate) mod evaluate;
pub(crate) mod exits;
mod groups;
pub mod inner_balls;
pub mod keep;
pub(crate) mod local_metric;
pub(crate) mod nearest_exit;
pub mod options;
pub(crate) mod plan;
pub mod prepared;
pub mod qp;
mod read_record;
mod record;
pub mod report;
pub(crate) mod search;
pub(crate) mod termination;

pub use answer::{Answer, Exit, StraightSegment, Unproved};
pub use contact_planes::index_samples;
pub use context::{Context, Stored, TouchingPairs};
pub use keep::{KeptError, KeptLink};
pub(crate) use nearest_exit::nearest_exit_under;
pub use nearest_exit::{nearest_exit, query};
pub use options::{DEFAULT_GAP, Effort, QueryOptions, REFINED_GAP, Toward};
pub(crate) use qp::{Qp, QpOutcome};
pub use record::{AnswerRecord, ContactRecord, ExitRecord};
pub use search::scratch::QueryScratch;
pub(crate) use termination::Deadline;
pub use termination::{Stop, Termination};

//! The query: from a colliding configuration to the nearest free one, verified and bounded.
//!
//! Read in this order: `nearest_exit` (the steps); in `search`, `grouped`, `run`, `sources`,
//! `directions` and `polish`; `groups`, `exits`, [`descent`], [`bound`], `report`.
//!
//! 1. *Check*: the pairs that collide at `q`; none: depth 0.
//! 2. *Group* the joints that these pairs connect (`groups`). Each group is searched on its own,
//!    while all other joints stay where the query has them.
//! 3. *Search* a group: starts from one source after another (`sources`): directions in which
//!    colliding bodies part, stored samples of a model, and around the query. Each start is
//!    *pruned* if it cannot beat the nearest exit so far, else *descends* toward `q` along the
//!    contacts. It ends once the exit is proved up to the gap, or when no further exit is to be
//!    expected. If nothing is found, anything free is taken.
//! 4. *Combine* the exits of the groups. Groups that then collide are one group, and searched
//!    again.
//! 5. *Polish* the nearest exit with exact contacts, and verify it.
//! 6. *Prove*: with effort `proved`, branch and bound until the gap is closed.
//! 7. *Report* what is said of the witness.

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
mod local_metric;
mod nearest_exit;
pub mod options;
pub(crate) mod plan;
pub mod prepared;
pub mod qp;
mod read_record;
mod record;
pub mod report;
pub(crate) mod search;
pub mod stream;
pub(crate) mod termination;

pub use answer::{Answer, Exit, StraightSegment, Unproved};
pub use contact_planes::index_samples;
pub use context::{Context, Held, Stored};
pub(crate) use nearest_exit::nearest_exit_under;
pub use nearest_exit::{nearest_exit, query};
pub use options::{DEFAULT_GAP, Effort, QueryOptions, REFINED_GAP, Toward};
pub use record::{AnswerRecord, ContactRecord, ExitRecord};
pub use search::scratch::QueryScratch;
pub(crate) use termination::Deadline;
pub use termination::{Stop, Termination};

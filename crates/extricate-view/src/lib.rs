//! Answers as a page: one HTML file that needs no network and no server, to inspect a scene,
//! configurations in collision and the results of queries.
//!
//! `scene_data`, `cloud`, `layers`, `answer_data`, `played` and `slice` define the data of the
//! page, and `html` writes the file; `page/` beside this folder runs in the browser. Nothing here
//! searches: answers come from the caller, and the exact checker computes what is added to them
//! (pairs that collide along an exit, distances, the slice).

mod answer_data;
mod cloud;
mod html;
mod layers;
mod live;
mod played;
mod scene_data;
mod slice;
mod triangles;
mod unit;

pub use answer_data::{AnswerData, Detail, Inspector};
pub use html::{Page, document, escaped, is_page};
pub use live::Live;
pub use played::{GraspData, Quality, Touch};
pub use unit::{MIXED_UNIT, metric_unit};

//! Answers as a page: one HTML file that needs no network and no server, to look at a scene, at
//! configurations in collision and at what a query found.
//!
//! Read `scene_data`, `answer_data`, `played` and `slice` for what the page is given, then `html`
//! for how it becomes a file; `page/` beside this folder is what runs in the browser. Nothing here
//! searches: answers come from the caller, and what is added to them (which pairs collide along an
//! exit, the slice) is asked of the exact checker.

mod answer_data;
mod html;
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
pub use scene_data::{SceneData, scene_data};
pub use unit::{MIXED_UNIT, metric_unit};

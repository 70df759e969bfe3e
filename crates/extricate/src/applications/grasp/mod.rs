//! Grasps: finds the nearest configuration of a hand at which no finger penetrates the object and
//! the hand still holds it, and measures how well.
//!
//! Read `hand` (which bodies and joints are fingers), `options` and `release` (the steps) first.
//! The steps use `opening` (on which side of the object a finger is) and `grip` (which links
//! touch). Then come `report`, `quality` and `wrench_hull` (how well the object is held), `weights`
//! (of a floating base) and `batch` (many grasps of many objects).

mod batch;
mod grip;
mod hand;
mod opening;
mod options;
mod quality;
mod release;
mod report;
mod weights;
mod wrench_hull;

pub use batch::Released;
pub use grip::GraspContact;
pub use hand::Hand;
pub use options::{Keep, ReleaseOptions};
pub use quality::GraspQuality;
pub use report::Grasp;

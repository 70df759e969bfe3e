//! What distances are measured in.

use extricate::{MetricKind, Scene};

/// What distances are measured in that add lengths to angles.
pub const MIXED_UNIT: &str = "rad, m";

/// What distances of the scene's metric are measured in (the joint metric adds what its joints are
/// measured in).
pub fn metric_unit(scene: &Scene) -> &'static str {
    if scene.metric() != MetricKind::Joint {
        return "m";
    }
    let turns = scene.joints().iter().any(|j| j.kind != "prismatic");
    let slides = scene.joints().iter().any(|j| matches!(j.kind.as_str(), "prismatic" | "planar" | "floating"));
    match (turns, slides) {
        (true, true) => MIXED_UNIT,
        (false, true) => "m",
        _ => "rad",
    }
}

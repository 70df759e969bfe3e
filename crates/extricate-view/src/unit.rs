//! The unit of the distances of a metric.

use extricate::{MetricKind, Scene};

/// Unit of distances that add lengths to angles.
pub const MIXED_UNIT: &str = "rad, m";

/// Returns the unit of the distances of the scene's metric; the joint metric adds coordinates in
/// the units of its joints.
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

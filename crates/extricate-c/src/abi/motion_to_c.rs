//! Converts motions of the library to the structures of the header; reads no pointers of callers.

use extricate::{Escape, Plan, Repaired, Scene};

use super::answer_to_c::pair;
use super::handles::{ExtricateEscape, ExtricatePlan, ExtricateRepaired};
use super::motion_types::{
    EXTRICATE_ESCAPE_NONE, EXTRICATE_PLAN_NONE, ExtricateEscapeSummary, ExtricatePairDistance, ExtricatePlanSummary,
    ExtricateRepairedSummary,
};
use crate::enum_constants::{ESCAPE_METHODS, PLAN_METHODS, number};

pub fn escape(scene: &Scene, escape: Escape) -> ExtricateEscape {
    let summary = ExtricateEscapeSummary {
        found: escape.is_found(),
        method: escape.method.map_or(EXTRICATE_ESCAPE_NONE, |method| number(ESCAPE_METHODS, method)),
        free_from: escape.free_from,
        deepening: escape.deepening,
        needed_tolerance: escape.needed_tolerance.unwrap_or(f64::NAN),
        length: escape.length,
        max_displacement: escape.max_displacement,
        checks: escape.checks as u64,
    };
    let distances = escape.colliding.iter();
    let colliding =
        distances.map(|(id, distance)| ExtricatePairDistance { pair: pair(scene, *id), distance: *distance });
    ExtricateEscape {
        summary,
        colliding: colliding.collect(),
        count: escape.points.len(),
        points: escape.points.concat(),
    }
}

pub fn plan(scene: &Scene, plan: Plan) -> ExtricatePlan {
    let summary = ExtricatePlanSummary {
        found: plan.is_found(),
        method: plan.method.map_or(EXTRICATE_PLAN_NONE, |method| number(PLAN_METHODS, method)),
        free_from: plan.free_from,
        free_to: plan.free_to,
        length: plan.length,
        checks: plan.checks as u64,
        nodes: plan.nodes,
    };
    let escapes = [plan.start_escape, plan.goal_escape].map(|found| found.map(|found| escape(scene, found)));
    ExtricatePlan { summary, escapes, count: plan.points.len(), points: plan.points.concat() }
}

pub fn repaired(repaired: Repaired) -> ExtricateRepaired {
    let summary = ExtricateRepairedSummary {
        found: repaired.is_found(),
        deviation: repaired.deviation,
        length: repaired.length,
        length_before: repaired.length_before,
        stretches: repaired.stretches,
        gaps: repaired.gaps,
        touched: repaired.touched,
        kept: repaired.kept,
        checks: repaired.checks as u64,
    };
    ExtricateRepaired { summary, points: repaired.points.concat(), places: repaired.places }
}

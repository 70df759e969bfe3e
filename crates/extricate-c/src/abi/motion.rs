//! Functions of motions: escapes, plans and repairs, each edge of which is proved.

#![allow(unsafe_code)]

use extricate::Rows;

use super::handles::{ExtricateEscape, ExtricatePlan, ExtricateRepaired, ExtricateRoadmap, ExtricateSolver};
use super::motion_to_c;
use super::motion_types::{
    ExtricateEscapeOptions, ExtricateEscapeSummary, ExtricatePairDistance, ExtricatePlanOptions, ExtricatePlanSummary,
    ExtricateRepairOptions, ExtricateRepairedSummary,
};
use super::types::ExtricateStatus;
use crate::motion_options;
use crate::options::of_call;
use crate::raw;
use crate::status::{Fault, Result, guarded};

/// Fills in the default options of escapes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_escape_options_init(options: *mut ExtricateEscapeOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        options?.put(motion_options::of_escapes());
        Ok(())
    })
}

/// Finds a path out of collision, from `q` to a free configuration; null options mean the defaults.
/// `q` must be within the limits. If no path is found, `escape` has no points and says why.
///
/// On the way no pair collides that does not at `q`, and none that does gets deeper by more than
/// the tolerance. All of this is proved for every configuration of the path. The query options of
/// the solver do not apply.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_escape(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    options: *const ExtricateEscapeOptions,
    escape: *mut *mut ExtricateEscape,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let escape = unsafe { raw::place(escape, "escape") };
    guarded(|| {
        let (solver, escape) = (&solver?.solver, escape?);
        // SAFETY: the same.
        let options = unsafe { motion_options::escape(options, solver.scene()) }?;
        let found = solver.escape(&solver.scene().config(q?)?, &options).map_err(of_call)?;
        escape.hand_over(motion_to_c::escape(solver.scene(), found));
        Ok(())
    })
}

/// Returns the numbers of an escape; null if `escape` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_escape_summary(escape: *const ExtricateEscape) -> *const ExtricateEscapeSummary {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(escape, "escape") }.map_or(std::ptr::null(), |escape| &raw const escape.summary)
}

/// Returns the number of points of the path, the query first, and points `points` to the first
/// number of the first one. Each has as many numbers as the query, and follows the one before; 0 if
/// no path was found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_escape_points(escape: *const ExtricateEscape, points: *mut *const f64) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(escape, points, |escape| &escape.points) };
    // SAFETY: the same.
    unsafe { raw::shared(escape, "escape") }.map_or(0, |escape| escape.count)
}

/// Returns the number of pairs that collide at the query, and points `pairs` to them and their
/// signed distances there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_escape_colliding(
    escape: *const ExtricateEscape,
    pairs: *mut *const ExtricatePairDistance,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(escape, pairs, |escape| &escape.colliding) }
}

/// Frees an escape. Those of a plan belong to the plan.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_escape_free(escape: *mut ExtricateEscape) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(escape) };
        Ok(())
    });
}

/// Fills in the default options of plans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan_options_init(options: *mut ExtricatePlanOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        options?.put(motion_options::of_plans());
        Ok(())
    })
}

/// Finds a path from `start` to `goal`, with every edge proved; null options mean the defaults.
/// Both must be within the limits. An end that collides is led out of collision first, as
/// extricate_escape() does, toward the other end. If no path is found, `plan` has no points.
///
/// `roadmap` is null, or a roadmap of earlier calls, which the plan extends, so that plans of one
/// scene that share it become cheaper. No other thread may use the roadmap during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan(
    solver: *const ExtricateSolver,
    start: *const f64,
    goal: *const f64,
    nq: usize,
    options: *const ExtricatePlanOptions,
    roadmap: *mut ExtricateRoadmap,
    plan: *mut *mut ExtricatePlan,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, start) = unsafe { (raw::shared(solver, "solver"), raw::slice(start, nq, "start")) };
    // SAFETY: the same.
    let (goal, plan) = unsafe { (raw::slice(goal, nq, "goal"), raw::place(plan, "plan")) };
    // SAFETY: the same.
    let roadmap = if roadmap.is_null() { Ok(None) } else { unsafe { raw::exclusive(roadmap, "roadmap") }.map(Some) };
    guarded(|| {
        let (solver, plan) = (&solver?.solver, plan?);
        // SAFETY: the same.
        let options = unsafe { motion_options::plan(options, solver.scene()) }?;
        let end = |name: &str, values: &[f64]| -> Result<_> {
            solver.scene().config(values).map_err(|error| Fault::from(error).of(name))
        };
        let (start, goal) = (end("start", start?)?, end("goal", goal?)?);
        let found = match roadmap? {
            Some(roadmap) => solver.plan_with(&start, &goal, &options, &mut roadmap.roadmap),
            None => solver.plan(&start, &goal, &options),
        };
        let found = found.map_err(of_call)?;
        plan.hand_over(motion_to_c::plan(solver.scene(), found));
        Ok(())
    })
}

/// Returns the numbers of a plan; null if `plan` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan_summary(plan: *const ExtricatePlan) -> *const ExtricatePlanSummary {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(plan, "plan") }.map_or(std::ptr::null(), |plan| &raw const plan.summary)
}

/// Returns the number of points of the path from start to goal, and points `points` to the first
/// number of the first one. Each has as many numbers as the start, and follows the one before; 0 if
/// no path was found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan_points(plan: *const ExtricatePlan, points: *mut *const f64) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(plan, points, |plan| &plan.points) };
    // SAFETY: the same.
    unsafe { raw::shared(plan, "plan") }.map_or(0, |plan| plan.count)
}

/// Returns the path from a colliding start to the free part, which lives as long as the plan; null
/// if the start is free. If it has no points, it says why there is no plan.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan_start_escape(plan: *const ExtricatePlan) -> *const ExtricateEscape {
    // SAFETY: the contract of this module.
    let plan = unsafe { raw::shared(plan, "plan") };
    plan.ok().and_then(|plan| plan.escapes[0].as_ref()).map_or(std::ptr::null(), |escape| &raw const *escape)
}

/// Returns the same from a colliding goal, which the plan takes in reverse.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan_goal_escape(plan: *const ExtricatePlan) -> *const ExtricateEscape {
    // SAFETY: the contract of this module.
    let plan = unsafe { raw::shared(plan, "plan") };
    plan.ok().and_then(|plan| plan.escapes[1].as_ref()).map_or(std::ptr::null(), |escape| &raw const *escape)
}

/// Frees a plan, with its escapes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_plan_free(plan: *mut ExtricatePlan) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(plan) };
        Ok(())
    });
}

/// Fills in the default options of repairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_repair_options_init(options: *mut ExtricateRepairOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        options?.put(motion_options::of_repairs());
        Ok(())
    })
}

/// Finds a path that is proved free, as near to the given one as it can. `path` has `count`
/// configurations within the limits, which follow one another, `nq` numbers each. Null options mean
/// the defaults. A colliding end is moved too. If no path is found, `repaired` has no points.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_repair(
    solver: *const ExtricateSolver,
    path: *const f64,
    count: usize,
    nq: usize,
    options: *const ExtricateRepairOptions,
    repaired: *mut *mut ExtricateRepaired,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, path) = unsafe { (raw::shared(solver, "solver"), raw::slice(path, count.saturating_mul(nq), "path")) };
    // SAFETY: the same.
    let repaired = unsafe { raw::place(repaired, "repaired") };
    guarded(|| {
        let (solver, path, repaired) = (&solver?.solver, path?, repaired?);
        // SAFETY: the same.
        let options = unsafe { motion_options::repair(options, solver.scene()) }?;
        let own = solver.scene().space().nq();
        if nq != own && count > 0 {
            return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
        }
        let found = solver.repair(Rows::new(path, own)?, &options).map_err(of_call)?;
        repaired.hand_over(motion_to_c::repaired(found));
        Ok(())
    })
}

/// Returns the numbers of a repaired path; null if `repaired` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_repaired_summary(
    repaired: *const ExtricateRepaired,
) -> *const ExtricateRepairedSummary {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(repaired, "repaired") }.map_or(std::ptr::null(), |repaired| &raw const repaired.summary)
}

/// Returns the number of points of a repaired path, and points `points` to the first number of the
/// first one. Each has `nq` numbers, and follows the one before; 0 if no path was found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_repaired_points(
    repaired: *const ExtricateRepaired,
    points: *mut *const f64,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(repaired, points, |repaired| &repaired.points) };
    // SAFETY: the same.
    unsafe { raw::shared(repaired, "repaired") }.map_or(0, |repaired| repaired.places.len())
}

/// Returns the number of points of a repaired path, and points `places` to the place of each on the
/// old path: 2.25 is a quarter of the edge from row 2 to row 3. Places ascend, and are whole
/// numbers for rows that stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_repaired_places(
    repaired: *const ExtricateRepaired,
    places: *mut *const f64,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(repaired, places, |repaired| &repaired.places) }
}

/// Frees a repaired path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_repaired_free(repaired: *mut ExtricateRepaired) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(repaired) };
        Ok(())
    });
}

//! Reads the options of motions from the structures that C callers fill in.

#![allow(unsafe_code)]

use std::ffi::c_char;

use extricate::{EscapeOptions, KeptLink, PlanOptions, QueryOptions, ReleaseOptions, RepairOptions, Scene};

use crate::abi::grasp_types::ExtricateReleaseOptions;
use crate::abi::motion_types::{ExtricateEscapeOptions, ExtricatePlanOptions, ExtricateRepairOptions};
use crate::enum_constants::{KEEPS, choice, number};
use crate::options::{Limits, fault, of_call, threads};
use crate::raw;
use crate::status::{Fault, Result};

/// Returns what `extricate_escape_options_init()` writes.
pub fn of_escapes() -> ExtricateEscapeOptions {
    let own = EscapeOptions::default();
    let limits = Limits::of(&own.termination);
    ExtricateEscapeOptions {
        aim: own.aim.unwrap_or(f64::NAN),
        tolerance: own.tolerance,
        keep: std::ptr::null(),
        toward: std::ptr::null(),
        toward_count: 0,
        exits: own.exits,
        resolution: own.resolution,
        tree_checks: own.tree_checks,
        seed: own.seed,
        max_checks: limits.max_checks,
        max_seconds: limits.max_seconds,
        stop: None,
        stop_data: std::ptr::null_mut(),
    }
}

/// Reads the options of an escape; null stands for the defaults.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// If a limit or the goal makes no sense; the library checks the rest.
pub unsafe fn escape(at: *const ExtricateEscapeOptions, scene: &Scene) -> Result<EscapeOptions> {
    if at.is_null() {
        return Ok(EscapeOptions::default());
    }
    // SAFETY: the contract of this function.
    let given = unsafe { raw::shared(at, "options") }?;
    // SAFETY: the same.
    let goal = unsafe { raw::slice(given.toward, given.toward_count, "options.toward") }?;
    let limits = Limits { max_checks: given.max_checks, max_seconds: given.max_seconds };
    // SAFETY: the header states the contract for `stop`.
    let termination = unsafe { limits.termination(given.stop, given.stop_data) }?;
    let mut options = EscapeOptions::default()
        .tolerance(given.tolerance)
        .exits(given.exits)
        .resolution(given.resolution)
        .tree_checks(given.tree_checks)
        .seed(given.seed)
        .termination(termination);
    options.aim = (!given.aim.is_nan()).then_some(given.aim);
    // SAFETY: the contract of this function.
    options.keep = unsafe { kept_links(given.keep, scene) }?;
    if !goal.is_empty() {
        options.toward = Some(scene.config(goal).map_err(|error| Fault::from(error).of("options.toward"))?);
    }
    Ok(options)
}

/// Reads the links that a motion keeps; null stands for none.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// If the text makes no sense, or names a link that `scene` does not have.
pub unsafe fn kept_links(text: *const c_char, scene: &Scene) -> Result<Vec<KeptLink>> {
    // SAFETY: the contract of this function.
    let text = unsafe { raw::optional_text(text, "options.keep") }?;
    text.map_or_else(|| Ok(Vec::new()), |text| KeptLink::from_text(scene, text).map_err(of_call))
}

/// Returns what `extricate_plan_options_init()` writes.
pub fn of_plans() -> ExtricatePlanOptions {
    let own = PlanOptions::default();
    let limits = Limits::of(&own.termination);
    ExtricatePlanOptions {
        resolution: own.resolution,
        tolerance: own.tolerance,
        keep: std::ptr::null(),
        clearance: own.clearance.unwrap_or(f64::NAN),
        shortcut: own.shortcut.into(),
        seed: own.seed,
        threads: own.threads,
        max_checks: limits.max_checks,
        max_seconds: limits.max_seconds,
        stop: None,
        stop_data: std::ptr::null_mut(),
    }
}

/// Reads the options of a plan; null stands for the defaults.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// If a limit or the number of threads makes no sense; the library checks the rest.
pub unsafe fn plan(at: *const ExtricatePlanOptions, scene: &Scene) -> Result<PlanOptions> {
    if at.is_null() {
        return Ok(PlanOptions::default());
    }
    // SAFETY: the contract of this function.
    let given = unsafe { raw::shared(at, "options") }?;
    let limits = Limits { max_checks: given.max_checks, max_seconds: given.max_seconds };
    // SAFETY: the header states the contract for `stop`.
    let termination = unsafe { limits.termination(given.stop, given.stop_data) }?;
    let mut options = PlanOptions::default()
        .resolution(given.resolution)
        .tolerance(given.tolerance)
        .shortcut(given.shortcut != 0)
        .seed(given.seed)
        .threads(
            threads(given.threads).map_err(|fault| Fault { message: format!("options.{}", fault.message), ..fault })?,
        )
        .termination(termination);
    options.clearance = (!given.clearance.is_nan()).then_some(given.clearance);
    // SAFETY: the contract of this function.
    options.keep = unsafe { kept_links(given.keep, scene) }?;
    Ok(options)
}

/// Returns what `extricate_repair_options_init()` writes.
pub fn of_repairs() -> ExtricateRepairOptions {
    let own = RepairOptions::default();
    let limits = Limits::of(&own.termination);
    ExtricateRepairOptions {
        aim: own.aim.unwrap_or(f64::NAN),
        max_deviation: own.max_deviation.unwrap_or(f64::INFINITY),
        keep: std::ptr::null(),
        frames: own.frames.into(),
        max_step: own.max_step.unwrap_or(f64::INFINITY),
        touch: own.touch.unwrap_or(f64::NAN),
        resolution: own.resolution,
        seed: own.seed,
        max_checks: limits.max_checks,
        max_seconds: limits.max_seconds,
        stop: None,
        stop_data: std::ptr::null_mut(),
    }
}

/// Reads the options of a repair; null stands for the defaults.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// If a limit makes no sense; the library checks the rest.
pub unsafe fn repair(at: *const ExtricateRepairOptions, scene: &Scene) -> Result<RepairOptions> {
    if at.is_null() {
        return Ok(RepairOptions::default());
    }
    // SAFETY: the contract of this function.
    let given = unsafe { raw::shared(at, "options") }?;
    let limits = Limits { max_checks: given.max_checks, max_seconds: given.max_seconds };
    // SAFETY: the header states the contract for `stop`.
    let termination = unsafe { limits.termination(given.stop, given.stop_data) }?;
    let mut options = RepairOptions::default()
        .frames(given.frames != 0)
        .resolution(given.resolution)
        .seed(given.seed)
        .termination(termination);
    options.aim = (!given.aim.is_nan()).then_some(given.aim);
    options.max_deviation = (given.max_deviation != f64::INFINITY).then_some(given.max_deviation);
    options.max_step = (given.max_step != f64::INFINITY).then_some(given.max_step);
    options.touch = (!given.touch.is_nan()).then_some(given.touch);
    // SAFETY: the contract of this function.
    options.keep = unsafe { kept_links(given.keep, scene) }?;
    Ok(options)
}

/// Returns what `extricate_release_options_init()` writes.
pub fn of_releases() -> ExtricateReleaseOptions {
    let own = ReleaseOptions::default();
    ExtricateReleaseOptions {
        keep: number(KEEPS, own.keep),
        touch: own.touch,
        friction: own.friction.unwrap_or(0.0),
        open: std::ptr::null(),
        open_count: 0,
        clearance: f64::NAN,
        locked: std::ptr::null(),
        locked_count: 0,
        max_checks: usize::MAX,
        max_seconds: f64::INFINITY,
        stop: None,
        stop_data: std::ptr::null_mut(),
    }
}

/// Reads the options of a release; null stands for the defaults.
///
/// # Safety
/// The contract of [`crate::raw`].
///
/// # Errors
/// If a member makes no sense.
pub unsafe fn release(at: *const ExtricateReleaseOptions, scene: &Scene) -> Result<ReleaseOptions> {
    if at.is_null() {
        return Ok(ReleaseOptions::default());
    }
    // SAFETY: the contract of this function.
    let given = unsafe { raw::shared(at, "options") }?;
    // SAFETY: the same.
    let locked = unsafe { raw::texts(given.locked, given.locked_count, "options.locked") }?;
    // SAFETY: the same.
    let open = unsafe { raw::slice(given.open, given.open_count, "options.open") }?;
    let limits = Limits { max_checks: given.max_checks, max_seconds: given.max_seconds };
    // SAFETY: the header states the contract for `stop`.
    let termination = unsafe { limits.termination(given.stop, given.stop_data) }?;
    let Some(keep) = choice(KEEPS, given.keep) else {
        return Err(fault("keep", given.keep, "EXTRICATE_KEEP_CONTACTS or _POSE"));
    };
    for (name, value) in [("touch", given.touch), ("friction", given.friction)] {
        if !(0.0..=1e9).contains(&value) {
            return Err(fault(name, value, "0 to 1e9"));
        }
    }
    let mut query = QueryOptions::default().locked(scene.joints_named("locked", locked)?).termination(termination);
    query.clearance = (!given.clearance.is_nan()).then_some(given.clearance);
    query.check().map_err(of_call)?;
    let mut options = ReleaseOptions::default().keep(keep).touch(given.touch).query(query);
    options.friction = (given.friction > 0.0).then_some(given.friction);
    if !open.is_empty() {
        let open = scene.space().config_anywhere(open).map_err(|error| Fault::from(error).of("options.open"))?;
        options.open = Some(open.to_vec());
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use extricate::builtin;

    use super::*;

    #[test]
    fn defaults_are_those_of_the_library() {
        let scene = builtin::scene("planar-arm").unwrap();
        let (escapes, plans, repairs) = (of_escapes(), of_plans(), of_repairs());
        // SAFETY: null may be read, and the structures live.
        unsafe {
            assert_eq!(escape(&escapes, &scene).unwrap(), EscapeOptions::default());
            assert_eq!(escape(std::ptr::null(), &scene).unwrap(), EscapeOptions::default());
            assert_eq!(plan(&plans, &scene).unwrap(), PlanOptions::default());
            assert_eq!(plan(std::ptr::null(), &scene).unwrap(), PlanOptions::default());
            assert_eq!(repair(&repairs, &scene).unwrap(), RepairOptions::default());
            assert_eq!(repair(std::ptr::null(), &scene).unwrap(), RepairOptions::default());
            assert_eq!(release(&of_releases(), &scene).unwrap(), ReleaseOptions::default());
            assert_eq!(release(std::ptr::null(), &scene).unwrap(), ReleaseOptions::default());
        }
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        let scene = builtin::scene("planar-arm").unwrap();
        let goal = [f64::NAN, 0.0, 0.0];
        let escapes = ExtricateEscapeOptions { toward: goal.as_ptr(), toward_count: 3, ..of_escapes() };
        let plans = ExtricatePlanOptions { threads: 5_000, ..of_plans() };
        let repairs = ExtricateRepairOptions { max_seconds: -1.0, ..of_repairs() };
        let held = ExtricatePlanOptions { keep: c"elbow".as_ptr(), ..of_plans() };
        // SAFETY: the structures and the goal live.
        let messages = unsafe {
            [
                escape(&escapes, &scene).unwrap_err().message,
                plan(&plans, &scene).unwrap_err().message,
                repair(&repairs, &scene).unwrap_err().message,
                plan(&held, &scene).unwrap_err().message,
            ]
        };
        assert!(messages[0].starts_with("options.toward: configuration: `joint_1`"), "{messages:?}");
        assert!(messages[1].starts_with("options.threads: got 5000"), "{messages:?}");
        assert!(messages[2].starts_with("options.max_seconds: got -1"), "{messages:?}");
        assert!(messages[3].contains("keep: got `elbow`"), "{messages:?}");
    }
}

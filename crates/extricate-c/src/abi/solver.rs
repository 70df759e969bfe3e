//! Functions of solvers: single queries, with options that stay between calls.

#![allow(unsafe_code)]

use std::time::Duration;

use super::answer_to_c;
use super::handles::{ExtricateAnswer, ExtricateScene, ExtricateSolver};
use super::types::{EXTRICATE_NOTHING_FREE, ExtricateOptions, ExtricateStatus};
use crate::options::{Wanted, defaults};
use crate::raw;
use crate::status::{Fault, guarded};

/// Fills in the default options.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_options_init(options: *mut ExtricateOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        options?.put(defaults());
        Ok(())
    })
}

/// Makes a solver, which answers queries of the scene with these options. The solver keeps the
/// scene and shares its prepared data. The call copies the options; null means the defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_new(
    scene: *const ExtricateScene,
    options: *const ExtricateOptions,
    solver: *mut *mut ExtricateSolver,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, solver) = unsafe { (raw::shared(scene, "scene"), raw::place(solver, "solver")) };
    guarded(|| {
        let (scene, solver) = (scene?, solver?);
        // SAFETY: the same.
        let wanted = unsafe { Wanted::read(options, scene.scene()) }?;
        solver.hand_over(wanted.of(&scene.solver)?);
        Ok(())
    })
}

/// Sets the options of a solver for the queries that follow; null means the defaults. No other
/// thread may use the solver during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_set_options(
    solver: *mut ExtricateSolver,
    options: *const ExtricateOptions,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let solver = unsafe { raw::exclusive(solver, "solver") };
    guarded(|| {
        let solver = solver?;
        // SAFETY: the same.
        let wanted = unsafe { Wanted::read(options, solver.base.scene()) }?;
        *solver = wanted.of(&solver.base)?;
        Ok(())
    })
}

/// Queries configurations all over the space for about this many seconds, so that the first real
/// query is as fast as later ones; 0.03 s are enough. Answers stay the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_warm_up(solver: *const ExtricateSolver, seconds: f64) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let solver = unsafe { raw::shared(solver, "solver") };
    guarded(|| {
        let wrong = |_| Fault::argument(format!("seconds: got {seconds}, expected 0 or more"));
        let duration = Duration::try_from_secs_f64(seconds).map_err(wrong)?;
        solver?.solver.warm_up(duration);
        Ok(())
    })
}

/// Frees a solver; its answers stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_free(solver: *mut ExtricateSolver) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(solver) };
        Ok(())
    });
}

/// Finds the nearest free configuration to `q`, which has `nq` numbers and may be beyond the
/// limits. Writes an answer, which the caller frees with extricate_answer_free(). Returns
/// EXTRICATE_NOTHING_FREE if nothing free was found: free configurations may be rare, or locked
/// joints, a clearance or a stop left none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_query(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    answer: *mut *mut ExtricateAnswer,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let answer = unsafe { raw::place(answer, "answer") };
    guarded(|| {
        let (solver, answer) = (solver?, answer?);
        let q = solver.config(q?)?;
        let found = solver.solver.query(&q).ok_or_else(nothing_free)?;
        answer.hand_over(answer_to_c::answer(solver.solver.scene(), found));
        Ok(())
    })
}

/// Finds the witness of extricate_query() alone, in less time. Writes `nq` numbers, those of `q` if
/// it is free. It proves nothing, unless the effort is EXTRICATE_PROVED or the options set a gap.
/// Returns the same status as extricate_query().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_nearest_exit(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    witness: *mut f64,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let witness = unsafe { raw::places(witness, nq, "witness") };
    guarded(|| {
        let (solver, mut witness) = (solver?, witness?);
        let found = solver.solver.nearest_exit(&solver.config(q?)?).ok_or_else(nothing_free)?;
        witness.fill(found.iter().copied());
        Ok(())
    })
}

pub fn nothing_free() -> Fault {
    let message = "query: nothing free was found, not even among 20,000 configurations".into();
    Fault { status: EXTRICATE_NOTHING_FREE, message }
}

//! Queries one by one, with options and memory that stay.

#![allow(unsafe_code)]

use std::sync::Arc;
use std::time::Duration;

use extricate::{CheckScratch, QueryScratch};

use super::describe;
use super::handles::{ExtricateAnswer, ExtricateScene, ExtricateSolver};
use super::types::{EXTRICATE_NOTHING_FREE, ExtricateOptions, ExtricateStatus};
use crate::options::{Wanted, defaults};
use crate::raw;
use crate::status::{Fault, guarded};

/// Fills in the usual options.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_options_init(options: *mut ExtricateOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        options?.put(defaults());
        Ok(())
    })
}

/// Makes a solver of queries of the scene. One for each thread; any number for one scene, which it
/// keeps. Options are read now; null stands for the usual ones.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_new(
    scene: *const ExtricateScene,
    options: *const ExtricateOptions,
    solver: *mut *mut ExtricateSolver,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, solver) = unsafe { (raw::shared(scene, "scene"), raw::place(solver, "solver")) };
    guarded(|| {
        let (asked, solver) = (Arc::clone(&scene?.0), solver?);
        // SAFETY: the same.
        let wanted = unsafe { Wanted::read(options, asked.scene()) }?;
        asked.view()?;
        let (scratch, check_scratch) = (QueryScratch::default(), CheckScratch::default());
        solver.hand_over(ExtricateSolver { asked, wanted, scratch, check_scratch });
        Ok(())
    })
}

/// Other options for the queries that follow; null stands for the usual ones.
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
        solver.wanted = unsafe { Wanted::read(options, solver.asked.scene()) }?;
        Ok(())
    })
}

/// Queries configurations all over the space for about so many seconds, so that the first query
/// that counts takes as long as those that follow: 0.03 are enough. Answers stay the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_warm_up(solver: *mut ExtricateSolver, seconds: f64) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let solver = unsafe { raw::exclusive(solver, "solver") };
    guarded(|| {
        let solver = solver?;
        let wrong = |_| Fault::argument(format!("seconds: got {seconds}, expected 0 or more"));
        let duration = Duration::try_from_secs_f64(seconds).map_err(wrong)?;
        let mut scratch = std::mem::take(&mut solver.scratch);
        solver.asked.view()?.warm_up(&solver.wanted.options, &mut scratch, duration);
        solver.scratch = scratch;
        Ok(())
    })
}

/// Frees a solver; its answers stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_solver_free(solver: *mut ExtricateSolver) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(solver) };
        Ok(())
    });
}

/// The nearest free configuration to `q`, which is `nq` numbers, beyond the limits too. Writes an
/// answer, to be freed with extricate_answer_free(). EXTRICATE_NOTHING_FREE where nothing free was
/// found: without a model only where it is rare indeed, and with joints that stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_query(
    solver: *mut ExtricateSolver,
    q: *const f64,
    nq: usize,
    answer: *mut *mut ExtricateAnswer,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::exclusive(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let answer = unsafe { raw::place(answer, "answer") };
    guarded(|| {
        let (solver, answer) = (solver?, answer?);
        let q = solver.asked.config(q?, solver.wanted.refuse_outside)?;
        // Taken, so that a fault leaves no half written memory behind.
        let mut scratch = std::mem::take(&mut solver.scratch);
        let found = solver.asked.view()?.query_with(&q, &solver.wanted.options, &mut scratch);
        solver.scratch = scratch;
        let found = found.ok_or_else(nothing_free)?;
        answer.hand_over(describe::answer(solver.asked.scene(), found));
        Ok(())
    })
}

/// What there is to say where nothing free was found.
pub fn nothing_free() -> Fault {
    let message = "query: nothing free was found, not even among 20,000 configurations".into();
    Fault { status: EXTRICATE_NOTHING_FREE, message }
}

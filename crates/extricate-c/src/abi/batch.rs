//! Many queries or checks on many threads.

#![allow(unsafe_code)]

use std::ops::ControlFlow;

use extricate::{CheckScratch, Checker, Config, ConfigSpace, Label};

use super::answer_to_c;
use super::handles::ExtricateScene;
use super::types::{ExtricateOptions, ExtricateStatus, ExtricateSummary};
use crate::options::{Wanted, threads as thread_count};
use crate::raw::{self, OutValues};
use crate::status::{Fault, Result, guarded};

/// Finds the nearest free configurations to `count` queries, which follow one another in `q`, `nq`
/// numbers each. Writes `count` witnesses and `count` summaries, in the same order. If nothing free
/// was found for a query, `found` of its summary is false and its witness is nan. Each answer
/// equals that of extricate_query(), with any number of threads (0: one per core). If a row is
/// wrong, the call fails before the first query.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_query_batch(
    scene: *const ExtricateScene,
    options: *const ExtricateOptions,
    q: *const f64,
    count: usize,
    nq: usize,
    threads: usize,
    witnesses: *mut f64,
    summaries: *mut ExtricateSummary,
) -> ExtricateStatus {
    let all = count.saturating_mul(nq);
    // SAFETY: the contract of this module.
    let (scene, q) = unsafe { (raw::shared(scene, "scene"), raw::slice(q, all, "q")) };
    // SAFETY: the same.
    let (witnesses, summaries) =
        unsafe { (raw::places(witnesses, all, "witnesses"), raw::places(summaries, count, "summaries")) };
    guarded(|| {
        let (scene, q, witnesses, summaries) = (scene?, q?, witnesses?, summaries?);
        // SAFETY: the same.
        let asked = unsafe { Wanted::read(options, scene.scene()) }?.of(&scene.solver)?;
        let configs = configs(scene.scene().space(), (q, count, nq), &|q| asked.config(q))?;
        let mut rows = witnesses.parts(nq).zip(summaries.parts(1));
        asked.solver.batch_each(configs, thread_count(threads)?, &mut |answered| {
            let Some((mut witness, mut summary)) = rows.next() else { return ControlFlow::Break(()) };
            match answered.answer {
                Some(answer) => {
                    summary.fill([answer_to_c::summary(&answer)]);
                    witness.fill(answer.witness.iter().copied());
                }
                None => {
                    summary.fill([answer_to_c::NOTHING]);
                    witness.fill(std::iter::repeat(f64::NAN));
                }
            }
            ControlFlow::Continue(())
        });
        Ok(())
    })
}

/// Checks whether each of `count` configurations is free, as extricate_check() does for one. They
/// follow one another in `q`, `nq` numbers each. `threads` is 0 for one per core.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_check_batch(
    scene: *const ExtricateScene,
    q: *const f64,
    count: usize,
    nq: usize,
    threads: usize,
    is_free: *mut bool,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, q) = unsafe { (raw::shared(scene, "scene"), raw::slice(q, count.saturating_mul(nq), "q")) };
    // SAFETY: the same.
    let is_free = unsafe { raw::places(is_free, count, "is_free") };
    guarded(|| {
        let (scene, q, is_free) = (scene?, q?, is_free?);
        let configs = configs_anywhere(scene.scene().space(), (q, count, nq))?;
        let checker = scene.solver.checker();
        map(&configs, thread_count(threads)?, is_free, |q, scratch| is_free_at(checker, q, scratch));
        Ok(())
    })
}

/// Computes the least signed distance of any checked pair \[m\] at each of `count` configurations,
/// as extricate_distance() does for one. They follow one another in `q`, `nq` numbers each.
/// `threads` is 0 for one per core.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_distance_batch(
    scene: *const ExtricateScene,
    q: *const f64,
    count: usize,
    nq: usize,
    threads: usize,
    distances: *mut f64,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, q) = unsafe { (raw::shared(scene, "scene"), raw::slice(q, count.saturating_mul(nq), "q")) };
    // SAFETY: the same.
    let distances = unsafe { raw::places(distances, count, "distances") };
    guarded(|| {
        let (scene, q, distances) = (scene?, q?, distances?);
        let configs = configs_anywhere(scene.scene().space(), (q, count, nq))?;
        let checker = scene.solver.checker();
        map(&configs, thread_count(threads)?, distances, |q, scratch| checker.clearance(q, scratch));
        Ok(())
    })
}

/// Whether `q` is free in the sense of the glossary: within its limits, and no pair collides.
fn is_free_at(checker: &Checker, q: &Config, scratch: &mut CheckScratch) -> bool {
    checker.scene().space().outside(q).next().is_none() && checker.label(q, scratch) == Label::Free
}

/// Reads all rows, which may lie beyond the limits; fails at the first that is no configuration.
fn configs_anywhere(space: &ConfigSpace, rows: (&[f64], usize, usize)) -> Result<Vec<Config>> {
    configs(space, rows, &|q| Ok(space.config_anywhere(q)?))
}

/// Reads all rows with `config`; fails at the first row that it refuses.
fn configs(
    space: &ConfigSpace,
    (q, count, nq): (&[f64], usize, usize),
    config: &dyn Fn(&[f64]) -> Result<Config>,
) -> Result<Vec<Config>> {
    let own = space.nq();
    if nq != own && count > 0 {
        return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
    }
    let rows = q.chunks_exact(own.max(1)).enumerate();
    let named = |row: usize, fault: Fault| Fault { message: format!("row {row}: {}", fault.message), ..fault };
    rows.map(|(row, q)| config(q).map_err(|fault| named(row, fault))).collect()
}

/// Number of rows that a thread takes per lock of the shared queue.
const PART_ROWS: usize = 256;

/// Writes `of` of each configuration to `out`, on `threads` threads (0: one per core).
fn map<T: Copy + Send>(
    configs: &[Config],
    threads: usize,
    out: OutValues<'_, T>,
    of: impl Fn(&Config, &mut CheckScratch) -> T + Sync,
) {
    let cores = || std::thread::available_parallelism().map_or(1, |cores| cores.get());
    let threads = if threads == 0 { cores() } else { threads };
    let parts = std::sync::Mutex::new(configs.chunks(PART_ROWS).zip(out.parts(PART_ROWS)));
    let work = || {
        let mut scratch = CheckScratch::default();
        loop {
            let part = parts.lock().unwrap_or_else(std::sync::PoisonError::into_inner).next();
            let Some((configs, mut out)) = part else { return };
            out.fill(configs.iter().map(|q| of(q, &mut scratch)));
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(configs.len().div_ceil(PART_ROWS)) {
            // If the system starts no more threads, the running ones do the work.
            let _ = std::thread::Builder::new().spawn_scoped(scope, work);
        }
        work();
    });
}

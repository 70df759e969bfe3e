//! Many queries or checks on many threads.

#![allow(unsafe_code)]

use std::ops::ControlFlow;

use extricate::{CheckScratch, Checker, Config, Label, SegmentOptions};

use super::answer_to_c;
use super::handles::{ExtricateScene, ExtricateSolver};
use super::types::{ExtricateOptions, ExtricateSegment, ExtricateSignedDistance, ExtricateStatus, ExtricateSummary};
use crate::options::{Wanted, threads as thread_count};
use crate::raw::{self, OutValues};
use crate::rows::{configs, configs_anywhere};
use crate::status::{Fault, guarded};

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

/// Measures how far each of `count` configurations is from the boundary of the free ones, in the
/// scene's metric. For one that collides it is minus the depth, else the distance to the nearest in
/// contact. They follow one another in `q`, `nq` numbers each, and may be beyond the limits.
/// `within` is a distance above 0 beyond which a free configuration is far enough; infinity for
/// none. `threads` is 0 for one per core. Limits on checks and seconds, effort and locked joints
/// are those of the options of the solver.
///
/// Writes `count` distances, witnesses of `nq` numbers and gradients of `nv` numbers, in tangent
/// coordinates. The witness is the nearest free configuration, or the nearest in contact, which is
/// free and just touches; nan if there is none. The gradient is that of the distance; it is 0
/// without a witness, and nan if nothing free was found.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_signed_distances(
    solver: *const ExtricateSolver,
    q: *const f64,
    count: usize,
    nq: usize,
    nv: usize,
    within: f64,
    threads: usize,
    distances: *mut ExtricateSignedDistance,
    witnesses: *mut f64,
    gradients: *mut f64,
) -> ExtricateStatus {
    let all = count.saturating_mul(nq);
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, all, "q")) };
    // SAFETY: the same.
    let (distances, witnesses) =
        unsafe { (raw::places(distances, count, "distances"), raw::places(witnesses, all, "witnesses")) };
    // SAFETY: the same.
    let gradients = unsafe { raw::places(gradients, count.saturating_mul(nv), "gradients") };
    guarded(|| {
        let (solver, q) = (&solver?.solver, q?);
        let (scene, own) = (solver.scene(), solver.scene().space().nv());
        if nv != own {
            return Err(Fault::argument(format!("nv: got {nv}, expected {own}")));
        }
        let configs = configs_anywhere(scene.space(), (q, count, nq))?;
        let mut rows = distances?.parts(1).zip(witnesses?.parts(nq).zip(gradients?.parts(nv)));
        let within = Some(within).filter(|within| *within != f64::INFINITY);
        solver.signed_distances(configs, within, thread_count(threads)?, &mut |answered| {
            let Some((mut distance, (mut witness, mut gradient))) = rows.next() else {
                return ControlFlow::Break(());
            };
            let found = answered.answer.as_ref();
            distance.fill([found.map_or(answer_to_c::NO_DISTANCE, |found| answer_to_c::signed_distance(scene, found))]);
            match found.and_then(|found| found.witness.as_ref()) {
                Some(at) => witness.fill(at.iter().copied()),
                None => witness.fill(std::iter::repeat(f64::NAN)),
            }
            match found {
                Some(found) => gradient.fill(found.gradient.iter().copied()),
                None => gradient.fill(std::iter::repeat(f64::NAN)),
            }
            ControlFlow::Continue(())
        })?;
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

/// Checks whether whole segments are free, as extricate_check_segment() does for one: from each of
/// `count` configurations in `from` to the same one in `to`, `nq` numbers each. `threads` is 0 for
/// one per core.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_check_segment_batch(
    scene: *const ExtricateScene,
    from: *const f64,
    to: *const f64,
    count: usize,
    nq: usize,
    resolution: f64,
    threads: usize,
    segments: *mut ExtricateSegment,
) -> ExtricateStatus {
    let all = count.saturating_mul(nq);
    // SAFETY: the contract of this module.
    let (scene, from) = unsafe { (raw::shared(scene, "scene"), raw::slice(from, all, "from")) };
    // SAFETY: the same.
    let (to, segments) = unsafe { (raw::slice(to, all, "to"), raw::places(segments, count, "segments")) };
    guarded(|| {
        let (scene, segments) = (scene?, segments?);
        check_resolution(resolution)?;
        let own = scene.scene();
        let read = |rows, name: &str| {
            configs(own.space(), (rows, count, nq), &|q| Ok(own.config(q)?)).map_err(|fault| fault.of(name))
        };
        let ends: Vec<(Config, Config)> = read(from?, "from")?.into_iter().zip(read(to?, "to")?).collect();
        let (checker, options) = (scene.solver.checker(), SegmentOptions::default().resolution(resolution));
        map(&ends, thread_count(threads)?, segments, |(from, to), scratch| {
            answer_to_c::segment(own, checker.segment(from, to, &options, scratch))
        });
        Ok(())
    })
}

/// Refuses resolutions that are no lengths.
pub fn check_resolution(resolution: f64) -> crate::status::Result<()> {
    match resolution > 0.0 && resolution.is_finite() {
        true => Ok(()),
        false => Err(Fault::argument(format!("resolution: got {resolution}, expected more than 0 [m]"))),
    }
}

/// Whether `q` is free in the sense of the glossary: within its limits, and no pair collides.
fn is_free_at(checker: &Checker, q: &Config, scratch: &mut CheckScratch) -> bool {
    checker.scene().space().outside(q).next().is_none() && checker.label(q, scratch) == Label::Free
}

/// Number of rows that a thread takes per lock of the shared queue.
const PART_ROWS: usize = 256;

/// Writes `of` of each row to `out`, on `threads` threads (0: one per core).
fn map<Row: Sync, T: Copy + Send>(
    configs: &[Row],
    threads: usize,
    out: OutValues<'_, T>,
    of: impl Fn(&Row, &mut CheckScratch) -> T + Sync,
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

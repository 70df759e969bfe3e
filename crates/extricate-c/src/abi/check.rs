//! Checks, distances and segments, with the memory of a solver.

#![allow(unsafe_code)]

use extricate::SegmentOptions;
use extricate::internals::collision::signed_distances;

use super::batch::is_free_at;
use super::describe;
use super::handles::{ExtricateScene, ExtricateSolver};
use super::types::{ExtricateSegment, ExtricateStatus};
use crate::raw;
use crate::status::{Fault, guarded};

/// Whether a configuration is free: within all limits, and every checked pair keeps the clearance.
/// Exact, on the geometry of the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_check(
    solver: *mut ExtricateSolver,
    q: *const f64,
    nq: usize,
    is_free: *mut bool,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::exclusive(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let is_free = unsafe { raw::place(is_free, "is_free") };
    guarded(|| {
        let (solver, is_free) = (solver?, is_free?);
        let q = solver.asked.config(q?, false)?;
        let mut scratch = std::mem::take(&mut solver.check_scratch);
        is_free.put(is_free_at(solver.asked.view()?.checker(), &q, &mut scratch));
        solver.check_scratch = scratch;
        Ok(())
    })
}

/// Least signed distance of any checked pair \[m\]: negative where two bodies overlap, infinity
/// where no pair is checked. Exact where positive, and of convex shapes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_distance(
    solver: *mut ExtricateSolver,
    q: *const f64,
    nq: usize,
    distance: *mut f64,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::exclusive(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let distance = unsafe { raw::place(distance, "distance") };
    guarded(|| {
        let (solver, distance) = (solver?, distance?);
        let q = solver.asked.config(q?, false)?;
        let mut scratch = std::mem::take(&mut solver.check_scratch);
        distance.put(solver.asked.view()?.checker().clearance(&q, &mut scratch));
        solver.check_scratch = scratch;
        Ok(())
    })
}

/// Signed distances of all checked pairs \[m\], by pair; `pair_count` is that of the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_pair_distances(
    solver: *mut ExtricateSolver,
    q: *const f64,
    nq: usize,
    distances: *mut f64,
    pair_count: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::exclusive(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let distances = unsafe { raw::places(distances, pair_count, "distances") };
    guarded(|| {
        let (solver, mut distances) = (solver?, distances?);
        let own = solver.asked.scene().pairs.len();
        if pair_count != own {
            return Err(Fault::argument(format!("pair_count: got {pair_count}, expected {own}")));
        }
        let q = solver.asked.config(q?, false)?;
        let mut scratch = std::mem::take(&mut solver.check_scratch);
        distances.fill(signed_distances(solver.asked.view()?.checker(), &q, &mut scratch));
        solver.check_scratch = scratch;
        Ok(())
    })
}

/// Whether the whole segment from one configuration to another is free, both within the limits:
/// proved, not sampled. `resolution` is how closely a first contact is enclosed \[m\]: 1e-4 is
/// usual.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_check_segment(
    solver: *mut ExtricateSolver,
    from: *const f64,
    to: *const f64,
    nq: usize,
    resolution: f64,
    segment: *mut ExtricateSegment,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, from) = unsafe { (raw::exclusive(solver, "solver"), raw::slice(from, nq, "from")) };
    // SAFETY: the same.
    let (to, segment) = unsafe { (raw::slice(to, nq, "to"), raw::place(segment, "segment")) };
    guarded(|| {
        let (solver, segment) = (solver?, segment?);
        if !(resolution > 0.0 && resolution.is_finite()) {
            return Err(Fault::argument(format!("resolution: got {resolution}, expected more than 0 [m]")));
        }
        let (from, to) = (solver.asked.config(from?, true)?, solver.asked.config(to?, true)?);
        let mut scratch = std::mem::take(&mut solver.check_scratch);
        let options = SegmentOptions { resolution };
        let outcome = solver.asked.view()?.checker().segment(&from, &to, &options, &mut scratch);
        solver.check_scratch = scratch;
        segment.put(describe::segment(solver.asked.scene(), outcome));
        Ok(())
    })
}

/// How far two configurations are from each other, in the scene's metric: what depths are measured
/// by.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_metric_distance(
    scene: *const ExtricateScene,
    from: *const f64,
    to: *const f64,
    nq: usize,
    distance: *mut f64,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, from) = unsafe { (raw::shared(scene, "scene"), raw::slice(from, nq, "from")) };
    // SAFETY: the same.
    let (to, distance) = unsafe { (raw::slice(to, nq, "to"), raw::place(distance, "distance")) };
    guarded(|| {
        let (asked, distance) = (&scene?.0, distance?);
        let (from, to) = (asked.config(from?, false)?, asked.config(to?, false)?);
        distance.put(asked.world()?.metric().distance(&from, &to));
        Ok(())
    })
}

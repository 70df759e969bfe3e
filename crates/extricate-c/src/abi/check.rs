//! Checks, distances and segments.

#![allow(unsafe_code)]

use extricate::SegmentOptions;

use super::answer_to_c;
use super::handles::{ExtricateScene, ExtricateSolver};
use super::types::{ExtricateSegment, ExtricateStatus};
use crate::raw;
use crate::status::{Fault, guarded};

/// Checks whether a configuration is free: it is within all limits, and every checked pair keeps
/// the clearance. The result is exact for the geometry of the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_check(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    is_free: *mut bool,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let is_free = unsafe { raw::place(is_free, "is_free") };
    guarded(|| {
        let (solver, is_free) = (&solver?.solver, is_free?);
        let space = solver.scene().space();
        let q = space.config_anywhere(q?)?;
        is_free.put(space.outside(&q).next().is_none() && solver.check(&q));
        Ok(())
    })
}

/// Computes the least signed distance of any checked pair \[m\]: negative if two bodies overlap,
/// infinity if no pair is checked. A positive distance is exact; between convex shapes, every
/// distance is exact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_distance(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    distance: *mut f64,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let distance = unsafe { raw::place(distance, "distance") };
    guarded(|| {
        let (solver, distance) = (&solver?.solver, distance?);
        let q = solver.scene().space().config_anywhere(q?)?;
        distance.put(solver.distance(&q));
        Ok(())
    })
}

/// Computes the signed distances of all checked pairs \[m\], in the order of
/// extricate_scene_pair(). `pair_count` must be the number that extricate_scene_pair_count()
/// returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_pair_distances(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    distances: *mut f64,
    pair_count: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let distances = unsafe { raw::places(distances, pair_count, "distances") };
    guarded(|| {
        let (solver, mut distances) = (&solver?.solver, distances?);
        let own = solver.scene().pairs().len();
        if pair_count != own {
            return Err(Fault::argument(format!("pair_count: got {pair_count}, expected {own}")));
        }
        let q = solver.scene().space().config_anywhere(q?)?;
        distances.fill(solver.pair_distances(&q));
        Ok(())
    })
}

/// Checks whether the whole straight segment from one configuration to another is free, by proof,
/// not by sampling. Both ends must be within the limits. The first contact is located to within
/// `resolution` \[m\]; 1e-4 is usual.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_check_segment(
    solver: *const ExtricateSolver,
    from: *const f64,
    to: *const f64,
    nq: usize,
    resolution: f64,
    segment: *mut ExtricateSegment,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, from) = unsafe { (raw::shared(solver, "solver"), raw::slice(from, nq, "from")) };
    // SAFETY: the same.
    let (to, segment) = unsafe { (raw::slice(to, nq, "to"), raw::place(segment, "segment")) };
    guarded(|| {
        let (solver, segment) = (&solver?.solver, segment?);
        if !(resolution > 0.0 && resolution.is_finite()) {
            return Err(Fault::argument(format!("resolution: got {resolution}, expected more than 0 [m]")));
        }
        let (from, to) = (solver.scene().config(from?)?, solver.scene().config(to?)?);
        let outcome = solver.check_segment(&from, &to, &SegmentOptions::default().resolution(resolution));
        segment.put(answer_to_c::segment(solver.scene(), outcome));
        Ok(())
    })
}

/// Computes the distance between two configurations in the scene's metric, which also measures
/// depths.
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
        let (solver, distance) = (&scene?.solver, distance?);
        let space = solver.scene().space();
        let (from, to) = (space.config_anywhere(from?)?, space.config_anywhere(to?)?);
        distance.put(solver.metric().distance(&from, &to));
        Ok(())
    })
}

//! Checks, distances and segments.

#![allow(unsafe_code)]

use std::ops::ControlFlow;

use extricate::parts::misses_allowed;
use extricate::{CheckScratch, Contact, PairId, Sampler, Scene, SegmentOptions, Solver};

use super::answer_to_c;
use super::handles::{ExtricateContacts, ExtricateScene, ExtricateSolver};
use super::types::{ExtricateContact, ExtricatePair, ExtricateSegment, ExtricateStatus};
use crate::enum_constants::{LABELS, choice};
use crate::raw::{self, OutValue, OutValues};
use crate::status::{Fault, Result, guarded};

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

/// Computes the radius of a ball around a configuration, in the scene's metric, in which every
/// configuration within the limits is proved free; 0 if the configuration is not free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_free_radius(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    radius: *mut f64,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let radius = unsafe { raw::place(radius, "radius") };
    guarded(|| {
        let (solver, radius) = (&solver?.solver, radius?);
        let q = solver.scene().space().config_anywhere(q?)?;
        radius.put(solver.free_radius(&q));
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
        super::batch::check_resolution(resolution)?;
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

/// Writes the pairs of bodies that collide at a configuration within the limits, and their number
/// to `count`. `pair_count` must be the number that extricate_scene_pair_count() returns, since all
/// pairs may collide.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_colliding_pairs(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    pairs: *mut ExtricatePair,
    pair_count: usize,
    count: *mut usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let (pairs, count) = unsafe { (raw::places(pairs, pair_count, "pairs"), raw::place(count, "count")) };
    guarded(|| {
        let solver = &solver?.solver;
        let q = solver.scene().config(q?)?;
        let found = || solver.colliding_pairs(&q);
        write_pairs(solver.scene(), found, (pairs?, pair_count), count?)
    })
}

/// Writes the pairs of bodies that collide in at least the share `share` of `samples` random
/// configurations, and their number to `count`. Most likely they are links that overlap by design:
/// extricate_scene_disabled() takes them off. A share of 1 and 100 samples are usual. `pair_count`
/// must be the number that extricate_scene_pair_count() returns.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_always_colliding(
    scene: *const ExtricateScene,
    samples: usize,
    seed: u64,
    share: f64,
    pairs: *mut ExtricatePair,
    pair_count: usize,
    count: *mut usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, pairs) = unsafe { (raw::shared(scene, "scene"), raw::places(pairs, pair_count, "pairs")) };
    // SAFETY: the same.
    let count = unsafe { raw::place(count, "count") };
    guarded(|| {
        let solver = &scene?.solver;
        if samples == 0 {
            return Err(Fault::argument("samples: got 0, expected 1 or more"));
        }
        if !(share > 0.0 && share <= 1.0) {
            return Err(Fault::argument(format!("share: got {share}, expected more than 0, at most 1")));
        }
        let found = || {
            let mut sampler = Sampler::new(solver, None, seed);
            let drawn = (0..samples).map_while(|_| sampler.draw(1, &mut |_, _| ControlFlow::Continue(())).ok()?.pop());
            let often = solver.checker().nearly_always_colliding(drawn, misses_allowed(samples, share));
            often.into_iter().map(|(pair, _)| pair).collect()
        };
        write_pairs(solver.scene(), found, (pairs?, pair_count), count?)
    })
}

fn write_pairs(
    scene: &Scene,
    found: impl FnOnce() -> Vec<PairId>,
    (mut pairs, pair_count): (OutValues<ExtricatePair>, usize),
    count: OutValue<usize>,
) -> Result<()> {
    let own = scene.pairs().len();
    if pair_count != own {
        return Err(Fault::argument(format!("pair_count: got {pair_count}, expected {own}")));
    }
    let found = found();
    count.put(found.len());
    pairs.fill(found.into_iter().map(|id| answer_to_c::pair(scene, id)));
    Ok(())
}

/// Makes the contacts of all bodies that are nearer to each other than `within` \[m\] at a
/// configuration within the limits, free or not, in the order of their pairs. A pair of convex
/// shapes has one contact, which is exact. Meshes have several, and the nearest is exact; if meshes
/// overlap, all are estimates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_contacts(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    within: f64,
    contacts: *mut *mut ExtricateContacts,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let contacts = unsafe { raw::place(contacts, "contacts") };
    hand_over_near(solver, q, within, contacts, |solver, q, scratch| {
        let mut found = Vec::new();
        solver.checker().contacts_within(q, within, scratch, &mut found);
        (found, Vec::new())
    })
}

/// Makes the nearest contact of every pair of bodies that are nearer to each other than `within`
/// \[m\], with the gradient of its distance. These are the rows that controllers and quadratic
/// programs take. Otherwise as extricate_contacts().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_distance_rows(
    solver: *const ExtricateSolver,
    q: *const f64,
    nq: usize,
    within: f64,
    contacts: *mut *mut ExtricateContacts,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (solver, q) = unsafe { (raw::shared(solver, "solver"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let contacts = unsafe { raw::place(contacts, "contacts") };
    hand_over_near(solver, q, within, contacts, |solver, q, scratch| {
        let rows = solver.checker().distance_rows(q, within, scratch);
        let contacts = rows.iter().map(|row| row.contact).collect();
        (contacts, rows.into_iter().flat_map(|row| row.gradient).collect())
    })
}

/// Hands the caller the contacts and gradients that `find` returns for a configuration.
fn hand_over_near(
    solver: Result<&ExtricateSolver>,
    q: Result<&[f64]>,
    within: f64,
    contacts: Result<OutValue<*mut ExtricateContacts>>,
    find: impl FnOnce(&Solver, &[f64], &mut CheckScratch) -> (Vec<Contact>, Vec<f64>),
) -> ExtricateStatus {
    guarded(|| {
        let (solver, contacts) = (&solver?.solver, contacts?);
        if !within.is_finite() {
            return Err(Fault::argument(format!("within: got {within}, expected a finite distance [m]")));
        }
        let (scene, q) = (solver.scene(), solver.scene().config(q?)?);
        let (found, gradients) = solver.with_scratch(|scratch| find(solver, &q, scratch));
        let found = found.iter().map(|contact| answer_to_c::contact(scene, contact)).collect();
        contacts.hand_over(ExtricateContacts { contacts: found, gradients });
        Ok(())
    })
}

/// Returns the gradients of the distances of contacts that extricate_distance_rows() made: `nv`
/// numbers for each contact \[m per rad or m\], in tangent coordinates. Returns null if there are
/// none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_contacts_gradients(contacts: *const ExtricateContacts) -> *const f64 {
    // SAFETY: the contract of this module.
    let contacts = unsafe { raw::shared(contacts, "contacts") };
    match contacts {
        Ok(contacts) if !contacts.gradients.is_empty() => contacts.gradients.as_ptr(),
        _ => std::ptr::null(),
    }
}

/// Returns the number of contacts, and points `list` to them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_contacts_list(
    contacts: *const ExtricateContacts,
    list: *mut *const ExtricateContact,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(contacts, list, |contacts| &contacts.contacts) }
}

/// Frees contacts of bodies.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_contacts_free(contacts: *mut ExtricateContacts) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(contacts) };
        Ok(())
    });
}

/// Draws `count` uniformly random configurations within the limits, `nq` numbers each: with
/// EXTRICATE_FREE or EXTRICATE_COLLIDING those of that kind alone, with EXTRICATE_ANY all. They
/// depend on the scene and `seed` alone. All cores check them. If a million in a row are of the
/// other kind, the call fails with EXTRICATE_INPUT.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_sample(
    scene: *const ExtricateScene,
    kind: u32,
    count: usize,
    seed: u64,
    q: *mut f64,
    nq: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, q) = unsafe { (raw::shared(scene, "scene"), raw::places(q, count.saturating_mul(nq), "q")) };
    guarded(|| {
        let (solver, mut rows) = (&scene?.solver, q?.parts(nq));
        let own = solver.scene().space().nq();
        if nq != own {
            return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
        }
        let Some(wanted) = choice(LABELS, kind) else {
            let expected = "EXTRICATE_ANY, EXTRICATE_FREE or EXTRICATE_COLLIDING";
            return Err(Fault::argument(format!("kind: got {kind}, expected {expected}")));
        };
        let mut sampler = Sampler::new(solver, wanted, seed);
        let mut missing = count;
        while missing > 0 {
            let drawn = sampler.draw(missing.min(ROWS_PER_DRAW), &mut |_, _| ControlFlow::Continue(()))?;
            missing -= drawn.len();
            drawn.into_iter().zip(&mut rows).for_each(|(q, mut row)| row.fill(q));
        }
        Ok(())
    })
}

/// Configurations that one call of the sampler draws.
const ROWS_PER_DRAW: usize = 4096;

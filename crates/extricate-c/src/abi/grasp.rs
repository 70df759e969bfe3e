//! Functions of hands: grasps that hold an object and penetrate nothing.

#![allow(unsafe_code)]

use std::ffi::{CString, c_char};

use extricate::{Grasp, Hand, Solver};

use super::grasp_types::{ExtricateGraspContact, ExtricateGraspSummary, ExtricateReleaseOptions};
use super::handles::{ExtricateGrasp, ExtricateHand, ExtricateScene};
use super::solver::nothing_free;
use super::types::ExtricateStatus;
use crate::motion_options;
use crate::raw;
use crate::status::{c_string, guarded};

/// Fills in the default options of releases.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_release_options_init(options: *mut ExtricateReleaseOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        options?.put(motion_options::of_releases());
        Ok(())
    })
}

/// Makes the hand of a scene that holds the obstacle `object`: it finds the fingers, and prepares
/// what releases need. It keeps the scene, but no model; any number of threads may use it.
///
/// If `scene_weights` is false, the base of a floating hand gets weights that make a displacement
/// of it as dear as one of the fingers; otherwise the weights of the scene apply.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_hand_new(
    scene: *const ExtricateScene,
    object: *const c_char,
    scene_weights: bool,
    hand: *mut *mut ExtricateHand,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, object) = unsafe { (raw::shared(scene, "scene"), raw::text(object, "object")) };
    // SAFETY: the same.
    let hand = unsafe { raw::place(hand, "hand") };
    guarded(|| {
        let (scene, hand) = (scene?, hand?);
        let own = Hand::new(scene.scene(), object?)?;
        let solver = scene.solver.without_model();
        let weighted = if scene_weights { None } else { Hand::weighted(scene.scene()) };
        let solver: Solver = match weighted {
            Some(weighted) => solver.with_scene(weighted)?,
            None => solver,
        };
        solver.prepare();
        hand.hand_over(ExtricateHand { solver, hand: own });
        Ok(())
    })
}

/// Frees a hand; its grasps stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_hand_free(hand: *mut ExtricateHand) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(hand) };
        Ok(())
    });
}

/// Finds the nearest configuration at which no finger penetrates the object and the hand still
/// holds it; null options mean the defaults. `q` may be beyond the limits. If nothing free was
/// found, it returns EXTRICATE_NOTHING_FREE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_release(
    hand: *const ExtricateHand,
    q: *const f64,
    nq: usize,
    options: *const ExtricateReleaseOptions,
    grasp: *mut *mut ExtricateGrasp,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (hand, q) = unsafe { (raw::shared(hand, "hand"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let grasp = unsafe { raw::place(grasp, "grasp") };
    guarded(|| {
        let (hand, grasp) = (hand?, grasp?);
        // SAFETY: the same.
        let options = unsafe { motion_options::release(options, hand.solver.scene()) }?;
        let q = hand.solver.scene().space().config_anywhere(q?)?;
        let found = hand.solver.release(&hand.hand, &q, &options).ok_or_else(nothing_free)?;
        grasp.hand_over(grasp_of(found));
        Ok(())
    })
}

fn grasp_of(grasp: Grasp) -> ExtricateGrasp {
    let summary = ExtricateGraspSummary {
        moved: grasp.moved,
        verified: grasp.verified,
        kept_sides: grasp.kept_sides,
        fingers_before: grasp.fingers[0],
        fingers_kept: grasp.fingers[1],
        depth_before: grasp.depth_before,
        epsilon: grasp.quality.map_or(f64::NAN, |quality| quality.epsilon),
        force_closure: grasp.quality.is_some_and(|quality| quality.force_closure),
        checks: grasp.checks as u64,
    };
    let names: Vec<CString> = grasp.contacts.iter().map(|contact| c_string(&contact.link)).collect();
    let contacts = grasp.contacts.iter().zip(&names).map(|(contact, name)| ExtricateGraspContact {
        link: name.as_ptr(),
        distance: contact.distance,
        point: contact.point,
        normal: contact.normal,
    });
    let texts = |names: &[String]| names.iter().map(|name| c_string(name)).collect::<Vec<_>>();
    ExtricateGrasp {
        summary,
        contacts: contacts.collect(),
        touched: texts(&grasp.touched),
        kept: texts(&grasp.kept),
        config: grasp.config.to_vec(),
        _names: names,
    }
}

/// Returns the numbers of a grasp; null if `grasp` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_grasp_summary(grasp: *const ExtricateGrasp) -> *const ExtricateGraspSummary {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(grasp, "grasp") }.map_or(std::ptr::null(), |grasp| &raw const grasp.summary)
}

/// Returns the configuration of a grasp, with as many numbers as the query; null if `grasp` is
/// null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_grasp_config(grasp: *const ExtricateGrasp) -> *const f64 {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(grasp, "grasp") }.map_or(std::ptr::null(), |grasp| grasp.config.as_ptr())
}

/// Returns the number of contacts with the object, and points `contacts` to them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_grasp_contacts(
    grasp: *const ExtricateGrasp,
    contacts: *mut *const ExtricateGraspContact,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(grasp, contacts, |grasp| &grasp.contacts) }
}

/// Returns the name of a link that touched the object at the query, or was in it; null if there are
/// not so many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_grasp_touched(grasp: *const ExtricateGrasp, index: usize) -> *const c_char {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(grasp, "grasp") }
        .map_or(std::ptr::null(), |grasp| super::scene_info::nth(&grasp.touched, index))
}

/// Returns the name of one of those links that still touches it; null if there are not so many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_grasp_kept(grasp: *const ExtricateGrasp, index: usize) -> *const c_char {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(grasp, "grasp") }.map_or(std::ptr::null(), |grasp| super::scene_info::nth(&grasp.kept, index))
}

/// Frees a grasp; null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_grasp_free(grasp: *mut ExtricateGrasp) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(grasp) };
        Ok(())
    });
}

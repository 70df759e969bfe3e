//! Functions that read an answer. The pointers that they return live as long as the answer.

#![allow(unsafe_code)]

use super::handles::ExtricateAnswer;
use super::types::{ExtricateContact, ExtricateExit, ExtricateKeptError, ExtricatePair, ExtricateSummary};
use crate::raw;
use crate::status::guarded;

/// Returns the numbers of an answer, such as depth and lower bound; null if `answer` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_summary(answer: *const ExtricateAnswer) -> *const ExtricateSummary {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(answer, "answer") }.map_or(std::ptr::null(), |answer| &raw const answer.summary)
}

/// Returns the free configuration, with as many numbers as the query; null if `answer` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_witness(answer: *const ExtricateAnswer) -> *const f64 {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(answer, "answer") }.map_or(std::ptr::null(), |answer| answer.answer.witness.as_ptr())
}

/// Returns the gradient of the depth with respect to the query: `nv` numbers, in tangent
/// coordinates; null if `answer` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_gradient(answer: *const ExtricateAnswer) -> *const f64 {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(answer, "answer") }.map_or(std::ptr::null(), |answer| answer.answer.gradient.as_ptr())
}

/// Returns the number of pairs that collide at the query, and points `pairs` to them. With
/// EXTRICATE_NEAREST it is one pair, unless the options request contacts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_colliding(
    answer: *const ExtricateAnswer,
    pairs: *mut *const ExtricatePair,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, pairs, |answer| &answer.colliding) }
}

/// Returns the number of pairs that touch at the witness, and points `pairs` to them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_touching(
    answer: *const ExtricateAnswer,
    pairs: *mut *const ExtricatePair,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, pairs, |answer| &answer.touching) }
}

/// Returns the number of coordinates of the query that are beyond their limits, and points
/// `coordinates` to their indices.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_outside(
    answer: *const ExtricateAnswer,
    coordinates: *mut *const usize,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, coordinates, |answer| &answer.answer.outside) }
}

/// Returns the number of kept links that are off at the query by more than their tolerances, and
/// points `links` to their indices in the order of the option `keep`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_off(answer: *const ExtricateAnswer, links: *mut *const usize) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, links, |answer| &answer.answer.off) }
}

/// Returns the number of kept links, and points `kept` to how far each is off at the witness; none
/// if the query is free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_kept(
    answer: *const ExtricateAnswer,
    kept: *mut *const ExtricateKeptError,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, kept, |answer| &answer.kept) }
}

/// Returns the number of contacts at the witness, and points `contacts` to them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_contacts(
    answer: *const ExtricateAnswer,
    contacts: *mut *const ExtricateContact,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, contacts, |answer| &answer.contacts) }
}

/// Returns the number of distinct exits, if the options request more than one, and points `exits`
/// to them, nearest first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_exits(
    answer: *const ExtricateAnswer,
    exits: *mut *const ExtricateExit,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(answer, exits, |answer| &answer.exits) }
}

/// Frees an answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_answer_free(answer: *mut ExtricateAnswer) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(answer) };
        Ok(())
    });
}

//! Functions of streams: sequences of queries that are near each other, as in a simulation. Each
//! query starts from the exit of the one before.

#![allow(unsafe_code)]

use extricate::{Stream, StreamOptions};

use super::answer_to_c;
use super::handles::{ExtricateAnswer, ExtricateScene, ExtricateStream};
use super::solver::nothing_free;
use super::types::{ExtricateOptions, ExtricateStatus};
use crate::options::{Wanted, fault};
use crate::raw;
use crate::status::{Fault, guarded};

/// Makes a stream, which answers queries that are near each other, such as the frames of one
/// motion. Each query starts from the exit of the one before. The stream keeps the scene; one
/// thread at a time may use it.
///
/// The stream keeps the exit of the last frame until another is nearer by more than the share
/// `hysteresis` of its depth, in \[0, 1); with 0 it always uses the nearest. Each frame tries
/// `starts_per_frame` other starts; 2 are usual.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_new(
    scene: *const ExtricateScene,
    options: *const ExtricateOptions,
    hysteresis: f64,
    starts_per_frame: usize,
    stream: *mut *mut ExtricateStream,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, stream) = unsafe { (raw::shared(scene, "scene"), raw::place(stream, "stream")) };
    guarded(|| {
        let (scene, stream) = (scene?, stream?);
        // SAFETY: the same.
        let wanted = unsafe { Wanted::read(options, scene.scene()) }?;
        if wanted.options.exits > 1 {
            return Err(fault("exits", wanted.options.exits, "1: a stream follows one exit"));
        }
        if wanted.options.toward.is_some() {
            return Err(fault("toward", "a goal", "null: a stream follows one exit"));
        }
        let (solver, first) = (scene.solver.clone(), wanted.of(&scene.solver)?);
        let options = StreamOptions::default().hysteresis(hysteresis).starts_per_frame(starts_per_frame);
        options.check()?;
        stream.hand_over(ExtricateStream { first, options, solver, stream: None });
        Ok(())
    })
}

/// Answers the next frame; otherwise as extricate_query().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_query(
    stream: *mut ExtricateStream,
    q: *const f64,
    nq: usize,
    answer: *mut *mut ExtricateAnswer,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (stream, q) = unsafe { (raw::exclusive(stream, "stream"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let answer = unsafe { raw::place(answer, "answer") };
    guarded(|| {
        let (stream, answer) = (stream?, answer?);
        let q = stream.first.config(q?)?;
        // Take the stream out, so that a failure or panic leaves no half-written one behind.
        let mut frames = match stream.stream.take() {
            Some(frames) => frames,
            None => stream.first.solver.stream(stream.options.clone())?,
        };
        let found = frames.query_in(&stream.solver, &q)?;
        stream.stream = Some(frames);
        let found = found.ok_or_else(nothing_free)?;
        answer.hand_over(answer_to_c::answer(stream.solver.scene(), found));
        Ok(())
    })
}

/// Sets the scene of a stream for the frames that follow, such as one in which obstacles moved. It
/// must have the same coordinates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_set_scene(
    stream: *mut ExtricateStream,
    scene: *const ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (stream, scene) = unsafe { (raw::exclusive(stream, "stream"), raw::shared(scene, "scene")) };
    guarded(|| {
        let (stream, scene) = (stream?, scene?);
        if scene.scene().space() != stream.first.solver.scene().space() {
            return Err(Fault::argument("scene: got other coordinates than those of the stream, expected the same"));
        }
        stream.solver = scene.solver.clone();
        Ok(())
    })
}

/// Forgets the frames so far; the next frame is answered as a single query.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_restart(stream: *mut ExtricateStream) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let stream = unsafe { raw::exclusive(stream, "stream") };
    guarded(|| {
        stream?.stream.iter_mut().for_each(Stream::restart);
        Ok(())
    })
}

/// Frees a stream; its answers stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_free(stream: *mut ExtricateStream) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(stream) };
        Ok(())
    });
}

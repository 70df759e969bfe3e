//! Functions of streams: sequences of queries that are near each other, as in a simulation. Each
//! query starts from the exit of the one before.

#![allow(unsafe_code)]

use extricate::{Stream, StreamOptions};

use super::answer_to_c;
use super::handles::{ExtricateAnswer, ExtricateScene, ExtricateStream};
use super::solver::nothing_free;
use super::types::{ExtricateOptions, ExtricateStatus, ExtricateStreamOptions};
use crate::options::{Wanted, fault, of_call};
use crate::raw;
use crate::status::{Fault, guarded};

/// Fills in the default options of streams.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_options_init(options: *mut ExtricateStreamOptions) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let options = unsafe { raw::place(options, "options") };
    guarded(|| {
        let StreamOptions { hysteresis, starts_per_frame, continuous, .. } = StreamOptions::default();
        options?.put(ExtricateStreamOptions { hysteresis, starts_per_frame, continuous: continuous.into() });
        Ok(())
    })
}

/// Makes a stream, which answers queries that are near each other, such as the frames of one
/// motion. Each query starts from the exit of the one before. The stream keeps the scene; one
/// thread at a time may use it.
/// Null options mean the defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_new(
    scene: *const ExtricateScene,
    options: *const ExtricateOptions,
    stream_options: *const ExtricateStreamOptions,
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
        let (solver, first) = {
            let first = wanted.of(&scene.solver)?;
            (first.solver.clone(), first)
        };
        // SAFETY: the same.
        let given =
            if stream_options.is_null() { None } else { Some(unsafe { raw::shared(stream_options, "options") }?) };
        let options = given.map_or_else(StreamOptions::default, |given| {
            StreamOptions::default()
                .hysteresis(given.hysteresis)
                .starts_per_frame(given.starts_per_frame)
                .continuous(given.continuous != 0)
        });
        options.check().map_err(of_call)?;
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
        let solver = stream.first.weights.solver(&scene.solver)?;
        if solver.scene().space() != stream.first.solver.scene().space() {
            return Err(Fault::argument("scene: got other coordinates than those of the stream, expected the same"));
        }
        stream.solver = solver;
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

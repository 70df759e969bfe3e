//! Queries that follow each other closely, as from a simulation: each begins with the exit of the
//! last one.

#![allow(unsafe_code)]

use std::sync::Arc;

use extricate::{Stream, StreamOptions};

use super::describe;
use super::handles::{ExtricateAnswer, ExtricateScene, ExtricateStream};
use super::solver::nothing_free;
use super::types::{ExtricateOptions, ExtricateStatus};
use crate::options::Wanted;
use crate::raw;
use crate::status::{Fault, guarded};

/// Makes a stream of queries of the scene, which it keeps. One for each thread.
///
/// The exit of the last frame is kept until another is nearer by more than the share `hysteresis`
/// of its depth, in \[0, 1); 0 always takes the nearest. `starts_per_frame` other starts are tried
/// each frame; 4 are usual.
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
        let (asked, stream) = (Arc::clone(&scene?.0), stream?);
        if !(0.0..1.0).contains(&hysteresis) {
            return Err(Fault::argument(format!("hysteresis: got {hysteresis}, expected 0 or more, and less than 1")));
        }
        // SAFETY: the same.
        let wanted = unsafe { Wanted::read(options, asked.scene()) }?;
        if wanted.options.exits > 1 || wanted.options.toward.is_some() {
            return Err(Fault::argument(
                "options: got several exits or a goal, expected none: a stream follows one exit",
            ));
        }
        asked.view()?;
        stream.hand_over(ExtricateStream { asked, wanted, hysteresis, starts_per_frame, stream: None });
        Ok(())
    })
}

/// The answer for the next frame; otherwise as extricate_query().
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
        let q = stream.asked.config(q?, stream.wanted.refuse_outside)?;
        let begin = || {
            let (query, hysteresis) = (stream.wanted.options.clone(), stream.hysteresis);
            Stream::new(StreamOptions {
                query,
                hysteresis,
                starts_per_frame: stream.starts_per_frame,
                ..StreamOptions::default()
            })
        };
        // Taken, so that a fault leaves no half written memory behind.
        let mut frames = stream.stream.take().unwrap_or_else(begin);
        let found = stream.asked.view()?.query_next(&q, &mut frames);
        stream.stream = Some(frames);
        let found = found.ok_or_else(nothing_free)?;
        answer.hand_over(describe::answer(stream.asked.scene(), found));
        Ok(())
    })
}

/// Another scene for the frames that follow, such as one in which obstacles moved. It must have the
/// same coordinates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_set_scene(
    stream: *mut ExtricateStream,
    scene: *const ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (stream, scene) = unsafe { (raw::exclusive(stream, "stream"), raw::shared(scene, "scene")) };
    guarded(|| {
        let (stream, scene) = (stream?, scene?);
        if scene.0.scene().space != stream.asked.scene().space {
            return Err(Fault::argument("scene: got other coordinates than those of the stream, expected the same"));
        }
        scene.0.view()?;
        stream.asked = Arc::clone(&scene.0);
        Ok(())
    })
}

/// Forgets the frames so far: the next one is answered as a query on its own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_restart(stream: *mut ExtricateStream) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let stream = unsafe { raw::exclusive(stream, "stream") };
    guarded(|| {
        stream?.stream.iter_mut().for_each(Stream::restart);
        Ok(())
    })
}

/// Frees a stream; its answers stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_stream_free(stream: *mut ExtricateStream) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(stream) };
        Ok(())
    });
}

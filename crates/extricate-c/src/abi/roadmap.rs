//! Functions of roadmaps, which the plans of one scene share.

#![allow(unsafe_code)]

use std::ffi::c_char;
use std::path::Path;

use extricate::{Roadmap, files};

use super::handles::{ExtricateRoadmap, ExtricateScene};
use super::types::ExtricateStatus;
use crate::raw;
use crate::status::guarded;

/// Makes an empty roadmap: free configurations and proved edges between them, which
/// extricate_plan() adds to and reuses. One thread at a time may use it.
///
/// In another scene with the same coordinates a roadmap is a guess that saves checks: every path
/// that is returned is proved in the scene of the plan.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_new(
    scene: *const ExtricateScene,
    seed: u64,
    roadmap: *mut *mut ExtricateRoadmap,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, roadmap) = unsafe { (raw::shared(scene, "scene"), raw::place(roadmap, "roadmap")) };
    guarded(|| {
        let (scene, roadmap) = (scene?.scene(), roadmap?);
        roadmap.hand_over(ExtricateRoadmap { roadmap: Roadmap::new(scene.space(), seed) });
        Ok(())
    })
}

/// Reads a roadmap file for a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_load(
    path: *const c_char,
    scene: *const ExtricateScene,
    roadmap: *mut *mut ExtricateRoadmap,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (path, scene) = unsafe { (raw::text(path, "path"), raw::shared(scene, "scene")) };
    // SAFETY: the same.
    let roadmap = unsafe { raw::place(roadmap, "roadmap") };
    guarded(|| {
        let (path, scene, roadmap) = (Path::new(path?), scene?.scene(), roadmap?);
        roadmap.hand_over(ExtricateRoadmap { roadmap: files::load_roadmap(path, scene)? });
        Ok(())
    })
}

/// Writes a roadmap file. A reader sees the old file or the whole new one. It replaces no file that
/// is not a roadmap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_save(
    roadmap: *const ExtricateRoadmap,
    path: *const c_char,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (roadmap, path) = unsafe { (raw::shared(roadmap, "roadmap"), raw::text(path, "path")) };
    guarded(|| Ok(files::save_roadmap(&roadmap?.roadmap, Path::new(path?))?))
}

/// Returns the number of configurations of a roadmap; 0 if `roadmap` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_size(roadmap: *const ExtricateRoadmap) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(roadmap, "roadmap") }.map_or(0, |roadmap| roadmap.roadmap.len())
}

/// Returns the number of proved edges of a roadmap; 0 if `roadmap` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_edges(roadmap: *const ExtricateRoadmap) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(roadmap, "roadmap") }.map_or(0, |roadmap| roadmap.roadmap.edges())
}

/// Returns the number of configurations that were evaluated to make a roadmap; 0 if `roadmap` is
/// null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_checks(roadmap: *const ExtricateRoadmap) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(roadmap, "roadmap") }.map_or(0, |roadmap| roadmap.roadmap.checks())
}

/// Frees a roadmap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_roadmap_free(roadmap: *mut ExtricateRoadmap) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(roadmap) };
        Ok(())
    });
}

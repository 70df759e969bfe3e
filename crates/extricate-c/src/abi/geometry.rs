//! Functions for viewers and cameras: where bodies are, their triangles, and points of the robot.

#![allow(unsafe_code)]

use std::ffi::c_char;

use extricate::parts::Seated;

use super::handles::{ExtricateMesh, ExtricateScene};
use super::types::ExtricateStatus;
use crate::raw;
use crate::rows::configs_anywhere;
use crate::status::{Fault, guarded};

/// Numbers of a transform.
const TRANSFORM: usize = 16;

/// Computes where bodies are in the world at `count` configurations, which follow one another in
/// `q`, `nq` numbers each. `names` are those of bodies or of links, which need no geometry; null
/// means all bodies. Writes a transform for each configuration and name: the 16 numbers of a 4 by 4
/// matrix, row by row, from a body's own coordinates \[m\] to those of the world. A link has the
/// coordinates of its URDF; an obstacle or an attached object has those of its shape.
/// `transform_count` must be the number of transforms: `count` times the number of names or bodies.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_scene_poses(
    scene: *const ExtricateScene,
    names: *const *const c_char,
    name_count: usize,
    q: *const f64,
    count: usize,
    nq: usize,
    transforms: *mut f64,
    transform_count: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, q) = unsafe { (raw::shared(scene, "scene"), raw::slice(q, count.saturating_mul(nq), "q")) };
    // SAFETY: the same.
    let names = unsafe { raw::texts(names, name_count, "names") };
    // SAFETY: the same.
    let transforms = unsafe { raw::places(transforms, transform_count.saturating_mul(TRANSFORM), "transforms") };
    guarded(|| {
        let (scene, names, transforms) = (scene?.scene(), names?, transforms?);
        let seat = |name: &&str| {
            scene.seat_named(name).ok_or_else(|| {
                Fault::argument(format!("names: got `{name}`, expected names of bodies or of links of the scene"))
            })
        };
        let seats: Vec<Seated> = match names.is_empty() {
            false => names.iter().map(seat).collect::<Result<_, _>>()?,
            true => (0..scene.bodies().len()).map(|body| scene.seat_of_body(body)).collect(),
        };
        let configs = configs_anywhere(scene.space(), (q?, count, nq))?;
        let expected = configs.len() * seats.len();
        if transform_count != expected {
            return Err(Fault::argument(format!("transform_count: got {transform_count}, expected {expected}")));
        }
        let (mut places, mut frames) = (transforms.parts(TRANSFORM), Vec::new());
        for q in &configs {
            scene.poses(q, &mut frames);
            for (seat, mut place) in seats.iter().zip(&mut places) {
                let pose = frames[seat.frame].then(&seat.pose_frame_own);
                let ([x, y, z], origin) = (pose.columns(), pose.origin());
                let rows = (0..3).flat_map(|row| [x[row], y[row], z[row], origin[row]]);
                place.fill(rows.chain([0.0, 0.0, 0.0, 1.0]));
            }
        }
        Ok(())
    })
}

/// Makes the triangles of a body, to draw it at its place by extricate_scene_poses(). Round shapes
/// are inscribed and get `segments` sides around their axis, 3 or more; 32 are usual. A half-space
/// becomes a square of 10 m.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_mesh(
    scene: *const ExtricateScene,
    body: usize,
    segments: usize,
    mesh: *mut *mut ExtricateMesh,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, mesh) = unsafe { (raw::shared(scene, "scene"), raw::place(mesh, "mesh")) };
    guarded(|| {
        let (scene, mesh) = (scene?.scene(), mesh?);
        let bodies = scene.bodies().len();
        if body >= bodies {
            return Err(Fault::argument(format!("body: got {body}, expected an index below {bodies}")));
        }
        if !(3..=MAX_SEGMENTS).contains(&segments) {
            return Err(Fault::argument(format!("segments: got {segments}, expected 3 to {MAX_SEGMENTS}")));
        }
        let (points, triangles) = scene.mesh_of_body(body, segments);
        mesh.hand_over(ExtricateMesh { points, triangles });
        Ok(())
    })
}

/// Most sides of round shapes: more would fill memory, and no eye could tell.
const MAX_SEGMENTS: usize = 4096;

/// Returns the number of corners of a mesh, and points `points` to their coordinates \[m\], three
/// numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_mesh_points(mesh: *const ExtricateMesh, points: *mut *const f64) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(mesh, points, |mesh| mesh.points.as_flattened()) / 3 }
}

/// Returns the number of triangles of a mesh, and points `triangles` to the indices of their
/// corners, three each, counterclockwise from outside.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_mesh_triangles(mesh: *const ExtricateMesh, triangles: *mut *const u32) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::list(mesh, triangles, |mesh| mesh.triangles.as_flattened()) / 3 }
}

/// Frees a mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_mesh_free(mesh: *mut ExtricateMesh) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(mesh) };
        Ok(())
    });
}

/// Finds the points that are not the robot's own: at `q`, no link is nearer to them than `padding`
/// \[m\]. `points` holds three numbers for each, in the world. Writes `point_count` flags, true for
/// the points to keep. Obstacles do not count.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn extricate_scene_robot_filter(
    scene: *const ExtricateScene,
    points: *const f64,
    point_count: usize,
    q: *const f64,
    nq: usize,
    padding: f64,
    keep: *mut bool,
) -> ExtricateStatus {
    // SAFETY: the contract of this module; an array is laid out as its values.
    let (scene, points) =
        unsafe { (raw::shared(scene, "scene"), raw::slice(points.cast::<[f64; 3]>(), point_count, "points")) };
    // SAFETY: the same.
    let (q, keep) = unsafe { (raw::slice(q, nq, "q"), raw::places(keep, point_count, "keep")) };
    guarded(|| {
        let (scene, points, mut keep) = (scene?, points?, keep?);
        if !(padding >= 0.0 && padding.is_finite()) {
            return Err(Fault::argument(format!("padding: got {padding}, expected 0 m or more")));
        }
        if let Some(at) = points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
            let point = points[at];
            return Err(Fault::argument(format!("points[{at}]: got {point:?}, expected finite coordinates [m]")));
        }
        let config = scene.scene().config(q?).map_err(|error| Fault::from(error).of("q"))?;
        let solver = &scene.solver;
        keep.fill(solver.with_scratch(|scratch| solver.checker().robot_filter(&config, points, padding, scratch)));
        Ok(())
    })
}

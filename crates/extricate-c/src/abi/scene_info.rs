//! Functions that read a scene (coordinates, joints, bodies, pairs, warnings), errors and versions.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char};
use std::path::Path;

use extricate::files::joint_positions;
use extricate::{LoadLimits, Manifold};

use super::handles::{ExtricatePositions, ExtricateScene};
use super::types::{EXTRICATE_ABI, EXTRICATE_METRIC_JOINT, ExtricatePair, ExtricateStatus};
use crate::enum_constants::{METRICS, number};
use crate::raw;
use crate::status::{Fault, c_string, guarded, last_error};

/// Returns the message of the last call that failed on this thread: file or argument, value, and
/// what was expected. The message is empty if no call failed. It stays until the next call on this
/// thread fails, or the thread ends; destructors of the thread's variables may find it gone.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_last_error() -> *const c_char {
    last_error(CStr::as_ptr)
}

/// Fails with this message and EXTRICATE_ARGUMENT. A layer on top of this interface calls it to
/// refuse an argument as the functions here do: extricate_last_error() then returns the message.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_refuse(message: *const c_char) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let message = unsafe { raw::text(message, "message") };
    guarded(|| Err(Fault::argument(message?)))
}

/// Returns the version of the library, such as "0.2.0".
#[unsafe(no_mangle)]
pub extern "C" fn extricate_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Returns EXTRICATE_ABI of the library. A program that was compiled with another value must not
/// continue.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_abi() -> u32 {
    EXTRICATE_ABI
}

/// Returns the number of coordinates of a configuration; 0 if `scene` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_nq(scene: *const ExtricateScene) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| scene.scene().space().nq())
}

/// Returns the number of tangent coordinates: one for each coordinate, but three for a rotation,
/// which has four coordinates; 0 if `scene` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_nv(scene: *const ExtricateScene) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| scene.scene().space().nv())
}

/// Returns the number of joints that have coordinates; 0 if `scene` is null. Indices of joints
/// follow the order of coordinates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_joint_count(scene: *const ExtricateScene) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| scene.scene().joints().len())
}

/// Returns the name of a joint, which lives as long as the scene; null if there is no such joint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_joint_name(scene: *const ExtricateScene, index: usize) -> *const c_char {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(std::ptr::null(), |scene| nth(&scene.names().joints, index))
}

/// Writes the first coordinate of a joint and the number of its coordinates; 0 and 0 if there is no
/// such joint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_joint_coordinates(
    scene: *const ExtricateScene,
    index: usize,
    first: *mut usize,
    count: *mut usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, first, count) =
        unsafe { (raw::shared(scene, "scene"), raw::place(first, "first"), raw::place(count, "count")) };
    guarded(|| {
        let (first, count) = (first?, count?);
        let range = scene?.scene().joints().get(index).map_or(0..0, |joint| joint.q.clone());
        first.put(range.start);
        count.put(range.len());
        Ok(())
    })
}

/// Writes the limits of all coordinates: `nq` lower and `nq` upper ones. A continuous joint has
/// minus and plus pi, which are the same position. The coordinates of a quaternion have minus and
/// plus 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_limits(
    scene: *const ExtricateScene,
    lower: *mut f64,
    upper: *mut f64,
    nq: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    // SAFETY: the same.
    let (lower, upper) = unsafe { (raw::places(lower, nq, "lower"), raw::places(upper, nq, "upper")) };
    guarded(|| {
        let (space, mut lower, mut upper) = (scene?.scene().space(), lower?, upper?);
        let own = space.nq();
        if nq != own {
            return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
        }
        let limits: Vec<[f64; 2]> = space
            .factors()
            .iter()
            .flat_map(|factor| match factor.manifold {
                Manifold::Interval { lower, upper } => vec![[lower, upper]],
                Manifold::Circle => vec![[-std::f64::consts::PI, std::f64::consts::PI]],
                Manifold::Rotation => vec![[-1.0, 1.0]; 4],
            })
            .collect();
        lower.fill(limits.iter().map(|limit| limit[0]));
        upper.fill(limits.iter().map(|limit| limit[1]));
        Ok(())
    })
}

/// Writes the configuration in which the named joints have these positions \[rad or m\], which
/// follow one another. `sizes` holds the number of coordinates of each joint; null means one each.
/// Locked, mimic and fixed joints may be among them, because robots report them too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_config(
    scene: *const ExtricateScene,
    names: *const *const c_char,
    sizes: *const usize,
    count: usize,
    positions: *const f64,
    position_count: usize,
    q: *mut f64,
    nq: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    // SAFETY: the same.
    let (names, positions) =
        unsafe { (raw::texts(names, count, "names"), raw::slice(positions, position_count, "positions")) };
    // SAFETY: the same.
    let sizes = if sizes.is_null() { Ok(None) } else { unsafe { raw::slice(sizes, count, "sizes") }.map(Some) };
    // SAFETY: the same.
    let q = unsafe { raw::places(q, nq, "q") };
    guarded(|| {
        let (scene, names, positions, mut q) = (scene?.scene(), names?, positions?, q?);
        let sizes = sizes?.map_or_else(|| vec![1; names.len()], <[usize]>::to_vec);
        let mut rest = positions;
        let mut named = Vec::with_capacity(names.len());
        for (name, size) in names.into_iter().zip(&sizes) {
            let Some((own, after)) = rest.split_at_checked(*size) else { break };
            named.push((name, own));
            rest = after;
        }
        if named.len() != count || !rest.is_empty() {
            let sum = sizes.iter().fold(0, |sum: usize, size| sum.saturating_add(*size));
            let said = format!("expected {sum}, the sum of the sizes of the joints");
            return Err(Fault::argument(format!("position_count: got {position_count}, {said}")));
        }
        let own = scene.space().nq();
        if nq != own {
            return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
        }
        q.fill(scene.config_of(named)?.values);
        Ok(())
    })
}

/// Makes the positions by joint at `q`, the inverse of extricate_scene_config(): mimic and locked
/// joints are among them, fixed ones are not. `q` may be beyond the limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_positions(
    scene: *const ExtricateScene,
    q: *const f64,
    nq: usize,
    positions: *mut *mut ExtricatePositions,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, q) = unsafe { (raw::shared(scene, "scene"), raw::slice(q, nq, "q")) };
    // SAFETY: the same.
    let positions = unsafe { raw::place(positions, "positions") };
    guarded(|| {
        let (scene, positions) = (scene?.scene(), positions?);
        let q = scene.space().config_anywhere(q?)?;
        let of_joints = scene.positions_at(&q).into_iter();
        positions.hand_over(ExtricatePositions {
            joints: of_joints.map(|(name, values)| (c_string(&name), values)).collect(),
        });
        Ok(())
    })
}

/// Returns the number of joints that have positions; 0 if `positions` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_positions_size(positions: *const ExtricatePositions) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(positions, "positions") }.map_or(0, |positions| positions.joints.len())
}

/// Returns the name of a joint that has positions, which lives as long as `positions`; null if
/// there is no such joint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_positions_name(positions: *const ExtricatePositions, index: usize) -> *const c_char {
    // SAFETY: the contract of this module.
    let positions = unsafe { raw::shared(positions, "positions") };
    let joint = positions.ok().and_then(|positions| positions.joints.get(index));
    joint.map_or(std::ptr::null(), |(name, _)| name.as_ptr())
}

/// Returns the number of coordinates of a joint, and points `values` to its positions \[rad or m\];
/// 0 if there is no such joint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_positions_values(
    positions: *const ExtricatePositions,
    index: usize,
    values: *mut *const f64,
) -> usize {
    // SAFETY: the contract of this module.
    unsafe {
        raw::list(positions, values, |positions| positions.joints.get(index).map_or(&[][..], |(_, values)| values))
    }
}

/// Frees the positions of joints.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_positions_free(positions: *mut ExtricatePositions) {
    guarded(|| {
        // SAFETY: the contract of this module.
        unsafe { raw::take_back(positions) };
        Ok(())
    });
}

/// Writes the configuration in a text that holds a ROS message: a JointState, alone or in a
/// RobotState, a PlanningScene or a planning request. The ending of `name` sets the format, .yaml
/// or .json. Error messages contain `name`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_config_text(
    scene: *const ExtricateScene,
    name: *const c_char,
    text: *const c_char,
    q: *mut f64,
    nq: usize,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    // SAFETY: the same.
    let (name, text, q) = unsafe { (raw::text(name, "name"), raw::text(text, "text"), raw::places(q, nq, "q")) };
    guarded(|| {
        let (scene, mut q) = (scene?.scene(), q?);
        let own = scene.space().nq();
        if nq != own {
            return Err(Fault::argument(format!("nq: got {nq}, expected {own}")));
        }
        let positions = joint_positions(Path::new(name?), text?, &LoadLimits::default())?;
        let named = positions.iter().map(|(name, position)| (name.as_str(), std::slice::from_ref(position)));
        q.fill(scene.config_of(named)?.values);
        Ok(())
    })
}

/// Returns the number of bodies: links with geometry, obstacles and attached objects; 0 if `scene`
/// is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_body_count(scene: *const ExtricateScene) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| scene.scene().bodies().len())
}

/// Returns the name of a body, which lives as long as the scene; null if there is no such body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_body_name(scene: *const ExtricateScene, index: usize) -> *const c_char {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(std::ptr::null(), |scene| nth(&scene.names().bodies, index))
}

/// Returns the number of checked pairs of bodies; 0 if `scene` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_pair_count(scene: *const ExtricateScene) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| scene.scene().pairs().len())
}

/// Returns a checked pair; both indices are SIZE_MAX if there is no such pair.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_pair(scene: *const ExtricateScene, index: usize) -> ExtricatePair {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    let pair = scene.ok().and_then(|scene| scene.scene().pairs().get(index).copied());
    pair.map_or(super::answer_to_c::NO_PAIR, |pair| ExtricatePair { first: pair.first, second: pair.second })
}

/// Returns the least distance that free configurations keep \[m\], except for pairs with a
/// clearance of their own; nan if `scene` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_clearance(scene: *const ExtricateScene) -> f64 {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(f64::NAN, |scene| scene.scene().clearance())
}

/// Returns the metric in which depths are measured: EXTRICATE_METRIC_JOINT or another.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_metric(scene: *const ExtricateScene) -> u32 {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    scene.map_or(EXTRICATE_METRIC_JOINT, |scene| number(METRICS, scene.scene().metric()))
}

/// Returns whether a model was learned from exactly this scene; extricate_save() writes that model.
/// A changed scene keeps the model of the original scene, whose samples are additional starts of
/// queries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_is_learned(scene: *const ExtricateScene) -> bool {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.is_ok_and(|scene| scene.solver.is_learned())
}

/// Returns how the model was learned and its measured quality, as JSON, which lives as long as the
/// scene; null if the scene has no model. docs/reference/statistics.md describes the keys.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_statistics(scene: *const ExtricateScene) -> *const c_char {
    // SAFETY: the contract of this module.
    let scene = unsafe { raw::shared(scene, "scene") };
    scene.ok().and_then(ExtricateScene::statistics).map_or(std::ptr::null(), |text| text.as_ptr())
}

/// Returns the number of stored samples of the model, and points `samples` to the first number of
/// the first one. They are free configurations beside the boundary, follow one another and have
/// `nq` numbers each. Returns 0 if the scene has no model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_samples(scene: *const ExtricateScene, samples: *mut *const f64) -> usize {
    // SAFETY: the contract of this module.
    let count = unsafe {
        raw::list(scene, samples, |scene| scene.solver.model().map_or(&[][..], |model| model.boundary().configs()))
    };
    // SAFETY: the same.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| count / scene.scene().space().nq().max(1))
}

/// Returns the number of warnings about the scene, such as open meshes, defaults that were assumed,
/// and ignored content of a message of MoveIt; 0 if `scene` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_warning_count(scene: *const ExtricateScene) -> usize {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(0, |scene| scene.scene().warnings().len())
}

/// Returns a warning, which lives as long as the scene; null if there is no such warning.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_warning(scene: *const ExtricateScene, index: usize) -> *const c_char {
    // SAFETY: the contract of this module.
    unsafe { raw::shared(scene, "scene") }.map_or(std::ptr::null(), |scene| nth(&scene.names().warnings, index))
}

/// Returns a text of a list; null if there is no such text.
pub fn nth(texts: &[CString], index: usize) -> *const c_char {
    texts.get(index).map_or(std::ptr::null(), |text| text.as_ptr())
}

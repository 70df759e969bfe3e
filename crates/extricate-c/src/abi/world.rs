//! Functions that derive a changed scene from a scene. The new scene keeps the model, and shares
//! everything that did not change.

#![allow(unsafe_code)]

use std::ffi::c_char;
use std::path::Path;

use extricate::entries::{assemble_world, parse};
use extricate::files::{Imported, import, is_foreign, load_world};
use extricate::{LoadLimits, Scene};

use super::handles::ExtricateScene;
use super::types::{ExtricateLoadOptions, ExtricateObstacle, ExtricatePose, ExtricateStatus};
use crate::load_options;
use crate::raw::{self, OutValue};
use crate::shapes;
use crate::status::{Fault, Result, guarded};

/// Makes a scene in which obstacles have other poses: `count` names, and their poses in the world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_moved(
    scene: *const ExtricateScene,
    names: *const *const c_char,
    poses: *const ExtricatePose,
    count: usize,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same.
    let (names, poses) = unsafe { (raw::texts(names, count, "names"), raw::slice(poses, count, "poses")) };
    change(scene, changed, |scene| {
        let moved = |(name, given): (&'_ &str, &ExtricatePose)| {
            Ok((name.to_string(), shapes::pose(&format!("obstacle \"{name}\""), given)?))
        };
        let moved = names?.iter().zip(poses?).map(moved).collect::<Result<Vec<_>>>()?;
        Ok(scene.moved(moved.iter().map(|(name, pose)| (name.as_str(), *pose)))?)
    })
}

/// Makes a scene with additional obstacles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_with_obstacles(
    scene: *const ExtricateScene,
    obstacles: *const ExtricateObstacle,
    count: usize,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same.
    let obstacles = unsafe { raw::slice(obstacles, count, "obstacles") };
    change(scene, changed, |scene| {
        // SAFETY: the same.
        let (bodies, told) = unsafe { shapes::bodies(obstacles?) }?;
        Ok(scene.with_obstacles(bodies)?.with_warnings(told))
    })
}

/// Makes a scene without the named obstacles or attached objects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_without(
    scene: *const ExtricateScene,
    names: *const *const c_char,
    count: usize,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same.
    let names = unsafe { raw::texts(names, count, "names") };
    change(scene, changed, |scene| Ok(scene.without(names?)?))
}

/// Makes a scene without any obstacle; attached objects stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_without_obstacles(
    scene: *const ExtricateScene,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    change(scene, changed, |scene| Ok(scene.without_obstacles()))
}

/// Makes a scene that does not check these pairs of bodies: two names per pair, one after the
/// other.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_disabled(
    scene: *const ExtricateScene,
    names: *const *const c_char,
    pair_count: usize,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same; a count that no memory can hold is refused.
    let names = unsafe { raw::texts(names, pair_count.saturating_mul(2), "names") };
    change(scene, changed, |scene| {
        let names = names?;
        Ok(scene.disabled(names.chunks_exact(2).map(|pair| [pair[0], pair[1]]))?)
    })
}

/// Makes a scene with an object that a link holds, such as a can in a gripper. The pose of the
/// object is in the coordinates of the link. The object is checked against everything except bodies
/// fixed to the link and the bodies named in `touch`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_attached(
    scene: *const ExtricateScene,
    object: *const ExtricateObstacle,
    link: *const c_char,
    touch: *const *const c_char,
    touch_count: usize,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same.
    let (object, link) = unsafe { (raw::slice(object, 1, "object"), raw::text(link, "link")) };
    // SAFETY: the same.
    let touch = unsafe { raw::texts(touch, touch_count, "touch") };
    change(scene, changed, |scene| {
        // SAFETY: the same.
        let (mut objects, told) = unsafe { shapes::bodies(object?) }?;
        let object = objects.pop().ok_or_else(|| Fault::argument("object: got none"))?;
        Ok(scene.attached(object, link?, &touch?)?.with_warnings(told))
    })
}

/// Puts the robots of the scene into the world of a file: a scene file (TOML) without a robot,
/// MoveIt's .scene text, or a PlanningScene message as .yaml or .json. Null options mean the
/// defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_in_world(
    scene: *const ExtricateScene,
    path: *const c_char,
    options: *const ExtricateLoadOptions,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same.
    let path = unsafe { raw::text(path, "path") };
    // SAFETY: the same.
    let options = unsafe { load_options::read(options) };
    change(scene, changed, |scene| Ok(load_world(scene, Path::new(path?), &options?)?))
}

/// Puts the robots of the scene into the world of a text, as extricate_scene_in_world() does for a
/// file. The ending of `name` sets the format: .toml, .scene, .yaml or .json. Error messages
/// contain `name`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn extricate_scene_in_world_text(
    scene: *const ExtricateScene,
    name: *const c_char,
    text: *const c_char,
    changed: *mut *mut ExtricateScene,
) -> ExtricateStatus {
    // SAFETY: the contract of this module.
    let (scene, changed) = unsafe { (raw::shared(scene, "scene"), raw::place(changed, "changed")) };
    // SAFETY: the same.
    let (name, text) = unsafe { (raw::text(name, "name"), raw::text(text, "text")) };
    change(scene, changed, |scene| in_world_of_text(scene, name?, text?))
}

/// Hands the caller the scene that `work` makes from `scene`.
fn change(
    scene: Result<&ExtricateScene>,
    changed: Result<OutValue<*mut ExtricateScene>>,
    work: impl FnOnce(&Scene) -> Result<Scene>,
) -> ExtricateStatus {
    guarded(|| {
        let (scene, changed) = (scene?, changed?);
        changed.hand_over(ExtricateScene::new(scene.solver.with_scene(work(scene.scene())?)?));
        Ok(())
    })
}

fn in_world_of_text(scene: &Scene, name: &str, text: &str) -> Result<Scene> {
    let path = Path::new(name);
    if !is_foreign(path) {
        return Ok(assemble_world(scene, name, &parse(name, text)?)?);
    }
    let Imported { entries, notes } = import(path, text, Some(scene), &LoadLimits::default())?;
    let notes = notes.into_iter().map(|note| format!("{name}: {note}"));
    Ok(assemble_world(scene, name, &entries)?.with_warnings(notes))
}

#[cfg(test)]
mod tests {
    use extricate::builtin;

    use super::*;

    #[test]
    fn texts_are_worlds() {
        let scene = builtin::scene("planar-arm").unwrap();
        let toml = "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.1 }\npose = { xyz = [0.5, 0, 0] }";
        let ball = in_world_of_text(&scene, "w.toml", toml).unwrap();
        let json = r#"{"world": {"collision_objects": [{"id": "ball", "header": {"frame_id": "world"},
            "pose": {"position": {"x": 0.5, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}},
            "primitives": [{"type": 2, "dimensions": [0.1]}],
            "primitive_poses": [{"position": {"x": 0, "y": 0, "z": 0}, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}],
            "operation": 0}]}, "object_colors": [{"id": "ball"}]}"#;
        let message = in_world_of_text(&scene, "w.json", json).unwrap();
        assert_eq!(ball.pairs(), message.pairs());
        assert!(message.warnings().iter().any(|warning| warning.starts_with("w.json: colours")));
        assert!(in_world_of_text(&scene, "w.json", "{").unwrap_err().message.starts_with("w.json"));
    }
}

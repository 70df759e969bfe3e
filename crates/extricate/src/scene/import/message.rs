//! Reads world, octomap, attached objects and padding from a `moveit_msgs/PlanningScene` in YAML
//! or JSON.
//! `matrix` reads allowed collisions, `message_objects` the objects.

use std::collections::HashMap;
use std::sync::Arc;

use serde_json::Value;

use super::imported::Imported;
use super::matrix::{OCTOMAP, allowed};
use super::message_objects::{object, operation};
use super::message_pose::MessagePose;
use super::objects::{Object, Objects, Shape};
use super::value::At;
use crate::error::{Error, Result, quoted};
use crate::math::Pose;
use crate::robot::LoadLimits;
use crate::robot::formats::octree::Octree;
use crate::scene::{LinkAttachment, Scene};

/// Fields of a PlanningScene; those that no code here reads do not describe the world.
const SCENE_FIELDS: &[&str] = &[
    "name",
    "robot_state",
    "robot_model_name",
    "fixed_frame_transforms",
    "allowed_collision_matrix",
    "link_padding",
    "link_scale",
    "object_colors",
    "world",
    "is_diff",
];
const WORLD_FIELDS: &[&str] = &["collision_objects", "octomap"];
/// Fields of an AttachedCollisionObject; `detach_posture` and `weight` are ignored.
const ATTACHED_FIELDS: &[&str] = &["link_name", "object", "touch_links", "detach_posture", "weight"];

/// Reads a PlanningSceneWorld or a PlanningScene, which may be the `msg` of rosbridge or the
/// `scene` of a service's answer.
///
/// # Errors
/// [`Error::Input`] that names the field, its value and what was expected.
pub fn read(file: &str, value: &Value, robots: Option<&Scene>, limits: &LoadLimits) -> Result<Imported> {
    let mut scene = At::new(file, "", value);
    for wrapper in ["msg", "values", "scene"] {
        if let Some(inner) = scene.get(wrapper)?.filter(|inner| inner.value.is_object()) {
            scene = inner;
        }
    }
    let world = scene.get("world")?;
    let is_world = scene.get("collision_objects")?.is_some();
    if world.is_none() && !is_world && scene.get("robot_state")?.is_none() {
        return Err(scene.fault("a PlanningScene (with `world`) or a PlanningSceneWorld (with `collision_objects`)"));
    }
    let mut objects = Objects::new(limits);
    if is_world && world.is_none() {
        objects.note_unknown(&scene, WORLD_FIELDS)?;
    } else {
        objects.note_unknown(&scene, SCENE_FIELDS)?;
    }
    if let Some(world) = &world {
        objects.note_unknown(world, WORLD_FIELDS)?;
    }
    let mut frames = Frames { robots, transforms: transforms(&scene)?, world: None };
    let world = world.unwrap_or_else(|| scene.clone());
    for at in world.list("collision_objects")? {
        standing(&at, &mut frames, &mut objects)?;
    }
    if let Some(octomap) = world.get("octomap")? {
        mapped(&octomap, &mut frames, &mut objects)?;
    }
    if let Some(state) = scene.get("robot_state")? {
        for at in state.list("attached_collision_objects")? {
            attached(&at, &frames, robots, &mut objects)?;
        }
        if state.get("joint_state")?.is_some_and(|joints| joints.list("name").is_ok_and(|names| !names.is_empty())) {
            objects.note(
                "robot_state: the positions of joints are no part of a scene: ask with them, as \
                 {\"name\": [..], \"position\": [..]}",
            );
        }
    }
    if let Some(frame) = frames.world.filter(|frame| frame != "world") {
        objects.note(format!("poses are given in the frame `{frame}`, which is taken for the world of the scene"));
    }
    if let Some(matrix) = scene.get("allowed_collision_matrix")? {
        allowed(&matrix, robots, &mut objects)?;
    }
    padding(&scene, robots, &mut objects)?;
    if scene.get("is_diff")?.is_some_and(|diff| diff.value == &Value::Bool(true)) {
        objects.note("is_diff: the message is a difference: what it leaves out is not in the world that was written");
    }
    if !scene.list("object_colors")?.is_empty() {
        objects.note("colours are not taken: a scene has none");
    }
    let (entries, notes) = objects.finish();
    Ok(Imported { entries, notes })
}

/// Frames that the poses of a message may be given in.
pub struct Frames<'a> {
    robots: Option<&'a Scene>,
    /// Poses in the world by name of the frame.
    transforms: HashMap<String, MessagePose>,
    /// Name of the frame that is taken for the world.
    world: Option<String>,
}

impl Frames<'_> {
    /// Returns the pose in the world of the frame that a header names.
    fn pose(&mut self, at: &At) -> Result<MessagePose> {
        let Some(header) = at.get("header")? else { return Ok(MessagePose::IDENTITY) };
        let name = header.text("frame_id")?.trim_start_matches('/');
        let fault = |expected: String| {
            let problem = format!("got the frame `{}`, expected {expected}", quoted(name));
            Err(Error::input(at.file, format!("{}.header.frame_id", at.path), problem))
        };
        if name.is_empty() {
            return Ok(MessagePose::IDENTITY);
        }
        if let Some(seat) = self.robots.and_then(|robots| link(robots, name)) {
            if seat.frame != 0 {
                return fault("one that does not move: where this link is depends on the configuration".into());
            }
            return Ok(pose_of(&seat.pose_frame_link));
        }
        if let Some(pose) = self.transforms.get(name) {
            return Ok(*pose);
        }
        match &self.world {
            Some(world) if world != name => {
                fault(format!("`{}` as before: where one is in the other is not said", quoted(world)))
            }
            _ => {
                self.world = Some(name.to_string());
                Ok(MessagePose::IDENTITY)
            }
        }
    }
}

fn link<'a>(robots: &'a Scene, name: &str) -> Option<&'a LinkAttachment> {
    robots.links.iter().find(|link| link.name == name)
}

fn pose_of(pose: &Pose) -> MessagePose {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.rotation);
    let quaternion = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
    MessagePose { xyz: pose.translation.into(), quaternion: quaternion.coords.into() }
}

fn transforms(scene: &At) -> Result<HashMap<String, MessagePose>> {
    let read = |at: At| {
        let pose = at.get("transform")?.map_or(Ok(MessagePose::IDENTITY), |transform| transform.as_pose())?;
        Ok((at.text("child_frame_id")?.trim_start_matches('/').to_string(), pose))
    };
    // The map keeps the last of one name, which is the first in the message.
    scene.list("fixed_frame_transforms")?.into_iter().rev().map(read).collect()
}

fn standing(at: &At, frames: &mut Frames, objects: &mut Objects) -> Result<()> {
    let named = At { path: format!("collision object {:?}", quoted(at.text("id")?)), ..at.clone() };
    if !operation(&named, objects)? {
        return Ok(());
    }
    let frame = frames.pose(&named)?;
    let object = object(&named, &frame, objects)?;
    objects.stand(at.file, object)
}

fn attached(at: &At, frames: &Frames, robots: Option<&Scene>, objects: &mut Objects) -> Result<()> {
    let inner = at.get("object")?.ok_or_else(|| at.fault("a mapping with `link_name` and `object`"))?;
    let named = At { path: format!("attached object {:?}", quoted(inner.text("id")?)), ..inner };
    objects.note_unknown(&At { path: named.path.clone(), ..at.clone() }, ATTACHED_FIELDS)?;
    if !operation(&named, objects)? {
        return Ok(());
    }
    let holder = at.text("link_name")?;
    if holder.is_empty() {
        return Err(At { path: format!("{}.link_name", named.path), ..at.clone() }.fault("the link that holds it"));
    }
    let frame = match named.get("header")? {
        Some(header) => header.text("frame_id")?.trim_start_matches('/'),
        None => "",
    };
    let seat = |name: &str| frames.robots.and_then(|robots| link(robots, name));
    let pose = match (seat(holder), seat(frame)) {
        _ if frame.is_empty() || frame == holder => MessagePose::IDENTITY,
        (Some(held), Some(given)) if held.frame == given.frame => {
            pose_of(&held.pose_frame_link.inverse().then(&given.pose_frame_link))
        }
        _ => {
            let (frame, holder) = (quoted(frame), quoted(holder));
            let problem = format!("got the frame `{frame}`, expected `{holder}`, the link that holds it");
            return Err(Error::input(named.file, format!("{}.header.frame_id", named.path), problem));
        }
    };
    let mut touch = Vec::new();
    for link_at in at.list("touch_links")? {
        let name = link_at.string()?;
        match robots {
            Some(robots) if link(robots, name).is_none() => {
                objects.note(format!("{}: touch_links: the robot has no link `{name}`", named.path));
            }
            _ if name == holder => {}
            _ => touch.push(name.to_string()),
        }
    }
    let object = object(&named, &pose, objects)?;
    objects.attach(at.file, object, holder, &touch)
}

/// Adds the occupied cells of an `octomap_msgs/OctomapWithPose` as an obstacle with MoveIt's name.
fn mapped(at: &At, frames: &mut Frames, objects: &mut Objects) -> Result<()> {
    let Some(map) = at.get("octomap")? else { return Ok(()) };
    let Some(bytes) = map.get("data")? else { return Ok(()) };
    let data = bytes.bytes()?;
    if data.is_empty() {
        return Ok(());
    }
    let needed = |key: &str| map.get(key)?.ok_or_else(|| map.fault(&format!("a mapping with `{key}`")));
    let is_binary = needed("binary")?.truth()?;
    let tree = Octree { id: map.text("id")?, is_binary, resolution: needed("resolution")?.number()?, data: &data };
    let voxels = tree.voxels(at.file, &map.path, &objects.entries().limits)?;
    if voxels.cells().is_empty() {
        return Ok(());
    }
    let pose = frames.pose(at)?.then(&at.pose("origin")?);
    objects.stand(at.file, Object { name: OCTOMAP.into(), shapes: vec![(Shape::Voxels(Arc::new(voxels)), pose)] })
}

/// Imports the padding of links. A scale is only noted, because links keep their size.
fn padding(scene: &At, robots: Option<&Scene>, objects: &mut Objects) -> Result<()> {
    for at in scene.list("link_padding")? {
        let (name, padding) = (at.text("link_name")?, at.get("padding")?.map_or(Ok(0.0), |padding| padding.number())?);
        if padding < 0.0 {
            objects.note(format!("link_padding of `{name}`: {padding} m is not taken: a link can only grow"));
        } else if padding > 0.0 && robots.is_some_and(|robots| link(robots, name).is_none()) {
            objects.note(format!("link_padding: the robot has no link `{name}`"));
        } else if padding > 0.0 {
            objects.entries().padding.insert(name.into(), padding);
        }
    }
    for at in scene.list("link_scale")? {
        let scale = at.get("scale")?.map_or(Ok(1.0), |scale| scale.number())?;
        if scale != 1.0 {
            objects.note(format!(
                "link_scale of `{}`: {scale} is not taken: links keep their size",
                at.text("link_name")?
            ));
        }
    }
    Ok(())
}

//! Checks frames, joints, links and coordinates.

use super::values::{index, pose, within};
use crate::cspace::{Factor, Manifold};
use crate::math::{FARTHEST, Vec3};
use crate::scene::{Coordinate, Frame, Motion, Scene};

/// Largest deviation of an axis from length 1.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-9;

pub fn check(scene: &Scene) -> Result<(), String> {
    let Scene { joints, space, frames, links, rigid, .. } = scene;
    let mut end = 0;
    for (number, joint) in joints.iter().enumerate() {
        let (q, nq) = (&joint.q, space.nq());
        if q.start != end || q.end <= end || q.end > nq {
            let found = format!("got the coordinates {q:?}, expected some from {end} to {nq}");
            return Err(format!("joint {number} (`{}`): {found}", joint.name));
        }
        end = q.end;
    }
    if end != space.nq() {
        return Err(format!("joints: got {end} coordinates, expected {}", space.nq()));
    }
    match frames.first() {
        Some(Frame { parent: 0, motion: Motion::World, .. }) => {}
        Some(first) => {
            return Err(format!("frame 0: got {:?} below frame {}, expected the world", first.motion, first.parent));
        }
        None => return Err("frame 0: got none, expected the world".into()),
    }
    for (number, frame) in frames.iter().enumerate() {
        check_frame(scene, number, frame).map_err(|problem| format!("frame {number} (`{}`): {problem}", frame.name))?;
    }
    for (number, link) in links.iter().enumerate() {
        let what = format!("link {number} (`{}`)", link.name);
        index(&format!("{what}: frame"), link.frame, frames.len())?;
        pose(&format!("{what}: pose"), &link.pose_frame_link)?;
    }
    let position = |joint: &crate::scene::RigidJoint| {
        within(&format!("joint `{}`: position", joint.name), joint.position, -FARTHEST)
    };
    rigid.iter().try_for_each(position)
}

fn check_frame(scene: &Scene, number: usize, frame: &Frame) -> Result<(), String> {
    pose("pose", &frame.pose_parent_joint)?;
    if number == 0 {
        return Ok(());
    }
    index("parent", frame.parent, number)?;
    match &frame.motion {
        Motion::World => Err("got a second world, expected a joint".into()),
        Motion::Revolute { axis, coordinate } => {
            check_axis(axis)?;
            check_coordinate(scene, coordinate, false)
        }
        Motion::Prismatic { axis, coordinate } => {
            check_axis(axis)?;
            check_coordinate(scene, coordinate, true)
        }
        Motion::Ball { q, v } => {
            let is_meant = |factor: &Factor| factor.q == *q && factor.v == *v && factor.manifold == Manifold::Rotation;
            if scene.space.factors().iter().any(is_meant) {
                return Ok(());
            }
            Err(format!("got a ball of the coordinates {q} and {v}, expected those of a rotation"))
        }
    }
}

fn check_axis(axis: &Vec3) -> Result<(), String> {
    if (axis.norm() - 1.0).abs() < AXIS_LENGTH_TOLERANCE {
        return Ok(());
    }
    Err(format!("axis: got {:?}, expected length 1", axis.as_slice()))
}

/// Checks that a joint's position stays within 1e9 for every value within the coordinate's limits.
fn check_coordinate(scene: &Scene, coordinate: &Coordinate, slides: bool) -> Result<(), String> {
    let Coordinate { q, v, multiplier, offset } = *coordinate;
    let factor = scene.space.factors().iter().find(|factor| factor.q == q && factor.manifold != Manifold::Rotation);
    let Some(factor) = factor else {
        return Err(format!("got the coordinate {q}, expected one of an interval or circle"));
    };
    if factor.v != v {
        return Err(format!("got the tangent coordinate {v}, expected {}", factor.v));
    }
    within("multiplier", multiplier, -FARTHEST)?;
    within("offset", offset, -FARTHEST)?;
    let reach = match factor.manifold {
        Manifold::Interval { lower, upper } if slides => lower.abs().max(upper.abs()),
        _ => 0.0,
    };
    within("farthest position", multiplier.abs() * reach + offset.abs(), 0.0)
}

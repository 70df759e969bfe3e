//! Checks scenes that were read from bytes of a model file or a pickle, which anyone can write, for
//! the invariants of assembled scenes. The first violation is an error; nothing is repaired.
//!
//! In a scene that passes, every index is valid, and every number and pose is finite at every
//! configuration.

mod bodies;
mod kinematic_tree;
mod values;

#[cfg(feature = "model-files")]
use crate::error::{self, Error};
use crate::scene::Scene;

/// Checks that the scene has the invariants of an assembled one.
///
/// # Errors
/// Names the element, its value and what was expected.
pub fn check(scene: &Scene) -> Result<(), String> {
    scene.space.check()?;
    kinematic_tree::check(scene)?;
    bodies::check(scene)
}

#[cfg(feature = "model-files")]
impl Scene {
    /// Serialises the scene for other processes of the same version.
    pub fn to_bytes(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("a scene has nothing that cannot be written")
    }

    /// Deserialises and checks a scene that [`Scene::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`Error::Input`] for bytes that are no valid scene of this version.
    pub fn from_bytes(bytes: &[u8]) -> error::Result<Self> {
        let wrong = |problem: String| {
            Error::input("scene", "bytes", format!("got bytes that are no scene of this version ({problem})"))
        };
        let scene: Self = postcard::from_bytes(bytes).map_err(|error| wrong(error.to_string()))?;
        check(&scene).map_err(wrong)?;
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Geometry;
    use crate::scene::{BodyPair, Motion, RigidJoint, builtin};

    #[test]
    fn built_in_scenes_are_sound() {
        for name in builtin::NAMES {
            assert_eq!(check(&builtin::scene(name).unwrap()), Ok(()), "{name}");
        }
    }

    #[test]
    fn what_no_scene_has_is_refused_by_name() {
        type Spoil = fn(&mut Scene);
        let spoils: [(Spoil, &str); 24] = [
            (|s| s.clearance = f64::NAN, "clearance: got NaN"),
            (|s| s.clearance = -1.0, "clearance: got -1.0"),
            (|s| s.clearances.own = Some(f64::INFINITY), "clearances: own: got inf"),
            (|s| s.clearances.padding.push(("link_1".into(), -1.0)), "clearances: padding of `link_1`: got -1.0"),
            (|s| s.joints[1].q = 1..9, "joint 1 (`joint_2`): got the coordinates 1..9, expected some from 1 to 3"),
            (|s| s.joints.truncate(1), "joints: got 1 coordinates, expected 3"),
            (|s| s.frames.clear(), "frame 0"),
            (|s| s.frames[2].parent = 2, "frame 2 (`joint_2`): parent: got 2, expected an index below 2"),
            (|s| s.frames[1].motion = Motion::World, "frame 1 (`joint_1`): got a second world"),
            (|s| s.frames[1].motion = Motion::Ball { q: 0, v: 0 }, "frame 1 (`joint_1`): got a ball"),
            (|s| s.frames[1].pose_parent_joint.rotation[(0, 0)] = 1.1, "frame 1 (`joint_1`): pose: got the columns"),
            (|s| s.frames[1].pose_parent_joint.translation.y = 1e13, "frame 1 (`joint_1`): pose: got 10000000000000.0"),
            (|s| revolute(s, |axis, _| axis.z = 0.9), "axis: got [0.0, 0.0, 0.9], expected length 1"),
            (|s| revolute(s, |_, at| at.q = 7), "got the coordinate 7"),
            (|s| revolute(s, |_, at| at.v = 2), "got the tangent coordinate 2, expected 0"),
            (|s| revolute(s, |_, at| at.multiplier = f64::INFINITY), "multiplier: got inf"),
            (|s| revolute(s, |_, at| at.offset = f64::NAN), "offset: got NaN"),
            (|s| s.bodies[0].frame = 9, "body 0 (`link_1`): frame: got 9, expected an index below 4"),
            (|s| s.bodies[1].name = "link_1".into(), "body 1 (`link_1`): got a name that another body has"),
            (
                |s| s.bodies[0].parts[1].geometry = Geometry::Sphere { radius: 0.0 },
                "body 0 (`link_1`): part 1: got 0.0",
            ),
            (|s| s.pairs[0] = BodyPair { first: 3, second: 3 }, "pair 0: got 3 and 3"),
            (|s| s.pairs[0].second = usize::MAX, "pair 0: got 0 and 18446744073709551615"),
            (|s| s.links[0].frame = 7, "link 0 (`base`): frame: got 7"),
            (|s| s.rigid.push(RigidJoint { name: "r".into(), kind: "fixed".into(), position: f64::NAN }), "position"),
        ];
        for (spoil, expected) in spoils {
            let mut scene = builtin::scene("planar-arm").unwrap();
            spoil(&mut scene);
            let message = check(&scene).err().unwrap_or_default();
            assert!(message.contains(expected), "{expected}: {message}");
        }
    }

    fn revolute(scene: &mut Scene, spoil: fn(&mut crate::math::Vec3, &mut crate::scene::Coordinate)) {
        if let Motion::Revolute { axis, coordinate } = &mut scene.frames[1].motion {
            spoil(axis, coordinate);
        }
    }
}

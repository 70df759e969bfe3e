//! Converts between configurations and positions by joint name, as ROS messages have them.

use super::names::unknown;
use super::{Motion, Scene};
use crate::error::{Error, Result};
use crate::math::wrap_angle;

/// Largest difference [rad or m] between the position of a joint without coordinates and the
/// scene's position that goes unreported, because encoders have noise.
const POSITION_TOLERANCE: f64 = 1e-3;

/// Name that error messages give in place of a file.
const FILE: &str = "positions";

/// Coordinates that were read from positions by name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedConfig {
    /// The `nq` coordinates in the order of the scene; they may be beyond limits or not finite.
    pub values: Vec<f64>,
    /// Names of locked, mimic and fixed joints whose position is not the scene's, and a message for
    /// each.
    pub differing: Vec<(String, String)>,
}

impl Scene {
    /// Reads a configuration from positions by joint name \[rad or m; as many as the joint has
    /// coordinates\]. Joints that are locked, fixed or follow another may be among them;
    /// [`NamedConfig::differing`] lists those whose position is not the scene's.
    ///
    /// # Errors
    /// [`Error::Input`] for a name that is unknown or occurs twice, a moving joint without a
    /// position, and a wrong number of positions.
    pub fn config_of<'a>(&self, positions: impl IntoIterator<Item = (&'a str, &'a [f64])>) -> Result<NamedConfig> {
        let mut values = vec![f64::NAN; self.space.nq()];
        let mut seen = vec![false; self.joints.len()];
        let mut others: Vec<(&str, f64)> = Vec::new();
        for (name, found) in positions {
            let count = |expected: usize| match found.len() == expected {
                true => Ok(()),
                false => {
                    let problem = format!("got {} numbers, expected {expected}", found.len());
                    Err(Error::input(FILE, format!("`{name}`"), problem))
                }
            };
            let twice = || Error::input(FILE, format!("`{name}`"), "it occurs twice, expected every joint once");
            if let Some(joint) = self.joints.iter().position(|joint| joint.name == name) {
                let coordinates = self.joints[joint].q.clone();
                count(coordinates.len())?;
                if std::mem::replace(&mut seen[joint], true) {
                    return Err(twice());
                }
                values[coordinates].copy_from_slice(found);
            } else if follower(self, name).is_some() || self.rigid.iter().any(|joint| joint.name == name) {
                count(1)?;
                if others.iter().any(|(other, _)| *other == name) {
                    return Err(twice());
                }
                others.push((name, found[0]));
            } else {
                let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
                return Err(Error::input(FILE, "name", unknown(name, &names)));
            }
        }
        let missing = self.joints.iter().zip(&seen).filter(|(_, seen)| !**seen);
        let missing: Vec<String> = missing.map(|(joint, _)| format!("`{}`", joint.name)).collect();
        if !missing.is_empty() {
            let problem = format!("got none for {}, expected one for each joint that moves", missing.join(", "));
            return Err(Error::input(FILE, "joints", problem));
        }
        let differing = others.into_iter().filter_map(|(name, found)| difference(self, name, found, &values)).collect();
        Ok(NamedConfig { values, differing })
    }

    /// Returns the positions at `q` \[rad or m\] of all joints that are not fixed: first those with
    /// coordinates, in order, then those that follow them, then locked ones.
    pub fn positions_at(&self, q: &[f64]) -> Vec<(String, Vec<f64>)> {
        let moving = self.joints.iter().map(|joint| (joint.name.clone(), q[joint.q.clone()].to_vec()));
        let following = self.frames.iter().filter(|frame| !self.joints.iter().any(|joint| joint.name == frame.name));
        let following = following.filter_map(|frame| Some((frame.name.clone(), vec![position(&frame.motion, q)?])));
        let locked = self.rigid.iter().filter(|joint| joint.kind != "fixed");
        moving.chain(following).chain(locked.map(|joint| (joint.name.clone(), vec![joint.position]))).collect()
    }
}

/// Returns the motion of a joint that follows another one; `None` for a name without a frame.
fn follower<'a>(scene: &'a Scene, name: &str) -> Option<&'a Motion> {
    let frame = scene.frames.iter().find(|frame| frame.name == name && frame.motion != Motion::World)?;
    Some(&frame.motion)
}

fn position(motion: &Motion, q: &[f64]) -> Option<f64> {
    match motion {
        Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } => {
            Some(coordinate.multiplier * q[coordinate.q] + coordinate.offset)
        }
        Motion::World | Motion::Ball { .. } => None,
    }
}

/// Returns name and message for a joint without coordinates whose position is not the scene's.
fn difference(scene: &Scene, name: &str, found: f64, q: &[f64]) -> Option<(String, String)> {
    let (expected, why, turns) = match follower(scene, name) {
        Some(motion) => (position(motion, q)?, "follows another joint", matches!(motion, Motion::Revolute { .. })),
        None => {
            let joint = scene.rigid.iter().find(|joint| joint.name == name)?;
            let why = if joint.kind == "fixed" { "is fixed" } else { "is locked" };
            (joint.position, why, joint.kind == "continuous")
        }
    };
    let off = if turns { wrap_angle(found - expected) } else { found - expected };
    // The comparison is false for NaN, so that a NaN is reported, too.
    let is_same = off.abs() <= POSITION_TOLERANCE;
    let text = || format!("joint `{name}` {why}: got {found}, the scene has it at {expected}");
    (!is_same).then(|| (name.to_string(), text()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::JointKind::*;
    use crate::scene::testing::{PLAIN, chain, following, joint, robot, scene};

    fn hand() -> Scene {
        let joints = vec![
            joint("wrist", Revolute, 0, 1),
            joint("finger", Prismatic, 1, 2),
            following(joint("thumb", Prismatic, 1, 3), 1, -1.0, 0.5),
            joint("lid", Continuous, 0, 4),
            joint("bolt", Fixed, 0, 5),
        ];
        scene(&format!("{PLAIN}locked = {{ lid = 0.25 }}"), &[robot(joints)]).unwrap()
    }

    fn read(scene: &Scene, positions: &[(&str, f64)]) -> Result<NamedConfig> {
        scene.config_of(positions.iter().map(|(name, position)| (*name, std::slice::from_ref(position))))
    }

    #[test]
    fn all_that_a_robot_reports_is_read_and_given_back() {
        let scene = hand();
        let reported =
            [("thumb", 0.3), ("bolt", 0.0), ("finger", 0.2), ("lid", 0.25 - std::f64::consts::TAU), ("wrist", -1.0)];
        let read = read(&scene, &reported).unwrap();
        assert_eq!(read, NamedConfig { values: vec![-1.0, 0.2], differing: vec![] });
        let back = scene.positions_at(&read.values);
        let expected = [("wrist", -1.0), ("finger", 0.2), ("thumb", 0.3), ("lid", 0.25)];
        assert_eq!(back, expected.map(|(name, x)| (name.to_string(), vec![x])));
        let again = scene.config_of(back.iter().map(|(name, x)| (name.as_str(), x.as_slice()))).unwrap();
        assert_eq!(again, read);
    }

    #[test]
    fn joints_that_stand_elsewhere_are_told() {
        let scene = hand();
        let reported = [("wrist", 0.0), ("finger", 0.2), ("thumb", 0.31), ("lid", 0.5), ("bolt", 1.0)];
        let told: Vec<String> = read(&scene, &reported).unwrap().differing.into_iter().map(|(_, text)| text).collect();
        assert_eq!(
            told,
            [
                "joint `thumb` follows another joint: got 0.31, the scene has it at 0.3",
                "joint `lid` is locked: got 0.5, the scene has it at 0.25",
                "joint `bolt` is fixed: got 1, the scene has it at 0",
            ]
        );
    }

    #[test]
    fn faults_name_the_joint_and_what_was_expected() {
        let scene = hand();
        let message = |positions: &[(&str, f64)]| read(&scene, positions).unwrap_err().to_string();
        assert_eq!(message(&[("elbow", 0.0)]), "positions: name: got `elbow`, expected one of `wrist`, `finger`");
        assert_eq!(
            message(&[("lid", 0.0)]),
            "positions: joints: got none for `wrist`, `finger`, expected one for each joint that moves"
        );
        assert!(message(&[("wrist", 0.0), ("wrist", 0.0)]).contains("`wrist`: it occurs twice"));
        assert!(message(&[("lid", 0.0), ("lid", 0.0)]).contains("`lid`: it occurs twice"));
        let two = [0.0; 2];
        let message = scene.config_of([("wrist", &two[..])]).unwrap_err().to_string();
        assert_eq!(message, "positions: `wrist`: got 2 numbers, expected 1");
        let base = "base = 'planar'\nbounds = { min = [-1, -1], max = [1, 1] }";
        let moving = crate::scene::testing::scene(&format!("{PLAIN}{base}"), &[chain(&[Revolute])]).unwrap();
        let named = moving.positions_at(&[0.1, 0.2, 0.3, 0.4]);
        assert_eq!(named, [("base".to_string(), vec![0.1, 0.2, 0.3]), ("j0".into(), vec![0.4])]);
    }
}

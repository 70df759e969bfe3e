//! Decides the role of each joint in a scene: rigid, follower of another, or with coordinates.

use std::f64::consts::PI;

use super::loaded::LoadedRobot;
use crate::cspace::{LIMIT_TOLERANCE, Manifold};
use crate::error::{Error, Result};
use crate::math::wrap_angle;
use crate::robot::{Joint, JointKind};
use crate::scene::file::limits::{LimitsEntry, interval};
use crate::scene::names;

/// The role of a joint in a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum JointRole {
    /// The joint stays at this position \[rad or m\]; 0 for fixed joints and those with several
    /// coordinates.
    Locked(f64),
    /// The position is `multiplier * position(joint) + offset`; `joint` has a coordinate.
    Mimic {
        /// Index of the joint that it follows.
        joint: usize,
        /// Factor of that joint's position.
        multiplier: f64,
        /// Offset of the position \[rad or m\].
        offset: f64,
    },
    /// The joint has coordinates on these manifolds; [`factor_suffixes`] has their order.
    Active(Vec<Manifold>),
}

/// Returns the suffixes of the names of a joint's factors: translations first, then the rotation.
pub fn factor_suffixes(kind: JointKind) -> &'static [&'static str] {
    match kind {
        JointKind::Planar => &[".x", ".y", ".yaw"],
        JointKind::Floating => &[".x", ".y", ".z", ".rotation"],
        _ => &[""],
    }
}

/// Returns the role of every joint, in document order.
///
/// A joint that is both locked and a follower is locked. If a follower of a continuous joint does
/// not return to its place after one revolution, the scene differs on both sides of the seam. The
/// joint then gets the interval `[-pi, pi]` instead of a circle. Translations without limits are
/// bounded by `reach` \[m\], with a warning.
///
/// # Errors
/// [`Error::Input`] for unknown or fixed joints in `locked` and `limits`, values outside limits,
/// missing limits, and followers in a circle or of a joint with several coordinates.
pub fn roles(file: &str, loaded: &LoadedRobot, reach: f64, warnings: &mut Vec<String>) -> Result<Vec<JointRole>> {
    let robot = &loaded.robot;
    let known: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
    let named = loaded.entry.locked.keys().map(|name| ("locked", name));
    for (table, name) in named.chain(loaded.entry.limits.keys().map(|name| ("limits", name))) {
        let Some(joint) = robot.joints.iter().find(|joint| &joint.name == name) else {
            return Err(Error::input(file, loaded.element(table), names::unknown(name, &known)));
        };
        if joint.kind == JointKind::Fixed {
            return Err(Error::input(file, loaded.element(table), format!("joint `{name}` is fixed in the URDF")));
        }
    }
    let mut roles = Vec::with_capacity(robot.joints.len());
    for index in 0..robot.joints.len() {
        roles.push(role(file, loaded, index, 0)?);
    }
    for (joint, role) in robot.joints.iter().zip(&mut roles) {
        if matches!(role, JointRole::Active(_)) {
            *role = JointRole::Active(manifolds(file, loaded, joint, reach, warnings)?);
        }
    }
    cut_circles(loaded, &mut roles, warnings);
    Ok(roles)
}

/// Returns the role of one joint, with empty manifolds. `depth` counts the followers that led here.
fn role(file: &str, loaded: &LoadedRobot, index: usize, depth: usize) -> Result<JointRole> {
    let robot = &loaded.robot;
    let joint = &robot.joints[index];
    if joint.kind == JointKind::Fixed {
        return Ok(JointRole::Locked(0.0));
    }
    if let Some(&value) = loaded.entry.locked.get(&joint.name) {
        return Ok(JointRole::Locked(locked_value(file, loaded, joint, value)?));
    }
    if let Some(mimic) = joint.mimic {
        let leader = &robot.joints[mimic.joint];
        let fault = |problem: String| Error::input(&loaded.urdf, format!("joint \"{}\": mimic", joint.name), problem);
        if depth > robot.joints.len() {
            return Err(fault(format!("joints follow each other in a circle through `{}`", leader.name)));
        }
        for end in [joint, leader] {
            if !(is_single(end.kind) || end.kind == JointKind::Fixed) {
                return Err(fault(format!("`{}` has several coordinates, expected a joint with one", end.name)));
            }
        }
        let (multiplier, offset) = (mimic.multiplier, mimic.offset);
        return Ok(match role(file, loaded, mimic.joint, depth + 1)? {
            JointRole::Locked(position) => JointRole::Locked(multiplier * position + offset),
            JointRole::Mimic { joint, multiplier: inner, offset: shift } => {
                JointRole::Mimic { joint, multiplier: multiplier * inner, offset: multiplier * shift + offset }
            }
            JointRole::Active(_) => JointRole::Mimic { joint: mimic.joint, multiplier, offset },
        });
    }
    if loaded.group.as_ref().is_some_and(|group| !group.contains(&index)) {
        let rest = match limits(file, loaded, joint)? {
            Some((lower, upper)) if is_single(joint.kind) => 0f64.clamp(lower, upper),
            _ => 0.0,
        };
        return Ok(JointRole::Locked(rest));
    }
    Ok(JointRole::Active(Vec::new()))
}

fn is_single(kind: JointKind) -> bool {
    matches!(kind, JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic)
}

fn locked_value(file: &str, loaded: &LoadedRobot, joint: &Joint, value: f64) -> Result<f64> {
    let fault = |problem: String| Err(Error::input(file, loaded.element("locked"), problem));
    if !is_single(joint.kind) {
        return fault(format!("joint `{}` has several coordinates, expected a joint with one", joint.name));
    }
    if !value.is_finite() {
        return fault(format!("`{}`: got {value}, expected a finite number", joint.name));
    }
    match limits(file, loaded, joint)? {
        Some((lower, upper)) if value < lower - LIMIT_TOLERANCE || value > upper + LIMIT_TOLERANCE => {
            fault(format!("`{}`: got {value}, expected a value within its limits [{lower}, {upper}]", joint.name))
        }
        Some((lower, upper)) => Ok(value.clamp(lower, upper)),
        None if joint.kind == JointKind::Continuous => Ok(wrap_angle(value)),
        None => Ok(value),
    }
}

/// Returns the limits of a joint with one coordinate, or of each translation of one with several.
/// Limits of the scene replace those of the URDF.
fn limits(file: &str, loaded: &LoadedRobot, joint: &Joint) -> Result<Option<(f64, f64)>> {
    let what = limits_element(loaded, joint);
    match loaded.entry.limits.get(&joint.name) {
        Some(LimitsEntry::Interval([lower, upper])) => interval(file, &what, *lower, *upper).map(Some),
        Some(LimitsEntry::Bounds(bounds)) if is_single(joint.kind) => {
            bounds.intervals(file, &what, &[1]).map(|all| Some(all[0]))
        }
        Some(LimitsEntry::Bounds(_)) => Ok(None),
        None if joint.kind == JointKind::Continuous => Ok(None),
        None => match joint.limits {
            Some((lower, upper)) => {
                interval(&loaded.urdf, &format!("joint \"{}\": limit", joint.name), lower, upper).map(Some)
            }
            None => Ok(None),
        },
    }
}

fn limits_element(loaded: &LoadedRobot, joint: &Joint) -> String {
    format!("{} `{}`", loaded.element("limits"), joint.name)
}

fn manifolds(
    file: &str,
    loaded: &LoadedRobot,
    joint: &Joint,
    reach: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Manifold>> {
    let of = |(lower, upper)| Manifold::Interval { lower, upper };
    let name = &joint.name;
    let (translations, turn, counts): (usize, Manifold, &[usize]) = match joint.kind {
        JointKind::Fixed => return Ok(Vec::new()),
        JointKind::Revolute | JointKind::Prismatic => {
            let missing = || {
                let problem = format!(
                    "got no limits, expected <limit> with `lower` and `upper`, or `limits = {{ {name} = [lower, upper] }}` \
                     in its [[robot]] of the scene"
                );
                Error::input(&loaded.urdf, format!("joint \"{name}\""), problem)
            };
            return Ok(vec![of(limits(file, loaded, joint)?.ok_or_else(missing)?)]);
        }
        JointKind::Continuous => return Ok(vec![limits(file, loaded, joint)?.map_or(Manifold::Circle, of)]),
        JointKind::Spherical => {
            if loaded.entry.limits.contains_key(name) {
                let what = limits_element(loaded, joint);
                return Err(Error::input(file, what, "a spherical joint has no coordinate that limits could bound"));
            }
            return Ok(vec![Manifold::Rotation]);
        }
        JointKind::Planar => (2, Manifold::Circle, &[2, 3]),
        JointKind::Floating => (3, Manifold::Rotation, &[3]),
    };
    if let Some(LimitsEntry::Bounds(bounds)) = loaded.entry.limits.get(name) {
        let mut all: Vec<Manifold> =
            bounds.intervals(file, &limits_element(loaded, joint), counts)?.into_iter().map(of).collect();
        if all.len() == translations {
            all.push(turn);
        }
        return Ok(all);
    }
    let each = match limits(file, loaded, joint)? {
        Some(each) => each,
        None => {
            let [min, max] = [-reach, reach].map(|x| vec![x.to_string(); translations].join(", "));
            warnings.push(format!(
                "joint `{name}` of robot `{}` has no limits: every translation is taken within {reach} m of 0; set them \
                 with `limits = {{ {name} = {{ min = [{min}], max = [{max}] }} }}` in its [[robot]]",
                loaded.name
            ));
            (-reach, reach)
        }
    };
    let mut all = vec![of(each); translations];
    all.push(turn);
    Ok(all)
}

/// Replaces circles by intervals if a follower does not return to its place after one revolution.
fn cut_circles(loaded: &LoadedRobot, roles: &mut [JointRole], warnings: &mut Vec<String>) {
    for (index, joint) in loaded.robot.joints.iter().enumerate() {
        let JointRole::Mimic { joint: leader, multiplier, .. } = roles[index] else { continue };
        let returns = joint.kind != JointKind::Prismatic && multiplier.fract() == 0.0;
        if !returns && roles[leader] == JointRole::Active(vec![Manifold::Circle]) {
            roles[leader] = JointRole::Active(vec![Manifold::Interval { lower: -PI, upper: PI }]);
            warnings.push(format!(
                "joint `{}` of robot `{}` is continuous, but `{}` follows it with factor {multiplier}: its angle is taken \
                 within [-pi, pi] and does not wrap",
                loaded.robot.joints[leader].name, loaded.name, joint.name
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::forward;
    use crate::math::Vec3;
    use crate::scene::testing::{PLAIN, chain, following, joint, robot, scene, scene_with};
    use crate::scene::{Motion, Scene};

    use JointKind::*;

    fn message(text: &str, robots: &crate::robot::Robot) -> String {
        scene(&format!("{PLAIN}{text}"), std::slice::from_ref(robots)).unwrap_err().to_string()
    }

    fn names(scene: &Scene) -> Vec<&str> {
        scene.joints.iter().map(|joint| joint.name.as_str()).collect()
    }

    #[test]
    fn locked_joints_fold_into_their_parent() {
        let arm = chain(&[Revolute, Prismatic, Continuous, Revolute]);
        let scene = scene(&format!("{PLAIN}locked = {{ j1 = 0.5, j2 = 7.0 }}"), &[arm]).unwrap();
        assert_eq!(names(&scene), ["j0", "j3"]);
        assert_eq!(scene.frames.len(), 3);
        let mut poses = Vec::new();
        forward(&scene, &[0.0, 0.0], &mut poses);
        let expected = Vec3::new(3.0 + 7f64.cos(), 7f64.sin(), 0.5);
        assert!((poses[2].translation - expected).norm() < 1e-12, "{}", poses[2].translation);
        let l2 = &scene.bodies[2];
        assert_eq!((l2.name.as_str(), l2.frame), ("l2", 1));
        assert_eq!(l2.parts[0].pose_frame_part.translation, Vec3::new(1.0, 0.0, 0.5));
    }

    #[test]
    fn faults_of_locked_and_limits_name_all() {
        let arm = chain(&[Revolute, Fixed, Planar, Spherical]);
        assert!(message("locked = { j9 = 0 }", &arm).contains("robot \"arm\": locked: got `j9`, expected one of `j0`"));
        assert!(
            message("locked = { j0 = 1.5 }", &arm)
                .contains("`j0`: got 1.5, expected a value within its limits [-1, 1]")
        );
        assert!(message("locked = { j0 = inf }", &arm).contains("finite"));
        assert!(message("locked = { j1 = 0 }", &arm).contains("fixed in the URDF"));
        assert!(message("locked = { j2 = 0 }", &arm).contains("several coordinates"));
        assert!(message("limits = { j9 = [0, 1] }", &arm).contains("limits: got `j9`"));
        assert!(message("limits = { j0 = [1, 0] }", &arm).contains("limits `j0`: got [1.0, 0.0]"));
        assert!(message("limits = { j3 = [0, 1] }", &arm).contains("spherical"));
        assert!(message("limits = { j2 = { min = [0], max = [1] } }", &arm).contains("expected 2 or 3 each"));
        let mut bare = chain(&[Revolute]);
        bare.joints[0].limits = None;
        assert!(message("", &bare).contains("arm.urdf: joint \"j0\": got no limits, expected"));
        let given = format!("{PLAIN}limits = {{ j0 = [0, 1] }}");
        assert!(scene(&given, &[bare]).is_ok(), "the scene's limits stand in for those that the URDF lacks");
    }

    #[test]
    fn scene_limits_replace_those_of_the_urdf() {
        let text =
            format!("{PLAIN}limits = {{ j0 = [-0.5, 3], j1 = [0, 1], j2 = {{ min = [0, 1, 2], max = [3, 4, 5] }} }}");
        let scene = scene(&text, &[chain(&[Revolute, Continuous, Planar])]).unwrap();
        let intervals: Vec<_> = scene.space.factors().iter().map(|factor| factor.manifold).collect();
        let expected = [(-0.5, 3.0), (0.0, 1.0), (0.0, 3.0), (1.0, 4.0), (2.0, 5.0)];
        assert_eq!(intervals, expected.map(|(lower, upper)| Manifold::Interval { lower, upper }));
        assert!(scene.warnings.is_empty());
    }

    #[test]
    fn unlimited_translations_let_bodies_leave_and_say_so() {
        let scene = scene(PLAIN, &[chain(&[Floating, Planar])]).unwrap();
        assert_eq!(scene.warnings.len(), 2);
        assert!(scene.warnings[0].contains("`limits = { j0 = { min = [-4.6, -4.6, -4.6], max = [4.6, 4.6, 4.6] } }`"));
        assert!(matches!(scene.space.factors()[0].manifold, Manifold::Interval { lower: -4.6, upper: 4.6 }));
        assert_eq!(scene.space.nq(), 7 + 3);
    }

    #[test]
    fn followers_take_the_coordinate_of_the_joint_that_moves() {
        let joints = vec![
            joint("j0", Revolute, 0, 1),
            following(joint("j1", Prismatic, 1, 2), 2, 3.0, 0.25),
            following(joint("j2", Revolute, 2, 3), 0, -2.0, 0.5),
        ];
        let scene = scene(PLAIN, &[robot(joints)]).unwrap();
        assert_eq!(names(&scene), ["j0"]);
        let Motion::Prismatic { coordinate, .. } = scene.frames[2].motion else { panic!() };
        assert_eq!((coordinate.q, coordinate.multiplier, coordinate.offset), (0, -6.0, 1.75));
        let mut poses = Vec::new();
        forward(&scene, &[0.1], &mut poses);
        assert!((poses[3].translation.z - (-6.0 * 0.1 + 1.75)).abs() < 1e-12);
    }

    #[test]
    fn followers_of_locked_joints_are_rigid() {
        let joints = vec![
            joint("j0", Revolute, 0, 1),
            following(joint("j1", Prismatic, 1, 2), 0, 2.0, 0.1),
            joint("j2", Revolute, 2, 3),
        ];
        let locked = scene(&format!("{PLAIN}locked = {{ j0 = 0.2 }}"), &[robot(joints.clone())]).unwrap();
        assert_eq!((names(&locked), locked.bodies[2].frame), (vec!["j2"], 0));
        assert!((locked.bodies[2].parts[0].pose_frame_part.translation.z - 0.5).abs() < 1e-12);
        let own = scene(&format!("{PLAIN}locked = {{ j1 = 0.7 }}"), &[robot(joints)]).unwrap();
        assert_eq!(names(&own), ["j0", "j2"]);
        assert!((own.bodies[2].parts[0].pose_frame_part.translation.z - 0.7).abs() < 1e-12);
    }

    #[test]
    fn bad_followers_are_refused() {
        let a = following(joint("j0", Revolute, 0, 1), 1, 1.0, 0.0);
        let b = following(joint("j1", Revolute, 1, 2), 0, 1.0, 0.0);
        assert!(message("", &robot(vec![a, b])).contains("in a circle"));
        let planar = joint("j0", Planar, 0, 1);
        let follower = following(joint("j1", Revolute, 1, 2), 0, 1.0, 0.0);
        assert!(message("", &robot(vec![planar, follower])).contains("`j0` has several coordinates"));
    }

    #[test]
    fn circles_are_cut_where_followers_do_not_return() {
        let with = |kind, multiplier| {
            let joints = vec![joint("j0", Continuous, 0, 1), following(joint("j1", kind, 1, 2), 0, multiplier, 0.0)];
            scene(PLAIN, &[robot(joints)]).unwrap()
        };
        assert_eq!(with(Continuous, -2.0).space.factors()[0].manifold, Manifold::Circle);
        for cut in [with(Revolute, 0.5), with(Prismatic, 1.0)] {
            assert_eq!(cut.space.factors()[0].manifold, Manifold::Interval { lower: -PI, upper: PI });
            assert!(cut.warnings[0].contains("`j0`") && cut.warnings[0].contains("`j1`"));
        }
    }

    #[test]
    fn joints_outside_the_group_stand_nearest_to_zero() {
        let mut arm = chain(&[Revolute, Prismatic, Revolute, Planar]);
        arm.joints[1].limits = Some((0.2, 0.4));
        let text = format!("{PLAIN}locked = {{ j2 = 0.3 }}");
        let scene = scene_with(&text, &[arm], &[], Some(vec![0, 2])).unwrap();
        assert_eq!(names(&scene), ["j0"]);
        assert!((scene.bodies[2].parts[0].pose_frame_part.translation - Vec3::new(1.0, 0.0, 0.2)).norm() < 1e-12);
    }
}

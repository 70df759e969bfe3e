//! Assigns the coordinates of a scene to joints and bases, with order, names and weights.

use super::frames::{FactorStart, Mover};
use super::joint_roles::{JointRole, factor_suffixes, roles};
use super::loaded::LoadedRobot;
use super::workspace_radius::reach;
use crate::cspace::{ConfigSpace, Manifold, WEIGHTS};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::robot::JointKind;
use crate::scene::file::{BaseKind, MetricEntry, WeightEntry};
use crate::scene::names::{NameIndex, Named, unique};
use crate::scene::{Body, MetricKind, RigidJoint, SceneJoint};

/// The coordinates of a whole scene, as [`coordinates`] returns them.
#[derive(Debug, Clone)]
pub struct Coordinates {
    /// For each robot the base, if it moves, then the joints in document order.
    pub joints: Vec<SceneJoint>,
    /// The space that the joints span.
    pub space: ConfigSpace,
    /// Joints that do not move.
    pub rigid: Vec<RigidJoint>,
    /// Coordinates of each robot.
    pub robots: Vec<RobotCoordinates>,
}

/// The coordinates of one robot; all vectors are by joint in document order.
#[derive(Debug, Clone)]
pub struct RobotCoordinates {
    /// The base if it moves.
    pub base: Option<Base>,
    /// Role of each joint.
    pub roles: Vec<JointRole>,
    /// Name of each joint, unique in the scene.
    pub names: Vec<String>,
    /// Places of each joint's factors; empty for joints without coordinates.
    pub places: Vec<Vec<FactorStart>>,
}

/// A base that moves.
#[derive(Debug, Clone)]
pub struct Base {
    /// Name, unique in the scene.
    pub name: String,
    /// Kind of the joint, planar or floating.
    pub kind: JointKind,
    /// Places of its factors in the configuration space.
    pub places: Vec<FactorStart>,
}

impl Base {
    /// Returns the base as a joint; a planar one moves in the x-y plane of its pose.
    pub fn mover(&self) -> Mover<'_> {
        let Base { name, kind, places } = self;
        Mover { name, kind: *kind, axis: Vec3::z(), places, multiplier: 1.0, offset: 0.0 }
    }
}

/// A base or joint before it has coordinates.
struct Candidate<'a> {
    named: Named<'a>,
    kind: JointKind,
    /// Manifolds of its factors; empty if it has no coordinates.
    manifolds: Vec<Manifold>,
    robot: usize,
    /// Index of the joint; `None` for the base.
    joint: Option<usize>,
}

/// Finds every coordinate of the scene.
///
/// # Errors
/// [`Error::Input`] for all that [`roles`] refuses, missing or bad bounds of a base, weights of
/// unknown joints or outside 1e-9 to 1e9, and scenes in which nothing moves.
pub fn coordinates(
    file: &str,
    metric: &MetricEntry,
    robots: &[LoadedRobot],
    obstacles: &[Body],
    warnings: &mut Vec<String>,
) -> Result<Coordinates> {
    let reach = reach(robots, obstacles);
    let mut candidates = Vec::new();
    let mut found = Vec::new();
    for (index, loaded) in robots.iter().enumerate() {
        let base = base(file, loaded, warnings)?;
        let roles = roles(file, loaded, reach, warnings)?;
        candidates.extend(base.map(|(name, kind, manifolds)| Candidate {
            named: Named { robot: Some(&loaded.name), name },
            kind,
            manifolds,
            robot: index,
            joint: None,
        }));
        for (number, (joint, role)) in loaded.robot.joints.iter().zip(&roles).enumerate() {
            let named = Named { robot: Some(&loaded.name), name: &joint.name };
            let manifolds = if let JointRole::Active(manifolds) = role { manifolds.clone() } else { Vec::new() };
            candidates.push(Candidate { named, kind: joint.kind, manifolds, robot: index, joint: Some(number) });
        }
        let places = vec![Vec::new(); roles.len()];
        found.push(RobotCoordinates { base: None, roles, names: Vec::new(), places });
    }
    let names = unique(&candidates.iter().map(|candidate| candidate.named).collect::<Vec<_>>());
    let weights = weights(file, metric, &candidates, warnings)?;
    let (mut joints, mut rigid, mut space) = (Vec::new(), Vec::new(), ConfigSpace::default());
    for ((candidate, name), weights) in candidates.iter().zip(&names).zip(weights) {
        let first = space.nq();
        let factors = candidate.manifolds.iter().zip(factor_suffixes(candidate.kind)).zip(weights);
        let places: Vec<FactorStart> = factors
            .map(|((&manifold, suffix), weight)| space.push(format!("{name}{suffix}"), manifold, weight))
            .collect();
        if !places.is_empty() {
            joints.push(SceneJoint { name: name.clone(), kind: spelled(candidate.kind).into(), q: first..space.nq() });
        }
        let robot = &mut found[candidate.robot];
        match candidate.joint {
            Some(joint) => {
                if let JointRole::Locked(position) = robot.roles[joint] {
                    let kind = spelled(candidate.kind).into();
                    rigid.push(RigidJoint { name: name.clone(), kind, position });
                }
                robot.names.push(name.clone());
                robot.places[joint] = places;
            }
            None => robot.base = Some(Base { name: name.clone(), kind: candidate.kind, places }),
        }
    }
    if joints.is_empty() {
        let problem = "every joint is fixed or locked, expected at least one that moves, or a planar or floating base; beside \
                       a robot that moves, such a file is an obstacle: shape = { urdf = \"..\" }";
        return Err(Error::input(file, "robot", problem));
    }
    Ok(Coordinates { joints, space, rigid, robots: found })
}

/// Returns name, kind and manifolds of a base; `None` if it is fixed.
fn base(
    file: &str,
    loaded: &LoadedRobot,
    warnings: &mut Vec<String>,
) -> Result<Option<(&'static str, JointKind, Vec<Manifold>)>> {
    let (kind, word, counts, example): (_, _, &[usize], _) = match loaded.entry.base {
        BaseKind::Fixed => {
            if loaded.entry.bounds.is_some() {
                warnings.push(format!("robot `{}`: `bounds` mean nothing for a fixed base", loaded.name));
            }
            return Ok(None);
        }
        BaseKind::Planar => (JointKind::Planar, "planar", &[2, 3], ["x0, y0", "x1, y1"]),
        BaseKind::Floating => (JointKind::Floating, "floating", &[3], ["x0, y0, z0", "x1, y1, z1"]),
    };
    let Some(bounds) = &loaded.entry.bounds else {
        let add = format!("bounds = {{ min = [{}], max = [{}] }}", example[0], example[1]);
        return Err(Error::input(
            file,
            loaded.element("base"),
            format!("a {word} base has no bounds, add `{add}` [m]"),
        ));
    };
    let intervals = bounds.intervals(file, &loaded.element("bounds"), counts)?;
    let mut manifolds: Vec<Manifold> =
        intervals.into_iter().map(|(lower, upper)| Manifold::Interval { lower, upper }).collect();
    match (kind, manifolds.len()) {
        (JointKind::Planar, 2) => manifolds.push(Manifold::Circle),
        (JointKind::Floating, _) => manifolds.push(Manifold::Rotation),
        _ => {}
    }
    let taken = loaded.robot.joints.iter().any(|joint| joint.name == "base");
    Ok(Some((if taken { "moving_base" } else { "base" }, kind, manifolds)))
}

/// Returns the weights of every candidate's factors.
fn weights(
    file: &str,
    metric: &MetricEntry,
    candidates: &[Candidate],
    warnings: &mut Vec<String>,
) -> Result<Vec<Vec<f64>>> {
    let mut weights: Vec<Vec<f64>> = candidates.iter().map(|candidate| vec![1.0; candidate.manifolds.len()]).collect();
    let names = NameIndex::new(candidates.iter().map(|candidate| candidate.named).collect());
    for (name, entry) in &metric.weights {
        let fault = |problem: String| Error::input(file, "metric: weights", problem);
        let index = names.find(name).map_err(fault)?;
        let composite = candidates[index].manifolds.len() > 1;
        let [translation, rotation] = match *entry {
            WeightEntry::Uniform(weight) => [weight; 2],
            WeightEntry::Split(split) if composite => split,
            WeightEntry::Split(split) => {
                let kind = spelled(candidates[index].kind);
                return Err(fault(format!("`{name}`: got {split:?}, expected a number, as the joint is {kind}")));
            }
        };
        if let Some(bad) = [translation, rotation].iter().find(|weight| !WEIGHTS.contains(*weight)) {
            return Err(fault(format!("`{name}`: got {bad:?}, expected a number from 1e-9 to 1e9")));
        }
        if candidates[index].manifolds.is_empty() {
            warnings
                .push(format!("metric: the weight of `{name}` means nothing: the joint has no coordinate of its own"));
        }
        weights[index].fill(translation);
        if let Some(last) = weights[index].last_mut() {
            *last = rotation;
        }
    }
    if metric.kind != MetricKind::Joint && !metric.weights.is_empty() {
        warnings.push("metric: `weights` mean nothing, only the joint metric has them".into());
        weights.iter_mut().for_each(|factors| factors.fill(1.0));
    }
    Ok(weights)
}

/// Returns the kind as URDF spells it.
fn spelled(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Fixed => "fixed",
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
        JointKind::Planar => "planar",
        JointKind::Spherical => "spherical",
        JointKind::Floating => "floating",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::JointKind::*;
    use crate::scene::Scene;
    use crate::scene::testing::{PLAIN, chain, scene};

    const PLANAR: &str = "base = 'planar'\nbounds = { min = [-1, -1], max = [1, 1] }\n";

    fn names(scene: &Scene) -> Vec<&str> {
        scene.joints.iter().map(|joint| joint.name.as_str()).collect()
    }

    #[test]
    fn bases_come_first_and_repeated_names_are_qualified() {
        let text = format!("{PLAIN}name = 'left'\n{PLANAR}{PLAIN}name = 'right'\n");
        let scene = scene(&text, &[chain(&[Revolute, Continuous]), chain(&[Revolute])]).unwrap();
        assert_eq!(names(&scene), ["base", "left/j0", "j1", "right/j0"]);
        assert_eq!(scene.joints[1].q, 3..4);
        assert_eq!(scene.bodies[0].name, "left/l0");
        let factors: Vec<&str> = scene.space.factors().iter().map(|factor| factor.name.as_str()).collect();
        assert_eq!(factors, ["base.x", "base.y", "base.yaw", "left/j0", "j1", "right/j0"]);
    }

    #[test]
    fn weights_are_given_by_joint_or_by_part() {
        let weights = |metric: &str| {
            let scene = scene(&format!("{metric}\n{PLAIN}{PLANAR}"), &[chain(&[Revolute, Revolute])]).unwrap();
            let weights: Vec<f64> = scene.space.factors().iter().map(|factor| factor.weight).collect();
            (weights, scene.warnings)
        };
        let (split, warnings) = weights("metric = { weights = { base = [4, 0.5], j1 = 3 } }");
        assert_eq!((split, warnings.len()), (vec![4.0, 4.0, 0.5, 1.0, 3.0], 0));
        assert_eq!(weights("metric = { weights = { base = 2, 'arm/j0' = 7 } }").0, [2.0, 2.0, 2.0, 7.0, 1.0]);
        let (other, warnings) = weights("metric = { kind = 'object-norm', weights = { j1 = 3 } }");
        assert_eq!((other, warnings.len()), (vec![1.0; 5], 1));
    }

    #[test]
    fn faults_name_element_and_expectation() {
        let message = |text: &str| scene(text, &[chain(&[Revolute, Fixed])]).unwrap_err().to_string();
        let weights = |weights: &str| message(&format!("metric = {{ weights = {{ {weights} }} }}\n{PLAIN}"));
        assert!(weights("j7 = 1").contains("metric: weights: got `j7`, expected one of `j0`, `j1`"));
        assert!(weights("j0 = -1").contains("`j0`: got -1.0, expected a number from 1e-9 to 1e9"));
        assert!(weights("j0 = [1, 2]").contains("the joint is revolute"));
        let unbounded = message(&format!("{PLAIN}base = 'floating'"));
        assert!(unbounded.contains("robot \"arm\": base") && unbounded.contains("min = [x0, y0, z0]"), "{unbounded}");
        let short = message(&format!("{PLAIN}base = 'floating'\nbounds = {{ min = [0, 0], max = [1, 1] }}"));
        assert!(short.contains("bounds: min and max: got 2 and 2 numbers, expected 3 each"), "{short}");
        assert!(message(&format!("{PLAIN}locked = {{ j0 = 0 }}")).contains("every joint is fixed or locked"));
    }

    #[test]
    fn yaw_may_be_bounded() {
        let text = format!("{PLAIN}base = 'planar'\nbounds = {{ min = [-1, -1, -2], max = [1, 1, 2] }}");
        let scene = scene(&text, &[chain(&[Revolute])]).unwrap();
        assert_eq!(scene.space.factors()[2].manifold, Manifold::Interval { lower: -2.0, upper: 2.0 });
    }
}

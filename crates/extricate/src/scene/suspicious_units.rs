//! Detects numbers that are most likely in other units: degrees for radians, millimetres for
//! metres.

use super::assemble::bodies::{OncePerMesh, radius};
use super::{Body, Motion, Scene};
use crate::cspace::{Config, Manifold};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::robot::Geometry;

/// Largest excess over a joint limit \[rad\] that may still be the overshoot of a drive.
const MAX_OVERSHOOT_RAD: f64 = 0.5;
/// Thickness of an obstacle in reaches of the robot above which a warning suspects its unit.
const MAX_THICKNESS_REACHES: f64 = 50.0;
/// Length of an obstacle in reaches of the robot below which a warning suspects its unit.
const MIN_LENGTH_REACHES: f64 = 1e-3;
/// Largest number of bodies whose suspicious size gets a warning of its own.
const MAX_SIZE_WARNINGS: usize = 3;

/// Hint for a query whose angles are beyond their limits, but would all be within them as degrees.
pub const DEGREES: &str = "angles are in rad: all of them would be within their limits if these were degrees";
/// Hint for a query of which most angles beyond their limits would be within them as degrees.
pub const MOSTLY_DEGREES: &str =
    "angles are in rad: most of those beyond their limits would be within them if these were degrees";

impl Scene {
    /// Checks the coordinates of a configuration, wraps angles and normalises quaternions.
    ///
    /// # Errors
    /// [`crate::Error::Config`], which names the coordinate, if the number of values is wrong or a
    /// value is not finite or beyond its limits. It has a hint if the values look like degrees.
    pub fn config(&self, values: &[f64]) -> Result<Config> {
        self.space.config(values).map_err(|error| match (error, self.degrees_hint(values)) {
            (Error::Config { element, value, expected }, Some(hint)) => {
                Error::Config { element, value, expected: format!("{expected} ({hint})") }
            }
            (other, _) => other,
        })
    }

    /// Returns a hint if most angles of `values` that are far beyond their limits would be within
    /// them as degrees.
    pub fn degrees_hint(&self, values: &[f64]) -> Option<&'static str> {
        if values.len() != self.space.nq() {
            return None;
        }
        let is_angle = |q: usize| self.joints.iter().any(|joint| joint.q.contains(&q) && joint.kind == "revolute");
        let (mut far, mut would_fit, mut all_fit) = (0, 0, true);
        for factor in self.space.factors() {
            if let Manifold::Interval { lower, upper } = factor.manifold
                && is_angle(factor.q)
            {
                let angle = values[factor.q];
                let fits = (lower..=upper).contains(&angle.to_radians());
                let is_far = !(lower - MAX_OVERSHOOT_RAD..=upper + MAX_OVERSHOOT_RAD).contains(&angle);
                far += usize::from(is_far);
                would_fit += usize::from(is_far && fits);
                all_fit &= fits;
            }
        }
        let is_most = 2 * would_fit > far;
        is_most.then_some(if all_fit { DEGREES } else { MOSTLY_DEGREES })
    }
}

/// Warns of obstacles and attached objects whose size beside the robots' suggests millimetres. The
/// shortest side decides whether one is too large, because floors and walls are long.
pub fn warn_of_sizes(scene: &Scene, bodies: &[Body], warnings: &mut Vec<String>) {
    let Some([arm, reach]) = reaches(scene) else { return };
    let mut told = 0;
    let mut known = OncePerMesh::default();
    for body in bodies {
        let all: Vec<[f64; 2]> = body.parts.iter().filter_map(|part| known.of(&part.geometry, sides)).collect();
        let Some(shortest) = all.iter().map(|sides| sides[0]).reduce(f64::max) else { continue };
        let longest = all.iter().map(|sides| sides[1]).fold(0.0, f64::max);
        let size = if shortest > MAX_THICKNESS_REACHES * reach {
            format!("{shortest:.0} m thick, more than 50 times the robot's reach of {reach:.3} m")
        } else if longest < MIN_LENGTH_REACHES * arm {
            format!("{longest:.1e} m long, less than a thousandth of the robot's reach of {arm:.3} m")
        } else {
            continue;
        };
        told += 1;
        if told <= MAX_SIZE_WARNINGS {
            let kind = if body.is_obstacle() { "obstacle" } else { "attached" };
            warnings.push(format!("{kind} `{}` is {size}: lengths are in m, not mm", body.name));
        }
    }
    if told > MAX_SIZE_WARNINGS {
        warnings.push(format!("{} more obstacles look like mm or scaled twice", told - MAX_SIZE_WARNINGS));
    }
}

/// Returns the shortest and the longest side of the box around a shape \[m\]; `None` for scenery
/// and for an empty mesh.
fn sides(geometry: &Geometry) -> Option<[f64; 2]> {
    let full = match geometry {
        Geometry::Sphere { radius } => Vec3::repeat(2.0 * radius),
        Geometry::Box { half_extents } => 2.0 * Vec3::from(*half_extents),
        Geometry::Cylinder { radius, half_length } => 2.0 * Vec3::new(*radius, *radius, *half_length),
        Geometry::Capsule { radius, half_length } => 2.0 * Vec3::new(*radius, *radius, radius + half_length),
        Geometry::Mesh(mesh) | Geometry::ConvexHull(mesh) => {
            let first = *mesh.vertices.first()?;
            let ends = mesh.vertices.iter().fold((first, first), |(low, high), v| (low.inf(v), high.sup(v)));
            ends.1 - ends.0
        }
        _ => return None,
    };
    Some([full.min(), full.max()])
}

/// Returns upper bounds on how far any robot reaches from its first joint \[m\], without and with
/// the travel of sliding joints. Returns `None` if no link has geometry.
fn reaches(scene: &Scene) -> Option<[f64; 2]> {
    let mut lengths: Vec<[f64; 2]> = Vec::with_capacity(scene.frames.len());
    for (index, frame) in scene.frames.iter().enumerate() {
        let [arm, reach] = if index == 0 { [0.0; 2] } else { lengths[frame.parent] };
        // The place of the first joint in the world does not add to the reach.
        let own = if frame.parent == 0 { 0.0 } else { frame.pose_parent_joint.translation.norm() };
        let travel = match &frame.motion {
            Motion::Prismatic { coordinate, .. } => travel(scene, coordinate.q) * coordinate.multiplier.abs(),
            _ => 0.0,
        };
        lengths.push([arm + own, reach + own + travel]);
    }
    let links = scene.bodies.iter().filter(|body| body.robot.is_some());
    let mut known = OncePerMesh::default();
    let mut of_link = |body: &Body| {
        let mut far = |part: &super::Part| {
            // The place of a link that does not move does not add to the reach either.
            let place = if body.frame == 0 { 0.0 } else { part.pose_frame_part.translation.norm() };
            place + known.of(&part.geometry, radius)
        };
        let own = body.parts.iter().map(&mut far).fold(0.0, f64::max);
        lengths[body.frame].map(|length| length + own)
    };
    links.map(&mut of_link).reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])
}

fn travel(scene: &Scene, q: usize) -> f64 {
    let interval = scene.space.factors().iter().find(|factor| factor.q == q).map(|factor| factor.manifold);
    match interval {
        Some(Manifold::Interval { lower, upper }) => upper - lower,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::JointKind::*;
    use crate::scene::testing::{PLAIN, chain, scene};

    #[test]
    fn degrees_are_told_where_all_angles_would_fit() {
        let scene = scene(PLAIN, &[chain(&[Revolute, Prismatic, Revolute, Continuous])]).unwrap();
        let message = |q: &[f64]| scene.config(q).unwrap_err().to_string();
        assert_eq!(
            message(&[45.0, 0.5, -30.0, 90.0]),
            "configuration: `j0` (coordinate 0): got 45, expected a value within [-1, 1] (angles are in rad: all of them \
             would be within their limits if these were degrees)"
        );
        // No hint for an overshoot, if only half of the angles fit as degrees, or for a length.
        for q in [[1.2, 0.0, 0.0, 0.0], [45.0, 0.0, 80.0, 0.0], [0.0, 9.0, 0.0, 0.0]] {
            assert!(message(&q).ends_with("[-1, 1]"), "{}", message(&q));
        }
        assert_eq!(scene.degrees_hint(&[45.0]), None);
        assert_eq!(scene.degrees_hint(&[f64::NAN; 4]), None);
        assert_eq!(&*scene.config(&[1.0, 0.0, 0.0, 0.0]).unwrap(), &[1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn degrees_are_told_where_most_angles_would_fit() {
        let scene = scene(PLAIN, &[chain(&[Revolute, Revolute, Revolute, Revolute])]).unwrap();
        assert_eq!(scene.degrees_hint(&[45.0, -30.0, 80.0, 0.0]), Some(MOSTLY_DEGREES));
        assert_eq!(scene.degrees_hint(&[45.0, -30.0, 20.0, 0.0]), Some(DEGREES));
        for q in [[45.0, 70.0, 80.0, 0.0], [500.0, 0.3, 0.2, 0.1], [0.9, -0.9, 0.2, 1.1]] {
            assert_eq!(scene.degrees_hint(&q), None, "{q:?}");
        }
    }

    #[test]
    fn sizes_in_millimetres_are_told() {
        let warnings = |shape: &str| {
            let text = format!("{PLAIN}[[obstacle]]\nname = 'box'\nshape = {shape}");
            scene(&text, &[chain(&[Revolute, Revolute, Prismatic])]).unwrap().warnings
        };
        // The joint origins and a ball reach 2.1 m; the sliding joint adds 2 m.
        let large = warnings("{ box = [300, 600, 400] }");
        assert_eq!(
            large,
            [
                "obstacle `box` is 300 m thick, more than 50 times the robot's reach of 4.100 m: lengths are in m, not mm"
            ]
        );
        let small = warnings("{ sphere = 5e-4 }");
        assert!(
            small[0].contains("is 1.0e-3 m long, less than a thousandth of the robot's reach of 2.100 m"),
            "{small:?}"
        );
        for fine in ["{ box = [1000, 1000, 0.1] }", "{ sphere = 0.0015 }"] {
            assert!(warnings(fine).is_empty(), "{fine}: {:?}", warnings(fine));
        }
    }
}

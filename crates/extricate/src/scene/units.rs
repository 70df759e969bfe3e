//! Numbers that are most likely in other units: degrees for radians, millimetres for metres.

use super::assemble::bodies::{OncePerMesh, radius};
use super::{Body, Motion, Scene};
use crate::cspace::{Config, Manifold};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::robot::Geometry;

/// Angles that far beyond their limits \[rad\] are no overshoot of a drive.
const FAR_BEYOND: f64 = 0.5;
/// Obstacles of more than so many times the robot's reach are told.
const TOO_LARGE: f64 = 50.0;
/// Obstacles of less than this share of the robot's reach are told.
const TOO_SMALL: f64 = 1e-3;

/// Bodies that a warning names.
const MOST_TOLD: usize = 3;

/// What is said of angles that look like degrees.
pub const DEGREES: &str = "angles are in rad: all of them would be within their limits if these were degrees";
/// The same where some would still be beyond their limits.
pub const MOSTLY_DEGREES: &str =
    "angles are in rad: most of those beyond their limits would be within them if these were degrees";

impl Scene {
    /// A configuration of the robot: checked, angles wrapped, quaternions normalised.
    ///
    /// # Errors
    /// [`crate::Error::Config`], naming the coordinate: if the length is not that of the scene's
    /// coordinates, a number is not finite or beyond its limits; with a hint if the values look
    /// like degrees.
    pub fn config(&self, values: &[f64]) -> Result<Config> {
        self.space.config(values).map_err(|error| match (error, self.degrees_hint(values)) {
            (Error::Config { element, value, expected }, Some(hint)) => {
                Error::Config { element, value, expected: format!("{expected} ({hint})") }
            }
            (other, _) => other,
        })
    }

    /// What is said if most angles of `values` far beyond their limits would be within them in
    /// degrees.
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
                let is_far = !(lower - FAR_BEYOND..=upper + FAR_BEYOND).contains(&angle);
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
/// shortest side tells what is too large, as floors and walls are long.
pub fn warn_of_sizes(scene: &Scene, bodies: &[Body], warnings: &mut Vec<String>) {
    let Some([arm, reach]) = reaches(scene) else { return };
    let mut told = 0;
    let mut known = OncePerMesh::default();
    for body in bodies {
        let all: Vec<[f64; 2]> = body.parts.iter().filter_map(|part| known.of(&part.geometry, sides)).collect();
        let Some(shortest) = all.iter().map(|sides| sides[0]).reduce(f64::max) else { continue };
        let longest = all.iter().map(|sides| sides[1]).fold(0.0, f64::max);
        let size = if shortest > TOO_LARGE * reach {
            format!("{shortest:.0} m thick, more than 50 times the robot's reach of {reach:.3} m")
        } else if longest < TOO_SMALL * arm {
            format!("{longest:.1e} m long, less than a thousandth of the robot's reach of {arm:.3} m")
        } else {
            continue;
        };
        told += 1;
        if told <= MOST_TOLD {
            let kind = if body.is_obstacle() { "obstacle" } else { "attached" };
            warnings.push(format!("{kind} `{}` is {size}: lengths are in m, not mm", body.name));
        }
    }
    if told > MOST_TOLD {
        warnings.push(format!("{} more obstacles look like mm or scaled twice", told - MOST_TOLD));
    }
}

/// The shortest and the longest side of a box around a shape \[m\]; `None` of what has no end, and
/// of points.
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

/// How far from its first joint a robot reaches \[m\], at most: without the travel of what slides,
/// and with it. `None` where no link has geometry.
fn reaches(scene: &Scene) -> Option<[f64; 2]> {
    let mut lengths: Vec<[f64; 2]> = Vec::with_capacity(scene.frames.len());
    for (index, frame) in scene.frames.iter().enumerate() {
        let [arm, reach] = if index == 0 { [0.0; 2] } else { lengths[frame.parent] };
        // Where the first joint stands in the world says nothing of the robot.
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
            // A link that stands still is as large as it is, wherever it stands.
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
        // An overshoot, as many angles too wide in degrees too, and a length: none of these is one.
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
        // Two metres of joints and a ball; two more that slide.
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

//! Measures how well an object is held: which wrenches its contacts can resist.

use serde::Serialize;

use super::grip::GraspContact;
use super::wrench_hull::{Wrench, least_support};
use crate::math::Vec3;
use crate::query::Context;

/// How well contacts hold an object.
///
/// # Source
/// C. Ferrari and J. Canny, "Planning optimal grasps", ICRA 1992, doi:10.1109/ROBOT.1992.219918:
/// the largest ball around the origin in the convex hull of what the contacts can exert with normal
/// forces that add up to 1 (their quality Q1). Moments are measured about the centre of the
/// object's bounding box, in units of half its longest side, as A. T. Miller and P. K. Allen,
/// "GraspIt!", IEEE Robotics & Automation Magazine 11(4), 2004, doi:10.1109/MRA.2004.1371616, do
/// with its largest radius. Friction cones are round, not pyramids.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GraspQuality {
    /// Radius of that ball; 0 if the origin is not inside the hull.
    pub epsilon: f64,
    /// Whether the contacts can resist any wrench: `epsilon` is proved to be above 0.
    pub force_closure: bool,
}

/// Measures the contacts of the body `object`, with the coefficient of friction `friction`.
pub fn quality(context: &Context, object: usize, contacts: &[GraspContact], friction: f64) -> GraspQuality {
    let poses = [crate::math::Pose::identity()];
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    context.checker.corners_of(object, &poses, &mut |corner| {
        low = low.inf(&corner);
        high = high.sup(&corner);
    });
    let (center, size) = (0.5 * (low + high), 0.5 * (high - low).max());
    let cones: Vec<Cone> = contacts.iter().map(|contact| Cone::new(contact, &center, size)).collect();
    let epsilon = least_support(|direction| {
        let ahead = cones.iter().map(|cone| cone.support(direction, friction));
        ahead.max_by(|a, b| dot(a, direction).total_cmp(&dot(b, direction)))
    });
    GraspQuality { epsilon, force_closure: epsilon > 0.0 }
}

/// Friction cone of a contact.
struct Cone {
    /// Unit normal into the object.
    normal: Vec3,
    /// Vector from the object's centre to the contact, in units of half the object's longest side.
    arm: Vec3,
}

impl Cone {
    fn new(contact: &GraspContact, center: &Vec3, size: f64) -> Self {
        Self { normal: contact.normal.into(), arm: (Vec3::from(contact.point) - center) / size }
    }

    /// Returns the wrench farthest along a direction, of those with a unit normal force.
    fn support(&self, direction: &Wrench, friction: f64) -> Wrench {
        let (force, moment) = (Vec3::from_column_slice(&direction[..3]), Vec3::from_column_slice(&direction[3..]));
        // (arm x f) . moment = f . (moment x arm).
        let pull = force + moment.cross(&self.arm);
        let along = pull - self.normal * pull.dot(&self.normal);
        let sideways = along.try_normalize(1e-12).unwrap_or_else(Vec3::zeros);
        let applied = self.normal + sideways * friction;
        let turned = self.arm.cross(&applied);
        [applied.x, applied.y, applied.z, turned.x, turned.y, turned.z]
    }
}

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::robot::Geometry;
    use crate::scene::{Body, builtin};
    use crate::solver::Solver;

    fn of(contacts: &[([f64; 3], [f64; 3])], friction: f64) -> GraspQuality {
        let scene = builtin::scene("planar-arm").unwrap().without_obstacles();
        let ball = Body::obstacle("ball", Geometry::Sphere { radius: 0.5 }, Pose::identity());
        let solver = Solver::new(scene.with_obstacles([ball]).unwrap());
        let contact = |(point, normal): &([f64; 3], [f64; 3])| GraspContact {
            link: String::new(),
            distance: 0.0,
            point: *point,
            normal: *normal,
        };
        let contacts: Vec<GraspContact> = contacts.iter().map(contact).collect();
        let object = solver.scene().bodies.len() - 1;
        quality(&solver.context(), object, &contacts, friction)
    }

    /// Without friction, six contacts on the axes of a ball resist all forces, but no moments.
    #[test]
    fn moments_need_friction() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let contacts: Vec<_> = axes
            .iter()
            .flat_map(|axis| [1.0, -1.0].map(|side| (axis.map(|x| 0.5 * side * x), axis.map(|x| -side * x))))
            .collect();
        assert_eq!(of(&contacts, 0.0), GraspQuality { epsilon: 0.0, force_closure: false });
        // The moment about (1, 1, 1) is the hardest: contacts give friction x sqrt(2 / 3) of it.
        let held = of(&contacts, 0.5);
        assert!(held.force_closure && (held.epsilon - 0.5 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-3, "{held:?}");
    }

    /// Two opposite contacts do not resist a moment about their line; three around a circle do.
    #[test]
    fn two_contacts_are_no_force_closure() {
        let side = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            ([0.5 * cos, 0.5 * sin, 0.0], [-cos, -sin, 0.0])
        };
        assert!(!of(&[side(0.0), side(std::f64::consts::PI)], 0.8).force_closure);
        let three = [0.0, 2.1, 4.2].map(side);
        assert!(of(&three, 0.8).force_closure && !of(&three, 0.0).force_closure);
        assert!(!of(&[side(0.0), side(1.0), side(2.0)], 0.2).force_closure);
        assert!(!of(&[], 0.8).force_closure);
    }
}

//! Finds the bodies of a hand that can touch the object, and the joints that move one finger alone.

use std::collections::BTreeSet;

use crate::error::{Error, Result};
use crate::scene::{Motion, PairId, Scene};

/// A hand and the object that it holds: the bodies that can touch the object, and the joints that
/// move one finger alone. It is made once for a scene.
///
/// A finger is the chain of joints to an outermost link, without the joints that all such chains
/// share (base, wrist).
///
/// ```
/// use extricate::geometry::{Body, Geometry, Pose};
/// use extricate::{Hand, ReleaseOptions, Solver, builtin};
/// let ball = Body::obstacle("ball", Geometry::Sphere { radius: 0.03 }, Pose::at([0.0, 0.0, 0.08]));
/// let solver = Solver::new(builtin::scene("hand")?.with_obstacles([ball])?);
/// let hand = Hand::new(solver.scene(), "ball")?;
/// let q = solver.scene().config(&[0.0, 0.4, 0.0, 0.4, 0.4])?;    // three fingers in the ball
/// let grasp = solver.release(&hand, &q, &ReleaseOptions::default()).unwrap();
/// assert!(grasp.verified && grasp.fingers == [3, 3]);
/// # extricate::Result::Ok(())
/// ```
#[derive(Debug, Clone)]
pub struct Hand {
    /// Index of the object among the bodies of the scene.
    pub(super) object: usize,
    pub(super) links: Vec<Link>,
    pub(super) fingers: Vec<Finger>,
}

/// A body of the hand that is checked against the object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    /// The pair of this body and the object.
    pub pair: PairId,
    /// Index among the bodies of the scene.
    pub body: usize,
    /// Index of its finger; `None` for the palm.
    pub finger: Option<usize>,
    /// Whether it is the second body of the pair, and the object the first.
    pub is_second: bool,
}

/// Joints that move one finger alone.
#[derive(Debug, Clone)]
pub(super) struct Finger {
    /// Indices of their factors in the configuration space.
    pub factors: Vec<usize>,
}

impl Hand {
    /// Makes the hand of a scene that holds the obstacle `object`.
    ///
    /// # Errors
    /// [`Error::Input`] if no body has that name, it moves, or no moving body is checked against
    /// it.
    pub fn new(scene: &Scene, object: &str) -> Result<Self> {
        let object = scene.body_named("object", object)?;
        let fault = |problem: &str| {
            let element = format!("object \"{}\"", scene.bodies[object].name);
            Err(Error::input("grasp", &element, problem.to_string()))
        };
        if scene.bodies[object].frame != 0 {
            return fault("got a body that moves with the robot, expected an obstacle");
        }
        let mut links = Vec::new();
        for (index, pair) in scene.pairs.iter().enumerate() {
            let is_second = pair.first == object;
            let body = if is_second { pair.second } else { pair.first };
            if (is_second || pair.second == object) && scene.bodies[body].frame != 0 {
                links.push(Link { pair: PairId::new(index), body, finger: None, is_second });
            }
        }
        if links.is_empty() {
            return fault("no body that moves is checked against it, expected a hand");
        }
        let chains: Vec<BTreeSet<usize>> =
            links.iter().map(|link| chain(scene, scene.bodies[link.body].frame)).collect();
        let mut fingers: Vec<BTreeSet<usize>> = Vec::new();
        for own in own_joints(scene, &chains) {
            let mut merged = own;
            fingers.retain(|finger| {
                let is_other = finger.is_disjoint(&merged);
                if !is_other {
                    merged.extend(finger);
                }
                is_other
            });
            if !merged.is_empty() {
                fingers.push(merged);
            }
        }
        for (link, chain) in links.iter_mut().zip(&chains) {
            link.finger = fingers.iter().position(|finger| !finger.is_disjoint(chain));
        }
        let factors = scene.space.factors();
        let of_finger = |tangents: &BTreeSet<usize>| Finger {
            factors: (0..factors.len()).filter(|at| tangents.contains(&factors[*at].v)).collect(),
        };
        Ok(Self { object, links, fingers: fingers.iter().map(of_finger).collect() })
    }

    /// Number of fingers that can touch the object.
    pub fn finger_count(&self) -> usize {
        self.fingers.len()
    }
}

/// Returns the tangent coordinates that move a frame.
fn chain(scene: &Scene, mut frame: usize) -> BTreeSet<usize> {
    let mut tangents = BTreeSet::new();
    while frame != 0 {
        match &scene.frames[frame].motion {
            Motion::World => {}
            Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } => {
                tangents.insert(coordinate.v);
            }
            Motion::Ball { v, .. } => tangents.extend(*v..v + 3),
        }
        frame = scene.frames[frame].parent;
    }
    tangents
}

/// Removes from each chain the base and what all outermost chains share. If nothing is left, as for
/// a gripper with one joint, removes the base alone.
fn own_joints(scene: &Scene, chains: &[BTreeSet<usize>]) -> Vec<BTreeSet<usize>> {
    let base = base_tangents(scene);
    let without_base: Vec<BTreeSet<usize>> = chains.iter().map(|chain| chain - &base).collect();
    let is_outermost = |chain: &&BTreeSet<usize>| {
        let goes_on = |other: &BTreeSet<usize>| other.len() > chain.len() && chain.is_subset(other);
        !without_base.iter().any(goes_on)
    };
    let mut outermost = without_base.iter().filter(is_outermost);
    let first = outermost.next().cloned().unwrap_or_default();
    let shared = outermost.fold(first, |shared, chain| &shared & chain);
    let own: Vec<BTreeSet<usize>> = without_base.iter().map(|chain| chain - &shared).collect();
    if own.iter().all(BTreeSet::is_empty) { without_base } else { own }
}

/// Returns the tangent coordinates of the bases of all robots.
pub(super) fn base_tangents(scene: &Scene) -> BTreeSet<usize> {
    let is_base = |name: &str| name == "base" || name.ends_with("/base");
    let bases = || scene.joints.iter().filter(|joint| is_base(&joint.name));
    let of_base = |q: usize| bases().any(|joint| joint.q.contains(&q));
    scene.space.factors().iter().filter(|factor| of_base(factor.q)).flat_map(|factor| factor.tangents()).collect()
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::math::{Pose, Vec3};
    use crate::robot::Geometry;
    use crate::scene::{Body, builtin};

    /// The built-in hand around a ball.
    pub fn with_ball(radius: f64) -> Scene {
        let pose = Pose::translation(Vec3::new(0.0, 0.0, 0.08));
        let ball = Body::obstacle("ball", Geometry::Sphere { radius }, pose);
        builtin::scene("hand").unwrap().with_obstacles([ball]).unwrap()
    }

    #[test]
    fn fingers_are_what_chains_do_not_share() {
        let scene = with_ball(0.03);
        let hand = Hand::new(&scene, "ball").unwrap();
        assert_eq!(hand.finger_count(), 3);
        let mut factors: Vec<usize> = hand.fingers.iter().flat_map(|finger| finger.factors.clone()).collect();
        factors.sort_unstable();
        assert_eq!(factors, [0, 1, 2, 3, 4]);
        assert!(hand.links.iter().all(|link| link.finger.is_some()), "the palm does not move");
        // An arm is one finger.
        let arm = builtin::scene("shelf-arm").unwrap();
        let obstacle = arm.bodies.iter().find(|body| body.is_obstacle()).unwrap();
        assert_eq!(Hand::new(&arm, &obstacle.name).unwrap().finger_count(), 1);
    }

    #[test]
    fn what_is_no_object_is_named() {
        let scene = with_ball(0.03);
        let message = |name: &str| Hand::new(&scene, name).unwrap_err().to_string();
        assert!(message("cup").contains("cup") && message("cup").contains("ball"), "{}", message("cup"));
        let link = scene.bodies.iter().find(|body| body.frame != 0).unwrap();
        assert!(message(&link.name).contains("expected an obstacle"), "{}", message(&link.name));
    }
}

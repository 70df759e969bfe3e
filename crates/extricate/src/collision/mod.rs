//! The exact checker: which pairs of a scene keep the clearance at a configuration, and signed distances where they nearly
//! do not. In f64 throughout.

pub mod convex;
pub mod epa;
pub mod gjk;

use std::sync::Arc;

use crate::cspace::Label;
use crate::math::Vec3;
use crate::scene::Scene;

/// The checked pairs of one scene, with all that makes checks fast. Immutable, shared between threads.
pub struct Checker {
    scene: Arc<Scene>,
}

/// Memory that checks reuse; one per thread.
#[derive(Default)]
pub struct CheckScratch {}

/// Two places of a checked pair that are near each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Index into [`Scene::pairs`].
    pub pair: usize,
    /// Signed distance [m]; negative where the two overlap.
    pub distance: f64,
    /// Nearest (or deepest) point on the first body, world coordinates [m].
    pub point_first: Vec3,
    /// The same on the second body.
    pub point_second: Vec3,
    /// Unit, world coordinates, from the second body toward the first: moving the first body along it by `t` changes
    /// `distance` by `t`.
    pub normal: Vec3,
}

impl Checker {
    /// Prepares every checked pair of `scene`.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self { scene }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene, shared.
    pub fn scene_arc(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Whether every checked pair keeps the clearance at `q` (length `nq`, within limits).
    pub fn label(&self, q: &[f64], scratch: &mut CheckScratch) -> Label {
        let _ = (q, scratch);
        todo!()
    }

    /// Appends the indices of all checked pairs that are nearer than the clearance at `q`, ascending.
    pub fn colliding_pairs(&self, q: &[f64], scratch: &mut CheckScratch, pairs: &mut Vec<usize>) {
        let _ = (q, scratch, pairs);
        todo!()
    }

    /// Least signed distance [m] of any checked pair at `q`; infinite where no pair is checked.
    pub fn clearance(&self, q: &[f64], scratch: &mut CheckScratch) -> f64 {
        let _ = (q, scratch);
        todo!()
    }

    /// Appends the contacts of all checked pairs nearer than `margin` [m] at `q`.
    pub fn contacts(&self, q: &[f64], margin: f64, scratch: &mut CheckScratch, contacts: &mut Vec<Contact>) {
        let _ = (q, margin, scratch, contacts);
        todo!()
    }

    /// Signed depth [m] of a point (in the body's frame) in the solid of `body`: positive inside, minus the distance
    /// outside; for surfaces minus the distance.
    pub fn solid_depth(&self, body: usize, point_frame: &Vec3) -> f64 {
        let _ = (body, point_frame);
        todo!()
    }
}

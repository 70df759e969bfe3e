//! What each tangent coordinate weighs, and whether several joints share it.

use crate::scene::{Motion, Scene};

/// What the joint metric's bound needs to know of a tangent coordinate.
#[derive(Debug, Clone, Copy)]
pub struct CoordinateUse {
    /// Of its square in the joint metric; of a ball joint its first coordinate has it.
    pub weight: f64,
    /// Whether several frames move with it (mimic joints).
    pub shared: bool,
}

/// One entry a tangent coordinate.
pub fn coordinate_uses(scene: &Scene) -> Vec<CoordinateUse> {
    let mut uses = vec![CoordinateUse { weight: 1.0, shared: false }; scene.space.nv()];
    scene.space.factors().iter().for_each(|f| uses[f.v].weight = f.weight);
    let mut seen = vec![false; uses.len()];
    for frame in &scene.frames {
        if let Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } = &frame.motion {
            uses[coordinate.v].shared |= std::mem::replace(&mut seen[coordinate.v], true);
        }
    }
    uses
}

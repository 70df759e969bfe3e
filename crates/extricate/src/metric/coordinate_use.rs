//! Weights of the tangent coordinates, and whether several joints share one.

use crate::scene::{Motion, Scene};

/// Weight and sharing of a tangent coordinate, for bounds under the joint metric.
#[derive(Debug, Clone, Copy)]
pub struct CoordinateUse {
    /// Weight of its square in the joint metric; a ball joint has it at its first coordinate.
    pub weight: f64,
    /// Whether several frames move with the coordinate (mimic joints).
    pub shared: bool,
}

/// Returns one entry per tangent coordinate.
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

//! Which tangent coordinates move what: of a frame, and of a pair of bodies. Nothing of a query.

use std::ops::Range;

use crate::scene::{Motion, PairId, Scene};

/// The tangent coordinates that a frame's own joint moves.
pub fn own(scene: &Scene, frame: usize) -> Range<usize> {
    match &scene.frames[frame].motion {
        Motion::World => 0..0,
        Motion::Revolute { coordinate, .. } | Motion::Prismatic { coordinate, .. } => coordinate.v..coordinate.v + 1,
        Motion::Ball { v, .. } => *v..v + 3,
    }
}

/// The tangent coordinates that move the bodies of a pair relative to each other.
pub fn coordinates(scene: &Scene, pair: PairId, each: &mut dyn FnMut(usize)) {
    let pair = &scene.pairs[pair.index()];
    let (mut first, mut second) = (scene.bodies[pair.first].frame, scene.bodies[pair.second].frame);
    // What carries both bodies parts nothing; frames come after those that carry them.
    while first != second {
        let frame = if first > second { &mut first } else { &mut second };
        own(scene, *frame).for_each(&mut *each);
        *frame = scene.frames[*frame].parent;
    }
}

//! Building blocks of trees over scenery: nodes, elements, and the relative pose of another shape.
//! Not the trees.

use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::bvh::{Seen, View};
use crate::math::Vec3;

/// Half side \[m\] of a box around an unbounded shape. It exceeds every coordinate, and rounding at
/// this size is still below a micrometre.
pub(super) const ENDLESS_HALF_SIDE_M: f64 = 4e9;

/// A node or an element: its level in the upper five bits, its number in the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct At(pub u32);

const NUMBER_BITS: u32 = 27;
const ELEMENT_LEVEL: u32 = 31;

impl At {
    pub(super) fn new(level: usize, number: usize) -> Self {
        Self((level as u32) << NUMBER_BITS | number as u32)
    }

    pub fn element(number: usize) -> Self {
        Self::new(ELEMENT_LEVEL as usize, number)
    }

    /// Number of an element; `None` for a node.
    pub fn as_element(self) -> Option<u32> {
        (self.0 >> NUMBER_BITS == ELEMENT_LEVEL).then_some(self.number() as u32)
    }

    pub(super) fn level(self) -> usize {
        (self.0 >> NUMBER_BITS) as usize
    }

    pub(super) fn number(self) -> usize {
        (self.0 & ((1 << NUMBER_BITS) - 1)) as usize
    }
}

/// One of many convex shapes.
#[derive(Debug, Clone, Copy)]
pub struct Element<'a> {
    /// Solid in its own frame, which is not rotated.
    pub solid: &'a ConvexSolid,
    /// Box around the solid, in its own frame.
    pub bounds: &'a Aabb,
    /// Origin of that frame \[m\].
    pub place: Vec3,
}

/// Another shape relative to scenery.
pub struct Approach<'a> {
    /// Maps the other shape's frame to that of the scenery.
    pub relative: &'a Relative,
    /// Box around the other shape, in its frame.
    pub bounds: &'a Aabb,
    /// View of the other box, for trees of boxes.
    pub(super) seen: Option<(View, Seen)>,
    /// Lowest z \[m\] of the other shape's box.
    pub(super) low: f64,
}

//! What trees over scenery are made of: nodes, elements, and how another shape stands to them. Not
//! the trees.

use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::bvh::{Seen, View};
use crate::math::Vec3;

/// Half side \[m\] of a box around what has no end: more than any coordinate, small enough that its
/// digits reach a micrometre.
pub(super) const ENDLESS: f64 = 4e9;

/// A node or an element: its level in the upper five bits, its number in the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct At(pub u32);

const LEVEL_BITS: u32 = 27;
const ELEMENT: u32 = 31;

impl At {
    pub(super) fn new(level: usize, number: usize) -> Self {
        Self((level as u32) << LEVEL_BITS | number as u32)
    }

    /// An element by its number.
    pub fn element(number: usize) -> Self {
        Self::new(ELEMENT as usize, number)
    }

    /// The number of an element; `None` of a node.
    pub fn as_element(self) -> Option<u32> {
        (self.0 >> LEVEL_BITS == ELEMENT).then_some(self.number() as u32)
    }

    pub(super) fn level(self) -> usize {
        (self.0 >> LEVEL_BITS) as usize
    }

    pub(super) fn number(self) -> usize {
        (self.0 & ((1 << LEVEL_BITS) - 1)) as usize
    }
}

/// A convex shape of many.
#[derive(Debug, Clone, Copy)]
pub struct Element<'a> {
    /// In its own frame, which is not turned.
    pub solid: &'a ConvexSolid,
    /// Around it, in its own frame.
    pub bounds: &'a Aabb,
    /// Where that frame has its origin \[m\].
    pub place: Vec3,
}

/// How another shape stands to scenery.
pub struct Approach<'a> {
    /// Maps the other shape's frame to that of the scenery.
    pub relative: &'a Relative,
    /// Around the other shape, in its frame.
    pub bounds: &'a Aabb,
    /// Of trees of boxes.
    pub(super) seen: Option<(View, Seen)>,
    /// Lowest z \[m\] of the other shape's box.
    pub(super) low: f64,
}

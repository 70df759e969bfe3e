//! Shapes that only obstacles have: many equal convex shapes, half-spaces, the ground below a grid
//! of heights. Each knows which of its parts are near another shape, so that a check costs what is
//! near and not what there is.
//!
//! A [`Scenery`] is seen as a tree whose leaves are *elements*: convex shapes in its frame. `pair`
//! decides and measures with them, `inner` names convex sets for proofs. Two sceneries never meet:
//! neither moves.

mod field;
mod half_space;
mod inner;
mod layers;
mod many;
mod pair;
mod places;
mod planes;
#[cfg(test)]
mod tests;

use super::bounds::{Aabb, Relative};
use super::bvh::{Cuboid, Seen, View};
use super::shape::ConvexSolid;
use crate::math::Vec3;
use crate::robot::Geometry;
pub use field::{Field, raised};
pub use half_space::HalfSpace;
pub use inner::{Stands, stand_ins};
pub use many::Many;
pub use pair::{closest, element_closest, element_in, lift, lifted, nearer};
pub use planes::Planes;

/// A shape that only obstacles have.
#[derive(Debug, Clone)]
pub enum Scenery {
    /// One convex shape at many places, not turned.
    Many(Box<Many>),
    /// All on one side of a plane.
    HalfSpace(HalfSpace),
    /// The ground below a grid of heights.
    Field(Field),
}

/// Half side \[m\] of a box around what has no end: more than any coordinate, small enough that its
/// digits reach a micrometre.
const ENDLESS: f64 = 4e9;

/// A node or an element: its level in the upper five bits, its number in the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct At(pub u32);

const LEVEL_BITS: u32 = 27;
const ELEMENT: u32 = 31;

impl At {
    fn new(level: usize, number: usize) -> Self {
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

    fn level(self) -> usize {
        (self.0 >> LEVEL_BITS) as usize
    }

    fn number(self) -> usize {
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
    seen: Option<(View, Seen)>,
    /// Lowest z \[m\] of the other shape's box.
    low: f64,
}

impl Scenery {
    /// Prepares scenery, with a box and a ball around it; `None` for what holds nothing and for
    /// shapes of other kinds.
    pub fn new(geometry: &Geometry) -> Option<(Self, Aabb, (Vec3, f64))> {
        match geometry {
            Geometry::Points(cloud) => Many::of_points(cloud).map(with_ball),
            Geometry::Voxels(voxels) => Many::of_voxels(voxels).map(with_ball),
            Geometry::HalfSpace { normal, offset } => {
                let all = Aabb { center: Vec3::zeros(), half: Vec3::repeat(ENDLESS) };
                let half_space = Self::HalfSpace(HalfSpace { normal: *normal, offset: *offset });
                Some((half_space, all, (Vec3::zeros(), 2.0 * ENDLESS)))
            }
            Geometry::HeightField(field) => {
                let field = Field::new(field)?;
                let bounds = field.bounds();
                Some((Self::Field(field), bounds, (Vec3::zeros(), 4.0 * ENDLESS)))
            }
            _ => None,
        }
    }

    /// Signed depth \[m\] of `point` where it is above `least`: positive inside, minus the distance
    /// outside.
    ///
    /// Of balls and cubes that in the deepest one, of cubes with what their neighbours add; of a
    /// height field that below the whole surface, and beside its walls it may be less than it is.
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        match self {
            Self::Many(many) => many.depth_above(point, least, stack),
            Self::HalfSpace(half) => Some(half.offset - half.normal.dot(point)).filter(|depth| *depth > least),
            Self::Field(field) => field.depth_above(point, least, stack),
        }
    }

    /// How a shape with box `bounds` stands to it.
    pub fn approach<'a>(&self, relative: &'a Relative, bounds: &'a Aabb) -> Approach<'a> {
        let pose = &relative.pose_a_b;
        let seen = match self {
            Self::Many(many) => {
                let cuboid = Cuboid::around(bounds);
                let view = View::new(pose, many.cuboid(), &cuboid);
                let seen = view.see(&cuboid, 0.0);
                Some((view, seen))
            }
            _ => None,
        };
        let reach: f64 = (0..3).map(|k| pose.rotation[(2, k)].abs() * bounds.half[k]).sum();
        Approach { relative, bounds, seen, low: pose.point(&bounds.center).z - reach }
    }

    /// The node that holds everything; `None` of a half-space.
    pub fn root(&self) -> Option<At> {
        match self {
            Self::Many(many) => Some(many.root()),
            Self::HalfSpace(_) => None,
            Self::Field(field) => Some(field.root()),
        }
    }

    /// Calls `each` with what a node is made of and what may be nearer than `limit` \[m\] to the
    /// other shape, and a lower bound \[m\] on how far it is (negative where boxes overlap).
    #[inline]
    pub fn open(&self, at: At, approach: &Approach, limit: f64, each: impl FnMut(f64, At)) {
        match self {
            Self::Many(many) => many.open(at, approach, limit, each),
            Self::HalfSpace(_) => {}
            Self::Field(field) => field.open(at, approach, limit, each),
        }
    }

    /// What `f` makes of an element; `None` where there is none of that number.
    #[inline]
    pub fn with_element<R>(&self, number: u32, approach: &Approach, f: impl FnOnce(Element) -> R) -> Option<R> {
        match self {
            Self::Many(many) => many.element(number).map(f),
            Self::HalfSpace(_) => None,
            Self::Field(field) => field.with_element(number, approach.low, f),
        }
    }
}

fn with_ball(many: Many) -> (Scenery, Aabb, (Vec3, f64)) {
    let bounds = *many.bounds();
    (Scenery::Many(Box::new(many)), bounds, (bounds.center, bounds.half.norm() * (1.0 + 1e-12)))
}

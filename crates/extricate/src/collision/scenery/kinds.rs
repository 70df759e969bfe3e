//! All kinds of scenery as one type, a tree of elements. No pairs.

use super::field::Field;
use super::half_space::HalfSpace;
use super::many::Many;
use super::nodes::{Approach, At, ENDLESS_HALF_SIDE_M, Element};
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::math::Vec3;
use crate::robot::Geometry;

/// A kind of shape that only obstacles have.
#[derive(Debug, Clone)]
pub enum Scenery {
    /// One convex shape at many places, without rotation.
    Many(Box<Many>),
    /// Everything on one side of a plane.
    HalfSpace(HalfSpace),
    /// Ground below a grid of heights.
    Field(Field),
}

impl Scenery {
    /// Prepares scenery with a bounding box and a bounding ball. `None` for empty scenery and for
    /// other geometry.
    pub fn new(geometry: &Geometry) -> Option<(Self, Aabb, (Vec3, f64))> {
        match geometry {
            Geometry::Points(cloud) => Many::of_points(cloud).map(with_ball),
            Geometry::Voxels(voxels) => Many::of_voxels(voxels).map(with_ball),
            Geometry::HalfSpace { normal, offset } => {
                let all = Aabb { center: Vec3::zeros(), half: Vec3::repeat(ENDLESS_HALF_SIDE_M) };
                let half_space = Self::HalfSpace(HalfSpace { normal: (*normal).into(), offset: *offset });
                Some((half_space, all, (Vec3::zeros(), 2.0 * ENDLESS_HALF_SIDE_M)))
            }
            Geometry::HeightField(field) => {
                let field = Field::new(field)?;
                let bounds = field.bounds();
                Some((Self::Field(field), bounds, (Vec3::zeros(), 4.0 * ENDLESS_HALF_SIDE_M)))
            }
            _ => None,
        }
    }

    /// Signed depth \[m\] of `point`, if above `least`: positive inside, minus the distance
    /// outside.
    ///
    /// For balls, it is the depth in the deepest one; for cubes, this plus what the neighbours add.
    /// For a height field, it is the depth in the whole ground, which beside the walls may be
    /// underestimated.
    pub fn depth_above(&self, point: &Vec3, least: f64, stack: &mut Vec<(f64, u32)>) -> Option<f64> {
        match self {
            Self::Many(many) => many.depth_above(point, least, stack),
            Self::HalfSpace(half) => Some(half.offset - half.normal.dot(point)).filter(|depth| *depth > least),
            Self::Field(field) => field.depth_above(point, least, stack),
        }
    }

    /// Prepares tests of nodes against a shape with box `bounds`.
    pub fn approach<'a>(&self, relative: &'a Relative, bounds: &'a Aabb) -> Approach<'a> {
        if let Self::Many(many) = self {
            return many.approach(relative, bounds);
        }
        let pose = &relative.pose_a_b;
        let reach: f64 = (0..3).map(|k| pose.rotation[(2, k)].abs() * bounds.half[k]).sum();
        Approach { relative, bounds, seen: None, low: pose.point(&bounds.center).z - reach }
    }

    /// Root node; a half-space has none.
    pub fn root(&self) -> Option<At> {
        match self {
            Self::Many(many) => Some(many.root()),
            Self::HalfSpace(_) => None,
            Self::Field(field) => Some(field.root()),
        }
    }

    /// Calls `each` for the children of a node that may be nearer than `limit` \[m\] to the other
    /// shape, with a lower bound \[m\] on their distance. The bound is negative if boxes overlap.
    #[inline]
    pub fn open(&self, at: At, approach: &Approach, limit: f64, each: impl FnMut(f64, At)) {
        match self {
            Self::Many(many) => many.open(at, approach, limit, each),
            Self::HalfSpace(_) => {}
            Self::Field(field) => field.open(at, approach, limit, each),
        }
    }

    /// Box around the contents of a node, if the tree keeps boxes.
    pub fn bounds_of(&self, at: At) -> Option<Aabb> {
        if let Self::Many(many) = self { Some(many.bounds_of(at)) } else { None }
    }

    /// Applies `f` to an element; `None` if the number is not in use.
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

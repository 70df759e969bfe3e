//! A prepared shape at a pose.

use super::shape::PreparedShape;
use crate::collision::shapes::Shape;
use crate::collision::shapes::inner_spheres::InnerSpheres;
use crate::math::Pose;

/// A prepared shape with its pose in the world.
#[derive(Clone, Copy)]
pub struct Placed<'a> {
    /// The shape and its derived data.
    pub prepared: &'a PreparedShape,
    /// Maps the frame of the shape to the world.
    pub pose: &'a Pose,
}

impl<'a> Placed<'a> {
    pub fn shape(self) -> &'a Shape {
        &self.prepared.shape
    }

    /// Returns the shape and the balls inside it.
    pub fn with_inner(self) -> (&'a Shape, &'a InnerSpheres) {
        (&self.prepared.shape, &self.prepared.inner)
    }
}

//! A prepared shape at a pose.

use super::shape::PreparedShape;
use crate::collision::shapes::Shape;
use crate::collision::shapes::inner_spheres::InnerSpheres;
use crate::math::Pose;

/// A shape and its pose in the world.
#[derive(Clone, Copy)]
pub struct Placed<'a> {
    /// The shape, with what is derived from it.
    pub prepared: &'a PreparedShape,
    /// Maps its frame to the world.
    pub pose: &'a Pose,
}

impl<'a> Placed<'a> {
    /// The shape itself.
    pub fn shape(self) -> &'a Shape {
        &self.prepared.shape
    }

    /// The shape and the balls in it.
    pub fn with_inner(self) -> (&'a Shape, &'a InnerSpheres) {
        (&self.prepared.shape, &self.prepared.inner)
    }
}

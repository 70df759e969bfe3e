//! Convex pieces as contacts use them: with boxes around them, eight side by side. They are made in
//! `cells` and `patches`.

use pulp::{Arch, Simd, WithSimd};

use crate::collision::shapes::Shape;
use crate::collision::shapes::bounds::Aabb;
use crate::collision::shapes::bvh::{Boxes, Cuboid, below, rounded_up, rounding_at};
use crate::math::{LANES, Vec3};

/// Convex shapes in one frame that together hold a shape, or its surface.
#[derive(Debug, Clone, Default)]
pub struct Pieces {
    shapes: Vec<Shape>,
    boxes: Vec<Boxes>,
    /// Index of the first piece that is parted from others by itself. Patches of a surface face
    /// several ways, and no direction parts all of them.
    pub first_apart: usize,
}

/// Borrowed [`Pieces`], or a convex shape that is its own only piece.
#[derive(Debug, Clone, Copy)]
pub struct PiecesRef<'a> {
    /// The pieces; none for scenery.
    pub shapes: &'a [Shape],
    /// Boxes around the pieces, eight at a time; none around a convex shape itself.
    pub boxes: &'a [Boxes],
    /// See [`Pieces::first_apart`].
    pub first_apart: usize,
}

impl Pieces {
    /// Puts boxes around pieces that are parted from others together.
    pub fn new(shapes: Vec<Shape>) -> Self {
        let bounds: Vec<Aabb> = shapes.iter().map(|shape| shape.bounds).collect();
        Self { boxes: bounds.chunks(LANES).map(Boxes::new).collect(), first_apart: shapes.len(), shapes }
    }

    /// Joins pieces that are parted from others together with pieces that are parted one by one.
    pub fn with_apart(mut together: Vec<Shape>, apart: Vec<Shape>) -> Self {
        let first_apart = together.len();
        together.extend(apart);
        Self { first_apart, ..Self::new(together) }
    }

    pub fn all(&self) -> PiecesRef<'_> {
        PiecesRef { shapes: &self.shapes, boxes: &self.boxes, first_apart: self.first_apart }
    }
}

impl PiecesRef<'_> {
    /// Returns whether the box of some piece of a mesh may be within `reach` \[m\] of `point`;
    /// `cuboid` holds all pieces.
    pub fn are_near(&self, point: &Vec3, reach: f64, cuboid: &Cuboid) -> bool {
        Arch::new().dispatch(AreNear { boxes: self.boxes, point, reach, cuboid })
    }
}

struct AreNear<'a> {
    boxes: &'a [Boxes],
    point: &'a Vec3,
    reach: f64,
    cuboid: &'a Cuboid,
}

impl WithSimd for AreNear<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let place = [self.point.x as f32, self.point.y as f32, self.point.z as f32];
        let (rounding, limit) = (rounding_at(self.point, self.cuboid), rounded_up(self.reach * self.reach));
        // `rounded_up` returns a limit above 0, so that a square of 0 is below it too.
        self.boxes.iter().any(|boxes| below(&boxes.distances_squared(simd, &place, rounding), limit) != 0)
    }
}

impl<'a> From<&'a Shape> for PiecesRef<'a> {
    fn from(convex: &'a Shape) -> Self {
        Self { shapes: std::slice::from_ref(convex), boxes: &[], first_apart: 1 }
    }
}

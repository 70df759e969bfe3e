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
mod kinds;
mod layers;
mod many;
mod pair;
mod places;
mod planes;
mod tree;

pub use field::raised;
pub use half_space::HalfSpace;
pub use inner::{Stands, stand_ins};
pub use kinds::Scenery;
pub use many::Many;
pub use pair::{closest, element_closest, element_in, from_half_space, lift, lifted, nearer};
pub use planes::Planes;
pub use tree::{At, Element};

#[cfg(test)]
mod tests;

//! Shapes that only obstacles have: many equal convex shapes, half-spaces, and the ground below a
//! grid of heights. Each finds its parts near another shape, so a check costs what is near.
//!
//! A [`Scenery`] is a tree with *elements* as leaves: convex shapes in its frame. `pair` checks and
//! measures them; `inner` offers convex sets for proofs. Two sceneries are never paired, since
//! neither moves.

mod field;
mod half_space;
mod inner;
mod kinds;
mod layers;
mod many;
mod nodes;
mod pair;
mod places;
mod planes;

pub use field::raised;
pub use half_space::HalfSpace;
pub use inner::{Stands, stand_ins};
pub use kinds::Scenery;
pub use many::Many;
pub use nodes::{At, Element};
pub use pair::{closest, element_closest, element_in, from_half_space, lift, lifted, nearer};
pub use planes::Planes;

#[cfg(test)]
mod tests;

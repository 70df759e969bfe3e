//! Distances and penetration depths of two convex shapes: `gjk` finds how far apart cores are,
//! `epa` how deep they overlap, both by support points of `minkowski`. `separation` combines them.

mod epa;
mod gjk;
mod minkowski;
mod separation;
mod warm_start;

pub use separation::{
    Separation, Slack, distance_within, nearer_than, nearer_than_from, separation, separation_from, separation_within,
};
pub use warm_start::{LastFeatures, separation_near};

#[cfg(test)]
mod tests;

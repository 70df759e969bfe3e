//! Distances and penetration depths of two convex shapes: `minkowski` is what both searches walk
//! on, `gjk` tells how far apart cores are, `epa` how deep they overlap; `separation` puts both
//! together.

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

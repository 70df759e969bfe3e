//! Memory of segment checks, and the stretches that they divide a segment into.

/// Memory that checks of segments reuse.
#[derive(Debug, Default)]
pub struct SegmentScratch {
    pub q: Vec<f64>,
    /// Rates of the tangent coordinates along the segment.
    pub rates: Vec<f64>,
    /// Bounds on the speeds of bodies \[m per segment\], body after body, frame after frame along
    /// its path to the world.
    pub speeds: Vec<f64>,
    /// Stretches to prove: a stack with the earliest on top, or a queue in a breadth-first proof.
    pub stretches: Vec<Stretch>,
    /// Pairs of all stretches, in the order in which the stretches were divided.
    pub pairs: Vec<u32>,
    /// Number of configurations evaluated for the last segment.
    pub checks: usize,
}

/// A part of the segment and the pairs that are not yet proved apart along all of it.
#[derive(Debug, Clone, Copy)]
pub struct Stretch {
    /// Fraction of the segment at which it begins.
    pub from: f64,
    /// Fraction of the segment at which it ends.
    pub to: f64,
    /// Index of its first pair in the list of pairs.
    pub first: usize,
    /// Index after its last pair.
    pub last: usize,
}

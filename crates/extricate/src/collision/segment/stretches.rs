//! Memory that checks of segments reuse.

/// Memory that checks of segments reuse.
#[derive(Debug, Default)]
pub struct SegmentScratch {
    /// A configuration of the segment.
    pub q: Vec<f64>,
    /// How fast tangent coordinates change along the segment.
    pub rates: Vec<f64>,
    /// Bounds on the speeds of bodies \[m per segment\], body after body along its path.
    pub speeds: Vec<f64>,
    /// Those not proved yet, earlier ones last.
    pub stretches: Vec<Stretch>,
    /// Pairs of stretches, those of later ones after those of earlier ones.
    pub pairs: Vec<u32>,
    /// Configurations at which the last segment was evaluated.
    pub checks: usize,
}

/// A part of the segment and the pairs that are not yet proved apart all along it.
#[derive(Debug, Clone, Copy)]
pub struct Stretch {
    /// Fraction of the segment where it begins.
    pub from: f64,
    /// Fraction of the segment where it ends.
    pub to: f64,
    /// Its first pair in the list of pairs.
    pub first: usize,
    /// Behind its last pair there.
    pub last: usize,
}

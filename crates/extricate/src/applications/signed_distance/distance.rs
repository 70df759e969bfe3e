//! What a search for a signed distance found.

use crate::cspace::Config;
use crate::query::constraints::SearchResult;
use crate::scene::PairId;

/// The signed distance of a configuration, see [`crate::Solver::signed_distance`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SignedDistance {
    /// Distance in metric units from the configuration to the witness: negative if the
    /// configuration collides, else 0 or more. It is infinite if nothing in contact was found, or
    /// nothing near enough.
    pub distance: f64,
    /// Proved bound of the same sign: no configuration nearer than this is on the other side. Its
    /// absolute value is at most that of `distance`.
    pub bound: f64,
    /// The nearest free configuration if the configuration collides. Otherwise the nearest one in
    /// contact: it is free, and collides if moved on by a ten-thousandth of the distance. `None` if
    /// there is none.
    pub witness: Option<Config>,
    /// Gradient of the distance in tangent coordinates, of length `nv`; zeros if there is no
    /// witness, or if the witness is the configuration.
    pub gradient: Vec<f64>,
    /// Pairs that collide at the configuration; for a free one, the pair that touches at the
    /// witness.
    pub pairs: Vec<PairId>,
    /// Number of configurations at which the exact checker evaluated anything.
    pub checks: usize,
    /// Whether a limit or a stop ended the search before it was done.
    pub cut_short: bool,
}

impl SearchResult for SignedDistance {
    fn nearest(&self) -> (f64, &[f64]) {
        (self.distance, self.witness.as_deref().unwrap_or_default())
    }
}

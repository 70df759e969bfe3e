//! Start of a descent: a configuration and its known contact planes.

use crate::query::context::Stored;
use crate::samples::contact_planes::Planes;

/// A configuration from which a descent starts, with its known contact planes.
#[derive(Clone, Copy)]
pub struct Start<'a> {
    /// The configuration; it may collide.
    pub config: &'a [f64],
    /// Contact planes of the free sample that the start was made from, if known.
    pub planes: Option<Planes<'a>>,
    /// Whether the planes cover all near contacts. If not, they can only prune the start, and the
    /// first step evaluates contacts.
    pub are_all: bool,
}

impl<'a> Start<'a> {
    /// Creates a start without known contacts.
    pub fn at(config: &'a [f64]) -> Self {
        Self { config, planes: None, are_all: false }
    }

    /// Creates a start from a stored sample and its planes that hold. `config` is the sample,
    /// possibly with some joints held still.
    pub fn stored(stored: &Stored<'a>, sample: u32, config: &'a [f64]) -> Self {
        let planes = stored.samples.planes(sample);
        let holding = |planes: Planes<'a>| stored.holding.map_or(planes, |holding| planes.of_pairs(holding));
        Self { config, planes: planes.map(holding), are_all: stored.holding.is_none() }
    }
}

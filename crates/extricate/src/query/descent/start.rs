//! Where a descent starts, and what is known of it.

use crate::query::context::Stored;
use crate::samples::contact_planes::Planes;

/// Where a descent starts.
#[derive(Clone, Copy)]
pub struct Start<'a> {
    /// The configuration; it may collide.
    pub config: &'a [f64],
    /// Its contacts, where it is free and they are known: the first step then needs no look at
    /// them.
    pub planes: Option<Planes<'a>>,
    /// Whether it has no others: only then the planes tell where it is safe to go, else they only
    /// tell where it leads nowhere.
    pub are_all: bool,
}

impl<'a> Start<'a> {
    /// From a configuration of which nothing is known.
    pub fn at(config: &'a [f64]) -> Self {
        Self { config, planes: None, are_all: false }
    }

    /// From a stored sample, at `config` if joints are held still, with what is known of it.
    pub fn stored(stored: &Stored<'a>, sample: u32, config: &'a [f64]) -> Self {
        let planes = stored.samples.planes(sample);
        let holding = |planes: Planes<'a>| stored.holding.map_or(planes, |holding| planes.of_pairs(holding));
        Self { config, planes: planes.map(holding), are_all: stored.holding.is_none() }
    }
}

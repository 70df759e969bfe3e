//! Where a descent starts, and what is known of it.

use crate::query::context::Context;
use crate::samples::contact_planes::{Elsewhere, Planes};

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

    /// From a stored sample, with what is known of it in this scene.
    pub fn of(context: &Context<'a>, sample: u32) -> Self {
        let of_planes = context.change.map(|change| change.of_planes());
        Self { config: context.samples().config(sample), ..Self::known(context, sample, of_planes) }
    }

    /// From a configuration of which planes of a stored sample hold, those of some pairs.
    pub fn known(context: &Context<'a>, sample: u32, holding: Option<Elsewhere<'a>>) -> Self {
        let planes = context.samples().planes(sample);
        let here = |planes: Planes<'a>| holding.map_or(planes, |elsewhere| planes.elsewhere(elsewhere));
        Self { config: &[], planes: planes.map(here), are_all: holding.is_none() }
    }
}

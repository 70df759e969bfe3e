//! Signed distance in configuration space: how far a configuration is from the boundary between
//! what collides and what is free.
//!
//! Inside it is minus the depth of a query. Outside it is the distance to the nearest configuration
//! in contact (`outside`). Both sides have a proved bound and a witness.

mod distance;
mod outside;

use std::ops::ControlFlow;

use crate::cspace::Config;
use crate::error::{Error, Result};
use crate::metric::motion_bound::MotionPath;
use crate::query::constraints::under;
use crate::query::evaluate::Evaluator;
use crate::query::report::free_radius::{Keeps, free_radius};
use crate::query::{Context, Deadline, QueryOptions, QueryScratch, query};
use crate::solver::{Answered, Solver, in_blocks};
pub use distance::SignedDistance;

impl Solver {
    /// Returns how far `q` is from the boundary of the free configurations: minus the depth of a
    /// query if it collides, else the distance to the nearest configuration in contact. A
    /// configuration is in contact if a checked pair is just at its clearance. Limits of joints are
    /// no contacts, but both witnesses are within them. A `q` beyond its limits is not free.
    ///
    /// `within` is a distance in metric units, above 0, beyond which a free configuration is far
    /// enough: the search ends once nothing is proved to touch within it. `None` searches on.
    ///
    /// Limits on checks and seconds, effort and locked joints are those of the options of this
    /// solver; the clearance is that of the scene. Returns `None` if `q` collides and nothing free
    /// was found.
    ///
    /// # Guarantee
    /// [`SignedDistance::bound`] is proved: outside, by bounds of the motion of each pair. The
    /// witness is verified by the exact checker. It is the nearest that the search found; outside,
    /// the true distance lies between the bound and the distance.
    ///
    /// # Errors
    /// [`Error::Option`] if `within` is not above 0.
    pub fn signed_distance(&self, q: &Config, within: Option<f64>) -> Result<Option<SignedDistance>> {
        let (context, within) = (self.context(), checked(within)?);
        let options = measuring(self.query_options());
        Ok(self.memory().of_queries(|scratch| signed_distance(&context, q, (&options, within), scratch)))
    }

    /// Computes many signed distances on `threads` threads (0: one per core) and passes them, in
    /// order, to `each`, which may end the batch. Returns the number passed on.
    ///
    /// # Guarantee
    /// Each is that of [`Solver::signed_distance`], whatever the number of threads.
    ///
    /// # Errors
    /// Those of [`Solver::signed_distance`].
    pub fn signed_distances(
        &self,
        queries: impl IntoIterator<Item = Config>,
        within: Option<f64>,
        threads: usize,
        each: &mut dyn FnMut(Answered<Option<SignedDistance>>) -> ControlFlow<()>,
    ) -> Result<usize> {
        let within = checked(within)?;
        self.prepare();
        let (context, options) = (self.context(), measuring(self.query_options()));
        let ask = |q: &Config, scratch: &mut QueryScratch| signed_distance(&context, q, (&options, within), scratch);
        Ok(in_blocks(&mut queries.into_iter(), threads, self.memory(), &ask, each))
    }

    /// Returns the radius of a ball around `q` in metric units in which everything is free; 0 if
    /// `q` is not. It is about [`SignedDistance::bound`], without the search for a contact.
    ///
    /// # Guarantee
    /// Proved: every configuration nearer to `q` than this that is within its limits is free.
    pub fn free_radius(&self, q: &Config) -> f64 {
        let context = self.context();
        self.memory().of_queries(|scratch| {
            let QueryScratch { evaluator, .. } = scratch;
            evaluator.begin(Deadline::default());
            if !is_free(&context, q, evaluator) {
                return 0.0;
            }
            free_radius(&context, q, (Keeps::Clearance, context.scale), evaluator, &mut MotionPath::default())
        })
    }
}

/// Checks the distance beyond which nothing matters, and returns it.
fn checked(within: Option<f64>) -> Result<f64> {
    match within {
        Some(within) if within > 0.0 => Ok(within),
        Some(within) => {
            let expected = "a number above 0".into();
            Err(Error::Option { name: "within", value: within.to_string(), expected })
        }
        None => Ok(f64::INFINITY),
    }
}

/// Returns these options without those that report more, or choose a farther witness.
fn measuring(options: &QueryOptions) -> QueryOptions {
    let QueryOptions { effort, starts, gap, locked, termination, .. } = options.clone();
    QueryOptions { effort, starts, gap, locked, termination, ..QueryOptions::default() }
}

fn is_free(context: &Context, q: &Config, evaluator: &mut Evaluator) -> bool {
    let is_within = context.checker.scene().space.outside(q).next().is_none();
    is_within && context.checker.colliding_pair(q, &mut evaluator.check).is_none()
}

fn signed_distance(
    context: &Context,
    q: &Config,
    (options, within): (&QueryOptions, f64),
    scratch: &mut QueryScratch,
) -> Option<SignedDistance> {
    if is_free(context, q, &mut scratch.evaluator) {
        return under(context, q, options, scratch, |context, options, _, scratch| {
            Some(outside::nearest_contact(context, q, within, &options.termination, scratch))
        });
    }
    let answer = query(context, q, options, scratch)?;
    Some(SignedDistance {
        distance: -answer.depth,
        bound: -answer.lower_bound,
        gradient: answer.gradient.iter().map(|slope| -slope).collect(),
        pairs: answer.colliding,
        checks: answer.checks,
        cut_short: answer.cut_short,
        witness: Some(answer.witness),
    })
}

#[cfg(test)]
mod tests;

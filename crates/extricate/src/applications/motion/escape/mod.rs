//! Escape: finds a path from a colliding configuration to a free one that makes nothing worse.
//!
//! Read in this order: `options` (options and result), `relaxed` (the set in which the path stays),
//! `search`, `mod` (the steps), `part_pairs`, `grow`, `needed`, `finish`.
//!
//! 1. *Set*: pairs that collide at `q` may overlap as deeply as there; all others keep their
//!    clearance (`relaxed`).
//! 2. *Straight*: try an edge to the nearest exit that keeps the aimed clearance, or as much of it
//!    as is kept nearby, then to other exits that the query met. It is proved to stay in the set.
//! 3. *Push*: part the colliding pairs little by little, each step from the end of the last one
//!    (`part_pairs`). Then try straight edges to more exits.
//! 4. Repeat steps 2 and 3 at the scene's clearance; go on from there toward the aim.
//! 5. *Grow*: run RRT-Connect in the set, between what was pushed and the exits (`grow`). Pushed
//!    and grown paths are shortened.
//! 6. *Finish*: find from where on the path is proved free, and measure it (`finish`). If there is
//!    no path, find out which tolerance has one (`needed`).

mod finish;
mod grow;
mod needed;
mod options;
mod part_pairs;
mod relaxed;
mod search;

pub use options::{Escape, EscapeMethod, EscapeOptions};

use super::path;
use super::prover::Prover;
use crate::collision::CheckScratch;
use crate::cspace::Config;
use crate::error::{Error, Result};
use crate::query::keep::LinkConstraint;
use crate::query::{Answer, Context, Deadline, QueryScratch};
use crate::solver::Solver;
use finish::finish;
use options::found_nothing;
use relaxed::Relaxed;
use search::Search;

impl Solver {
    /// Returns a path out of collision, from `q` to a free configuration. On the way no pair
    /// collides that does not at `q`, and none that does gets deeper by more than
    /// [`EscapeOptions::tolerance`]. From [`Escape::free_from`] on the path is free. Links of
    /// [`EscapeOptions::keep`] keep their places all along it.
    ///
    /// # Guarantee
    /// All of this is proved for every configuration of the path, not for samples. Depths are those
    /// of [`crate::Checker::clearance`]: exact for convex shapes, from below for meshes. Surfaces
    /// that cross have a depth of 0, however much of them is beyond. If no such path is found,
    /// [`Escape::points`] is empty; that proves nothing. The same solver, `q` and options give the
    /// same answer, unless a limit in seconds ends it.
    ///
    /// # Errors
    /// [`Error::Config`] if `q` lies beyond a limit, because a path cannot begin there: move it
    /// onto its limits first; or if a link that is to be kept is off there. [`Error::Option`] for
    /// an option that makes no sense.
    pub fn escape(&self, q: &Config, options: &EscapeOptions) -> Result<Escape> {
        options.check()?;
        let space = &self.scene().space;
        if let Some(at) = space.outside(q).next() {
            return Err(Error::Config {
                element: format!("coordinate {at}"),
                value: q[at].to_string(),
                expected: "a value within its limits: a path cannot begin beyond them".into(),
            });
        }
        let kept = LinkConstraint::kept_at(self.scene(), &options.keep, &[("q", q)])?;
        Ok(escape(&self.context().keeping(&kept), q, options))
    }
}

/// As [`Solver::escape`], for a query within its limits.
pub(super) fn escape(context: &Context, q: &Config, options: &EscapeOptions) -> Escape {
    let mut check = CheckScratch::default();
    let relaxed = Relaxed::at(context.checker, q, options.tolerance, &mut check);
    if relaxed.colliding.is_empty() {
        return options::is_free_already(q);
    }
    let prover =
        Prover::new(&relaxed.checker, options.resolution, Deadline::of(&options.termination)).holding(context.kept);
    let mut search =
        Search { context, q, options, relaxed: &relaxed, prover, query: QueryScratch::default(), has_exit: false };
    search.prover.checks += 1;
    let Some((points, method)) = search.find() else {
        // If nothing is free, no tolerance changes that.
        let needed_tolerance = if search.has_exit { search.needed_tolerance() } else { None };
        return Escape { needed_tolerance, ..found_nothing(&relaxed.colliding, search.prover.checks) };
    };
    finish(search, points, method)
}

/// Shortens an escape together with the free path `onward`, which begins at its end: a straight
/// edge from the query to a later point takes its place, if it is proved and does not collide for
/// longer. Returns the escape, and the index of the point of `onward` at which it ends.
pub(super) fn shortened_onward(
    context: &Context,
    q: &Config,
    options: &EscapeOptions,
    found: Escape,
    onward: &[Vec<f64>],
) -> (Escape, usize) {
    let relaxed = Relaxed::at(context.checker, q, options.tolerance, &mut CheckScratch::default());
    let colliding_length =
        |escape: &Escape| path::length(context.metric, &escape.points[..=escape.free_from].concat(), q.len());
    let most = colliding_length(&found);
    let (limit, mut checks) = (Deadline::of(&options.termination), 0);
    for at in (1..onward.len().min(1 + MAX_SKIPPED_POINTS)).rev() {
        if limit.is_reached(checks) {
            break;
        }
        let left = Deadline::of(&limit.left(checks));
        let mut prover = Prover::new(&relaxed.checker, options.resolution, left).holding(context.kept);
        if !prover.proves(q, &onward[at]) {
            checks += prover.checks;
            continue;
        }
        let search =
            Search { context, q, options, relaxed: &relaxed, prover, query: QueryScratch::default(), has_exit: false };
        let escape = finish(search, vec![q.to_vec(), onward[at].clone()], EscapeMethod::Exit);
        checks += escape.checks;
        if escape.is_found() && colliding_length(&escape) <= most {
            return (Escape { checks: found.checks + checks, ..escape }, at);
        }
    }
    (Escape { checks: found.checks + checks, ..found }, 0)
}

/// Exits besides the nearest one to which a straight edge is tried.
const OTHER_EXITS: usize = 4;
/// Points of a later path that a shortened escape skips at most.
const MAX_SKIPPED_POINTS: usize = 4;

/// A path, and the step that found it.
type FoundPath = (Vec<Vec<f64>>, EscapeMethod);

impl Search<'_> {
    fn find(&mut self) -> Option<FoundPath> {
        let wanted = self.query(1, self.aim())?;
        let (found, mut pushed) = self.lead_out(&wanted);
        if found.is_some() {
            return found;
        }
        let mut exits: Vec<Vec<f64>> = match self.options.exits {
            0 | 1 => vec![wanted.witness.into()],
            several => {
                self.query(several, wanted.clearance)?.exits.into_iter().map(|exit| exit.witness.into()).collect()
            }
        };
        if let Some(path) = self.straight(&exits) {
            return Some((path, EscapeMethod::Exit));
        }
        // A nearer exit may be reached if the path keeps the scene's clearance alone.
        if wanted.clearance > self.context.clearance {
            let own = self.query(1, self.context.clearance)?;
            let (found, other) = self.lead_out(&own);
            if let Some((path, method)) = found {
                return Some((self.raised(path), method));
            }
            exits.push(own.witness.into());
            pushed = if other.len() > pushed.len() { other } else { pushed };
        }
        let grown = grow::grow(self, &pushed, &exits)?;
        let path = self.shorter(grown);
        Some((self.raised(path), EscapeMethod::Grown))
    }

    /// Returns a path, straight or pushed, to the witness of an answer or to another exit that its
    /// query met. If there is none, also returns how far pushing came.
    fn lead_out(&mut self, answer: &Answer) -> (Option<FoundPath>, Vec<Vec<f64>>) {
        if let Some(path) = self.straight(&[answer.witness.to_vec()]) {
            return (Some((path, EscapeMethod::Nearest)), Vec::new());
        }
        let met = self.query.other_exits(&self.context.checker.scene().space, answer, OTHER_EXITS);
        let met: Vec<Vec<f64>> = met.into_iter().map(|(_, exit)| exit).collect();
        if let Some(path) = self.straight(&met) {
            return (Some((path, EscapeMethod::Exit)), Vec::new());
        }
        let pushed = part_pairs::push(self, answer.clearance);
        if pushed.is_out {
            let path = self.shorter(pushed.points);
            return (Some((path, EscapeMethod::Pushed)), Vec::new());
        }
        (None, pushed.points)
    }
}

#[cfg(test)]
mod tests;

//! Parts the colliding pairs little by little. Each step is the nearest exit from a set that is a
//! little smaller than the last, so the path bends around obstacles.

use super::search::Search;
use crate::query::{Context, QueryOptions, QueryScratch, nearest_exit};

/// Length of the first step, as a share of what the pairs have to part. A step whose edge is proved
/// is doubled, another is halved.
const FIRST_STEP_SHARE: f64 = 0.25;
/// Length of the least step that is tried, as the same share.
const MIN_STEP_SHARE: f64 = 1.0 / 64.0;
/// Descents of a step: the nearest exit of a set that is a little smaller is near.
const STARTS_PER_STEP: usize = 2;

pub struct PartedPairs {
    /// The query, and a configuration for every step; every edge is proved to stay in the set.
    pub points: Vec<Vec<f64>>,
    /// Whether the last one is free.
    pub is_out: bool,
}

/// Pushes the colliding pairs apart until they keep `clearance` \[m\], or a step fails.
pub fn push(search: &mut Search, clearance: f64) -> PartedPairs {
    let (mut points, mut memory) = (vec![search.q.to_vec()], QueryScratch::default());
    let (mut share, mut step) = (0.0, FIRST_STEP_SHARE);
    let space = &search.context.checker.scene().space;
    while share < 1.0 && step >= MIN_STEP_SHARE && !search.prover.is_spent() {
        let next = f64::min(1.0, share + step);
        let checker = search.relaxed.raised(search.context.checker, clearance, next);
        let Context { metric, balls, kept, .. } = *search.context;
        let context = Context::new(&checker, metric, balls, None).keeping(kept);
        let options =
            QueryOptions { starts: Some(STARTS_PER_STEP), termination: search.left(), ..QueryOptions::default() };
        let here = points[points.len() - 1].clone();
        let Ok(from) = space.config(&here) else { break };
        let answer = nearest_exit(&context, &from, &options, &mut memory);
        search.prover.checks += memory.checks();
        match answer.and_then(|answer| search.prover.join(&here, &answer.witness)) {
            Some(way) => {
                points.extend(way);
                (share, step) = (next, 2.0 * step);
            }
            None => step *= 0.5,
        }
    }
    PartedPairs { points, is_out: share >= 1.0 }
}

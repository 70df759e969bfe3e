//! Grows trees in the set of the escape, from the query and what was pushed, and from the exits.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::search::Search;
use crate::applications::motion::rrt_connect::RrtConnect;
use crate::cspace::sampling::uniform;

/// Longest edge, as a share of the distance from the query to the first exit in the set.
const MAX_EDGE_SHARE: f64 = 0.5;
/// Reach around the query of half of the samples, as a multiple of the same distance.
const SAMPLE_REACH_FACTOR: f64 = 4.0;

/// Returns a path in the set from the query to one of the exits.
pub fn grow(search: &mut Search, pushed: &[Vec<f64>], exits: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let context = search.context;
    let (metric, space) = (context.metric, &context.checker.scene().space);
    let (q, mut far) = (search.q, vec![0.0; search.q.len()]);
    let mut rng = ChaCha8Rng::seed_from_u64(search.options.seed);
    let inside: Vec<Vec<f64>> = exits.iter().filter(|exit| search.prover.holds(exit)).cloned().collect();
    let size = metric.distance(q, inside.first()?);
    let mut sample = |rng: &mut ChaCha8Rng, out: &mut [f64]| {
        uniform(space, rng, out);
        if rng.random::<bool>() {
            far.copy_from_slice(out);
            let share = (SAMPLE_REACH_FACTOR * size / metric.distance(q, &far)).min(1.0);
            space.interpolate(q, &far, share * rng.random::<f64>(), out);
        }
    };
    let limited = search.prover.limited(search.options.tree_checks);
    let mut trees = RrtConnect::new(metric, [pushed, &inside], MAX_EDGE_SHARE * size);
    let path = trees.grow(&mut search.prover, &mut sample, &mut rng);
    search.prover.unlimit(limited);
    let path = path?;
    // Proved edges join the pushed points, which are the roots of the first tree.
    let root = pushed.iter().position(|point| *point == path[0])?;
    Some(pushed[..root].iter().cloned().chain(path).collect())
}

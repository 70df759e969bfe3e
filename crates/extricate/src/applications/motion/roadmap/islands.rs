//! Islands: components that trees are to join to others.
//!
//! New nodes are joined by straight edges. In a narrow passage that bends, samplers find free
//! configurations that no straight edge leads to. A tree from there and one from around it meet.
//!
//! # Source
//! Trees as what a roadmap joins: E. Plaku, K. E. Bekris, B. Y. Chen, A. M. Ladd and L. E. Kavraki,
//! "Sampling-based roadmap of trees for parallel motion planning", IEEE Transactions on Robotics
//! 21(4), 2005, doi:10.1109/TRO.2005.847599. Deviation: trees grow from components, not from
//! samples.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::grower::Grower;
use crate::applications::motion::prover::Prover;
use crate::applications::motion::rrt_connect::RrtConnect;
use crate::cspace::sampling::uniform;

/// Maximum roots of a tree.
const MAX_ROOTS: usize = 24;
/// Neighbours of an island's node among which roots of both trees are searched.
const SEARCHED_NEIGHBOURS: usize = 100;
/// Checks of one attempt to join an island.
const ATTEMPT_CHECKS: usize = 400;
/// Largest distance of samples from a root, as a share of that of random configurations.
const SAMPLE_SHARE: f64 = 0.2;
/// Longest edge of a tree, as a share of the metric's diameter.
const MAX_EDGE_SHARE: f64 = 0.05;

/// Two grown trees: their roots, the nodes that grew with their parents, and whether the trees met.
pub struct Trees {
    pub roots: [Vec<usize>; 2],
    pub grown: [Vec<(Vec<f64>, usize)>; 2],
    pub has_met: bool,
}

/// Returns the nodes of each component but the largest, in order of their first nodes.
pub fn islands(grower: &Grower) -> Vec<Vec<usize>> {
    let mut components: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for node in 0..grower.nodes.len() {
        components.entry(grower.components.root(node)).or_default().push(node);
    }
    let largest = components.iter().max_by_key(|(root, nodes)| (nodes.len(), usize::MAX - **root));
    let largest = largest.map(|(root, _)| *root);
    components.into_iter().filter(|(root, _)| Some(*root) != largest).map(|(_, nodes)| nodes).collect()
}

/// Grows a tree from a random island and one from what is around it. Returns `None` if only the
/// island's own nodes are near.
pub fn grow_trees(grower: &Grower, islands: &[Vec<usize>], index: u64, prover: &mut Prover) -> Option<Trees> {
    let mut rng = ChaCha8Rng::seed_from_u64(grower.roadmap.seed);
    rng.set_stream(index);
    let island = &islands[rng.random_range(0..islands.len())];
    let middle = island[rng.random_range(0..island.len())];
    let near = grower.nodes.near(grower.nodes.config(middle), SEARCHED_NEIGHBOURS);
    let (own, others): (Vec<usize>, Vec<usize>) = near.into_iter().partition(|n| grower.are_joined(*n, middle));
    if others.is_empty() {
        return None;
    }
    let roots = [own, others].map(|nodes| nodes.into_iter().take(MAX_ROOTS).collect::<Vec<usize>>());
    let config = |node: &usize| grower.nodes.config(*node).to_vec();
    let configs = [0, 1].map(|side| roots[side].iter().map(config).collect::<Vec<_>>());
    let metric = grower.nodes.metric();
    let (space, mut far) = (&metric.scene().space, vec![0.0; configs[0][0].len()]);
    let mut sample = |rng: &mut ChaCha8Rng, out: &mut [f64]| {
        let around = &configs[rng.random_range(0..2)];
        let root = &around[rng.random_range(0..around.len())];
        uniform(space, rng, &mut far);
        space.interpolate(root, &far, SAMPLE_SHARE * rng.random::<f64>().powi(2), out);
    };
    let mut trees = RrtConnect::new(metric, [&configs[0], &configs[1]], MAX_EDGE_SHARE * metric.diameter());
    let limited = prover.limited(ATTEMPT_CHECKS);
    let has_met = trees.grow(prover, &mut sample, &mut rng).is_some();
    prover.unlimit(limited);
    Some(Trees { roots, grown: trees.grown(), has_met })
}

/// Adds what grew; returns whether that joined two components.
pub fn take_trees(grower: &mut Grower, trees: Trees) -> bool {
    let Trees { roots, grown, has_met } = trees;
    let mut ends = [roots[0][0], roots[1][0]];
    for (side, (mut nodes, grown)) in roots.into_iter().zip(grown).enumerate() {
        for (q, parent) in grown {
            let node = grower.push(&q);
            grower.join(node, &[nodes[parent]]);
            nodes.push(node);
            ends[side] = node;
        }
    }
    // Trees that meet end in the same configuration.
    let [a, b] = ends;
    has_met && grower.nodes.config(a) == grower.nodes.config(b) && grower.join(a, &[b]) > 0
}

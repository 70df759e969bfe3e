//! Leads a proxy that was left behind to the nearest exit, along a path that is proved free.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::proxy::toward;
use crate::applications::motion::prover::Prover;
use crate::applications::motion::rrt_connect::{MAX_EDGE_SHARE, RrtConnect};
use crate::applications::motion::shortcut::shortcut;
use crate::cspace::sampling::uniform;
use crate::query::evaluate::Evaluator;
use crate::query::{Context, Deadline, Termination};

/// A proxy is behind if it is farther from the query than this multiple of the nearest exit.
const BEHIND_FACTOR: f64 = 1.5;
/// The proxy may be this much farther in any case, as a share of the metric's diameter.
const BEHIND_SHARE: f64 = 1e-3;
/// Frames in a row that a proxy has to be behind before a detour is searched: contacts mostly let
/// it go on sooner.
const MIN_FRAMES_BEHIND: usize = 2;
/// Checks of the trees in one frame.
const CHECKS_PER_FRAME: usize = 200;
/// Checks after which the trees begin anew, and frames until then: the proxy or its goal may be
/// elsewhere by that time.
const MAX_CHECKS: usize = 10_000;
const PAUSE_FRAMES: usize = 200;
/// Frames until another path is searched if one could not be walked.
const RETRY_FRAMES: usize = 16;
/// Longest move along a detour in one frame, as a share of the metric's diameter.
const MAX_MOVE_SHARE: f64 = 0.05;

/// A path on which a proxy goes back to the nearest exit, at a bounded speed.
#[derive(Default)]
pub struct Detour {
    /// Configurations still to visit, the next one last.
    path: Vec<Vec<f64>>,
    /// Frames in a row in which the proxy was behind.
    behind: usize,
    /// Trees of the proxy and of its goal.
    trees: [Tree; 2],
    /// Checks spent on the trees.
    checks: usize,
    /// Value of `behind` at which the next search begins.
    next_search: usize,
    /// Number of searches so far, the seed of the next one.
    searches: u64,
}

impl Detour {
    /// Forgets the path and the frames so far.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    pub fn is_walked(&self) -> bool {
        !self.path.is_empty()
    }

    /// Returns where the proxy goes in this frame: toward the next point of the path, by a bounded
    /// move. The caller proves the move, since the scene may have changed, and drops the path if
    /// that fails.
    pub fn next(&self, context: &Context, from: &[f64], max_move: Option<f64>) -> Option<Vec<f64>> {
        let to = self.path.last()?;
        let own = MAX_MOVE_SHARE * context.metric.diameter();
        Some(toward(context, from, to, max_move.map_or(own, |most| most.min(own))))
    }

    /// Notes that the proxy is at `config`, and forgets the point of the path that it has reached.
    pub fn pass(&mut self, config: &[f64]) {
        if self.path.last().is_some_and(|next| next == config) {
            self.path.pop();
        }
    }

    /// Gives up the path, and searches another after a pause.
    pub fn drop_path(&mut self) {
        if !self.path.is_empty() {
            self.path.clear();
            self.next_search = self.behind + RETRY_FRAMES;
        }
    }

    /// Notes how far the proxy is from the query in this frame. Returns whether a detour is to be
    /// searched now.
    pub fn is_due(&mut self, context: &Context, depth: f64, nearest: f64) -> bool {
        if depth <= BEHIND_FACTOR * nearest + BEHIND_SHARE * context.metric.diameter() {
            (self.behind, self.next_search) = (0, 0);
            self.path.clear();
            self.begin_anew();
            return false;
        }
        self.behind += 1;
        self.path.is_empty() && self.behind >= self.next_search.max(MIN_FRAMES_BEHIND)
    }

    fn begin_anew(&mut self) {
        self.trees = Default::default();
        self.checks = 0;
    }

    /// Goes on with the search of a path in the free space of `context`, from the proxy to its
    /// goal.
    pub fn search(&mut self, context: &Context, [from, to]: [&[f64]; 2], resolution: f64, evaluator: &mut Evaluator) {
        // Joints that the query keeps locked are no way back.
        let mut held = from.to_vec();
        context.hold(to, &mut held);
        if held != from {
            return;
        }
        let prover = |evaluator: &Evaluator| {
            let left = evaluator.limit.left(evaluator.checks);
            let checks = left.max_checks.map_or(CHECKS_PER_FRAME, |most| most.min(CHECKS_PER_FRAME));
            Prover::new(context.checker, resolution, Deadline::of(&Termination { max_checks: Some(checks), ..left }))
        };
        let mut rng = ChaCha8Rng::seed_from_u64(self.searches);
        self.searches += 1;
        let mut growing = prover(evaluator);
        let found = self.grow(context, [from, to], &mut growing, &mut rng);
        self.checks += growing.checks;
        evaluator.checks += growing.checks;
        if let Some(mut path) = found {
            let mut shortening = prover(evaluator);
            shortcut(&mut shortening, context.metric, &mut path, &mut rng);
            evaluator.checks += shortening.checks;
            path.reverse();
            path.pop();
            self.path = path;
            self.begin_anew();
        } else if self.checks > MAX_CHECKS {
            self.begin_anew();
            self.next_search = self.behind + PAUSE_FRAMES;
        }
    }

    /// Returns a path, or adds to the trees.
    fn grow(
        &mut self,
        context: &Context,
        ends: [&[f64]; 2],
        prover: &mut Prover,
        rng: &mut ChaCha8Rng,
    ) -> Option<Vec<Vec<f64>>> {
        if prover.proves(ends[0], ends[1]) {
            return Some(ends.map(<[f64]>::to_vec).to_vec());
        }
        for (tree, end) in self.trees.iter_mut().zip(ends) {
            tree.attach(prover, end);
        }
        let (metric, space) = (context.metric, &context.checker.scene().space);
        let mut sample = |rng: &mut ChaCha8Rng, out: &mut [f64]| {
            uniform(space, rng, out);
            context.hold(ends[1], out);
        };
        let roots = self.trees.each_ref().map(|tree| tree.configs.as_slice());
        let mut trees = RrtConnect::new(metric, roots, MAX_EDGE_SHARE * metric.diameter());
        let Some(path) = trees.grow(prover, &mut sample, rng) else {
            for (tree, grown) in self.trees.iter_mut().zip(trees.grown()) {
                for (config, parent) in grown {
                    tree.configs.push(config);
                    tree.parents.push(Some(parent));
                }
            }
            return None;
        };
        let [first, second] = &self.trees;
        let mut whole = first.way_from_end(&path[0])?;
        whole.extend(path.iter().skip(1).cloned());
        let back = second.way_from_end(&path[path.len() - 1])?;
        whole.extend(back.into_iter().rev().skip(1));
        Some(whole)
    }
}

/// A tree that goes on growing in later frames. One of its nodes is where its end is now.
#[derive(Default)]
struct Tree {
    configs: Vec<Vec<f64>>,
    parents: Vec<Option<usize>>,
    end: usize,
}

impl Tree {
    /// Notes where the end of the tree is now. If no edge is proved to there, the tree begins anew.
    fn attach(&mut self, prover: &mut Prover, end: &[f64]) {
        if self.configs.get(self.end).is_some_and(|config| config == end) {
            return;
        }
        let is_joined = self.configs.get(self.end).is_some_and(|last| prover.proves(last, end));
        if !is_joined {
            *self = Self::default();
        }
        self.parents.push(is_joined.then_some(self.end));
        self.end = self.configs.len();
        self.configs.push(end.to_vec());
    }

    /// Returns the way from the end to another node, through the tree.
    fn way_from_end(&self, config: &[f64]) -> Option<Vec<Vec<f64>>> {
        let to = self.configs.iter().position(|node| node == config)?;
        let ancestors =
            |node| std::iter::successors(Some(node), |node: &usize| self.parents[*node]).collect::<Vec<_>>();
        let (mut down, mut up) = (ancestors(self.end), ancestors(to));
        // Both lists end at the root; what they share beyond the first common node is no way.
        while down.len() > 1 && up.len() > 1 && down[down.len() - 2] == up[up.len() - 2] {
            down.pop();
            up.pop();
        }
        up.pop();
        Some(down.into_iter().chain(up.into_iter().rev()).map(|node| self.configs[node].clone()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::applications::stream::StreamOptions;
    use crate::collision::{SegmentOptions, SegmentOutcome};
    use crate::cspace::sampling::Halton;
    use crate::scene::builtin;
    use crate::solver::Solver;

    /// Straight queries through the whole space leave a proxy behind in most frames if it has no
    /// detours.
    #[test]
    fn a_proxy_that_was_left_behind_finds_back() {
        let (mut frames, mut behind, mut walked) = (0, 0, 0);
        for name in ["planar-arm", "shelf-arm"] {
            let solver = Solver::new(builtin::scene(name).unwrap());
            let (space, metric) = (&solver.scene().space, solver.metric());
            let mut stream = solver.stream(StreamOptions::default().continuous(true)).unwrap();
            let halton = Halton::new(space.nv(), 7);
            let mut ends = vec![vec![0.0; space.nq()]; 4];
            ends.iter_mut().enumerate().for_each(|(k, q)| halton.config(space, k as u64, q));
            let (mut before, mut q, mut scratch) = (Vec::new(), vec![0.0; space.nq()], Default::default());
            for (from, to) in ends.iter().zip(&ends[1..]) {
                for frame in 0..200 {
                    space.interpolate(from, to, f64::from(frame) / 200.0, &mut q);
                    let answer = stream.query(&space.config(&q).unwrap()).unwrap();
                    let nearest = answer.nearest.unwrap();
                    assert!(answer.verified && answer.depth >= nearest - 1e-9, "{name}: {} {nearest}", answer.depth);
                    if answer.detour && !before.is_empty() {
                        let moved = metric.distance(&before, &answer.witness);
                        assert!(moved <= MAX_MOVE_SHARE * metric.diameter() + 1e-9, "{name}, frame {frame}: {moved}");
                    }
                    if !before.is_empty() {
                        let options = SegmentOptions { resolution: 2e-5 };
                        let moved = solver.checker().segment(&before, &answer.witness, &options, &mut scratch);
                        assert!(!matches!(moved, SegmentOutcome::Contact { .. }), "{name}, frame {frame}: {moved:?}");
                    }
                    frames += 1;
                    walked += usize::from(answer.detour);
                    behind += usize::from(answer.depth > 1.5 * nearest + BEHIND_SHARE * metric.diameter());
                    before = answer.witness.to_vec();
                }
            }
        }
        assert!(walked > 5 && 2 * behind < frames, "{walked} walked, {behind} behind, of {frames} frames");
    }
}

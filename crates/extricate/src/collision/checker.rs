//! The checked pairs of a scene and the scratch memory of checks: how both are made, and the check
//! of one pair at a placed configuration. The queries on them are in `answers`.

use std::collections::BinaryHeap;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::collision::answers::recent_pairs::RecentPairs;
use crate::collision::broad_phase::{Broad, BroadScratch};
use crate::collision::contacts::ContactBuffers;
use crate::collision::narrow_phase::best_first::Entry;
use crate::collision::narrow_phase::{self, Buffers, SeparatingWitness};
use crate::collision::prepared::{Bodies, Placement, TreeArrays};
use crate::collision::segment::speed_paths::SpeedPaths;
use crate::collision::segment::stretches::SegmentScratch;
use crate::kinematics::{LANES, PoseBlock};
use crate::math::Pose;
use crate::scene::clearances::PairClearance;
use crate::scene::{PairId, Scene};

/// The checked pairs of one scene, prepared for fast checks. Immutable; threads share it.
pub struct Checker {
    pub(super) scene: Arc<Scene>,
    pub(super) bodies: Arc<Bodies>,
    pub(super) pairs: Arc<[CheckedPair]>,
    pub(super) broad: Arc<Broad>,
    pub(super) paths: Arc<SpeedPaths>,
    /// Whether the convex pieces of all meshes are made; shared like `bodies`.
    pub(super) is_prepared: Arc<AtomicBool>,
    hints: usize,
    /// Clearance of pairs without one of their own \[m\].
    pub(super) clearance: f64,
    /// Greatest clearance of any pair \[m\].
    pub(super) most_clearance: f64,
    /// Whether each pair is checked; `None` if all are.
    only: Option<Arc<Vec<bool>>>,
    /// Identifies the checker whose hints a scratch holds.
    id: u64,
}

#[derive(Clone, Copy)]
pub(super) struct CheckedPair {
    pub(super) first: usize,
    pub(super) second: usize,
    /// Sum of the radii of the balls around the bodies \[m\].
    pub(super) radii: f64,
    /// Index of the hint of its first pair of parts.
    hints: usize,
    clearance: PairClearance,
}

/// Scratch memory that checks reuse; each thread needs its own.
///
/// It remembers which pairs collided last and at which features, so that checks try those first. No
/// label depends on it; contacts may, see [`CheckScratch::forget_contacts`].
#[derive(Default)]
pub struct CheckScratch {
    owner: u64,
    pub(super) placement: Placement,
    pub(super) block: PoseBlock,
    /// Centres of the moving bodies at the configurations of `block` \[m\].
    pub(super) centers: Vec<[[f64; LANES]; 3]>,
    pub(super) broad: BroadScratch,
    /// Whether the pose of some body is not finite: then every checked pair counts as colliding.
    pub(super) nowhere: bool,
    pub(super) history: RecentPairs,
    /// One hint for every pair of parts.
    pub(super) hints: Vec<SeparatingWitness>,
    pub(super) queue: BinaryHeap<Entry>,
    pub(super) buffers: Buffers,
    pub(super) contact_buffers: ContactBuffers,
    pub(super) segment: SegmentScratch,
}

impl fmt::Debug for Checker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Checker")
            .field("pairs", &self.pairs.len())
            .field("clearance", &self.clearance)
            .finish_non_exhaustive()
    }
}

impl fmt::Debug for CheckScratch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CheckScratch").finish_non_exhaustive()
    }
}

impl Checker {
    /// Prepares every checked pair of `scene`.
    pub fn new(scene: Arc<Scene>) -> Self {
        let bodies = Bodies::new(&scene, None);
        Self::prepare(scene, bodies)
    }

    /// Prepares `scene` with the triangle trees of another checker of the same scene; `None` if
    /// they cannot be those. Trees only order triangles, so no answer depends on them.
    pub(crate) fn with_trees(scene: Arc<Scene>, kept: &TreeArrays) -> Option<Self> {
        let bodies = Bodies::with_layouts(&scene, kept.layouts()?)?;
        Some(Self::prepare(scene, bodies))
    }

    /// Prepares another scene, such as one in which an obstacle moved, and shares what this checker
    /// has prepared of equal bodies. Answers are those of [`Checker::new`].
    pub(crate) fn for_scene(&self, scene: Arc<Scene>) -> Self {
        let bodies = Bodies::new(&scene, Some((&self.scene, &self.bodies)));
        Self::prepare(scene, bodies)
    }

    fn prepare(scene: Arc<Scene>, bodies: Bodies) -> Self {
        static NEXT_ID: AtomicU64 = AtomicU64::new(1);
        let mut hints = 0;
        let prepare = |(pair, clearance): (&crate::scene::BodyPair, PairClearance)| {
            let (a, b) = (&bodies.bodies[pair.first], &bodies.bodies[pair.second]);
            let radii = a.ball.1 + b.ball.1;
            let start = hints;
            hints += a.parts.len() * b.parts.len();
            CheckedPair { first: pair.first, second: pair.second, radii, hints: start, clearance }
        };
        let clearances = scene.pair_clearances();
        let pairs = scene.pairs.iter().zip(clearances).map(prepare).collect();
        let broad = Broad::new(&scene, &bodies).into();
        let paths = SpeedPaths::new(&scene).into();
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        let (bodies, clearance) = (bodies.into(), scene.clearance);
        let is_prepared = Arc::default();
        Self { bodies, pairs, broad, paths, is_prepared, hints, clearance, most_clearance: 0.0, only: None, id, scene }
            .with_clearance(clearance)
    }

    /// Returns a checker of the same pairs with `clearance` \[m\] in place of the scene's; pairs
    /// with a clearance of their own keep it. It shares all prepared data, and a scratch serves
    /// both.
    pub fn with_clearance(&self, clearance: f64) -> Self {
        let Self { scene, bodies, pairs, broad, paths, is_prepared, hints, only, id, .. } = self;
        let most_clearance = pairs.iter().map(|pair| pair.clearance.over(clearance)).fold(0.0, f64::max);
        Self {
            scene: Arc::clone(scene),
            bodies: Arc::clone(bodies),
            pairs: Arc::clone(pairs),
            broad: Arc::clone(broad),
            paths: Arc::clone(paths),
            is_prepared: Arc::clone(is_prepared),
            hints: *hints,
            clearance,
            most_clearance,
            only: only.clone(),
            id: *id,
        }
    }

    /// Returns a checker for which only marked pairs collide or are near. A scratch serves both.
    pub(crate) fn only(&self, marked: Arc<Vec<bool>>) -> Self {
        Self { only: Some(marked), ..self.with_clearance(self.clearance) }
    }

    /// Returns whether a pair is checked; see [`Checker::only`].
    pub(super) fn is_checked(&self, pair: u32) -> bool {
        self.only.as_ref().is_none_or(|only| only[pair as usize])
    }

    /// Returns a checker in which the pairs of `floors` keep the given signed distances \[m\]
    /// instead of their clearances. A floor below 0 allows bodies to overlap by that depth, as
    /// [`Checker::clearance`] measures it. A scratch serves both.
    pub(crate) fn with_floors(&self, floors: &[(PairId, f64)]) -> Self {
        let mut pairs = self.pairs.to_vec();
        for (pair, floor) in floors {
            pairs[pair.index()].clearance = PairClearance { own: Some(*floor), padding: 0.0 };
        }
        Self { pairs: pairs.into(), ..self.with_clearance(self.clearance) }.with_clearance(self.clearance)
    }

    /// Returns the radius of the ball around the smallest moving body \[m\], a length scale of what
    /// moves; 1 if there is none.
    pub(crate) fn moving_radius(&self) -> f64 {
        let radii = self.broad.movers().map(|body| self.bodies.bodies[body].ball.1);
        let least = radii.filter(|radius| *radius > 0.0).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 1.0 }
    }

    /// Returns the clearance of pairs without one of their own \[m\].
    pub(crate) fn base_clearance(&self) -> f64 {
        self.clearance
    }

    /// Returns the clearance of a checked pair \[m\].
    pub(crate) fn clearance_of(&self, pair: usize) -> f64 {
        self.pairs[pair].clearance.over(self.clearance)
    }

    /// Returns how much more than [`Checker::base_clearance`] a pair keeps \[m\]; below 0 if it
    /// keeps less.
    pub(crate) fn excess(&self, pair: usize) -> f64 {
        self.clearance_of(pair) - self.clearance
    }

    /// Returns the scene that is checked.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the shared handle of the scene.
    pub fn scene_arc(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Computes where all bodies are at `q`.
    pub(super) fn place(&self, q: &[f64], scratch: &mut CheckScratch) {
        self.adopt(scratch);
        scratch.nowhere = false;
        self.bodies.place(&self.scene, q, &mut scratch.placement);
    }

    /// Prepares a scratch that served another checker, or none.
    pub(super) fn adopt(&self, scratch: &mut CheckScratch) {
        if scratch.owner != self.id {
            scratch.owner = self.id;
            scratch.placement = self.bodies.placement();
            scratch.history = RecentPairs::new(self.pairs.len());
            scratch.hints.clear();
            scratch.hints.resize(self.hints, SeparatingWitness::default());
            scratch.contact_buffers.forget();
        }
    }

    /// Collects the pairs that may be nearer than `margin` \[m\] once everything is placed; all
    /// pairs if a pose is not finite.
    pub(super) fn find_near(&self, margin: f64, scratch: &mut CheckScratch) {
        let centers = &scratch.placement.centers;
        scratch.nowhere = !self.broad.movers().all(|body| centers[body].iter().all(|x| x.is_finite()));
        if scratch.nowhere {
            scratch.broad.pairs.clear();
            scratch.broad.pairs.extend(0..self.pairs.len() as u32);
        } else {
            self.broad.find(self.broad.movers().map(|body| centers[body]), margin, &mut scratch.broad);
        }
        if self.only.is_some() {
            scratch.broad.pairs.retain(|pair| self.is_checked(*pair));
        }
    }

    /// Returns whether two placed bodies are nearer than their clearance.
    pub(super) fn pair_collides(&self, pair: usize, scratch: &mut CheckScratch) -> bool {
        self.pair_nearer(pair, self.clearance_of(pair), scratch)
    }

    /// Returns whether two placed bodies are nearer than `limit` \[m\].
    pub(super) fn pair_nearer(&self, pair: usize, limit: f64, scratch: &mut CheckScratch) -> bool {
        scratch.nowhere
            || self.part_pairs(pair).any(|(first, second, hint)| {
                let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
                if limit < 0.0 {
                    return narrow_phase::signed_distance(a, b, limit, &mut scratch.buffers).is_some();
                }
                narrow_phase::nearer(a, b, limit, &mut scratch.hints[hint], &mut scratch.buffers)
            })
    }

    /// Returns whether balls inside two placed bodies prove that they are nearer than their
    /// clearance.
    pub(super) fn pair_seen_to_collide(&self, pair: usize, scratch: &mut CheckScratch) -> bool {
        // Below 0 balls prove nothing: they may overlap by more than the depth of a mesh, which is
        // measured from below.
        let may_tell = self.clearance_of(pair) >= 0.0;
        may_tell
            && self.part_pairs(pair).any(|(first, second, _)| {
                let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
                narrow_phase::proved_nearer(a, b, self.clearance_of(pair))
            })
    }

    /// Returns the pairs of parts of two bodies, each with the index of its hint.
    pub(super) fn part_pairs(&self, pair: usize) -> impl Iterator<Item = (usize, usize, usize)> + use<'_> {
        let pair = &self.pairs[pair];
        let (a, b) = (&self.bodies.bodies[pair.first].parts, &self.bodies.bodies[pair.second].parts);
        a.clone().flat_map(move |i| b.clone().map(move |j| (i, j))).zip(pair.hints..).map(|((i, j), h)| (i, j, h))
    }
}

impl CheckScratch {
    /// Forgets the contacts from which later searches start. Otherwise, exact contacts depend on
    /// earlier calls within rounding.
    pub fn forget_contacts(&mut self) {
        self.contact_buffers.forget();
    }

    /// Returns at how many configurations the last checked segment was evaluated.
    pub(crate) fn segment_checks(&self) -> usize {
        self.segment.checks
    }

    /// Returns the world poses of the frames at the configuration that was last checked.
    pub fn poses(&self) -> &[Pose] {
        &self.placement.poses
    }
}

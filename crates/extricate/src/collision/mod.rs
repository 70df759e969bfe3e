//! The exact checker: which pairs of a scene keep the clearance at a configuration, and signed distances where they nearly
//! do not. In f64 throughout.
//!
//! Convex shapes meet in `gjk` and `epa`; meshes are trees of triangles (`bvh`) that descend
//! together, end in exact distances of triangles, and then ask whether one solid holds the other
//! (`inside`). Clouds, grids and the ground (`scenery`) tell which of their parts are near.

mod bodies;
mod bounds;
mod broad;
mod bvh;
#[cfg(test)]
mod checker_tests;
mod contact;
pub mod convex;
mod convex_contact;
mod convex_pair;
mod cover;
mod depth;
pub mod epa;
mod filter;
mod found;
pub mod gjk;
mod inner_pair;
mod inner_pieces;
mod inside;
mod label;
mod mesh_convex;
mod mesh_mesh;
mod mesh_shape;
mod orient;
mod overlaps;
mod pair_memory;
mod part_pair;
mod pieces;
mod queue;
mod scenery;
mod segment;
#[cfg(test)]
mod segment_tests;
mod shape;
mod shape_pair;
mod still;
#[cfg(test)]
mod test_mesh;
mod triangle;

use std::collections::BinaryHeap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::kinematics::{LANES, PoseBlock};
use crate::math::Pose;
use crate::scene::Scene;
use crate::scene::clearances::PairClearance;
use crate::scene::matching::by_name;

use bodies::{Bodies, Placement};
use broad::{Broad, BroadScratch};
use contact::ContactBuffers;
pub use convex_pair::ConvexPair;
pub use cover::largest_balls;
pub use found::{
    Contact, ContactQuery, ContactSearch, always_colliding, contacts_within, most_often_colliding, signed_distances,
};
use label::History;
pub use overlaps::ConvexOverlap;
use part_pair::{Buffers, Hint};
pub use pieces::{KeptPieces, convex_parts};
use queue::Entry;
pub use segment::{LEAST_RESOLUTION, SegmentOptions, SegmentOutcome};
use segment::{SegmentScratch, SpeedPaths};
pub use shape_pair::{PairScratch, PreparedShape};

/// The checked pairs of one scene, with all that makes checks fast. Immutable, shared between threads.
pub struct Checker {
    scene: Arc<Scene>,
    bodies: Arc<Bodies>,
    pairs: Arc<[CheckedPair]>,
    broad: Arc<Broad>,
    paths: Arc<SpeedPaths>,
    hints: usize,
    /// Of pairs that follow the scene's \[m\].
    clearance: f64,
    /// Greatest of any pair \[m\].
    most_clearance: f64,
    /// Tells whose hints a scratch holds.
    id: u64,
}

struct CheckedPair {
    first: usize,
    second: usize,
    /// Sum of the radii of the bodies' balls \[m\].
    radii: f64,
    /// Where the hints of its pairs of parts start.
    hints: usize,
    /// What it keeps.
    clearance: PairClearance,
}

/// Memory that checks reuse; one per thread.
///
/// It remembers when pairs collided last and where, to try those first; no answer depends on it.
#[derive(Default)]
pub struct CheckScratch {
    owner: u64,
    placement: Placement,
    /// Poses at several configurations, and the centres of moving bodies there.
    block: PoseBlock,
    centers: Vec<[[f64; LANES]; 3]>,
    broad: BroadScratch,
    history: History,
    /// One for every pair of parts.
    hints: Vec<Hint>,
    queue: BinaryHeap<Entry>,
    buffers: Buffers,
    contact_buffers: ContactBuffers,
    segment: SegmentScratch,
}

/// How a pair in the queue is bounded.
const BY_BALL: u32 = 0;
const BY_BOX: u32 = 1;

impl Checker {
    /// Prepares every checked pair of `scene`.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self::prepare(scene, None)
    }

    /// A checker of another scene, such as one in which an obstacle moved: what this one has
    /// prepared of equal bodies is shared. It says what [`Checker::new`] would.
    pub fn for_scene(&self, scene: Arc<Scene>) -> Self {
        Self::prepare(scene, Some((&self.scene, &self.bodies)))
    }

    fn prepare(scene: Arc<Scene>, before: Option<(&Scene, &Bodies)>) -> Self {
        static NEXT_ID: AtomicU64 = AtomicU64::new(1);
        let bodies = Bodies::new(&scene, before);
        let mut hints = 0;
        let prepare = |(pair, clearance): (&crate::scene::BodyPair, PairClearance)| {
            let (a, b) = (&bodies.bodies[pair.first], &bodies.bodies[pair.second]);
            let radii = a.ball.1 + b.ball.1;
            let start = hints;
            hints += a.parts.len() * b.parts.len();
            CheckedPair { first: pair.first, second: pair.second, radii, hints: start, clearance }
        };
        let clearances = scene.clearances.of_pairs(&scene);
        let pairs = scene.pairs.iter().zip(clearances).map(prepare).collect();
        let broad = Broad::new(&scene, &bodies).into();
        let paths = SpeedPaths::new(&scene).into();
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        let (bodies, clearance) = (bodies.into(), scene.clearance);
        Self { bodies, pairs, broad, paths, hints, clearance, most_clearance: 0.0, id, scene }.with_clearance(clearance)
    }

    /// The same pairs, where those that follow the clearance of the scene keep another one \[m\].
    /// Shares all that is prepared; memory of one serves the other.
    pub fn with_clearance(&self, clearance: f64) -> Self {
        let Self { scene, bodies, pairs, broad, paths, hints, id, .. } = self;
        let most_clearance = pairs.iter().map(|pair| pair.clearance.over(clearance)).fold(0.0, f64::max);
        Self {
            scene: Arc::clone(scene),
            bodies: Arc::clone(bodies),
            pairs: Arc::clone(pairs),
            broad: Arc::clone(broad),
            paths: Arc::clone(paths),
            hints: *hints,
            clearance,
            most_clearance,
            id: *id,
        }
    }

    /// What pairs without a clearance of their own keep \[m\].
    pub fn base_clearance(&self) -> f64 {
        self.clearance
    }

    /// Least distance \[m\] that a checked pair keeps where it is free.
    pub fn clearance_of(&self, pair: usize) -> f64 {
        self.pairs[pair].clearance.over(self.clearance)
    }

    /// What a pair keeps beyond [`Checker::base_clearance`] \[m\]; below 0 where it keeps less.
    pub fn excess(&self, pair: usize) -> f64 {
        self.clearance_of(pair) - self.clearance
    }

    /// For every body, the one of `other` that is the same solid in [`Checker::pose_frame_solid`]'s
    /// coordinates, wherever it is.
    pub fn same_solids(&self, other: &Self) -> Vec<Option<usize>> {
        let parts = |checker: &'_ Self, body: usize| checker.bodies.bodies[body].parts.clone();
        let is_same = |(body, twin): (usize, Option<usize>)| {
            let (own, others) = (&self.bodies.parts[parts(self, body)], &other.bodies.parts[parts(other, twin?)]);
            let are_same = own.len() == others.len()
                && own.iter().zip(others).all(|(a, b)| {
                    let stays = own.len() == 1 || a.pose_frame_part == b.pose_frame_part;
                    Arc::ptr_eq(&a.shape, &b.shape) && stays
                });
            twin.filter(|_| are_same)
        };
        by_name(&other.scene, &self.scene).into_iter().enumerate().map(is_same).collect()
    }

    /// For every body, the first that is the same solid in those coordinates.
    pub fn first_of_equal_solids(&self) -> Vec<usize> {
        let mut first = std::collections::HashMap::new();
        let of_body = |(at, body): (usize, &bodies::PreparedBody)| match &self.bodies.parts[body.parts.clone()] {
            [part] => *first.entry(Arc::as_ptr(&part.shape)).or_insert(at),
            _ => at,
        };
        self.bodies.bodies.iter().enumerate().map(of_body).collect()
    }

    /// Maps coordinates in which a body's solid is the same wherever it stands on its frame (those
    /// of its shape where it has only one) to frame coordinates.
    pub fn pose_frame_solid(&self, body: usize) -> Pose {
        match &self.bodies.parts[self.bodies.bodies[body].parts.clone()] {
            [part] => part.pose_frame_part,
            _ => Pose::identity(),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene, shared.
    pub fn scene_arc(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Appends the indices of all checked pairs that are nearer than the clearance at `q`, ascending.
    pub fn colliding_pairs(&self, q: &[f64], scratch: &mut CheckScratch, pairs: &mut Vec<usize>) {
        self.place(q, scratch);
        self.find_near(self.most_clearance, scratch);
        scratch.broad.pairs.sort_unstable();
        let near = std::mem::take(&mut scratch.broad.pairs);
        pairs.extend(near.iter().map(|&pair| pair as usize).filter(|&pair| self.pair_collides(pair, scratch)));
        scratch.broad.pairs = near;
    }

    /// A checked pair that is nearer than the clearance at `q`, if there is one. Of several, one of which balls inside the bodies prove it goes before
    /// others; among those, the one whose enclosing balls overlap most.
    pub fn colliding_pair(&self, q: &[f64], scratch: &mut CheckScratch) -> Option<usize> {
        self.place(q, scratch);
        self.find_near(self.most_clearance, scratch);
        let CheckScratch { placement, broad, queue, .. } = scratch;
        queue.clear();
        queue.extend(broad.pairs.iter().map(|&index| self.gap_of_balls(index, placement)));
        broad.pairs.clear();
        // What balls prove is told soonest; surfaces that are near and do not meet take longest.
        while let Some(Entry { second, .. }) = scratch.queue.pop() {
            if self.pair_seen_to_collide(second as usize, scratch) {
                return Some(second as usize);
            }
            scratch.broad.pairs.push(second);
        }
        let near = std::mem::take(&mut scratch.broad.pairs);
        let found = near.iter().map(|&pair| pair as usize).find(|&pair| self.pair_collides(pair, scratch));
        scratch.broad.pairs = near;
        found
    }

    fn gap_of_balls(&self, index: u32, placement: &Placement) -> Entry {
        let (pair, centers) = (&self.pairs[index as usize], &placement.centers);
        let bound = (centers[pair.first] - centers[pair.second]).norm() - pair.radii;
        Entry { bound, first: BY_BALL, second: index }
    }

    /// Least signed distance \[m\] of any checked pair at `q`; infinite where no pair is checked.
    ///
    /// Exact where it is positive, and for convex shapes (minus the penetration depth). For overlapping meshes it is minus
    /// an estimate of the overlap from below: the depth of the deepest vertex of one inside the other, or 0 if none is.
    pub fn clearance(&self, q: &[f64], scratch: &mut CheckScratch) -> f64 {
        self.place(q, scratch);
        let CheckScratch { placement, queue, .. } = scratch;
        queue.clear();
        queue.extend((0..self.pairs.len() as u32).map(|index| self.gap_of_balls(index, placement)));
        let mut best = f64::INFINITY;
        while let Some(entry) = scratch.queue.pop().filter(|entry| entry.bound < best) {
            let pair = entry.second as usize;
            let mut bound = f64::INFINITY;
            for (first, second, _) in self.part_pairs(pair) {
                let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
                if entry.first == BY_BALL {
                    bound = bound.min(part_pair::lower_bound(a, b));
                } else {
                    best = part_pair::signed_distance(a, b, best, &mut scratch.buffers).unwrap_or(best);
                }
            }
            if entry.first == BY_BALL {
                scratch.queue.push(Entry { bound: bound.max(entry.bound), first: BY_BOX, ..entry });
            }
        }
        best
    }

    /// Appends the contacts of all checked pairs nearer than the query's margin at `q`. Distances
    /// are less what a pair keeps beyond the clearance of the scene ([`Checker::excess`]): those
    /// below that clearance are too near, whatever the pair.
    ///
    /// Two convex shapes give one contact, exact also where they overlap; in a coarse search, one that was found before and is
    /// still proved farther than the clearance may be moved along instead of searched anew. Meshes give their nearest contact and up to eleven
    /// more that differ from it in place or normal; where they overlap, distances and normals are heuristics for proposals.
    pub fn contacts(&self, q: &[f64], query: ContactQuery, scratch: &mut CheckScratch, contacts: &mut Vec<Contact>) {
        self.place(q, scratch);
        self.find_near(query.margin + self.most_clearance - self.clearance, scratch);
        scratch.broad.pairs.sort_unstable();
        for at in 0..scratch.broad.pairs.len() {
            let index = scratch.broad.pairs[at] as usize;
            let start = contacts.len();
            let (clearance, excess) = (self.clearance_of(index), self.excess(index));
            let query = ContactQuery { margin: query.margin + excess, ..query };
            for (first, second, parts) in self.part_pairs(index) {
                let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
                let place = contact::PairPlace { pair: index, parts, start, clearance };
                let hint = &mut scratch.hints[parts];
                contact::gather([a, b], query, place, hint, &mut scratch.contact_buffers, contacts);
            }
            contacts[start..].iter_mut().for_each(|contact| contact.distance -= excess);
        }
    }

    fn place(&self, q: &[f64], scratch: &mut CheckScratch) {
        self.adopt(scratch);
        self.bodies.place(&self.scene, q, &mut scratch.placement);
    }

    /// Prepares a scratch that served another checker, or none.
    fn adopt(&self, scratch: &mut CheckScratch) {
        if scratch.owner != self.id {
            scratch.owner = self.id;
            scratch.placement = self.bodies.placement();
            scratch.history = History::new(self.pairs.len());
            scratch.hints.clear();
            scratch.hints.resize(self.hints, Hint::default());
            scratch.contact_buffers.forget();
        }
    }

    /// Collects the pairs that may be nearer than `margin` \[m\] where everything is placed.
    fn find_near(&self, margin: f64, scratch: &mut CheckScratch) {
        let centers = &scratch.placement.centers;
        self.broad.find(self.broad.movers().map(|body| centers[body]), margin, &mut scratch.broad);
    }

    fn pair_collides(&self, pair: usize, scratch: &mut CheckScratch) -> bool {
        self.pair_nearer(pair, self.clearance_of(pair), scratch)
    }

    /// Whether two placed bodies are nearer than `limit` \[m\].
    fn pair_nearer(&self, pair: usize, limit: f64, scratch: &mut CheckScratch) -> bool {
        self.part_pairs(pair).any(|(first, second, hint)| {
            let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
            part_pair::nearer(a, b, limit, &mut scratch.hints[hint], &mut scratch.buffers)
        })
    }

    /// Whether balls inside two placed bodies prove that they are nearer than the clearance.
    fn pair_seen_to_collide(&self, pair: usize, scratch: &mut CheckScratch) -> bool {
        self.part_pairs(pair).any(|(first, second, _)| {
            let (a, b) = self.bodies.placed(&mut scratch.placement, first, second);
            part_pair::proved_nearer(a, b, self.clearance_of(pair))
        })
    }

    /// Parts of the first body, parts of the second body, and the places of their hints.
    fn part_pairs(&self, pair: usize) -> impl Iterator<Item = (usize, usize, usize)> + use<'_> {
        let pair = &self.pairs[pair];
        let (a, b) = (&self.bodies.bodies[pair.first].parts, &self.bodies.bodies[pair.second].parts);
        a.clone().flat_map(move |i| b.clone().map(move |j| (i, j))).zip(pair.hints..).map(|((i, j), h)| (i, j, h))
    }
}

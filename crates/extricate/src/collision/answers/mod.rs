//! What can be asked of a checker. Each question is answered by the file that does the work.

mod collisions;
mod depth;
mod filter;
mod found;
mod label;
mod never_free;
pub mod recent_pairs;
mod solids;

pub use found::{always_colliding, contacts_within, most_often_colliding, signed_distances, signed_distances_of};
pub use never_free::{disable_list, misses_allowed};

use crate::collision::checker::{CheckScratch, Checker};
use crate::collision::contacts::{Contact, ContactQuery, ContactSearch};
use crate::collision::overlap::{self, ConvexOverlap, ConvexPair, OverlappingPieces};
use crate::collision::prepared::{self, PieceArrays, TreeArrays};
use crate::collision::segment::{self, SegmentBudget, SegmentOptions, SegmentOutcome};
use crate::cspace::Label;
use crate::kinematics::LANES;
use crate::math::{Pose, Vec3};
use crate::scene::PairId;

impl Checker {
    /// Appends the indices of all checked pairs that are nearer than the clearance at `q`,
    /// ascending.
    pub fn colliding_pairs(&self, q: &[f64], scratch: &mut CheckScratch, pairs: &mut Vec<PairId>) {
        collisions::colliding_pairs(self, q, scratch, pairs);
    }

    /// Of each of these checked pairs, whether it is nearer than it keeps at `q`.
    pub(crate) fn collide(
        &self,
        q: &[f64],
        pairs: impl Iterator<Item = PairId>,
        scratch: &mut CheckScratch,
    ) -> Vec<bool> {
        collisions::collide(self, q, pairs, scratch)
    }

    /// A checked pair that is nearer than the clearance at `q`, if there is one. Of several, one of
    /// which balls inside the bodies prove it goes before others; among those, the one whose
    /// enclosing balls overlap most.
    pub fn colliding_pair(&self, q: &[f64], scratch: &mut CheckScratch) -> Option<PairId> {
        collisions::colliding_pair(self, q, scratch)
    }

    /// Least signed distance \[m\] of any checked pair at `q`; infinite where no pair is checked.
    ///
    /// Exact where it is positive, and for convex shapes (minus the penetration depth). For
    /// overlapping meshes it is minus an estimate of the overlap from below: the depth of the
    /// deepest vertex of one inside the other, or 0 if none is.
    pub fn clearance(&self, q: &[f64], scratch: &mut CheckScratch) -> f64 {
        collisions::clearance(self, q, scratch)
    }

    /// For every body, the one of `other` that is the same solid in [`Checker::pose_frame_solid`]'s
    /// coordinates, wherever it is.
    pub(crate) fn same_solids(&self, other: &Self) -> Vec<Option<usize>> {
        solids::same_solids(self, other)
    }

    /// For every body, the first that is the same solid in those coordinates.
    pub(crate) fn first_of_equal_solids(&self) -> Vec<usize> {
        solids::first_of_equal_solids(self)
    }

    /// Maps coordinates in which a body's solid is the same wherever it stands on its frame (those
    /// of its shape where it has only one) to frame coordinates.
    pub(crate) fn pose_frame_solid(&self, body: usize) -> Pose {
        solids::pose_frame_solid(self, body)
    }

    /// Calls `each` with the corners (world) of a box around every shape of a body, where frames
    /// have these poses.
    pub(crate) fn corners_of(&self, body: usize, poses: &[Pose], each: &mut dyn FnMut(Vec3)) {
        solids::corners_of(self, body, poses, each);
    }

    /// Whether no shape of a body is a mesh.
    pub(crate) fn is_convex(&self, body: usize) -> bool {
        solids::is_convex(self, body)
    }

    /// Appends the contacts of all checked pairs nearer than the query's margin at `q`. Distances
    /// are less what a pair keeps beyond the clearance of the scene (`Checker::excess`): those
    /// below that clearance are too near, whatever the pair.
    ///
    /// Two convex shapes give one contact, exact also where they overlap; in a coarse search, one
    /// that was found before and is still proved farther than the clearance may be moved along
    /// instead of searched anew. Meshes give their nearest contact and up to eleven more that
    /// differ from it in place or normal; where they overlap, distances and normals are heuristics
    /// for proposals.
    pub fn contacts(&self, q: &[f64], query: ContactQuery, scratch: &mut CheckScratch, contacts: &mut Vec<Contact>) {
        found::contacts(self, q, query, scratch, contacts);
    }

    /// As [`Checker::contacts`], of one checked pair.
    pub(crate) fn contacts_of(
        &self,
        q: &[f64],
        pair: PairId,
        query: ContactQuery,
        scratch: &mut CheckScratch,
        contacts: &mut Vec<Contact>,
    ) {
        found::contacts_of(self, q, pair, query, scratch, contacts);
    }

    /// Whether contacts found in such a search tell of all overlaps, containment included, so that
    /// none below the clearance means free (up to rounding): where all shapes are convex, or are
    /// taken for their pieces.
    pub(crate) fn contacts_are_complete(&self, search: ContactSearch) -> bool {
        found::contacts_are_complete(self, search)
    }

    /// How far \[m\] exact contacts of all pairs are found in a search with that margin, whatever
    /// is
    /// nearest: of meshes and scenery, those that are farther than the nearest of their pair by
    /// more than half of it are not.
    pub(crate) fn exact_within(&self, margin: f64) -> f64 {
        found::exact_within(self, margin)
    }

    /// Signed depth \[m\] of a point (in the body's frame) in the solid of `body`: positive inside,
    /// minus the distance outside; for surfaces minus the distance.
    ///
    /// Exact for one shape and for points outside; where solids overlap, the depth in the deepest
    /// of them, which is not more than that in their union. Minus infinity for a body without
    /// geometry.
    pub(crate) fn solid_depth(&self, body: usize, point_frame: &Vec3) -> f64 {
        depth::solid_depth(self, body, point_frame)
    }

    /// As [`Checker::solid_depth`] if that is above `least` \[m\]; most points that are not cost a
    /// box or a plane.
    pub(crate) fn solid_depth_above(
        &self,
        body: usize,
        point_frame: &Vec3,
        least: f64,
        scratch: &mut CheckScratch,
    ) -> Option<f64> {
        depth::solid_depth_above(self, body, point_frame, least, scratch)
    }

    /// Upper bounds \[m\] on [`Checker::solid_depth`] of points, eight an entry, given axis by axis
    /// in a frame with the pose `pose_body_points`; into `depths`, as far as that is long. They
    /// cost a box a shape.
    #[inline(always)]
    pub(crate) fn solid_depth_bounds<'a>(
        &self,
        body: usize,
        pose_body_points: &Pose,
        points: impl Iterator<Item = &'a [[f64; LANES]; 3]> + Clone,
        depths: &mut [[f64; LANES]],
    ) {
        depth::solid_depth_bounds(self, body, pose_body_points, points, depths);
    }

    /// Appends the contacts of all checked pairs that are nearer than `within` \[m\] at `q`, free
    /// or not, in the order of the pairs. Distances are signed ones between the bodies, whatever
    /// clearances they keep; else as [`Checker::contacts`].
    pub fn contacts_within(&self, q: &[f64], within: f64, scratch: &mut CheckScratch, contacts: &mut Vec<Contact>) {
        found::contacts_within(self, q, within, scratch, contacts);
    }

    /// The signed distance \[m\] of every checked pair at `q`, by pair: what [`Checker::clearance`]
    /// is the least of, and as exact.
    pub fn signed_distances(&self, q: &[f64], scratch: &mut CheckScratch) -> Vec<f64> {
        found::signed_distances(self, q, scratch)
    }

    /// The checked pairs that collide in all but at most `misses` of `configs`, and in how many, in
    /// the order of the pairs. Such pairs most likely overlap by design, see [`disable_list`].
    pub fn nearly_always_colliding(
        &self,
        configs: impl IntoIterator<Item = impl AsRef<[f64]>>,
        misses: usize,
    ) -> Vec<(PairId, usize)> {
        found::nearly_always_colliding(self, configs, misses)
    }

    /// The checked pairs that collide in each of `samples` evenly spread configurations.
    pub fn pairs_always_colliding(&self, samples: u64) -> Vec<PairId> {
        never_free::pairs_always_colliding(self, samples)
    }

    /// The checked pairs that collide in at least this share of `samples` evenly spread
    /// configurations, and in how many, the most frequent first.
    pub fn pairs_nearly_always_colliding(&self, samples: u64, share: f64) -> Vec<(PairId, usize)> {
        never_free::pairs_nearly_always_colliding(self, samples, share)
    }

    /// What to say if no free configuration was found: which pairs collide in all of a hundred
    /// configurations, and what to do if they overlap by design. `None` if no pair does. Nothing to
    /// rely on if `stopped` said so.
    pub fn advice_if_never_free(&self, stopped: impl Fn() -> bool) -> Option<String> {
        never_free::advice_if_never_free(self, stopped)
    }

    /// Whether every checked pair keeps the clearance at `q` (length `nq`, within limits).
    ///
    /// Closed components of meshes are solid, open ones are surfaces. With a clearance of 0,
    /// surfaces that cross collide and surfaces that only touch do not.
    pub fn label(&self, q: &[f64], scratch: &mut CheckScratch) -> Label {
        label::label(self, q, scratch)
    }

    /// Labels `n` configurations (row major, `n x nq`, each within limits) on all threads of the
    /// current rayon pool.
    ///
    /// `labels[i]` is what [`Checker::label`] says of configuration `i`, whatever the number of
    /// threads.
    ///
    /// # Panics
    /// Where `configs` is not `labels.len() * nq` long.
    ///
    /// ```
    /// use extricate::{Checker, Label, builtin};
    /// let scene = builtin::scene("planar-arm").unwrap();
    /// let checker = Checker::new(scene.into());
    /// let mut labels = [Label::Free; 2];
    /// checker.label_batch(&[0.0, 0.0, 0.0, 0.3, -0.2, 0.1], &mut labels);
    /// ```
    pub fn label_batch(&self, configs: &[f64], labels: &mut [Label]) {
        label::label_batch(self, configs, labels);
    }

    /// As [`Checker::label_batch`] on the calling thread, without allocating once `scratch` has
    /// served this checker.
    ///
    /// # Panics
    /// Where `configs` is not `labels.len() * nq` long.
    #[doc(hidden)]
    pub fn label_batch_serial(&self, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
        label::label_batch_serial(self, configs, labels, scratch);
    }

    /// Which of `points` (world coordinates \[m\]) no link of a robot comes nearer to than
    /// `padding` \[m\] at `q`: those to keep where a camera also sees the robot itself. A point
    /// inside a link is within any padding; obstacles do not count.
    ///
    /// # Cost
    /// A ball a point and link, and a look at the link's shapes where that is near.
    pub fn robot_filter(&self, q: &[f64], points: &[[f64; 3]], padding: f64, scratch: &mut CheckScratch) -> Vec<bool> {
        filter::robot_filter(self, q, points, padding, scratch)
    }

    /// Whether the geodesic from `from` to `to` (length `nq` each, within limits) keeps the
    /// clearance all along.
    ///
    /// # Guarantee
    /// Free is proved for every configuration between, not for samples: each stretch is short
    /// enough that no pair of bodies can lose within it what its middle keeps. What is not proved
    /// is not called free; see [`SegmentOutcome`].
    ///
    /// # Cost
    /// About as many checks as the motion is long, divided by how near it comes to a collision; few
    /// where all is far.
    ///
    /// # Source
    /// F. Schwarzer, M. Saha and J.-C. Latombe, "Adaptive dynamic collision checking for single and
    /// multiple articulated robots in complex environments", IEEE Transactions on Robotics 21(3),
    /// 2005, doi:10.1109/TRO.2004.838012. Deviations: bounds on motion hold for each stretch, not
    /// for all configurations; distances are only compared with what a stretch needs; the earliest
    /// contact is looked for.
    pub fn segment(
        &self,
        from: &[f64],
        to: &[f64],
        options: &SegmentOptions,
        scratch: &mut CheckScratch,
    ) -> SegmentOutcome {
        segment::segment(self, from, to, options, scratch)
    }

    /// As [`Checker::segment`], given up where the budget ends.
    pub(crate) fn segment_within(
        &self,
        ends: (&[f64], &[f64]),
        options: &SegmentOptions,
        budget: &SegmentBudget,
        scratch: &mut CheckScratch,
    ) -> SegmentOutcome {
        segment::segment_within(self, ends, options, budget, scratch)
    }

    /// Appends the overlapping convex shapes among the checked pairs `pairs` at `q`. Convex shapes
    /// inside scenery stand for it: what parts the scenery from another shape parts them from it
    /// too.
    pub(crate) fn convex_overlaps(
        &self,
        q: &[f64],
        pairs: &[PairId],
        scratch: &mut CheckScratch,
        overlaps: &mut Vec<ConvexOverlap>,
    ) {
        overlap::convex_overlaps(self, q, pairs, scratch, overlaps);
    }

    /// Calls `each` with the convex shapes of the checked pairs `pairs` at `q` that may be nearer
    /// than they keep; of meshes, with all pieces around them that are; of scenery, with its
    /// elements that overlap most, or with a box that ends where it does.
    pub(crate) fn overlapping_pieces(
        &self,
        q: &[f64],
        pairs: &[PairId],
        scratch: &mut CheckScratch,
        each: &mut dyn FnMut(&OverlappingPieces),
    ) {
        overlap::overlapping_pieces(self, q, pairs, scratch, each);
    }

    /// Calls `each` with convex sets inside the bodies of the checked pairs `pairs` at `q`, of
    /// which some may overlap: what parts the bodies parts them too. Of meshes and scenery, those
    /// that overlap most; of surfaces there are none.
    pub(crate) fn inner_pairs(
        &self,
        q: &[f64],
        pairs: &[PairId],
        scratch: &mut CheckScratch,
        each: &mut dyn FnMut(&ConvexPair),
    ) {
        overlap::inner_pairs(self, q, pairs, scratch, each);
    }

    /// Makes the convex pieces of every mesh that is part of a checked pair, on all threads of the
    /// current pool, unless that was done before.
    #[doc(hidden)]
    pub fn prepare_proposals(&self) {
        solids::prepare_proposals(self);
    }

    /// Whether [`Checker::prepare_proposals`] has anything to make.
    pub(crate) fn lacks_pieces(&self) -> bool {
        solids::lacks_pieces(self)
    }

    /// Whether [`Checker::prepare_proposals`] was called.
    #[doc(hidden)]
    pub fn has_pieces(&self) -> bool {
        self.is_prepared.load(std::sync::atomic::Ordering::Acquire)
    }

    /// The trees of triangles, for [`Checker::with_trees`].
    pub(crate) fn kept_trees(&self) -> TreeArrays {
        TreeArrays::of(&self.bodies.parts)
    }

    /// The pieces that were made.
    pub(crate) fn kept_pieces(&self) -> PieceArrays {
        prepared::kept_pieces(&self.bodies.parts)
    }

    /// Takes pieces over that were made of the same meshes; whether they can be those. They have to
    /// lie in the boxes of their meshes, and their boxes to hold all vertices. That is no proof:
    /// nothing that is verified depends on pieces, and wrong ones could only lower a bound (a point
    /// that none is near counts as no deeper than the caller needs).
    pub(crate) fn take_pieces(&self, kept: &PieceArrays) -> bool {
        prepared::take_pieces(&self.bodies.parts, kept)
    }

    /// Whether no shape is a mesh: all are convex, or scenery made of convex shapes.
    pub(crate) fn all_convex(&self) -> bool {
        self.bodies.all_convex
    }
}

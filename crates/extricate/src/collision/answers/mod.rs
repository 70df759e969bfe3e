//! The queries of a [`Checker`]. Each method delegates to the file that does the work.

mod collisions;
mod depth;
mod filter;
mod jacobian;
mod label;
mod never_free;
mod pair_answers;
pub mod recent_pairs;
mod solids;
mod stand_ins;

pub use jacobian::DistanceRow;
pub use never_free::{disable_list, misses_allowed};
pub use pair_answers::{
    always_colliding, contacts_within, most_often_colliding, signed_distance_below, signed_distances,
    signed_distances_of,
};
pub use stand_ins::StandIns;

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
    /// Appends all checked pairs that are nearer than their clearance at `q`, ascending.
    pub fn colliding_pairs(&self, q: &[f64], scratch: &mut CheckScratch, pairs: &mut Vec<PairId>) {
        collisions::colliding_pairs(self, q, scratch, pairs);
    }

    /// Returns, for each of these checked pairs, whether it is nearer than its clearance at `q`.
    pub(crate) fn collide(
        &self,
        q: &[f64],
        pairs: impl Iterator<Item = PairId>,
        scratch: &mut CheckScratch,
    ) -> Vec<bool> {
        collisions::collide(self, q, pairs, scratch)
    }

    /// Returns a checked pair that is nearer than its clearance at `q`, if there is one. Pairs that
    /// balls inside the bodies prove to collide go before others. Among those, the pair whose
    /// enclosing balls overlap most goes first.
    pub fn colliding_pair(&self, q: &[f64], scratch: &mut CheckScratch) -> Option<PairId> {
        collisions::colliding_pair(self, q, scratch)
    }

    /// Returns the least signed distance \[m\] of any checked pair at `q`; infinite if no pair is
    /// checked.
    ///
    /// It is exact if positive, and also below 0 for convex shapes (minus the penetration depth).
    /// For overlapping meshes it is minus an estimate of the overlap from below: the depth of the
    /// deepest vertex of one inside the other, or 0 if none is.
    pub fn clearance(&self, q: &[f64], scratch: &mut CheckScratch) -> f64 {
        collisions::clearance(self, q, scratch)
    }

    /// Returns, for every body, the body of the same name in `other` if it is the same solid in the
    /// coordinates of [`Checker::pose_frame_solid`], wherever it is.
    pub(crate) fn same_solids(&self, other: &Self) -> Vec<Option<usize>> {
        solids::same_solids(self, other)
    }

    /// Returns, for every body, the first body that is the same solid in the coordinates of
    /// [`Checker::pose_frame_solid`].
    pub(crate) fn first_of_equal_solids(&self) -> Vec<usize> {
        solids::first_of_equal_solids(self)
    }

    /// Returns the pose of a body's solid in its frame: that of its shape if it has only one, else
    /// the identity. In its own coordinates a solid is the same wherever it is on its frame.
    pub(crate) fn pose_frame_solid(&self, body: usize) -> Pose {
        solids::pose_frame_solid(self, body)
    }

    /// Calls `each` with the corners (world) of a box around every shape of a body, given the poses
    /// of the frames.
    pub(crate) fn corners_of(&self, body: usize, poses: &[Pose], each: &mut dyn FnMut(Vec3)) {
        solids::corners_of(self, body, poses, each);
    }

    /// Returns whether no shape of a body is a mesh.
    pub(crate) fn is_convex(&self, body: usize) -> bool {
        solids::is_convex(self, body)
    }

    /// Appends the contacts of all checked pairs nearer than the query's margin at `q`. What a pair
    /// keeps beyond the clearance of the scene (`Checker::excess`) is subtracted from its
    /// distances. A distance below the scene's clearance is then too near, whatever the pair.
    ///
    /// Two convex shapes give one contact, exact also if they overlap. A coarse search may move a
    /// contact along that was found before and is still proved farther than the clearance. Meshes
    /// give their nearest contact and up to eleven more that differ from it in place or normal. If
    /// they overlap, distances and normals are heuristics for proposals.
    pub fn contacts(&self, q: &[f64], query: ContactQuery, scratch: &mut CheckScratch, contacts: &mut Vec<Contact>) {
        pair_answers::contacts(self, q, query, scratch, contacts);
    }

    /// Appends the contacts of one checked pair as [`Checker::contacts`] does.
    pub(crate) fn contacts_of(
        &self,
        q: &[f64],
        pair: PairId,
        query: ContactQuery,
        scratch: &mut CheckScratch,
        contacts: &mut Vec<Contact>,
    ) {
        pair_answers::contacts_of(self, q, pair, query, scratch, contacts);
    }

    /// Returns whether such a search finds all overlaps, containment included, so that no contact
    /// below the clearance means free (up to rounding). It does if all shapes are convex, or are
    /// replaced by their pieces.
    pub(crate) fn contacts_are_complete(&self, search: ContactSearch) -> bool {
        pair_answers::contacts_are_complete(self, search)
    }

    /// Returns how far \[m\] a search with that margin finds exact contacts of all pairs. With
    /// meshes or scenery it is half of the margin: farther ones may be missing if another contact
    /// of their pair is nearer.
    pub(crate) fn exact_within(&self, margin: f64) -> f64 {
        pair_answers::exact_within(self, margin)
    }

    /// Returns the signed depth \[m\] of a point (in the body's frame) in the solid of `body`:
    /// positive inside, minus the distance outside. For surfaces it is minus the distance.
    ///
    /// It is exact for one shape and for points outside. If solids overlap, it is the depth in the
    /// deepest of them, which is not more than that in their union. It is minus infinity for a body
    /// without geometry.
    pub(crate) fn solid_depth(&self, body: usize, point_frame: &Vec3) -> f64 {
        depth::solid_depth(self, body, point_frame)
    }

    /// Returns [`Checker::solid_depth`] if it is above `least` \[m\]. Most points that are not
    /// deeper cost one test of a box or a plane.
    pub(crate) fn solid_depth_above(
        &self,
        body: usize,
        point_frame: &Vec3,
        least: f64,
        scratch: &mut CheckScratch,
    ) -> Option<f64> {
        depth::solid_depth_above(self, body, point_frame, least, scratch)
    }

    /// Writes upper bounds \[m\] on [`Checker::solid_depth`] of points to `depths`, as far as that
    /// is long. An entry of `points` is eight points, axis by axis, in a frame with the pose
    /// `pose_body_points`. The cost is one box per shape and point.
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
    /// or not, in the order of the pairs. Distances are signed distances between the bodies,
    /// whatever clearances they keep. All else is as in [`Checker::contacts`].
    pub fn contacts_within(&self, q: &[f64], within: f64, scratch: &mut CheckScratch, contacts: &mut Vec<Contact>) {
        pair_answers::contacts_within(self, q, within, scratch, contacts);
    }

    /// Returns the nearest contact of every checked pair that is nearer than `within` \[m\] at
    /// `q`, in the order of the pairs, with the gradient of its distance. These are the rows that
    /// quadratic programs and barrier functions of controllers take.
    ///
    /// # Guarantee
    /// Distances are those of [`Checker::contacts_within`]. The gradient is the derivative of the
    /// distance, unless the nearest points jump, as between parallel faces.
    pub fn distance_rows(&self, q: &[f64], within: f64, scratch: &mut CheckScratch) -> Vec<DistanceRow> {
        jacobian::distance_rows(self, q, within, scratch)
    }

    /// Returns the signed distance \[m\] of every checked pair at `q`, in the order of the pairs.
    /// [`Checker::clearance`] is the least of them, and they are as exact.
    pub fn signed_distances(&self, q: &[f64], scratch: &mut CheckScratch) -> Vec<f64> {
        pair_answers::signed_distances(self, q, scratch)
    }

    /// Returns the checked pairs that collide in all but at most `misses` of `configs`, with the
    /// number of collisions, in the order of the pairs. Such pairs most likely overlap by design;
    /// see [`disable_list`].
    pub fn nearly_always_colliding(
        &self,
        configs: impl IntoIterator<Item = impl AsRef<[f64]>>,
        misses: usize,
    ) -> Vec<(PairId, usize)> {
        pair_answers::nearly_always_colliding(self, configs, misses)
    }

    /// Returns the checked pairs that collide in each of `samples` evenly spread configurations.
    pub fn pairs_always_colliding(&self, samples: u64) -> Vec<PairId> {
        never_free::pairs_always_colliding(self, samples)
    }

    /// Returns the checked pairs that collide in at least this share of `samples` evenly spread
    /// configurations. They come with the number of collisions, the most frequent first.
    pub fn pairs_nearly_always_colliding(&self, samples: u64, share: f64) -> Vec<(PairId, usize)> {
        never_free::pairs_nearly_always_colliding(self, samples, share)
    }

    /// Returns advice for the case that no free configuration was found: which pairs collide in all
    /// of a hundred configurations, and what to do if they overlap by design. `None` if no pair
    /// does. The result is not reliable if `stopped` returned `true`.
    pub fn advice_if_never_free(&self, stopped: impl Fn() -> bool) -> Option<String> {
        never_free::advice_if_never_free(self, stopped)
    }

    /// Labels `q` (length `nq`, within limits): it is free if every checked pair keeps its
    /// clearance.
    ///
    /// Closed components of meshes are solid, open ones are surfaces. With a clearance of 0,
    /// surfaces that cross collide and surfaces that only touch do not.
    pub fn label(&self, q: &[f64], scratch: &mut CheckScratch) -> Label {
        label::label(self, q, scratch)
    }

    /// Labels `n` configurations (row major, `n x nq`, each within limits) on all threads of the
    /// current rayon pool.
    ///
    /// `labels[i]` is the result of [`Checker::label`] for configuration `i`, whatever the number
    /// of threads.
    ///
    /// # Panics
    /// Panics if `configs` is not `labels.len() * nq` long.
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

    /// Labels configurations as [`Checker::label_batch`] does, but on the calling thread. It does
    /// not allocate once `scratch` has served this checker.
    ///
    /// # Panics
    /// Panics if `configs` is not `labels.len() * nq` long.
    #[doc(hidden)]
    pub fn label_batch_serial(&self, configs: &[f64], labels: &mut [Label], scratch: &mut CheckScratch) {
        label::label_batch_serial(self, configs, labels, scratch);
    }

    /// Returns which of `points` (world coordinates \[m\]) to keep if a camera also sees the robot:
    /// those that no link comes nearer to than `padding` \[m\] at `q`. A point inside a link is
    /// within any padding that is not negative; obstacles do not count.
    ///
    /// # Cost
    /// One ball per point and link, and an evaluation of the link's shapes if that is near.
    pub fn robot_filter(&self, q: &[f64], points: &[[f64; 3]], padding: f64, scratch: &mut CheckScratch) -> Vec<bool> {
        filter::robot_filter(self, q, points, padding, scratch)
    }

    /// Returns whether the geodesic from `from` to `to` (length `nq` each, within limits) keeps the
    /// clearance all along.
    ///
    /// # Guarantee
    /// Free is proved for every configuration between, not for samples: each stretch is so short
    /// that no pair of bodies can lose within it the distance that it keeps in the middle. Nothing
    /// unproved is called free; see [`SegmentOutcome`].
    ///
    /// # Cost
    /// The number of checks is about the length of the motion divided by its distance from a
    /// collision, hence small if all bodies are far apart.
    ///
    /// # Source
    /// F. Schwarzer, M. Saha and J.-C. Latombe, "Adaptive dynamic collision checking for single and
    /// multiple articulated robots in complex environments", IEEE Transactions on Robotics 21(3),
    /// 2005, doi:10.1109/TRO.2004.838012. Deviations: bounds on motion hold for each stretch, not
    /// for all configurations; distances are only compared with the one that a stretch needs; the
    /// search is for the earliest contact.
    pub fn segment(
        &self,
        from: &[f64],
        to: &[f64],
        options: &SegmentOptions,
        scratch: &mut CheckScratch,
    ) -> SegmentOutcome {
        segment::segment(self, from, to, options, scratch)
    }

    /// Checks as [`Checker::segment`] does, but gives up when the budget ends.
    pub(crate) fn segment_within(
        &self,
        ends: (&[f64], &[f64]),
        options: &SegmentOptions,
        budget: &SegmentBudget,
        scratch: &mut CheckScratch,
    ) -> SegmentOutcome {
        segment::segment_within(self, ends, options, budget, scratch)
    }

    /// Appends the overlapping convex shapes among the checked pairs `pairs` at `q`. Scenery is
    /// represented by convex shapes inside it: a motion that parts the scenery from another shape
    /// parts them from it too.
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
    /// than their clearance. A mesh gives all pieces around it that are. Scenery gives its elements
    /// that overlap most, or a box that ends where it does.
    pub(crate) fn overlapping_pieces(
        &self,
        q: &[f64],
        pairs: &[PairId],
        scratch: &mut CheckScratch,
        each: &mut dyn FnMut(&OverlappingPieces),
    ) {
        overlap::overlapping_pieces(self, q, pairs, scratch, each);
    }

    /// Calls `each` with convex sets inside the bodies of the checked pairs `pairs` at `q`, some of
    /// which may overlap: a motion that parts the bodies parts them too. Meshes and scenery give
    /// the sets that overlap most; surfaces have none.
    pub(crate) fn inner_pairs(
        &self,
        q: &[f64],
        pairs: &[PairId],
        scratch: &mut CheckScratch,
        each: &mut dyn FnMut(&ConvexPair),
    ) {
        overlap::inner_pairs(self, q, pairs, scratch, each);
    }

    /// Returns what stands for the shapes of a body in quick tests and proposals, to look at.
    pub fn stand_ins(&self, body: usize) -> StandIns {
        stand_ins::stand_ins(self, body)
    }

    /// Makes the convex pieces of every mesh that is part of a checked pair, on all threads of the
    /// current pool, unless that was done before.
    #[doc(hidden)]
    pub fn prepare_proposals(&self) {
        solids::prepare_proposals(self);
    }

    /// Returns whether [`Checker::prepare_proposals`] has anything to make.
    pub(crate) fn lacks_pieces(&self) -> bool {
        solids::lacks_pieces(self)
    }

    /// Returns whether [`Checker::prepare_proposals`] was called.
    #[doc(hidden)]
    pub fn has_pieces(&self) -> bool {
        self.is_prepared.load(std::sync::atomic::Ordering::Acquire)
    }

    /// Returns the trees of triangles, for [`Checker::with_trees`].
    pub(crate) fn kept_trees(&self) -> TreeArrays {
        TreeArrays::of(&self.bodies.parts)
    }

    /// Returns the convex pieces that were made.
    pub(crate) fn kept_pieces(&self) -> PieceArrays {
        prepared::kept_pieces(&self.bodies.parts)
    }

    /// Takes over pieces that were made of the same meshes, and returns whether they can be those:
    /// they lie in the boxes of their meshes, and their boxes hold all vertices. That proves
    /// nothing, but nothing verified depends on pieces. Wrong ones could only lower a bound,
    /// because a point that no piece is near counts as no deeper than the caller needs.
    pub(crate) fn take_pieces(&self, kept: &PieceArrays) -> bool {
        prepared::take_pieces(&self.bodies.parts, kept)
    }

    /// Returns whether no shape is a mesh: all are convex, or scenery made of convex shapes.
    pub(crate) fn all_convex(&self) -> bool {
        self.bodies.all_convex
    }
}

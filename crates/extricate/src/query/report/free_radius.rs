//! The free radius: how far around a configuration nothing touches, proved from its clearance.

use std::collections::BTreeMap;

use crate::collision::{CheckScratch, Contact, ContactQuery, ContactSearch, signed_distance_below};
use crate::math::{Pose, Vec3};
use crate::metric::motion_bound::{BoundedPoint, MotionPath};
use crate::metric::pair_motion::PairMotion;
use crate::query::bound::reach::{Curvature, ReachScratch, least_reach, reach_by_rate};
use crate::query::bound::{BoundEffort, distance_along};
use crate::query::context::Context;
use crate::query::evaluate::Evaluator;
use crate::scene::{MetricKind, PairId, Scene};

/// Margin for the rounding of measured distances \[m\].
const ROUNDING_M: f64 = 1e-9;
/// Contacts are searched this much beyond the distance of a pair \[m\].
pub const PLAY_M: f64 = 1e-6;
/// Bodies with more corners are bounded by their nearest distance alone.
const MAX_CORNERS: usize = 32;
/// Ceilings that are tried one after another, and the factor by which a ceiling exceeds what is
/// known.
const MAX_CEILINGS: usize = 3;
const CEILING_FACTOR: f64 = 3.0;

/// Distance of bodies that a pair has to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keeps {
    /// The clearance of the pair: the configuration stays free.
    Clearance,
    /// None: the bodies do not touch. A witness often just keeps its clearance.
    Apart,
}

/// A pair, and how far it is from being too near.
#[derive(Debug, Clone, Copy)]
struct PairRadius {
    pair: PairId,
    /// Distance \[m\] that the pair has to keep.
    keeps: f64,
    /// Distance \[m\] beyond that.
    apart: f64,
    /// Distance \[metric units\] within which the pair is proved to keep its distance.
    radius: f64,
}

/// Returns a distance from `q` \[metric units\], at most `ceiling`, within which every checked pair
/// keeps its distance.
///
/// # Guarantee
/// Proved pair by pair: two bodies at distance `d` do not meet while no point of one moves by `d`
/// as seen from the other. The motion bound is a convex function of the point, so over a shape it
/// is largest at a corner of the box around it. The nearest pairs are bounded more closely, as
/// `Closing::radius` proves it.
pub fn free_radius(
    context: &Context,
    q: &[f64],
    (keeps, ceiling): (Keeps, f64),
    evaluator: &mut Evaluator,
    path: &mut MotionPath,
) -> f64 {
    let (checker, scene) = (context.checker, context.checker.scene());
    let kept = |pair: usize| if keeps == Keeps::Clearance { checker.clearance_of(pair) } else { 0.0 };
    let ceiling = ceiling.min(context.scale);
    evaluator.checks += 1;
    let most = (0..scene.pairs.len()).map(kept).fold(0.0, f64::max);
    let least = (checker.clearance(q, &mut evaluator.check) - most - ROUNDING_M).max(0.0);
    let poses = evaluator.check.poses().to_vec();
    let mut ways: BTreeMap<[usize; 2], Vec<PairId>> = BTreeMap::new();
    for pair in 0..scene.pairs.len() {
        ways.entry(carried(scene, pair)).or_default().push(PairId::new(pair));
    }
    // Distances of pairs are measured as far as matters for a radius, and that grows until it does.
    let mut reach = ways.keys().fold(ceiling, |reach, way| radius_of(context, &poses, *way, least, reach, path));
    let mut closing = Closing::default();
    loop {
        reach = (CEILING_FACTOR * reach).max(1e-9 * ceiling).min(ceiling);
        let mut near = Vec::new();
        for (way, pairs) in &ways {
            let moved = farthest(context, &poses, *way, reach, path);
            for &pair in pairs {
                let keeps = kept(pair.index());
                let cutoff = moved + keeps + ROUNDING_M;
                let Some(distance) = signed_distance_below(checker, pair, cutoff, &mut evaluator.check) else {
                    continue;
                };
                let apart = distance - keeps;
                let radius = radius_of(context, &poses, *way, (apart - ROUNDING_M).max(0.0), reach, path);
                near.push(PairRadius { pair, keeps, apart, radius });
            }
        }
        let mut is_raised = vec![false; near.len()];
        let found = loop {
            let Some(at) = (0..near.len()).min_by(|a, b| near[*a].radius.total_cmp(&near[*b].radius)) else {
                break reach;
            };
            if near[at].radius >= reach || std::mem::replace(&mut is_raised[at], true) {
                break near[at].radius.min(reach);
            }
            let raised = closing.radius(context, (q, &poses), &near[at], reach, &mut evaluator.check);
            near[at].radius = near[at].radius.max(raised);
        };
        if found < reach || reach >= ceiling {
            return found;
        }
    }
}

/// Radii of pairs by how far points of boxes around their shapes have to move along the normal of a
/// contact.
#[derive(Default)]
struct Closing {
    motion: PairMotion,
    reach: ReachScratch,
    contacts: Vec<Contact>,
    corners: [Vec<Vec3>; 2],
}

impl Closing {
    /// Returns a distance, at most `most`, within which a pair keeps its distance; 0 if none is
    /// proved.
    ///
    /// # Guarantee
    /// Let `n` be a direction that rests in the frame that carries both bodies. At any
    /// configuration, `n . (a - b)` is affine in the points `a` and `b` of the two bodies, so over
    /// boxes around their shapes it is least at corners. While it exceeds the distance to keep
    /// there, the bodies keep it. [`least_reach`] proves how far each pair of corners keeps it.
    fn radius(
        &mut self,
        context: &Context,
        (q, poses): (&[f64], &[Pose]),
        pair: &PairRadius,
        most: f64,
        check: &mut CheckScratch,
    ) -> f64 {
        let PairRadius { pair, keeps, apart, radius } = *pair;
        let scene = context.checker.scene();
        let bodies = [scene.pairs[pair.index()].first, scene.pairs[pair.index()].second];
        let frames = bodies.map(|body| scene.bodies[body].frame);
        context.metric.pair_motion(poses, frames, |v| context.is_locked(v), &mut self.motion);
        if context.metric.kind() == MetricKind::MaxDisplacement {
            context.metric.place_points(poses, [&Vec3::zeros(); 2], &mut self.motion);
            return reach_by_rate(&self.motion, (apart - ROUNDING_M).max(0.0), most);
        }
        for (corners, body) in self.corners.iter_mut().zip(bodies) {
            corners.clear();
            context.checker.corners_of(body, poses, &mut |corner| corners.push(corner));
        }
        if self.corners.iter().any(|corners| corners.len() > MAX_CORNERS) {
            return 0.0;
        }
        self.contacts.clear();
        let distance = apart + keeps - context.checker.excess(pair.index());
        let margin = distance.max(context.clearance) + PLAY_M;
        let query = ContactQuery { margin, search: ContactSearch::Exact };
        context.checker.contacts_of(q, pair, query, check, &mut self.contacts);
        let Some(n) = self.contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).map(|c| c.normal) else {
            return 0.0;
        };
        let keeps = keeps + ROUNDING_M;
        // The curvature is bounded up to a ceiling, so a near one proves more.
        let mut best: f64 = 0.0;
        let mut ceiling = (CEILING_FACTOR * radius).min(most);
        for _ in 0..MAX_CEILINGS {
            let found = self.along(context, poses, (frames, &n), (keeps, ceiling));
            best = best.max(found);
            let is_met = found >= ceiling;
            if found <= radius || is_met && ceiling >= most {
                break;
            }
            ceiling = if is_met { CEILING_FACTOR * ceiling } else { found + 0.2 * (ceiling - found) }.min(most);
        }
        best
    }

    /// Returns the distance, at most `ceiling`, within which all corners stay apart along `n`.
    fn along(
        &mut self,
        context: &Context,
        poses: &[Pose],
        (frames, n): ([usize; 2], &Vec3),
        (keeps, ceiling): (f64, f64),
    ) -> f64 {
        let Self { motion, reach, corners: [first, second], .. } = self;
        // Of a body that rests, only the extreme corner counts.
        let extreme = |corners: &[Vec3], sign: f64| {
            corners.iter().copied().max_by(|a, b| (sign * n.dot(a)).total_cmp(&(sign * n.dot(b)))).into_iter().collect()
        };
        let a: Vec<Vec3> = if frames[0] == 0 { extreme(first, -1.0) } else { first.clone() };
        let b: Vec<Vec3> = if frames[1] == 0 { extreme(second, 1.0) } else { second.clone() };
        let mut least = ceiling;
        for (a, b) in a.iter().flat_map(|a| b.iter().map(move |b| (a, b))) {
            let needed = n.dot(&(a - b)) - keeps;
            if needed.is_nan() || needed <= 0.0 {
                return 0.0;
            }
            context.metric.place_points(poses, [a, b], motion);
            let curvature = Curvature::of(motion, least);
            least = least_reach(motion, &curvature, &[(-n, needed); 3], (least, least), reach);
        }
        least
    }
}

/// Returns the body of a pair that moves, and the frame from which it is seen.
fn carried(scene: &Scene, pair: usize) -> [usize; 2] {
    let [a, b] = [scene.pairs[pair].first, scene.pairs[pair].second];
    if scene.bodies[a].frame == 0 { [b, 0] } else { [a, scene.bodies[b].frame] }
}

/// Returns how far \[m\] any point of a body moves within `distance`, as seen from a frame.
fn farthest(
    context: &Context,
    poses: &[Pose],
    [body, relative_to]: [usize; 2],
    distance: f64,
    path: &mut MotionPath,
) -> f64 {
    let of = context.checker.scene().bodies[body].frame;
    let mut most: f64 = 0.0;
    if of != relative_to {
        context.metric.motion_between(poses, of, relative_to, path);
        context.checker.corners_of(body, poses, &mut |position| {
            let point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: false };
            context.metric.motion_of(poses, &point, path);
            most = most.max(path.bound(distance));
        });
    }
    most
}

/// Returns the largest distance, at most `ceiling`, within which no point of a body moves by
/// `needed` \[m\] as seen from a frame.
fn radius_of(
    context: &Context,
    poses: &[Pose],
    [body, relative_to]: [usize; 2],
    needed: f64,
    mut ceiling: f64,
    path: &mut MotionPath,
) -> f64 {
    let of = context.checker.scene().bodies[body].frame;
    if of == relative_to {
        return ceiling;
    }
    context.metric.motion_between(poses, of, relative_to, path);
    context.checker.corners_of(body, poses, &mut |position| {
        let point = BoundedPoint { position, of, relative_to, inside_of: true, inside_relative_to: false };
        context.metric.motion_of(poses, &point, path);
        if ceiling > 0.0 && path.bound(ceiling) >= needed {
            let least = 1e-9 * ceiling;
            let low = (least, path.bound(least));
            ceiling = distance_along(path, low, ceiling, needed, BoundEffort::Close).unwrap_or(0.0);
        }
    });
    ceiling
}

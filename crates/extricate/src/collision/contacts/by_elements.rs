//! Contacts of scenery and another shape.

use super::buffers::{BEYOND_NEAREST_SHARE, ContactBuffers};
use super::by_pieces::solid;
use super::contact::{ContactQuery, ContactSearch};
use super::convex_convex::COARSE_SLACK;
use super::sink::{Near, Sink};
use crate::collision::convex_distance::{self, Separation, Slack};
use crate::collision::narrow_phase::Buffers;
use crate::collision::prepared::PreparedShape;
use crate::collision::scenery::{
    At, Element, Planes, Scenery, element_closest, element_in, from_half_space, lift, lifted, raised,
};
use crate::collision::shapes::bounds::Relative;
use crate::collision::shapes::bvh::push_sorted;
use crate::collision::shapes::{ConvexSolid, ShapeKind};
use crate::math::{Pose, Vec3};

/// Overlapping elements after which a search ends: a link in a wall of cubes overlaps hundreds.
/// With twice as many, queries end a hundredth farther away and take a fourth longer. Lab L098.
const MAX_OVERLAPS: usize = 4;
/// Tests of elements after which only those that may be nearer than the nearest contact are tested.
/// Lab L098.
const UNRESTRICTED_TESTS: usize = 4;
/// Contacts after which only nearer ones are searched for: a few that are near each other are
/// representative.
const UNRESTRICTED_CONTACTS: usize = 4;

/// Offers `sink` contacts of scenery (the first shape, in whose frame they are found) and `other`
/// that are nearer than the margin, nearest first.
///
/// The nearest one is among them, unless [`MAX_OVERLAPS`] elements overlap. None is farther than it
/// by more than half of the margin. A shape that lies in the ground has the contacts that it would
/// have if it were raised out of it, with distances from where it is.
pub fn by_elements(
    scenery: &Scenery,
    other: &PreparedShape,
    relative: &Relative,
    query: ContactQuery,
    buffers: &mut ContactBuffers,
    sink: &mut Sink,
) {
    if let Scenery::HalfSpace(half) = scenery {
        let found = from_half_space(half, relative, &other.shape).filter(|found| found.distance < query.margin);
        found.into_iter().for_each(|found| sink.push(&Near::from(found)));
        return;
    }
    let rise = lift(scenery, &other.shape, relative, &mut buffers.shapes);
    let relative = if rise > 0.0 { &raised(relative, rise) } else { relative };
    let approach = scenery.approach(relative, &other.shape.bounds);
    let beyond = BEYOND_NEAREST_SHARE * query.margin;
    let (mut limit, mut nearest) = (query.margin, query.margin);
    let (mut tests, mut overlaps) = (0, 0);
    let mut measured = Measured { other, relative, search: query.search, planes: Planes::default() };
    let ContactBuffers { found, shapes, .. } = buffers;
    let mut stack = std::mem::take(&mut shapes.places);
    stack.clear();
    found.clear();
    stack.extend(scenery.root().map(|root| (f64::NEG_INFINITY, root.0)));
    while let Some((bound, at)) = stack.pop() {
        if overlaps == MAX_OVERLAPS {
            break;
        }
        if bound >= if tests >= UNRESTRICTED_TESTS { nearest } else { limit } {
            continue;
        }
        let cutoff = if found.len() >= UNRESTRICTED_CONTACTS { nearest } else { limit };
        let Some(number) = At(at).as_element() else {
            if scenery.bounds_of(At(at)).is_some_and(|bounds| measured.planes.part_box(&bounds, cutoff)) {
                continue;
            }
            let start = stack.len();
            scenery.open(At(at), &approach, cutoff, |bound, child| {
                push_sorted(&mut stack, start, (bound, child.0), |entry| entry.0);
            });
            continue;
        };
        tests += 1;
        let contact = |element: Element| measured.separation(&element, cutoff, shapes);
        let Some(separation) = scenery.with_element(number, &approach, contact).flatten() else { continue };
        nearest = nearest.min(separation.distance);
        limit = limit.min(separation.distance.max(0.0) + beyond);
        overlaps += usize::from(separation.distance < 0.0);
        found.push(Near::from(if rise > 0.0 { lifted(separation, rise) } else { separation }));
    }
    shapes.places = stack;
    found.sort_unstable_by(|x, y| x.distance.total_cmp(&y.distance));
    for near in found.iter().take_while(|near| near.distance < limit) {
        if !sink.offer(near) {
            break;
        }
    }
}

/// The other shape, and planes that it lies behind, found by searches for earlier elements.
struct Measured<'a> {
    other: &'a PreparedShape,
    relative: &'a Relative,
    search: ContactSearch,
    planes: Planes,
}

impl Measured<'_> {
    /// Returns the separation of an element if it is below `limit` \[m\]. A coarse search replaces
    /// a mesh by its pieces.
    fn separation(&mut self, element: &Element, limit: f64, buffers: &mut Buffers) -> Option<Separation> {
        let Self { other, relative, search, .. } = *self;
        let found = match &other.shape.kind {
            ShapeKind::Convex(_) if self.planes.part(element, limit) => None,
            // A plane proves that the middle of the element is outside the shape.
            ShapeKind::Convex(solid) if self.planes.part(element, -element.solid.shape.radius) => {
                self.searched(element, solid, limit)
            }
            ShapeKind::Convex(solid) => {
                element_in(element, solid, relative).or_else(|| self.searched(element, solid, limit))
            }
            _ if search == ContactSearch::Exact => element_closest(element, &other.shape, relative, limit, buffers),
            _ => of_pieces(element, other, relative, limit),
        };
        found.filter(|found| found.distance < limit)
    }

    fn searched(&mut self, element: &Element, solid: &ConvexSolid, limit: f64) -> Option<Separation> {
        let (place, pose) = (Pose::translation(element.place), &self.relative.pose_a_b);
        let mut normal = Vec3::zeros();
        let (shapes, poses) = ([&element.solid.shape, &solid.shape], [&place, pose]);
        let slack = if self.search == ContactSearch::Exact { Slack::NONE } else { COARSE_SLACK };
        let found = convex_distance::separation_within(&mut normal, shapes, poses, limit, slack);
        if found.is_none_or(|found| found.distance > 0.0) {
            self.planes.add(&normal, solid, pose);
        }
        found
    }
}

fn of_pieces(element: &Element, other: &PreparedShape, relative: &Relative, mut limit: f64) -> Option<Separation> {
    let place = Pose::translation(element.place);
    let from_element = Relative::new(place.inverse().then(&relative.pose_a_b));
    let mut best = None;
    for piece in other.cover().shapes {
        if from_element.lower_bound(element.bounds, &piece.bounds) >= limit {
            continue;
        }
        let found =
            convex_distance::separation(&element.solid.shape, &place, &solid(piece).shape, &relative.pose_a_b, limit);
        if let Some(found) = found.filter(|found| found.distance < limit) {
            (best, limit) = (Some(found), found.distance);
        }
    }
    best
}

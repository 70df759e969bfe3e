//! Scenery against another shape: whether they keep a distance, and their signed distance.

use super::field::{Field, raised};
use super::half_space::HalfSpace;
use super::kinds::Scenery;
use super::nodes::{Approach, At, Element};
use super::planes::Planes;
use crate::collision::convex_distance::{self, Separation};
use crate::collision::narrow_phase::mesh_solid::mesh_nearer;
use crate::collision::narrow_phase::{Buffers, SeparatingWitness, mesh_convex};
use crate::collision::shapes::bounds::{Aabb, ROUNDING, Relative};
use crate::collision::shapes::bvh::push_sorted;
use crate::collision::shapes::convex::ConvexCore;
use crate::collision::shapes::mesh::MeshShape;
use crate::collision::shapes::{ConvexSolid, Shape, ShapeKind};
use crate::math::{Pose, Vec3};

/// Whether the signed distance to `other` is below `limit` \[m\]. `relative` places `other` in the
/// frame of the scenery.
pub fn nearer(
    scenery: &Scenery,
    other: &Shape,
    relative: &Relative,
    limit: f64,
    hint: &mut SeparatingWitness,
    buffers: &mut Buffers,
) -> bool {
    match scenery {
        Scenery::HalfSpace(half) => {
            return half.lower_bound(relative, &other.bounds) < limit + ROUNDING
                && from_half_space(half, relative, other).is_some_and(|found| found.distance < limit);
        }
        Scenery::Field(field) if within(field, other, relative) => return true,
        _ => {}
    }
    let approach = scenery.approach(relative, &other.bounds);
    let mut planes = Planes::default();
    let mut is_near = |number: u32, hint: &mut SeparatingWitness, buffers: &mut Buffers| {
        let near = |element: Element| element_nearer(&element, other, relative, limit, (hint, &mut planes), buffers);
        scenery.with_element(number, &approach, near).unwrap_or(false)
    };
    let last = hint.triangles.1;
    if is_near(last, hint, buffers) {
        return true;
    }
    let mut stack = std::mem::take(&mut buffers.places);
    let mut found = None;
    visit(scenery, &approach, limit, &mut stack, |number, _| {
        if number != last && is_near(number, hint, buffers) {
            found = Some(number);
        }
        found.is_some()
    });
    buffers.places = stack;
    hint.triangles.1 = found.unwrap_or(last);
    found.is_some()
}

/// Calls `each` with the numbers of elements that may be nearer than `limit` \[m\], nearer ones
/// first, until it returns `true`. `each` may lower the limit.
fn visit(
    scenery: &Scenery,
    approach: &Approach,
    mut limit: f64,
    stack: &mut Vec<(f64, u32)>,
    mut each: impl FnMut(u32, &mut f64) -> bool,
) {
    stack.clear();
    stack.extend(scenery.root().map(|root| (f64::NEG_INFINITY, root.0)));
    while let Some((bound, at)) = stack.pop() {
        let at = At(at);
        if bound >= limit + ROUNDING {
            continue;
        }
        match at.as_element() {
            Some(number) => {
                if each(number, &mut limit) {
                    return;
                }
            }
            None => {
                let start = stack.len();
                scenery.open(at, approach, limit + ROUNDING, |bound, child| {
                    push_sorted(stack, start, (bound, child.0), |entry| entry.0);
                });
            }
        }
    }
}

/// Whether the centre of a solid or a vertex of a mesh lies in the ground. This decides deep
/// penetration at once.
fn within(field: &Field, other: &Shape, relative: &Relative) -> bool {
    let point = match &other.kind {
        ShapeKind::Convex(solid) => solid.shape.core.center(),
        ShapeKind::Mesh(mesh) => mesh.representatives[0],
        ShapeKind::Scenery(_) => return false,
    };
    field.holds(&relative.pose_a_b.point(&point))
}

/// Maps the frame of the other shape to that of an element.
fn from_element(place: &Vec3, relative: &Relative) -> Pose {
    let Pose { rotation, translation } = relative.pose_a_b;
    Pose { rotation, translation: translation - place }
}

fn element_nearer(
    element: &Element,
    other: &Shape,
    relative: &Relative,
    limit: f64,
    (hint, planes): (&mut SeparatingWitness, &mut Planes),
    buffers: &mut Buffers,
) -> bool {
    /// Margin \[m\] above the error of a search.
    const PARTING_MARGIN_M: f64 = 1e-8;
    let pose = from_element(&element.place, relative);
    match &other.kind {
        ShapeKind::Convex(solid) => match depth_of_core(element.solid, solid, &pose) {
            Some(depth) => depth + limit > 0.0,
            None if planes.part(element, limit + PARTING_MARGIN_M) => false,
            None => {
                let (mut normal, here) = (Vec3::zeros(), Pose::identity());
                let shapes = (&element.solid.shape, &solid.shape);
                let is_near = convex_distance::nearer_than_from(&mut normal, shapes.0, &here, shapes.1, &pose, limit);
                if !is_near {
                    planes.add(&normal, solid, &relative.pose_a_b);
                }
                is_near
            }
        },
        ShapeKind::Mesh(mesh) => {
            let relative = Relative::new(pose.inverse());
            !relative.apart(&other.bounds, element.bounds, limit)
                && mesh_nearer(mesh, element.bounds, element.solid, &relative, limit, hint, buffers)
        }
        ShapeKind::Scenery(_) => false,
    }
}

/// Signed depth \[m\] of a solid in another one, in closed form. `None` unless one is a ball and
/// the other a primitive.
fn depth_of_core(a: &ConvexSolid, b: &ConvexSolid, pose_a_b: &Pose) -> Option<f64> {
    let is_ball = |solid: &ConvexSolid| matches!(solid.shape.core, ConvexCore::Point);
    if is_ball(a) && b.is_primitive() {
        return Some(b.depth(&pose_a_b.inverse_point(&Vec3::zeros())) + a.shape.radius);
    }
    (is_ball(b) && a.is_primitive()).then(|| a.depth(&pose_a_b.translation) + b.shape.radius)
}

/// Signed distance to `other` and the points that realise it, if below `cutoff` \[m\]. The first
/// point belongs to the scenery, in its frame.
///
/// It is exact if they are apart. Below 0, it is exact for a half-space. For balls and cubes, it is
/// that of the one with the deepest overlap, as if alone. For a height field, it is estimated from
/// the lift that frees the other shape.
pub fn closest(
    scenery: &Scenery,
    other: &Shape,
    relative: &Relative,
    cutoff: f64,
    buffers: &mut Buffers,
) -> Option<Separation> {
    if let Scenery::HalfSpace(half) = scenery {
        return from_half_space(half, relative, other).filter(|found| found.distance < cutoff);
    }
    let rise = lift(scenery, other, relative, buffers);
    if rise == 0.0 {
        return closest_element(scenery, other, relative, cutoff, buffers);
    }
    let found = closest_element(scenery, other, &raised(relative, rise), f64::INFINITY, buffers)?;
    Some(lifted(found, rise)).filter(|found| found.distance < cutoff)
}

/// Signed distance of a half-space and a shape, with the points that realise it. In closed form,
/// exact also below 0; `None` for scenery.
pub fn from_half_space(half: &HalfSpace, relative: &Relative, other: &Shape) -> Option<Separation> {
    let pose = &relative.pose_a_b;
    let down = pose.inverse_vector(&-half.normal);
    let lowest = match &other.kind {
        ShapeKind::Convex(solid) => solid.shape.core.support(&down) + down * solid.shape.radius,
        ShapeKind::Mesh(mesh) => {
            let along = |v: &Vec3| down.dot(v);
            *mesh.vertices.iter().max_by(|a, b| along(a).total_cmp(&along(b)))?
        }
        ShapeKind::Scenery(_) => return None,
    };
    let point_second = pose.point(&lowest);
    let distance = half.height(&point_second);
    let point_first = point_second - half.normal * distance;
    Some(Separation { distance, depth_lower: -distance, point_first, point_second, normal: -half.normal })
}

/// Converts the separation of a shape that was raised by `rise` \[m\] to its original position.
pub fn lifted(found: Separation, rise: f64) -> Separation {
    let up = Vec3::z() * rise;
    let distance = found.distance + found.normal.dot(&up);
    Separation { distance, depth_lower: f64::NEG_INFINITY, point_second: found.point_second - up, ..found }
}

fn closest_element(
    scenery: &Scenery,
    other: &Shape,
    relative: &Relative,
    cutoff: f64,
    buffers: &mut Buffers,
) -> Option<Separation> {
    let approach = scenery.approach(relative, &other.bounds);
    let mut stack = std::mem::take(&mut buffers.places);
    let mut best = None;
    visit(scenery, &approach, cutoff, &mut stack, |number, limit| {
        let of_element = |element: Element| element_closest(&element, other, relative, *limit, buffers);
        if let Some(found) = scenery.with_element(number, &approach, of_element).flatten()
            && found.distance < *limit
        {
            (best, *limit) = (Some(found), found.distance);
        }
        false
    });
    buffers.places = stack;
    best
}

/// Lift \[m\] that just frees a shape from a height field; 0 if they do not overlap.
///
/// It is at most 0.1 mm too large, except on ground so rough that the steps run out earlier.
pub fn lift(scenery: &Scenery, other: &Shape, relative: &Relative, buffers: &mut Buffers) -> f64 {
    /// Gap \[m\] that may remain below the lifted shape.
    const MAX_GAP_M: f64 = 1e-4;
    let Scenery::Field(field) = scenery else { return 0.0 };
    let low = scenery.approach(relative, &other.bounds).low;
    let highest = field.rise_above(low);
    if highest < 0.0 || !nearer(scenery, other, relative, 0.0, &mut SeparatingWitness::default(), buffers) {
        return 0.0;
    }
    // Start above the ground and descend by the distance that is proved free.
    let mut rise = highest + MAX_GAP_M;
    for _ in 0..12 {
        let found = closest_element(scenery, other, &raised(relative, rise), f64::INFINITY, buffers);
        let Some(gap) = found.map(|found| found.distance).filter(|gap| *gap > 0.0) else { break };
        rise -= gap;
        if gap < MAX_GAP_M {
            break;
        }
    }
    rise.max(f64::MIN_POSITIVE)
}

/// Separation of a ball with its centre in a solid, if a face of that solid determines it.
pub fn element_in(element: &Element, solid: &ConvexSolid, relative: &Relative) -> Option<Separation> {
    let (pose, radius) = (&relative.pose_a_b, element.solid.shape.radius);
    if !matches!(element.solid.shape.core, ConvexCore::Point) {
        return None;
    }
    let (depth, outward) = solid.nearest_face(&pose.inverse_point(&element.place))?;
    let normal = pose.vector(&outward);
    let distance = -(depth + radius + solid.shape.radius);
    let point_first = element.place - normal * radius;
    let point_second = point_first - normal * distance;
    Some(Separation { distance, depth_lower: -distance, point_first, point_second, normal })
}

/// Same as [`closest`], for one element.
pub fn element_closest(
    element: &Element,
    other: &Shape,
    relative: &Relative,
    cutoff: f64,
    buffers: &mut Buffers,
) -> Option<Separation> {
    match &other.kind {
        ShapeKind::Convex(solid) => {
            let place = Pose::translation(element.place);
            convex_distance::separation(&element.solid.shape, &place, &solid.shape, &relative.pose_a_b, cutoff)
        }
        ShapeKind::Mesh(mesh) => {
            let found = mesh_closest(mesh, &other.bounds, element, relative, cutoff, buffers)?;
            let pose = &relative.pose_a_b;
            Some(Separation {
                point_first: pose.point(&found.point_second),
                point_second: pose.point(&found.point_first),
                normal: -pose.vector(&found.normal),
                ..found
            })
        }
        ShapeKind::Scenery(_) => None,
    }
}

/// Separation of a mesh (first, in its frame) and an element.
fn mesh_closest(
    mesh: &MeshShape,
    bounds: &Aabb,
    element: &Element,
    relative: &Relative,
    cutoff: f64,
    buffers: &mut Buffers,
) -> Option<Separation> {
    let to_mesh = Relative::new(from_element(&element.place, relative).inverse());
    if to_mesh.lower_bound(bounds, element.bounds) >= cutoff {
        return None;
    }
    let pose = &to_mesh.pose_a_b;
    let found = mesh_convex::closest(&mesh.tree, element.solid, element.bounds, &to_mesh, cutoff, &mut buffers.single);
    let floor = found.map_or(cutoff, |(found, _)| found.distance);
    let center = pose.point(&element.solid.shape.core.center());
    // Both solids contain a ball around this point, so separating the solids separates the balls.
    let ball = element.solid.depth(&element.solid.shape.core.center()).max(0.0);
    if let Some((depth, surface)) = mesh.depth_inside(&center, (-floor - ball).max(0.0), &mut buffers.nodes) {
        let normal = (center - surface) / depth;
        let (point_first, point_second) = (surface, center + normal * ball);
        return Some(Separation {
            distance: -depth - ball,
            depth_lower: f64::NEG_INFINITY,
            point_first,
            point_second,
            normal,
        });
    }
    found.map(|(found, _)| found)
}

//! A tree of triangles against a convex solid: whether they are near, and their distance. The mesh
//! counts as a surface here, not as a solid.

use pulp::{Arch, Simd, WithSimd};

use super::triangle::{Triangle, closest_on_triangle};
use crate::collision::convex_distance::{self, Separation};
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::bvh::{Bvh, Cuboid, Ref, View, below, lanes_of, push_sorted, rounded_up};
use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::math::{LANES, Pose};

/// Widest gap \[m\] along a face axis of two boxes, and the node or block of the mesh.
pub type Entry = (f32, Ref);

/// Finds a triangle that is nearer than `limit` \[m\] to the solid with box `bounds`. `relative`
/// maps the solid to the mesh.
pub fn nearer(
    mesh: &Bvh,
    solid: &ConvexSolid,
    bounds: &Aabb,
    relative: &Relative,
    limit: f64,
    stack: &mut Vec<Entry>,
) -> Option<u32> {
    Arch::new().dispatch(Nearer { mesh, solid, bounds, pose: &relative.pose_a_b, limit, stack })
}

struct Nearer<'a> {
    mesh: &'a Bvh,
    solid: &'a ConvexSolid,
    bounds: &'a Aabb,
    pose: &'a Pose,
    limit: f64,
    stack: &'a mut Vec<Entry>,
}

impl WithSimd for Nearer<'_> {
    type Output = Option<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<u32> {
        let Self { mesh, solid, bounds, pose, limit, stack } = self;
        let cuboid = Cuboid::around(bounds);
        let view = View::new(pose, &mesh.cuboid, &cuboid);
        let seen = view.see(&cuboid, rounded_up(limit));
        stack.clear();
        stack.push((0.0, mesh.root));
        while let Some((_, at)) = stack.pop() {
            if at.is_block() {
                let block = &mesh.blocks[at.index()];
                let (mask, _) = block.boxes.near(simd, &view, &seen);
                let hit =
                    lanes_of(mask).find(|&lane| triangle_nearer(&block.triangle(lane), solid, bounds, pose, limit));
                if let Some(lane) = hit {
                    return Some((at.index() * LANES + lane) as u32);
                }
            } else {
                let node = &mesh.nodes[at.index()];
                let (mask, gaps) = node.boxes.near(simd, &view, &seen);
                let start = stack.len();
                for lane in lanes_of(mask) {
                    push_sorted(stack, start, (gaps[lane], node.children[lane]), |entry| entry.0);
                }
            }
        }
        None
    }
}

/// Whether a triangle is nearer than `limit` \[m\] to a convex solid. `pose` maps the solid to the
/// frame of the triangle.
pub fn triangle_nearer(triangle: &Triangle, solid: &ConvexSolid, bounds: &Aabb, pose: &Pose, limit: f64) -> bool {
    if let ConvexCore::Point = solid.shape.core {
        let reach = solid.shape.radius + limit;
        let center = &pose.translation;
        return (closest_on_triangle(triangle, center) - center).norm_squared() < reach * reach;
    }
    // First a cheap test: the whole box may lie on one side of the plane of the triangle.
    let reach = pose.inverse_vector(&triangle.normal).abs().dot(&bounds.half);
    if triangle.height(&pose.point(&bounds.center)).abs() > reach + limit {
        return false;
    }
    convex_distance::nearer_than(&as_convex(triangle), &Pose::identity(), &solid.shape, pose, limit)
}

/// Least signed distance \[m\] of any triangle to the solid, if below `cutoff`, and the index of
/// that triangle. The result is in the frame of the mesh, which comes first.
///
/// A negative distance is the translation that separates the solid from the one triangle that it
/// overlaps most. It underestimates the translation that separates it from the mesh.
pub fn closest(
    mesh: &Bvh,
    solid: &ConvexSolid,
    bounds: &Aabb,
    relative: &Relative,
    cutoff: f64,
    stack: &mut Vec<Entry>,
) -> Option<(Separation, u32)> {
    Arch::new().dispatch(Closest { mesh, solid, bounds, pose: &relative.pose_a_b, cutoff, stack })
}

struct Closest<'a> {
    mesh: &'a Bvh,
    solid: &'a ConvexSolid,
    bounds: &'a Aabb,
    pose: &'a Pose,
    cutoff: f64,
    stack: &'a mut Vec<Entry>,
}

impl WithSimd for Closest<'_> {
    type Output = Option<(Separation, u32)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<(Separation, u32)> {
        let Self { mesh, solid, bounds, pose, cutoff, stack } = self;
        let cuboid = Cuboid::around(bounds);
        let view = View::new(pose, &mesh.cuboid, &cuboid);
        let seen = view.see(&cuboid, 0.0);
        let mut best = None;
        let mut limit = cutoff;
        stack.clear();
        stack.push((f32::NEG_INFINITY, mesh.root));
        while let Some((bound, at)) = stack.pop() {
            if f64::from(bound) >= limit {
                continue;
            }
            if at.is_block() {
                let block = &mesh.blocks[at.index()];
                let bounds = block.boxes.lower_bounds(simd, &view, &seen);
                for lane in lanes_of(below(&bounds, rounded_up(limit))) {
                    let found = triangle_separation(&block.triangle(lane), solid, pose, limit);
                    if let Some(separation) = found.filter(|s| s.distance < limit) {
                        limit = separation.distance;
                        best = Some((separation, (at.index() * LANES + lane) as u32));
                    }
                }
            } else {
                let node = &mesh.nodes[at.index()];
                let bounds = node.boxes.lower_bounds(simd, &view, &seen);
                let start = stack.len();
                for lane in lanes_of(below(&bounds, rounded_up(limit))) {
                    push_sorted(stack, start, (bounds[lane], node.children[lane]), |entry| entry.0);
                }
            }
        }
        best
    }
}

/// Signed distance and nearest points of a triangle (first) and a convex solid (second), in the
/// frame of the triangle.
pub fn triangle_separation(triangle: &Triangle, solid: &ConvexSolid, pose: &Pose, cutoff: f64) -> Option<Separation> {
    convex_distance::separation(&as_convex(triangle), &Pose::identity(), &solid.shape, pose, cutoff)
}

fn as_convex(triangle: &Triangle) -> ConvexShape {
    ConvexShape { core: ConvexCore::Triangle(triangle.points), radius: 0.0 }
}

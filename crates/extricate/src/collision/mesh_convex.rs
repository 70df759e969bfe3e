//! A tree of triangles against a convex solid: whether they come near, and how near. The mesh is a surface here.

use super::bounds::{Aabb, Relative};
use super::bvh::Bvh;
use super::convex::{ConvexCore, ConvexShape};
use super::gjk::{self, Separation};
use super::shape::ConvexSolid;
use super::triangle::{Triangle, closest_on_triangle};
use crate::math::Pose;

/// Some triangle that is nearer than `limit` \[m\] to the solid with box `bounds`; `relative` maps the solid to the mesh.
pub fn nearer(
    mesh: &Bvh,
    solid: &ConvexSolid,
    bounds: &Aabb,
    relative: &Relative,
    limit: f64,
    stack: &mut Vec<(u32, u32)>,
) -> Option<u32> {
    stack.clear();
    stack.push((0, 0));
    while let Some((index, _)) = stack.pop() {
        let node = &mesh.nodes[index as usize];
        if relative.apart(&node.bounds, bounds, limit) {
            continue;
        }
        let hit = |k: &usize| triangle_nearer(&mesh.triangles[*k], solid, bounds, &relative.pose_a_b, limit);
        if let Some(found) = mesh.leaf(node).find(hit) {
            return Some(found as u32);
        }
        if node.count == 0 {
            stack.extend([(node.first, 0), (node.first + 1, 0)]);
        }
    }
    None
}

/// Whether a triangle is nearer than `limit` \[m\] to a convex solid; `pose` maps the solid to the triangle's frame.
pub fn triangle_nearer(triangle: &Triangle, solid: &ConvexSolid, bounds: &Aabb, pose: &Pose, limit: f64) -> bool {
    if let ConvexCore::Point = solid.shape.core {
        let reach = solid.shape.radius + limit;
        let center = &pose.translation;
        return (closest_on_triangle(triangle, center) - center).norm_squared() < reach * reach;
    }
    // The box on one side of the triangle's plane.
    let reach = pose.inverse_vector(&triangle.normal).abs().dot(&bounds.half);
    if triangle.height(&pose.point(&bounds.center)).abs() > reach + limit {
        return false;
    }
    gjk::nearer_than(&as_convex(triangle), &Pose::identity(), &solid.shape, pose, limit)
}

/// The least signed distance \[m\] of any triangle to the solid, if below `cutoff`.
///
/// Below 0 it is the translation that parts the solid from the one triangle that it overlaps most: an estimate from below
/// of what parts it from the mesh.
pub fn closest(
    mesh: &Bvh,
    solid: &ConvexSolid,
    bounds: &Aabb,
    relative: &Relative,
    cutoff: f64,
    stack: &mut Vec<(f64, u32, u32)>,
) -> Option<f64> {
    let mut best = None;
    let mut limit = cutoff;
    let bound = |k: u32| (relative.lower_bound(&mesh.nodes[k as usize].bounds, bounds), k, 0);
    stack.clear();
    stack.push(bound(0));
    while let Some((at_least, index, _)) = stack.pop() {
        if at_least >= limit {
            continue;
        }
        let node = &mesh.nodes[index as usize];
        for k in mesh.leaf(node) {
            let found = triangle_separation(&mesh.triangles[k], solid, &relative.pose_a_b, limit);
            if let Some(separation) = found.filter(|s| s.distance < limit) {
                limit = separation.distance;
                best = Some(limit);
            }
        }
        if node.count == 0 {
            let (a, b) = (bound(node.first), bound(node.first + 1));
            stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
        }
    }
    best
}

/// Signed distance and witness of a triangle (first) and a convex solid (second), in the triangle's frame.
pub fn triangle_separation(triangle: &Triangle, solid: &ConvexSolid, pose: &Pose, cutoff: f64) -> Option<Separation> {
    gjk::separation(&as_convex(triangle), &Pose::identity(), &solid.shape, pose, cutoff)
}

fn as_convex(triangle: &Triangle) -> ConvexShape {
    ConvexShape { core: ConvexCore::Triangle(triangle.points), radius: 0.0 }
}

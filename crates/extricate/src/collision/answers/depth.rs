//! How deep points lie in bodies, and cheap bounds on that depth. [`Checker`] documents the public
//! functions at its methods of the same names.

use crate::collision::checker::{CheckScratch, Checker};
use crate::collision::prepared::{PreparedPart, PreparedShape};
use crate::collision::shapes::{Shape, ShapeKind, slab_depth};
use crate::math::{LANES, Pose, Vec3};

pub fn solid_depth(checker: &Checker, body: usize, point_frame: &Vec3) -> f64 {
    let mut scratch = CheckScratch::default();
    solid_depth_above(checker, body, point_frame, f64::NEG_INFINITY, &mut scratch).unwrap_or(f64::NEG_INFINITY)
}

pub fn solid_depth_above(
    checker: &Checker,
    body: usize,
    point_frame: &Vec3,
    least: f64,
    scratch: &mut CheckScratch,
) -> Option<f64> {
    let parts = &checker.bodies.parts[checker.bodies.bodies[body].parts.clone()];
    let stack = &mut scratch.buffers.nodes;
    let mut deepest = None;
    for PreparedPart { prepared, pose_frame_part, .. } in parts {
        let point = pose_frame_part.inverse_point(point_frame);
        let above = deepest.unwrap_or(least);
        if may_be_deeper(prepared, &point, above) {
            deepest = prepared.shape.depth_above(&point, above, stack).or(deepest);
        }
    }
    deepest
}

#[inline(always)]
pub fn solid_depth_bounds<'a>(
    checker: &Checker,
    body: usize,
    pose_body_points: &Pose,
    points: impl Iterator<Item = &'a [[f64; LANES]; 3]> + Clone,
    depths: &mut [[f64; LANES]],
) {
    let parts = &checker.bodies.parts[checker.bodies.bodies[body].parts.clone()];
    depths.fill([f64::NEG_INFINITY; LANES]);
    for PreparedPart { prepared, pose_frame_part, .. } in parts {
        let pose_part_points = pose_frame_part.inverse().then(pose_body_points);
        let (center, half) = (&prepared.shape.bounds.center, &prepared.shape.bounds.half);
        let half_space = prepared.shape.half_space();
        for (points, depths) in points.clone().zip(depths.iter_mut()) {
            let placed = pose_part_points.points(points);
            if let Some(plane) = half_space {
                for (lane, depth) in depths.iter_mut().enumerate() {
                    *depth = depth.max(-plane.height(&Vec3::from(placed.map(|axis| axis[lane]))));
                }
                continue;
            }
            // The largest excess along an axis is at most the distance of a point outside the box.
            for lane in 0..LANES {
                let beyond = |axis: usize| (placed[axis][lane] - center[axis]).abs() - half[axis];
                let [x, y, z] = [beyond(0), beyond(1), beyond(2)];
                let xy = if x > y { x } else { y };
                let depth = -(if xy > z { xy } else { z });
                depths[lane] = if depth > depths[lane] { depth } else { depths[lane] };
            }
        }
    }
}

/// Returns the depth \[m\] of a point in the box around a shape, which is at least that in the
/// shape.
fn depth_in_box(shape: &Shape, point: &Vec3) -> f64 {
    slab_depth((point - shape.bounds.center).abs() - shape.bounds.half)
}

/// Returns `false` if the shape's box, its convex pieces, or a plane that it lies behind prove that
/// the point is not deeper than `least` \[m\].
fn may_be_deeper(prepared: &PreparedShape, point: &Vec3, least: f64) -> bool {
    let shape = &prepared.shape;
    if depth_in_box(shape, point) <= least {
        return false;
    }
    match &shape.kind {
        ShapeKind::Convex(solid) => solid.planes().iter().all(|(n, offset)| offset - n.dot(point) > least),
        // The pieces hold the mesh, and their boxes fill less than its own, such as not the hole of
        // a ring. Wrong pieces would lose depth, so that bounds become lower, never too high.
        ShapeKind::Mesh(mesh) => {
            let reach = (-least).max(0.0);
            prepared.known_cover().is_none_or(|pieces| pieces.are_near(point, reach, &mesh.tree.cuboid))
        }
        ShapeKind::Scenery(_) => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::test_mesh::bumpy;
    use crate::robot::Geometry;
    use crate::scene::builtin;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    #[test]
    fn boxes_bound_the_depths_of_eight_points() {
        let checker = Checker::new(builtin::scene("hand").unwrap().into());
        let (mut rng, mut inside) = (rand_chacha::ChaCha8Rng::seed_from_u64(9), 0);
        for body in 0..checker.scene().bodies.len() {
            for _ in 0..200 {
                let mut number = || rng.random::<f64>() - 0.5;
                let pose = Pose::from_xyz_rpy([0.0; 3].map(|_| 0.1 * number()), [0.0; 3].map(|_| 6.0 * number()));
                let points = [[0.0; LANES]; 3].map(|axis| axis.map(|_| 0.1 * number()));
                let mut bounds = [[0.0; LANES]];
                checker.solid_depth_bounds(body, &pose, [points].iter(), &mut bounds);
                for lane in 0..LANES {
                    let point = pose.point(&Vec3::from(points.map(|axis| axis[lane])));
                    let depth = checker.solid_depth(body, &point);
                    assert!(depth <= bounds[0][lane] + 1e-12, "{body} {point}: {depth} {}", bounds[0][lane]);
                    inside += usize::from(depth > 0.0);
                }
            }
        }
        assert!(inside > 100, "{inside}");
    }

    #[test]
    fn quick_bounds_rule_out_no_deeper_point() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
        let mesh = Arc::new(bumpy(9, 2, 0.3));
        let mut ruled_out = 0;
        for geometry in [
            Geometry::ConvexHull(mesh.clone()),
            Geometry::Mesh(mesh),
            Geometry::Box { half_extents: [0.3, 0.6, 0.9] },
            Geometry::Capsule { radius: 0.3, half_length: 0.5 },
        ] {
            let shape = PreparedShape::new(&geometry).unwrap();
            for _ in 0..500 {
                let p = Vec3::from_fn(|_, _| 4.0 * (rng.random::<f64>() - 0.5));
                let (depth, least) = (shape.shape.depth(&p, &mut Vec::new()), rng.random::<f64>() - 0.8);
                assert!(depth <= least + 1e-12 || may_be_deeper(&shape, &p, least), "{p} {depth} {least}");
                ruled_out += usize::from(!may_be_deeper(&shape, &p, least));
            }
        }
        assert!(ruled_out > 500, "{ruled_out}");
    }
}

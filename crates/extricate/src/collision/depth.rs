//! How deep a point lies in a body, as far as it matters to the caller.

use super::contact::BEYOND_NEAREST;
use super::shape::{Shape, ShapeKind, slab_depth};
use super::{CheckScratch, Checker, ContactSearch, bodies::PreparedPart};
use crate::math::{LANES, Pose, Vec3};

impl Checker {
    /// Signed depth \[m\] of a point (in the body's frame) in the solid of `body`: positive inside, minus the distance
    /// outside; for surfaces minus the distance.
    ///
    /// Exact for one shape and for points outside; where solids overlap, the depth in the deepest of them, which is not more
    /// than that in their union. Minus infinity for a body without geometry.
    pub fn solid_depth(&self, body: usize, point_frame: &Vec3) -> f64 {
        let mut scratch = CheckScratch::default();
        self.solid_depth_above(body, point_frame, f64::NEG_INFINITY, &mut scratch).unwrap_or(f64::NEG_INFINITY)
    }

    /// As [`Checker::solid_depth`] if that is above `least` \[m\]; most points that are not cost a box or a plane.
    pub fn solid_depth_above(
        &self,
        body: usize,
        point_frame: &Vec3,
        least: f64,
        scratch: &mut CheckScratch,
    ) -> Option<f64> {
        let parts = &self.bodies.parts[self.bodies.bodies[body].parts.clone()];
        let stack = &mut scratch.buffers.nodes;
        let mut deepest = None;
        for PreparedPart { shape, pose_frame_part, .. } in parts {
            let point = pose_frame_part.inverse_point(point_frame);
            let above = deepest.unwrap_or(least);
            if may_be_deeper(shape, &point, above) {
                deepest = shape.depth_above(&point, above, stack).or(deepest);
            }
        }
        deepest
    }

    /// Upper bounds \[m\] on [`Checker::solid_depth`] of points, eight an entry, given axis by axis in a frame with the pose `pose_body_points`; into
    /// `depths`, as far as that is long. They cost a box a shape.
    #[inline(always)]
    pub fn solid_depth_bounds<'a>(
        &self,
        body: usize,
        pose_body_points: &Pose,
        points: impl Iterator<Item = &'a [[f64; LANES]; 3]> + Clone,
        depths: &mut [[f64; LANES]],
    ) {
        let parts = &self.bodies.parts[self.bodies.bodies[body].parts.clone()];
        depths.fill([f64::NEG_INFINITY; LANES]);
        for PreparedPart { shape, pose_frame_part, .. } in parts {
            let pose_part_points = pose_frame_part.inverse().then(pose_body_points);
            let (center, half) = (&shape.bounds.center, &shape.bounds.half);
            let half_space = shape.half_space();
            for (points, depths) in points.clone().zip(depths.iter_mut()) {
                let placed = pose_part_points.points(points);
                if let Some(plane) = half_space {
                    for (lane, depth) in depths.iter_mut().enumerate() {
                        *depth = depth.max(-plane.height(&Vec3::from(placed.map(|axis| axis[lane]))));
                    }
                    continue;
                }
                // Of a point outside, the farthest coordinate is not farther than the point.
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

    /// Whether contacts found in such a search tell of all overlaps, containment included, so that none below the clearance means free (up to
    /// rounding): where all shapes are convex, or are taken for their pieces.
    pub fn contacts_are_complete(&self, search: ContactSearch) -> bool {
        self.all_convex() || search == ContactSearch::Coarse
    }

    /// How far \[m\] exact contacts of all pairs are told in a search with that margin, whatever is
    /// nearest: of meshes and scenery, those that are farther than the nearest of their pair by
    /// more than half of it are not.
    pub fn exact_within(&self, margin: f64) -> f64 {
        if self.all_convex() && !self.bodies.has_scenery { margin } else { BEYOND_NEAREST * margin }
    }

    /// Calls `each` with the corners (world) of a box around every shape of a body, where frames
    /// have these poses.
    pub fn corners_of(&self, body: usize, poses: &[Pose], each: &mut dyn FnMut(Vec3)) {
        let body = &self.bodies.bodies[body];
        for PreparedPart { shape, pose_frame_part, .. } in &self.bodies.parts[body.parts.clone()] {
            let pose = poses[body.frame].then(pose_frame_part);
            shape.bounds.corners().iter().for_each(|corner| each(pose.point(corner)));
        }
    }

    /// Whether no shape of a body is a mesh.
    pub fn is_convex(&self, body: usize) -> bool {
        let parts = &self.bodies.parts[self.bodies.bodies[body].parts.clone()];
        parts.iter().all(|part| !matches!(part.shape.kind, ShapeKind::Mesh(_)))
    }

    /// Whether no shape is a mesh: all are convex, or scenery made of convex shapes.
    pub fn all_convex(&self) -> bool {
        self.bodies.all_convex
    }
}

/// Depth \[m\] in the box around a shape, which is not less than that in the shape.
fn depth_in_box(shape: &Shape, point: &Vec3) -> f64 {
    slab_depth((point - shape.bounds.center).abs() - shape.bounds.half)
}

/// `false` is proved by the shape's box, or by a plane that a hull lies behind.
fn may_be_deeper(shape: &Shape, point: &Vec3, least: f64) -> bool {
    if depth_in_box(shape, point) <= least {
        return false;
    }
    match &shape.kind {
        ShapeKind::Convex(solid) => solid.planes().iter().all(|(n, offset)| offset - n.dot(point) > least),
        // Its pieces hold it, and their boxes hold less than its own: not the hole of a ring. Wrong ones would lose depth, so that bounds become lower, never
        // too high.
        ShapeKind::Mesh(mesh) => {
            let reach = (-least).max(0.0);
            shape.known_pieces().is_none_or(|pieces| pieces.are_near(point, reach, &mesh.tree.cuboid))
        }
        ShapeKind::Scenery(_) => true,
    }
}

impl CheckScratch {
    /// Forgets from where searches for contacts start, so that contacts no longer depend (within rounding) on earlier calls.
    pub fn forget_contacts(&mut self) {
        self.contact_buffers.forget();
    }

    /// World poses of the frames at the configuration that was last checked.
    pub fn poses(&self) -> &[Pose] {
        &self.placement.poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::test_mesh::bumpy;
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
            Geometry::Box { half_extents: Vec3::new(0.3, 0.6, 0.9) },
            Geometry::Capsule { radius: 0.3, half_length: 0.5 },
        ] {
            let shape = Shape::new(&geometry).unwrap();
            for _ in 0..500 {
                let p = Vec3::from_fn(|_, _| 4.0 * (rng.random::<f64>() - 0.5));
                let (depth, least) = (shape.depth(&p, &mut Vec::new()), rng.random::<f64>() - 0.8);
                assert!(depth <= least + 1e-12 || may_be_deeper(&shape, &p, least), "{p} {depth} {least}");
                ruled_out += usize::from(!may_be_deeper(&shape, &p, least));
            }
        }
        assert!(ruled_out > 500, "{ruled_out}");
    }
}

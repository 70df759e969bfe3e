//! Contacts of a mesh and a convex solid.

use pulp::{Arch, Simd, WithSimd};

use super::buffers::ContactBuffers;
use super::overlap::outward;
use super::sink::{Near, Sink};
use crate::collision::convex_distance;
use crate::collision::narrow_phase::best_first::Entry;
use crate::collision::narrow_phase::mesh_convex::triangle_separation;
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::bvh::{Boxes, Bvh, Cuboid, Lanes, Ref, Seen, View, below, lanes_of, rounded_up};
use crate::collision::shapes::convex::{ConvexCore, ConvexShape};
use crate::collision::shapes::mesh::MeshShape;
use crate::math::{Pose, Vec3};

/// Computes lower bounds on the distances of boxes from one box.
struct LowerBounds<'a> {
    boxes: &'a Boxes,
    view: &'a View,
    seen: &'a Seen,
}

impl WithSimd for LowerBounds<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Lanes {
        self.boxes.lower_bounds(simd, self.view, self.seen)
    }
}

pub fn mesh_with_convex(
    mesh: &MeshShape,
    solid: &ConvexSolid,
    bounds: &Aabb,
    relative: &Relative,
    buffers: &mut ContactBuffers,
    sink: &mut Sink,
) {
    let tree: &Bvh = &mesh.tree;
    let pose = &relative.pose_a_b;
    let cuboid = Cuboid::around(bounds);
    let view = View::new(pose, &tree.cuboid, &cuboid);
    let seen = view.see(&cuboid, 0.0);
    let lower_bounds = |boxes: &Boxes| Arch::new().dispatch(LowerBounds { boxes, view: &view, seen: &seen });
    buffers.restart(sink.margin, relative.lower_bound(&tree.bounds, bounds), tree.root.0, 0);
    let overlap = buffers.run(sink, |buffers, _, at, _| {
        let limit = buffers.limit;
        let at = Ref(at);
        if !at.is_block() {
            let node = &tree.nodes[at.index()];
            let bounds = lower_bounds(&node.boxes);
            for lane in lanes_of(below(&bounds, rounded_up(limit))) {
                // The box around the solid has corners that the solid, a cylinder or a hull, does
                // not have. By boxes alone, all nodes near them would be opened before the nearest
                // ones.
                let cuboid = node.boxes.get(lane);
                let Some(distance) = distance_of_box(&cuboid, solid, pose, limit) else { continue };
                let bound = f64::from(bounds[lane]).max(distance);
                buffers.queue.push(Entry { bound, first: node.children[lane].0, second: 0 });
            }
            return 0;
        }
        let block = &tree.blocks[at.index()];
        let bounds = lower_bounds(&block.boxes);
        let mut tests = 0;
        for lane in lanes_of(below(&bounds, rounded_up(limit))) {
            tests += 1;
            let face = block.triangle(lane);
            let closed = mesh.closed[block.group as usize];
            let found = triangle_separation(&face, solid, pose, limit);
            if let Some(separation) = found.filter(|s| s.distance < limit) {
                buffers.find(outward(Near::from(separation), &face, closed, solid, pose));
            }
        }
        tests
    });
    let center = pose.point(&solid.shape.core.center());
    if !overlap && let Some((depth, surface)) = mesh.depth_inside(&center, 0.0, &mut buffers.nodes) {
        let normal = (center - surface) / depth;
        sink.offer(&Near { distance: -depth, point_first: surface, point_second: center, normal });
    }
}

/// Returns a lower bound \[m\] on the distance of a box's contents from a solid, 0 if they overlap;
/// `None` beyond `limit`.
fn distance_of_box(cuboid: &Cuboid, solid: &ConvexSolid, pose: &Pose, limit: f64) -> Option<f64> {
    let core = ConvexCore::Box { half_extents: Vec3::from(cuboid.half.map(f64::from)) };
    let shape = ConvexShape { core, radius: 0.0 };
    let place = Pose::translation(Vec3::from(cuboid.center.map(f64::from)));
    convex_distance::distance_within([&shape, &solid.shape], [&place, pose], limit)
}

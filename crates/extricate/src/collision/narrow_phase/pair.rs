//! Two placed shapes of any kind: whether they keep a distance, and their signed distance. A body
//! inside a solid is in collision with it.

use super::memory::{Buffers, SeparatingWitness};
use super::mesh_solid::mesh_nearer;
use super::{mesh_convex, mesh_mesh, triangle};
use crate::collision::convex_distance;
use crate::collision::prepared::Placed;
use crate::collision::scenery;
use crate::collision::shapes::bounds::Relative;
use crate::collision::shapes::inner_spheres::proves_nearer;
use crate::collision::shapes::mesh::MeshShape;
use crate::collision::shapes::{ConvexSolid, ShapeKind};
use crate::math::{Pose, Vec3};

/// Share of a depth by which its proved lower bound may be too low. A bound within 1e-12 takes
/// twice as long and raises the bounds derived from it by only 0.5 %.
const DEPTH_SLACK_SHARE: f64 = 0.1;

/// Proved lower bound on the penetration depth \[m\] of two convex solids; `None` if they are
/// apart.
pub fn convex_depth((x, pose_x): (&ConvexSolid, &Pose), (y, pose_y): (&ConvexSolid, &Pose)) -> Option<f64> {
    let last = &mut convex_distance::LastFeatures::default();
    let slack = convex_distance::Slack { depth: DEPTH_SLACK_SHARE, ..convex_distance::Slack::NONE };
    let separation = convex_distance::separation_near(last, &x.shape, pose_x, &y.shape, pose_y, 0.0, slack)?;
    Some(separation.depth_lower).filter(|depth| *depth > 0.0)
}

/// Whether the signed distance of two shapes is below `limit` \[m\]. Crossing surfaces count as
/// below 0.
pub fn nearer(first: Placed, second: Placed, limit: f64, hint: &mut SeparatingWitness, buffers: &mut Buffers) -> bool {
    let relative = Relative::between(first.pose, second.pose);
    if relative.apart(&first.shape().bounds, &second.shape().bounds, limit) {
        return false;
    }
    proves_nearer(first.with_inner(), second.with_inner(), &relative.pose_a_b, limit)
        || surfaces_nearer(first, second, &relative, limit, hint, buffers)
}

/// Whether balls inside the shapes prove that their signed distance is below `limit` \[m\]. `false`
/// proves nothing.
pub fn proved_nearer(first: Placed, second: Placed, limit: f64) -> bool {
    proves_nearer(first.with_inner(), second.with_inner(), &first.pose.inverse().then(second.pose), limit)
}

/// Same as [`nearer`], by surfaces and containment alone.
pub fn surfaces_nearer(
    first: Placed,
    second: Placed,
    relative: &Relative,
    limit: f64,
    hint: &mut SeparatingWitness,
    buffers: &mut Buffers,
) -> bool {
    use ShapeKind::{Convex, Mesh, Scenery};
    let (a, b) = (first.shape(), second.shape());
    match (&a.kind, &b.kind) {
        (Scenery(x), _) => scenery::nearer(x, b, relative, limit, hint, buffers),
        (_, Scenery(y)) => {
            let relative = Relative::between(second.pose, first.pose);
            scenery::nearer(y, a, &relative, limit, hint, buffers)
        }
        (Convex(x), Convex(y)) => {
            let (pose, normal) = (&relative.pose_a_b, &mut hint.normal);
            if parted(x, y, pose, normal, limit) {
                return false;
            }
            // The search must not start from the hint: within rounding of the limit, the answer
            // would then depend on earlier checks.
            *normal = Vec3::zeros();
            convex_distance::nearer_than_from(normal, &x.shape, &Pose::identity(), &y.shape, pose, limit)
        }
        (Mesh(x), Convex(y)) => mesh_nearer(x, &b.bounds, y, relative, limit, hint, buffers),
        (Convex(x), Mesh(y)) => {
            let relative = Relative::between(second.pose, first.pose);
            mesh_nearer(y, &a.bounds, x, &relative, limit, hint, buffers)
        }
        (Mesh(x), Mesh(y)) => {
            let (i, j) = hint.triangles;
            if let (Some(s), Some(t)) = (x.tree.triangle(i), y.tree.triangle(j))
                && triangle::nearer(&s, &t.moved(&relative.pose_a_b), limit)
            {
                return true;
            }
            match mesh_mesh::nearer(&x.tree, &y.tree, relative, limit, &mut buffers.pairs) {
                Some(found) => {
                    hint.triangles = found;
                    true
                }
                None => holds_other(x, y, &relative.pose_a_b, &mut buffers.nodes),
            }
        }
    }
}

/// Whether a plane across `normal` separates two solids by clearly more than `limit`. `normal` has
/// any length, lies in the frame of `x` and points from `y` to `x`.
fn parted(x: &ConvexSolid, y: &ConvexSolid, pose: &Pose, normal: &Vec3, limit: f64) -> bool {
    /// Margin \[m\] above the error of a search without a hint.
    const PARTING_MARGIN_M: f64 = 1e-8;
    let lowest = x.shape.core.support(&-normal);
    let highest = pose.point(&y.shape.core.support(&pose.inverse_vector(normal)));
    normal.dot(&(lowest - highest)) > (limit + PARTING_MARGIN_M + x.shape.radius + y.shape.radius) * normal.norm()
}

/// Whether a component of one mesh lies inside a closed component of the other. Their surfaces must
/// be apart, so that one vertex of each component decides.
fn holds_other(a: &MeshShape, b: &MeshShape, pose_a_b: &Pose, stack: &mut Vec<(f64, u32)>) -> bool {
    b.representatives.iter().any(|p| a.holds(&pose_a_b.point(p), stack))
        || a.representatives.iter().any(|p| b.holds(&pose_a_b.inverse_point(p), stack))
}

/// Lower bound \[m\] on the signed distance of two shapes, from their boxes.
pub fn lower_bound(first: Placed, second: Placed) -> f64 {
    Relative::between(first.pose, second.pose).lower_bound(&first.shape().bounds, &second.shape().bounds)
}

/// Signed distance \[m\] of two shapes, if below `cutoff`.
///
/// It is exact if they are apart, and for convex shapes. With a mesh, a negative distance
/// underestimates the translation that separates the two:
/// - mesh and mesh: depth of the deepest vertex of either inside the other, or 0 if surfaces cross
///   and no vertex is inside;
/// - mesh and convex: translation that separates the solid from one triangle, or depth of its
///   centre inside the mesh plus that inside itself;
/// - scenery: see [`scenery::closest`].
pub fn signed_distance(first: Placed, second: Placed, cutoff: f64, buffers: &mut Buffers) -> Option<f64> {
    use ShapeKind::{Convex, Mesh, Scenery};
    let (a, b) = (first.shape(), second.shape());
    let relative = Relative::between(first.pose, second.pose);
    let pose = &relative.pose_a_b;
    if relative.lower_bound(&a.bounds, &b.bounds) >= cutoff {
        return None;
    }
    match (&a.kind, &b.kind) {
        (Convex(x), Convex(y)) => {
            convex_distance::separation(&x.shape, &Pose::identity(), &y.shape, pose, cutoff).map(|found| found.distance)
        }
        (Scenery(x), _) => scenery::closest(x, b, &relative, cutoff, buffers).map(|found| found.distance),
        (_, Scenery(_)) | (Convex(_), Mesh(_)) => return signed_distance(second, first, cutoff, buffers),
        (Mesh(x), Convex(y)) => {
            let found = mesh_convex::closest(&x.tree, y, &b.bounds, &relative, cutoff, &mut buffers.single);
            let found = found.map(|(found, _)| found.distance);
            let floor = found.unwrap_or(cutoff);
            let center = pose.point(&y.shape.core.center());
            // Both solids contain a ball around this point, so separating the solids separates the
            // balls.
            let ball = y.depth(&y.shape.core.center()).max(0.0);
            let inside = x.depth_inside(&center, (-floor - ball).max(0.0), &mut buffers.nodes);
            inside.map(|(depth, _)| -depth - ball).or(found)
        }
        (Mesh(x), Mesh(y)) => {
            let found = mesh_mesh::closest(&x.tree, &y.tree, &relative, cutoff.max(0.0), &mut buffers.pairs);
            let crosses = found == Some(0.0);
            let mut depth = (-cutoff).max(0.0);
            let mut deeper = false;
            let stack = &mut buffers.nodes;
            // One vertex decides whether a component is inside, but the depth needs all vertices,
            // as it does for crossing surfaces. Otherwise the depth would jump as a body goes in.
            let is_inside = !crosses && holds_other(x, y, pose, stack);
            if crosses || is_inside {
                for p in y.vertices.iter().map(|p| pose.point(p)) {
                    if let Some((deepest, _)) =
                        a.bounds.contains(&p).then(|| x.depth_inside(&p, depth, stack)).flatten()
                    {
                        (depth, deeper) = (deepest, true);
                    }
                }
                for p in x.vertices.iter().map(|p| pose.inverse_point(p)) {
                    if let Some((deepest, _)) =
                        b.bounds.contains(&p).then(|| y.depth_inside(&p, depth, stack)).flatten()
                    {
                        (depth, deeper) = (deepest, true);
                    }
                }
            }
            match (deeper, is_inside) {
                (true, _) => Some(-depth),
                (false, true) => Some(0.0),
                (false, false) => found,
            }
        }
    }
    .filter(|distance| *distance < cutoff)
}

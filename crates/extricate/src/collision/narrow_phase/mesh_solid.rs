//! Whether the solid that a mesh bounds is near a convex one.

use super::memory::{Buffers, SeparatingWitness};
use super::mesh_convex;
use crate::collision::shapes::ConvexSolid;
use crate::collision::shapes::bounds::{Aabb, Relative};
use crate::collision::shapes::mesh::MeshShape;

/// Whether the signed distance of a mesh and a convex solid is below `limit` \[m\]. The solid has
/// box `bounds`, and `relative` maps it to the mesh.
pub fn mesh_nearer(
    mesh: &MeshShape,
    bounds: &Aabb,
    solid: &ConvexSolid,
    relative: &Relative,
    limit: f64,
    hint: &mut SeparatingWitness,
    buffers: &mut Buffers,
) -> bool {
    let pose = &relative.pose_a_b;
    if let Some(t) = mesh.tree.triangle(hint.triangles.0)
        && mesh_convex::triangle_nearer(&t, solid, bounds, pose, limit)
    {
        return true;
    }
    match mesh_convex::nearer(&mesh.tree, solid, bounds, relative, limit, &mut buffers.single) {
        Some(found) => {
            hint.triangles.0 = found;
            true
        }
        None => mesh.holds(&pose.point(&solid.shape.core.center()), &mut buffers.nodes),
    }
}

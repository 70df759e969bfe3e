//! Convex pieces that together hold a mesh: its box is cut, plane by plane, until the hull of what
//! lies in each cell follows the surface ([`cells`]). What such cells leave hollow is parted along
//! its surface instead ([`patches`]). One mesh, no pairs.

mod approximate_hull;
mod cells;
mod cut;
mod list;
mod patches;
mod scattered;
mod surface_points;

use super::shapes::bounds::{Aabb, bounding_ball};
use super::shapes::convex::{ConvexCore, ConvexShape, HullPoints};
use super::shapes::mesh::MeshShape;
use super::shapes::{ConvexSolid, Shape, ShapeKind};
use crate::math::Vec3;
use crate::robot::TriangleMesh;
pub use cells::THICKNESS;
use cells::{Divider, TOLERANCE, cells, deepest};
pub use list::{Pieces, PiecesRef};
use patches::connected;
use scattered::scattered;

/// A mesh whose hollows the pieces fill by more than this share of the radius of its ball is parted
/// along its surface: a body of that size finds no way into them.
const HOLLOW: f64 = 0.1;
/// How far patches along the surface may stand out, as a share of the same, the most of a component
/// while it is parted, and when those are joined that one hull follows.
const PATCH_TOLERANCE: f64 = 0.001;
const MOST_PATCHES: usize = 192;
const MOST_KEPT: usize = 96;
/// Most pieces for proposals of contacts. On 13 robots of raw meshes among obstacles drawn at
/// random, 48 took up to a third more time for the same answers; with 24 the room of six walls in
/// the tests is not followed, with 12 one query in 40 more ended over 1 % farther.
const MOST: usize = 32;
/// The same of scenes that have them in the place of a mesh.
const MOST_PARTS: usize = 48;

/// Convex shapes in the frame of `mesh` whose union holds its closed components and its surfaces.
///
/// Each is the hull of what lies in one cell, corners of the cell within the solid included. They
/// stand out of the mesh by [`TOLERANCE`] where no more than [`MOST`] are needed for that, as far
/// as their largest faces and points spread over the mesh tell; and they hold it up to
/// [`THICKNESS`]. Many small solids are a piece each.
///
/// If that leaves a hollow filled and there are no more than [`MOST`] components, each is looked at
/// by itself: a convex one is a piece, one that cells follow is theirs, and any other is made of
/// patches along its surface.
pub fn pieces(mesh: &MeshShape, bounds: &Aabb) -> Pieces {
    if let Some(solids) = scattered(mesh, MOST, bounds.half.norm()) {
        return Pieces::new(solids.iter().map(|points| solid(points)).collect());
    }
    let radius = bounds.half.norm();
    let all = mesh.tree.triangles(0..mesh.tree.blocks.len()).map(|t| t.points).collect();
    let whole = cells(mesh, all, radius, MOST, false);
    let by_cells = || Pieces::new(whole.iter().map(|cell| solid(&cell.hull.vertices)).collect());
    if deepest(&whole) <= HOLLOW * radius {
        return by_cells();
    }
    // Only now, for it takes a pass over all triangles of surfaces.
    let components = components(mesh);
    if components.len() > MOST {
        return by_cells();
    }
    let divider = Divider { mesh, thickness: THICKNESS * radius, across: false };
    let (mut solids, mut is_skin) = (Vec::new(), false);
    // What cells do with one that is alone is known.
    let is_one_of_several = components.len() > 1;
    for triangles in components {
        if is_one_of_several {
            if let Some(hull) = divider.convex(&triangles, TOLERANCE * radius) {
                solids.push(solid(&hull.vertices));
                continue;
            }
            let cells = cells(mesh, triangles.clone(), radius, MOST, false);
            if deepest(&cells) <= HOLLOW * radius {
                solids.extend(cells.iter().map(|cell| solid(&cell.hull.vertices)));
                continue;
            }
        }
        // A surface that so many do not follow is no box of walls: its patches fill the hollow too,
        // and take long to look at.
        let patches = divider.patches(triangles, PATCH_TOLERANCE * radius, MOST_PATCHES);
        let follow = patches.iter().all(|patch| patch.depth <= TOLERANCE * radius);
        if !follow || patches.len() > MOST_KEPT {
            return by_cells();
        }
        is_skin = true;
        solids.extend(patches.iter().map(|patch| solid(&patch.hull.vertices)));
    }
    if is_skin { Pieces::skin(solids) } else { Pieces::new(solids) }
}

/// The triangles of every closed component, and of surfaces those that share corners.
fn components(mesh: &MeshShape) -> Vec<Vec<[Vec3; 3]>> {
    let mut all = Vec::new();
    for (group, is_closed) in mesh.tree.groups.iter().zip(&mesh.closed) {
        let triangles: Vec<[Vec3; 3]> = mesh.tree.triangles(group.blocks.clone()).map(|t| t.points).collect();
        if *is_closed { all.push(triangles) } else { all.extend(connected(&triangles)) }
    }
    all
}

/// Convex hulls that together hold a mesh, for scenes that have them in its place: those that the
/// search makes of it.
pub fn convex_parts(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    let shape = MeshShape::new(mesh);
    let bounds = Aabb::around(shape.vertices.iter());
    let all = shape.tree.triangles(0..shape.tree.blocks.len()).map(|t| t.points).collect();
    cells(&shape, all, bounds.half.norm(), MOST_PARTS, true).into_iter().map(|cell| cell.hull).collect()
}

/// The hull of points.
pub fn solid(points: &[Vec3]) -> Shape {
    let core = ConvexCore::Hull(HullPoints::new(points));
    let shape = ConvexShape { core, radius: 0.0 };
    let kind = ShapeKind::Convex(ConvexSolid::without_planes(shape));
    Shape { kind, bounds: Aabb::around(points.iter()), ball: bounding_ball(points) }
}

#[cfg(test)]
mod tests;

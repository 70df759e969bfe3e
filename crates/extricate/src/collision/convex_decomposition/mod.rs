//! Convex pieces that together hold a mesh. Its box is cut plane by plane until the hull of what
//! lies in each cell follows the surface ([`cells`]). Components with a hollow that such cells fill
//! are split into patches along their surface instead ([`patches`]).

mod approximate_hull;
mod cells;
mod cut;
mod list;
mod patches;
mod surface_points;

use rayon::prelude::*;

use super::shapes::bounds::{Aabb, bounding_ball};
use super::shapes::convex::{ConvexCore, ConvexShape, HullPoints};
use super::shapes::mesh::MeshShape;
use super::shapes::{ConvexSolid, Shape, ShapeKind};
use crate::math::Vec3;
use crate::robot::TriangleMesh;
pub use cells::THICKNESS;
use cells::{Cell, Divider, TOLERANCE_SHARE, cells, deepest};
pub use list::{Pieces, PiecesRef};
use patches::connected;

/// Sizes of bodies for which a mesh has pieces: its radius, and that halved once more for each.
pub const SIZES: usize = 8;
/// A hollow has to stay open for a body if it is more than this many times as deep as the body is
/// large: the body could enter. Lab L119.
const ENTERABLE_DEPTH_RATIO: f64 = 1.5;
/// The hull of a component, and its cells, may stand out by this share of the body's size.
const SOLID_TOLERANCE_SHARE: f64 = 0.5;
/// Patches are split until they stand out by no more than this share of the body's size. With 0.1,
/// fewer exits from cups and bent pipes are found. Lab L119.
const PATCH_TOLERANCE_SHARE: f64 = 0.03;
/// If patches still stand out by more than this share of the body's size, the component keeps its
/// cells.
const MAX_PATCH_DEPTH_SHARE: f64 = 0.1;
/// Most patches of a component whose hollow is as deep as the body is large; a deeper one has more,
/// by the square. With more, contacts cost more time than nearer exits are worth. Lab L119.
const BASE_PATCHES: f64 = 96.0;
/// Most patches of any component.
const MAX_PATCHES: usize = 1024;
/// A mesh of more components is split as one.
const MAX_COMPONENTS: usize = 4096;
/// Most pieces of a mesh. If there were more, it keeps its cells, because contacts remember pairs
/// of pieces.
pub const MOST_PIECES: usize = 4096;
/// Most cells of a mesh. On 13 robots of raw meshes among obstacles drawn at random, 48 took up to
/// a third more time for the same answers. With 24, six walls around a space in the tests are not
/// followed; with 12, one query in 40 more ended over 1 % farther. Lab L110.
const MAX_CELLS: usize = 32;
/// Most convex parts of a mesh, for scenes that have them in the place of it.
const MAX_PARTS: usize = 48;

/// Returns which of the [`SIZES`] of a mesh of `radius` represents a body of `size` \[m\]: the
/// largest that is no larger, else the smallest.
pub fn size_index(radius: f64, size: f64) -> usize {
    (0..SIZES - 1).find(|index| size_at(radius, *index) <= size).unwrap_or(SIZES - 1)
}

fn size_at(radius: f64, index: usize) -> f64 {
    radius * 0.5_f64.powi(index as i32)
}

/// Returns convex shapes in the frame of `mesh` whose union holds its closed components and its
/// surfaces, and for which of the [`SIZES`] of bodies they fill a hollow.
///
/// Each is the hull of what lies in one cell, corners of the cell within the solid included. They
/// stand out of the mesh by [`TOLERANCE_SHARE`] at most if [`MAX_CELLS`] of them suffice, as far as
/// their largest faces and points spread over the mesh show. They hold it up to [`THICKNESS`].
pub fn cell_pieces(mesh: &MeshShape, bounds: &Aabb) -> (Pieces, [bool; SIZES]) {
    let radius = bounds.half.norm();
    let cells = cells(mesh, triangles(mesh), radius, TOLERANCE_SHARE * radius, MAX_CELLS, false);
    let hollow = deepest(&cells);
    let is_coarse = |index| hollow > ENTERABLE_DEPTH_RATIO * size_at(radius, index);
    (Pieces::new(cells.iter().map(Cell::solid).collect()), std::array::from_fn(is_coarse))
}

/// Returns finer pieces, for bodies of the size `index`. A component becomes its hull if that
/// follows it, else its cells if they leave no hollow that such a body could enter. Else it becomes
/// patches along its surface, unless these are too many.
pub fn fine_pieces(mesh: &MeshShape, bounds: &Aabb, index: usize) -> Pieces {
    let radius = bounds.half.norm();
    let size = size_at(radius, index);
    let divider = Divider { mesh, thickness: THICKNESS * radius, across: false };
    let of_component = |triangles: Vec<[Vec3; 3]>| {
        if let Some(hull) = divider.convex(&triangles, SOLID_TOLERANCE_SHARE * size) {
            return (vec![solid(&hull.vertices)], Vec::new());
        }
        let cells = cells(mesh, triangles.clone(), radius, SOLID_TOLERANCE_SHARE * size, MAX_CELLS, false);
        let hollow = deepest(&cells);
        if hollow > ENTERABLE_DEPTH_RATIO * size {
            let most = ((BASE_PATCHES * (hollow / size).powi(2)) as usize).min(MAX_PATCHES);
            let patches = divider.patches(triangles, PATCH_TOLERANCE_SHARE * size, most);
            if patches.iter().all(|patch| patch.depth <= MAX_PATCH_DEPTH_SHARE * size) {
                return (Vec::new(), patches.iter().map(|patch| solid(&patch.hull.vertices)).collect());
            }
        }
        (cells.iter().map(Cell::solid).collect(), Vec::new())
    };
    let found: Vec<(Vec<Shape>, Vec<Shape>)> = components(mesh).into_par_iter().map(of_component).collect();
    if found.iter().map(|(together, apart)| together.len() + apart.len()).sum::<usize>() > MOST_PIECES {
        return cell_pieces(mesh, bounds).0;
    }
    let (together, apart): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    Pieces::with_apart(together.concat(), apart.concat())
}

fn triangles(mesh: &MeshShape) -> Vec<[Vec3; 3]> {
    mesh.tree.triangles(0..mesh.tree.blocks.len()).map(|t| t.points).collect()
}

/// Returns the triangles of every closed component, and of surfaces the groups that share corners.
fn components(mesh: &MeshShape) -> Vec<Vec<[Vec3; 3]>> {
    let mut all = Vec::new();
    for (group, is_closed) in mesh.tree.groups.iter().zip(&mesh.closed) {
        let triangles: Vec<[Vec3; 3]> = mesh.tree.triangles(group.blocks.clone()).map(|t| t.points).collect();
        if *is_closed { all.push(triangles) } else { all.extend(connected(&triangles)) }
    }
    if all.len() > MAX_COMPONENTS { vec![all.concat()] } else { all }
}

/// Returns convex hulls that together hold a mesh, for scenes that have them in its place. Also
/// returns how far they stand out of it \[m\], as far as their largest faces and points spread over
/// the mesh show.
pub fn convex_parts(mesh: &TriangleMesh) -> (Vec<TriangleMesh>, f64) {
    let shape = MeshShape::new(mesh);
    let bounds = Aabb::around(shape.vertices.iter());
    let radius = bounds.half.norm();
    let cells = cells(&shape, triangles(&shape), radius, TOLERANCE_SHARE * radius, MAX_PARTS, true);
    let beyond = deepest(&cells);
    (cells.into_iter().map(|cell| cell.hull).collect(), beyond)
}

impl Cell {
    fn solid(&self) -> Shape {
        solid(&self.hull.vertices)
    }
}

/// Returns the hull of points as a shape.
pub fn solid(points: &[Vec3]) -> Shape {
    let core = ConvexCore::Hull(HullPoints::new(points));
    let shape = ConvexShape { core, radius: 0.0 };
    let kind = ShapeKind::Convex(ConvexSolid::without_planes(shape));
    Shape { kind, bounds: Aabb::around(points.iter()), ball: bounding_ball(points) }
}

#[cfg(test)]
mod tests;

//! Convex pieces as plain arrays, stored beside their meshes. No file format.

use rayon::prelude::*;

use super::bodies::PreparedPart;
use crate::collision::convex_decomposition::{MOST_PIECES, Pieces, SIZES, THICKNESS, solid};
use crate::collision::shapes::convex::ConvexCore;
use crate::collision::shapes::mesh::MeshShape;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::math::Vec3;

/// Convex pieces of the meshes of a scene: cells, and finer ones for contact with small bodies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PieceArrays {
    /// Number of cells of every shape, body after body; 0 if it has none or none yet.
    pub counts: Vec<u32>,
    /// Bit mask for every shape: bit `k` is set if its cells are too coarse for bodies of size `k`.
    pub coarse: Vec<u8>,
    /// Four numbers for every set of finer pieces: index of the shape, index of the size, number of
    /// pieces, and how many of them must be separated together.
    pub fine: Vec<u32>,
    /// Number of hull points of every piece; all cells come first.
    pub sizes: Vec<u32>,
    /// Three coordinates of every point in the frame of its shape \[m\].
    pub points: Vec<f64>,
}

impl PieceArrays {
    fn keep(&mut self, pieces: &Pieces) {
        for piece in pieces.all().shapes {
            let ShapeKind::Convex(solid) = &piece.kind else { continue };
            let ConvexCore::Hull(hull) = &solid.shape.core else { continue };
            self.sizes.push(hull.points().len() as u32);
            self.points.extend(hull.points().iter().flat_map(|point| point.iter()));
        }
    }
}

/// See [`crate::Checker::kept_pieces`].
pub fn kept_pieces(parts: &[PreparedPart]) -> PieceArrays {
    let mut kept = PieceArrays::default();
    let known: Vec<_> = parts.iter().map(|part| part.prepared.known_pieces()).collect();
    for (cells, _) in &known {
        kept.counts.push(cells.map_or(0, |(cells, _)| cells.all().shapes.len() as u32));
        let bits = |is_coarse: &[bool; SIZES]| (0..SIZES).map(|k| u8::from(is_coarse[k]) << k).sum();
        kept.coarse.push(cells.map_or(0, |(_, is_coarse)| bits(is_coarse)));
        cells.iter().for_each(|(cells, _)| kept.keep(cells));
    }
    for (at, (_, fine)) in known.iter().enumerate() {
        for (index, pieces) in fine.iter().enumerate() {
            let Some(pieces) = pieces else { continue };
            let all = pieces.all();
            kept.fine.extend([at as u32, index as u32, all.shapes.len() as u32, all.first_apart as u32]);
            kept.keep(pieces);
        }
    }
    kept
}

/// Takes the points of the next `count` pieces.
fn next_pieces(sizes: &mut &[u32], points: &mut &[f64], count: u32) -> Option<Vec<Vec<Vec3>>> {
    if count as usize > MOST_PIECES {
        return None;
    }
    let mut pieces = Vec::new();
    for _ in 0..count {
        let (size, others) = sizes.split_first()?;
        let of_piece = (*size as usize).checked_mul(3).filter(|len| (1..=points.len()).contains(len))?;
        let (of_piece, rest) = points.split_at(of_piece);
        pieces.push(of_piece.as_chunks().0.iter().map(|p| Vec3::from(*p)).collect());
        (*sizes, *points) = (others, rest);
    }
    Some(pieces)
}

/// See [`crate::Checker::take_pieces`].
pub fn take_pieces(parts: &[PreparedPart], kept: &PieceArrays) -> bool {
    taken(parts, kept).is_some()
}

fn taken(parts: &[PreparedPart], kept: &PieceArrays) -> Option<()> {
    let (mut sizes, mut points) = (&kept.sizes[..], &kept.points[..]);
    let (fine, rest) = kept.fine.as_chunks::<4>();
    let are_in_order = fine.is_sorted_by(|a, b| a[..2] < b[..2]);
    if [kept.counts.len(), kept.coarse.len()] != [parts.len(); 2] || !rest.is_empty() || !are_in_order {
        return None;
    }
    let (mut of_parts, mut of_fine) = (Vec::new(), Vec::new());
    for ((part, count), coarse) in parts.iter().zip(&kept.counts).zip(&kept.coarse) {
        let cells = next_pieces(&mut sizes, &mut points, *count)?;
        let fits = match &part.shape().kind {
            ShapeKind::Mesh(mesh) => *count == 0 || are_of(part.shape(), mesh, &cells),
            ShapeKind::Convex(_) | ShapeKind::Scenery(_) => *count == 0,
        };
        fits.then_some(())?;
        of_parts.push((&part.prepared, cells, std::array::from_fn(|k| coarse >> k & 1 == 1)));
    }
    for &[at, index, count, together] in fine {
        let pieces = next_pieces(&mut sizes, &mut points, count)?;
        let part = parts.get(at as usize)?;
        let ShapeKind::Mesh(mesh) = &part.shape().kind else { return None };
        let is_known = (index as usize) < SIZES && together <= count && count > 0;
        (is_known && are_of(part.shape(), mesh, &pieces)).then_some(())?;
        of_fine.push((&part.prepared, index as usize, pieces, together as usize));
    }
    (sizes.is_empty() && points.is_empty()).then_some(())?;
    let solids = |pieces: &[Vec<Vec3>]| pieces.par_iter().map(|points| solid(points)).collect();
    of_parts.par_iter().filter(|(_, cells, _)| !cells.is_empty()).for_each(|(prepared, cells, is_coarse)| {
        prepared.set_cells(Pieces::new(solids(cells)), *is_coarse);
    });
    of_fine.par_iter().for_each(|(prepared, index, pieces, together)| {
        let (together, apart) = pieces.split_at(*together);
        prepared.set_fine(*index, Pieces::with_apart(solids(together), solids(apart)));
    });
    Some(())
}

fn are_of(shape: &Shape, mesh: &MeshShape, pieces: &[Vec<Vec3>]) -> bool {
    // Flat hulls are thickened, so allow for that.
    let beyond = Vec3::repeat(2.0 * THICKNESS * shape.bounds.half.norm());
    let (low, high) =
        (shape.bounds.center - shape.bounds.half - beyond, shape.bounds.center + shape.bounds.half + beyond);
    let is_between = |p: &Vec3, low: &Vec3, high: &Vec3| (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]);
    if !pieces.iter().flatten().all(|point| is_between(point, &low, &high)) {
        return false;
    }
    let around = |points: &Vec<Vec3>| {
        let low = points.iter().fold(points[0], |low, p| low.inf(p));
        let high = points.iter().fold(points[0], |high, p| high.sup(p));
        (low - beyond, high + beyond)
    };
    let boxes: Vec<(Vec3, Vec3)> = pieces.iter().map(around).collect();
    mesh.vertices.par_iter().all(|vertex| boxes.iter().any(|(low, high)| is_between(vertex, low, high)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Checker;
    use crate::collision::shapes::test_mesh::{cuboid, joined};
    use crate::robot::Geometry;
    use crate::scene::builtin;
    use std::sync::Arc;

    /// A built-in scene with two bodies replaced by a bracket, which is not a convex mesh.
    fn checker(size: f64) -> Checker {
        let mut scene = builtin::scene("planar-arm").unwrap();
        let bracket = joined(&[
            cuboid(Vec3::zeros(), Vec3::new(size, 0.02, 0.02)),
            cuboid(Vec3::new(0.8 * size, 0.0, 0.1), Vec3::new(0.02, 0.02, 0.1)),
        ]);
        scene.bodies.iter_mut().take(2).for_each(|body| {
            body.parts[0].geometry = Geometry::Mesh(Arc::new(bracket.clone()));
        });
        Checker::new(Arc::new(scene))
    }

    #[test]
    fn pieces_are_the_same_once_more() {
        let made = checker(0.2);
        assert!(made.kept_pieces().sizes.is_empty(), "none is made before it is needed");
        made.prepare_proposals();
        let (kept, again) = (made.kept_pieces(), checker(0.2));
        assert!(kept.sizes.len() >= 4, "{} pieces", kept.sizes.len());
        assert!(again.take_pieces(&kept));
        assert_eq!(again.kept_pieces(), kept);
    }

    #[test]
    fn pieces_of_other_meshes_are_refused() {
        let made = checker(0.2);
        made.prepare_proposals();
        let kept = made.kept_pieces();
        assert!(!checker(0.19).take_pieces(&kept), "of a smaller mesh");
        assert!(!checker(0.21).take_pieces(&kept), "of a larger mesh");
        let refused = |spoil: fn(&mut PieceArrays)| {
            let mut spoiled = kept.clone();
            spoil(&mut spoiled);
            !checker(0.2).take_pieces(&spoiled)
        };
        assert!(!refused(|_| ()));
        assert!(refused(|kept| kept.counts.truncate(1)));
        assert!(refused(|kept| kept.counts.push(0)));
        assert!(refused(|kept| *kept.counts.last_mut().unwrap() += 1));
        assert!(refused(|kept| kept.counts[0] = u32::MAX));
        assert!(refused(|kept| kept.sizes[0] = 0));
        assert!(refused(|kept| kept.sizes[0] = u32::MAX));
        assert!(refused(|kept| kept.points[4] = f64::NAN));
        assert!(refused(|kept| kept.points[4] = 1e3));
        assert!(refused(|kept| kept.points.push(0.0)));
        assert!(refused(|kept| kept.points.truncate(9)));
    }
}

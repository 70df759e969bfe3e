//! Convex pieces as plain arrays, to keep beside the meshes that they were made of. No file format.

use rayon::prelude::*;

use super::bodies::PreparedPart;
use crate::collision::convex_decomposition::{Pieces, THICKNESS, solid};
use crate::collision::shapes::convex::ConvexCore;
use crate::collision::shapes::mesh::MeshShape;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::math::Vec3;

/// The pieces of the meshes of a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PieceArrays {
    /// Of every shape, body after body: 0 for one that has no pieces, or none yet.
    pub counts: Vec<u32>,
    /// Of every shape, 1 if its pieces hold its surface alone, else 0.
    pub skins: Vec<u8>,
    /// Of every piece, how many points it is the hull of.
    pub sizes: Vec<u32>,
    /// Of every point, three numbers in the frame of its shape \[m\].
    pub points: Vec<f64>,
}

/// See [`crate::Checker::kept_pieces`].
pub fn kept_pieces(parts: &[PreparedPart]) -> PieceArrays {
    let mut kept = PieceArrays::default();
    for part in parts {
        let known = part.prepared.known_pieces().filter(|_| matches!(part.shape().kind, ShapeKind::Mesh(_)));
        let shapes = known.map_or(&[][..], |pieces| pieces.shapes);
        kept.counts.push(shapes.len() as u32);
        kept.skins.push(u8::from(known.is_some_and(|pieces| pieces.is_skin)));
        for piece in shapes {
            let ShapeKind::Convex(solid) = &piece.kind else { continue };
            let ConvexCore::Hull(hull) = &solid.shape.core else { continue };
            kept.sizes.push(hull.points().len() as u32);
            kept.points.extend(hull.points().iter().flat_map(|point| point.iter()));
        }
    }
    kept
}

/// See [`crate::Checker::take_pieces`].
pub fn take_pieces(parts: &[PreparedPart], kept: &PieceArrays) -> bool {
    let (mut sizes, mut points) = (&kept.sizes[..], &kept.points[..]);
    let mut of_parts = Vec::new();
    for ((part, count), is_skin) in parts.iter().zip(&kept.counts).zip(&kept.skins) {
        let mut pieces = Vec::new();
        for _ in 0..*count {
            let Some((size, others)) = sizes.split_first() else { return false };
            let Some(of_piece) = (*size as usize).checked_mul(3).filter(|len| (1..=points.len()).contains(len)) else {
                return false;
            };
            let (of_piece, rest) = points.split_at(of_piece);
            pieces.push(of_piece.as_chunks().0.iter().map(|p| Vec3::from(*p)).collect());
            (sizes, points) = (others, rest);
        }
        match &part.shape().kind {
            ShapeKind::Mesh(mesh) if *count == 0 || are_of(part.shape(), mesh, &pieces) => {}
            ShapeKind::Convex(_) | ShapeKind::Scenery(_) if *count == 0 => {}
            _ => return false,
        }
        of_parts.push((&part.prepared, pieces, *is_skin != 0));
    }
    let counts = [kept.counts.len(), kept.skins.len()];
    if of_parts.len() != parts.len() || counts != [of_parts.len(); 2] || !(sizes.is_empty() && points.is_empty()) {
        return false;
    }
    let those = of_parts.into_par_iter().filter(|(_, pieces, _)| !pieces.is_empty());
    those.for_each(|(prepared, pieces, is_skin)| {
        let solids = pieces.par_iter().map(|points: &Vec<Vec3>| solid(points)).collect();
        prepared.set_pieces(if is_skin { Pieces::skin(solids) } else { Pieces::new(solids) });
    });
    true
}

fn are_of(shape: &Shape, mesh: &MeshShape, pieces: &[Vec<Vec3>]) -> bool {
    // Flat hulls are thickened.
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
    mesh.vertices.iter().all(|vertex| boxes.iter().any(|(low, high)| is_between(vertex, low, high)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::Checker;
    use crate::collision::shapes::test_mesh::{cuboid, joined};
    use crate::robot::Geometry;
    use crate::scene::builtin;
    use std::sync::Arc;

    /// A built-in scene in which some shapes are a bracket, which is no convex mesh.
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

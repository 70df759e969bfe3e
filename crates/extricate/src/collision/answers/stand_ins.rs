//! The balls and convex pieces that stand for the shapes of a body, for people who debug shapes. No
//! check uses this copy of them.

use super::solids::parts_of;
use crate::collision::checker::Checker;
use crate::collision::convex_decomposition::PiecesRef;
use crate::collision::shapes::ShapeKind;
use crate::collision::shapes::convex::ConvexCore;
use crate::robot::TriangleMesh;
use crate::robot::mesh::convex_hull::convex_hull;

/// What stands for the shapes of a body, in the coordinates of its frame.
#[derive(Debug, Clone, Default)]
pub struct StandIns {
    /// Balls inside the solids, centre and radius \[m\]. Two that overlap prove a collision.
    pub balls: Vec<([f64; 3], f64)>,
    /// Convex pieces that together contain the meshes. They are made when a query first needs them.
    pub pieces: Vec<TriangleMesh>,
}

/// See [`Checker::stand_ins`].
pub fn stand_ins(checker: &Checker, body: usize) -> StandIns {
    let mut found = StandIns::default();
    for part in parts_of(checker, body) {
        let pose = &part.pose_frame_part;
        found.balls.extend(part.prepared.inner.iter().map(|(centre, radius)| (pose.point(&centre).into(), radius)));
        // A convex shape is its own piece.
        let is_mesh = matches!(part.shape().kind, ShapeKind::Mesh(_));
        let pieces = part.prepared.known_cover().filter(|_| is_mesh).map_or(&[][..], |PiecesRef { shapes, .. }| shapes);
        for piece in pieces {
            let ShapeKind::Convex(solid) = &piece.kind else { continue };
            let ConvexCore::Hull(hull) = &solid.shape.core else { continue };
            let points: Vec<_> = hull.points().iter().map(|point| pose.point(point)).collect();
            found.pieces.extend(convex_hull(&points));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn balls_lie_in_their_body_and_pieces_of_meshes_are_there_once_made() {
        let scene = builtin::scene("free-box").unwrap();
        let checker = Checker::new(scene.into());
        let mut scratch = crate::CheckScratch::default();
        let count = |checker: &Checker| {
            (0..checker.scene().bodies.len()).map(|b| checker.stand_ins(b).pieces.len()).sum::<usize>()
        };
        assert_eq!(count(&checker), 0);
        for body in 0..checker.scene().bodies.len() {
            for (centre, radius) in checker.stand_ins(body).balls {
                let depth = checker.solid_depth_above(body, &centre.into(), 0.0, &mut scratch).unwrap();
                assert!(radius > 0.0 && depth >= radius - 1e-12, "{body}: {depth} {radius}");
            }
        }
        let has_mesh = !checker.all_convex();
        checker.prepare_proposals();
        assert_eq!(count(&checker) > 0, has_mesh);
        assert!(has_mesh, "the scene has a mesh that is not convex");
    }
}

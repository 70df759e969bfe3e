//! A shape with all that is derived from it: balls and convex pieces in it, and convex pieces
//! around it. No pairs.

use std::sync::{Arc, OnceLock};

use crate::collision::convex_decomposition::{Pieces, PiecesRef, pieces};
use crate::collision::overlap::inner_pieces::{InnerPiece, inner_pieces};
use crate::collision::shapes::inner_spheres::InnerSpheres;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::robot::Geometry;

/// A shape prepared for checks against others: a tree of triangles, or a convex solid. Immutable,
/// shared between threads.
///
/// ```
/// use extricate::internals::collision::{PairScratch, PreparedShape};
/// use extricate::geometry::{Geometry, Pose, Vec3};
/// let ball = PreparedShape::new(&Geometry::Sphere { radius: 1.0 }).unwrap();
/// let apart = Pose::translation(Vec3::new(2.5, 0.0, 0.0));
/// assert!(!ball.is_nearer(&ball, &apart, 0.4, &mut PairScratch::default()));
/// assert!(ball.is_nearer(&ball, &apart, 0.6, &mut PairScratch::default()));
/// ```
pub struct PreparedShape {
    /// As exact checks take it.
    pub shape: Shape,
    /// Balls in it; none in scenery.
    pub inner: InnerSpheres,
    /// Of a mesh; made when they are first needed.
    pieces: OnceLock<Arc<Pieces>>,
    inner_pieces: OnceLock<Arc<[InnerPiece]>>,
}

impl PreparedShape {
    /// Prepares `geometry`; `None` for a mesh without triangles, and for a cloud or grid that holds
    /// nothing.
    ///
    /// # Cost
    /// For a mesh that of sorting its triangles a few times over.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        Some(Self::of(Shape::new(geometry)?))
    }

    /// Prepares what else there is of `shape`.
    pub(super) fn of(shape: Shape) -> Self {
        let inner = match &shape.kind {
            ShapeKind::Scenery(_) => InnerSpheres::default(),
            _ => InnerSpheres::of(&shape),
        };
        Self { shape, inner, pieces: OnceLock::new(), inner_pieces: OnceLock::new() }
    }

    /// [`PreparedShape::pieces`], unless they would first have to be made.
    pub fn known_pieces(&self) -> Option<PiecesRef<'_>> {
        match &self.shape.kind {
            ShapeKind::Convex(_) => Some((&self.shape).into()),
            ShapeKind::Mesh(_) => self.pieces.get().map(|pieces| pieces.all()),
            ShapeKind::Scenery(_) => None,
        }
    }

    /// [`PreparedShape::known_pieces`], if they hold all of the shape.
    pub fn known_cover(&self) -> Option<PiecesRef<'_>> {
        self.known_pieces().filter(|pieces| !pieces.is_skin)
    }

    /// Convex shapes in the same frame whose union holds it, or its surface: itself, or those of
    /// [`pieces`]; none of scenery, which is requested its elements.
    pub fn pieces(&self) -> PiecesRef<'_> {
        match &self.shape.kind {
            ShapeKind::Convex(_) => (&self.shape).into(),
            ShapeKind::Mesh(mesh) => {
                // Made outside of the lock: it is shared work, and a thread that waits for its
                // parts may come to ask for the same pieces.
                let made = self.pieces.get().is_none().then(|| Arc::new(pieces(mesh, &self.shape.bounds)));
                self.pieces.get_or_init(|| made.unwrap_or_default()).all()
            }
            ShapeKind::Scenery(_) => PiecesRef { shapes: &[], boxes: &[], is_skin: false },
        }
    }

    /// Of a mesh, convex pieces inside it; made when they are first asked for.
    pub fn inner_pieces(&self) -> &[InnerPiece] {
        let ShapeKind::Mesh(mesh) = &self.shape.kind else { return &[] };
        self.inner_pieces.get_or_init(|| inner_pieces(mesh, &self.shape.bounds).into())
    }

    /// Whether all pieces are made that there are.
    pub fn has_pieces(&self) -> bool {
        let is_mesh = matches!(self.shape.kind, ShapeKind::Mesh(_));
        !is_mesh || (self.pieces.get().is_some() && self.inner_pieces.get().is_some())
    }

    /// Makes those that are not.
    pub fn make_pieces(&self) {
        self.pieces();
        self.inner_pieces();
    }

    /// Takes the pieces of a mesh over from where they were made before; not where it has some.
    pub fn set_pieces(&self, pieces: Pieces) {
        self.pieces.get_or_init(|| Arc::new(pieces));
    }
}

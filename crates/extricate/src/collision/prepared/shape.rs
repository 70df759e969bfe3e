//! A shape with all that is derived from it: balls and convex pieces in it, and convex pieces
//! around it. No pairs.

use std::sync::{Arc, OnceLock};

use crate::collision::convex_decomposition::{Pieces, PiecesRef, SIZES, cell_pieces, fine_pieces, size_index};
use crate::collision::overlap::inner_pieces::{InnerPiece, inner_pieces};
use crate::collision::shapes::inner_spheres::InnerSpheres;
use crate::collision::shapes::mesh::MeshShape;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::robot::Geometry;

/// Cells, and for which sizes of bodies they are too coarse.
pub type Cells = (Pieces, [bool; SIZES]);

/// A shape prepared for checks against others: a tree of triangles, or a convex solid. Immutable,
/// shared between threads.
///
/// ```
/// use extricate::internals::collision::{PairScratch, PreparedShape};
/// use extricate::geometry::{Geometry, Pose};
/// let ball = PreparedShape::new(&Geometry::Sphere { radius: 1.0 }).unwrap();
/// let apart = Pose::at([2.5, 0.0, 0.0]);
/// assert!(!ball.is_nearer(&ball, &apart, 0.4, &mut PairScratch::default()));
/// assert!(ball.is_nearer(&ball, &apart, 0.6, &mut PairScratch::default()));
/// ```
pub struct PreparedShape {
    /// As exact checks take it.
    pub shape: Shape,
    /// Balls in it; none in scenery.
    pub inner: InnerSpheres,
    /// The least half extent of its box \[m\]; infinite for scenery, which is no one body.
    pub size: f64,
    /// The cells of a mesh, and for which sizes of bodies they are too coarse; made when they are
    /// first needed.
    cells: OnceLock<Arc<Cells>>,
    /// What is finer than the cells of a mesh, by the size of the body beside it.
    fine: [OnceLock<Arc<Pieces>>; SIZES],
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
        let (inner, size) = match &shape.kind {
            ShapeKind::Scenery(_) => (InnerSpheres::default(), f64::INFINITY),
            _ => (InnerSpheres::of(&shape), shape.bounds.half.min()),
        };
        Self { shape, inner, size, cells: OnceLock::new(), fine: Default::default(), inner_pieces: OnceLock::new() }
    }

    /// Convex shapes in the same frame whose union holds the shape: itself, or the cells of a mesh;
    /// none of scenery, which is requested its elements.
    pub fn cover(&self) -> PiecesRef<'_> {
        match &self.shape.kind {
            ShapeKind::Convex(_) => (&self.shape).into(),
            ShapeKind::Mesh(mesh) => self.cells(mesh).0.all(),
            ShapeKind::Scenery(_) => PiecesRef { shapes: &[], boxes: &[], first_apart: 0 },
        }
    }

    /// [`PreparedShape::cover`], unless it would first have to be made.
    pub fn known_cover(&self) -> Option<PiecesRef<'_>> {
        match &self.shape.kind {
            ShapeKind::Convex(_) => Some((&self.shape).into()),
            ShapeKind::Mesh(_) => self.cells.get().map(|cells| cells.0.all()),
            ShapeKind::Scenery(_) => None,
        }
    }

    /// Convex shapes in the same frame whose union holds the shape or its surface, and leaves open
    /// what the other one could enter.
    pub fn pieces_beside(&self, other: &Self) -> PiecesRef<'_> {
        let ShapeKind::Mesh(mesh) = &self.shape.kind else { return self.cover() };
        let cells = self.cells(mesh);
        match self.finer_beside(cells, other) {
            Some(index) => self.fine(mesh, index).all(),
            None => cells.0.all(),
        }
    }

    /// Whether [`PreparedShape::pieces_beside`] are other ones than the known cover.
    pub fn is_finer_beside(&self, other: &Self) -> bool {
        self.cells.get().is_some_and(|cells| self.finer_beside(cells, other).is_some())
    }

    /// Of which size pieces finer than the cells are needed.
    fn finer_beside(&self, cells: &Cells, other: &Self) -> Option<usize> {
        let index = size_index(self.shape.bounds.half.norm(), other.size);
        cells.1[index].then_some(index)
    }

    fn cells(&self, mesh: &MeshShape) -> &Cells {
        made_once(&self.cells, || cell_pieces(mesh, &self.shape.bounds))
    }

    fn fine(&self, mesh: &MeshShape, index: usize) -> &Pieces {
        made_once(&self.fine[index], || fine_pieces(mesh, &self.shape.bounds, index))
    }

    /// Of a mesh, convex pieces inside it; made when they are first asked for.
    pub fn inner_pieces(&self) -> &[InnerPiece] {
        let ShapeKind::Mesh(mesh) = &self.shape.kind else { return &[] };
        self.inner_pieces.get_or_init(|| inner_pieces(mesh, &self.shape.bounds).into())
    }

    /// Whether all pieces are made that it has by itself.
    pub fn has_cells(&self) -> bool {
        let is_mesh = matches!(self.shape.kind, ShapeKind::Mesh(_));
        !is_mesh || (self.cells.get().is_some() && self.inner_pieces.get().is_some())
    }

    /// Makes those that are not.
    pub fn make_cells(&self) {
        self.cover();
        self.inner_pieces();
    }

    /// Of which size finer pieces are needed beside `other` that are not made.
    pub fn missing_beside(&self, other: &Self) -> Option<usize> {
        self.finer_beside(self.cells.get()?, other).filter(|index| self.fine[*index].get().is_none())
    }

    /// Makes the pieces beside bodies of the size `index`.
    pub fn make_fine(&self, index: usize) {
        if let ShapeKind::Mesh(mesh) = &self.shape.kind {
            self.fine(mesh, index);
        }
    }

    /// The cells, and the finer pieces by the size of the body beside, as far as they are made.
    pub fn known_pieces(&self) -> (Option<&Cells>, [Option<&Pieces>; SIZES]) {
        let fine = self.fine.each_ref().map(|fine| fine.get().map(|pieces| &**pieces));
        (self.cells.get().map(|cells| &**cells), fine)
    }

    /// Takes the cells of a mesh over from where they were made before; not if it has some.
    pub fn set_cells(&self, cells: Pieces, is_coarse: [bool; SIZES]) {
        self.cells.get_or_init(|| Arc::new((cells, is_coarse)));
    }

    /// The same of what is finer, beside bodies of the size `index`.
    pub fn set_fine(&self, index: usize, pieces: Pieces) {
        self.fine[index].get_or_init(|| Arc::new(pieces));
    }
}

/// What is made outside of the lock: it is shared work, and a thread that waits for its parts may
/// come to ask for the same.
fn made_once<T>(place: &OnceLock<Arc<T>>, make: impl FnOnce() -> T) -> &T {
    if let Some(known) = place.get() {
        return known;
    }
    let made = Arc::new(make());
    place.get_or_init(|| made)
}

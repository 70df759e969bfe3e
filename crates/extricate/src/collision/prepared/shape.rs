//! A shape with all derived data: balls and convex pieces inside it, and convex pieces around it.
//! No pairs.

use std::sync::{Arc, OnceLock};

use crate::collision::convex_decomposition::{Pieces, PiecesRef, SIZES, cell_pieces, fine_pieces, size_index};
use crate::collision::overlap::inner_pieces::{InnerPiece, inner_pieces};
use crate::collision::shapes::inner_spheres::InnerSpheres;
use crate::collision::shapes::mesh::MeshShape;
use crate::collision::shapes::{Shape, ShapeKind};
use crate::robot::Geometry;

/// Cells of a mesh, and whether they are too coarse for each size of body.
pub type Cells = (Pieces, [bool; SIZES]);

/// A convex solid, a mesh or scenery, prepared for checks against others. Immutable, shared between
/// threads.
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
    /// The shape that exact checks use.
    pub shape: Shape,
    /// Balls inside the shape; scenery has none.
    pub inner: InnerSpheres,
    /// Least half extent of the bounding box \[m\]; infinite for scenery, which is more than one
    /// body.
    pub size: f64,
    /// Cells of a mesh, made on first use.
    cells: OnceLock<Arc<Cells>>,
    /// Finer pieces of a mesh for each size of the other body, made on first use.
    fine: [OnceLock<Arc<Pieces>>; SIZES],
    inner_pieces: OnceLock<Arc<[InnerPiece]>>,
}

impl PreparedShape {
    /// Prepares `geometry`; `None` for a mesh without triangles, and for an empty cloud or grid.
    ///
    /// # Cost
    /// For a mesh, about that of sorting its triangles a few times.
    pub fn new(geometry: &Geometry) -> Option<Self> {
        Some(Self::of(Shape::new(geometry)?))
    }

    /// Derives the other data from `shape`.
    pub(super) fn of(shape: Shape) -> Self {
        let (inner, size) = match &shape.kind {
            ShapeKind::Scenery(_) => (InnerSpheres::default(), f64::INFINITY),
            _ => (InnerSpheres::of(&shape), shape.bounds.half.min()),
        };
        Self { shape, inner, size, cells: OnceLock::new(), fine: Default::default(), inner_pieces: OnceLock::new() }
    }

    /// Convex shapes in the same frame, the union of which contains the shape: the shape itself, or
    /// the cells of a mesh. Scenery has none, since it offers its elements instead.
    pub fn cover(&self) -> PiecesRef<'_> {
        match &self.shape.kind {
            ShapeKind::Convex(_) => (&self.shape).into(),
            ShapeKind::Mesh(mesh) => self.cells(mesh).0.all(),
            ShapeKind::Scenery(_) => PiecesRef { shapes: &[], boxes: &[], first_apart: 0 },
        }
    }

    /// Same as [`PreparedShape::cover`], but `None` if the cells are not made yet.
    pub fn known_cover(&self) -> Option<PiecesRef<'_>> {
        match &self.shape.kind {
            ShapeKind::Convex(_) => Some((&self.shape).into()),
            ShapeKind::Mesh(_) => self.cells.get().map(|cells| cells.0.all()),
            ShapeKind::Scenery(_) => None,
        }
    }

    /// Convex shapes in the same frame, the union of which contains the shape or its surface.
    /// Hollows that the other body could enter stay open.
    pub fn pieces_beside(&self, other: &Self) -> PiecesRef<'_> {
        let ShapeKind::Mesh(mesh) = &self.shape.kind else { return self.cover() };
        let cells = self.cells(mesh);
        match self.finer_beside(cells, other) {
            Some(index) => self.fine(mesh, index).all(),
            None => cells.0.all(),
        }
    }

    /// Whether [`PreparedShape::pieces_beside`] differs from the known cover.
    pub fn is_finer_beside(&self, other: &Self) -> bool {
        self.cells.get().is_some_and(|cells| self.finer_beside(cells, other).is_some())
    }

    /// Index of the size for which pieces finer than the cells are needed.
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

    /// Convex pieces inside a mesh, made on first use; empty for other shapes.
    pub fn inner_pieces(&self) -> &[InnerPiece] {
        let ShapeKind::Mesh(mesh) = &self.shape.kind else { return &[] };
        self.inner_pieces.get_or_init(|| inner_pieces(mesh, &self.shape.bounds).into())
    }

    /// Whether the cells and the inner pieces of a mesh are made; `true` for other shapes.
    pub fn has_cells(&self) -> bool {
        let is_mesh = matches!(self.shape.kind, ShapeKind::Mesh(_));
        !is_mesh || (self.cells.get().is_some() && self.inner_pieces.get().is_some())
    }

    /// Makes the missing cells and inner pieces.
    pub fn make_cells(&self) {
        self.cover();
        self.inner_pieces();
    }

    /// Index of the size for which finer pieces are needed beside `other` and not made yet.
    pub fn missing_beside(&self, other: &Self) -> Option<usize> {
        self.finer_beside(self.cells.get()?, other).filter(|index| self.fine[*index].get().is_none())
    }

    /// Makes the finer pieces for bodies of the size `index`.
    pub fn make_fine(&self, index: usize) {
        if let ShapeKind::Mesh(mesh) = &self.shape.kind {
            self.fine(mesh, index);
        }
    }

    /// Returns the cells and, for each size, the finer pieces that are already made.
    pub fn known_pieces(&self) -> (Option<&Cells>, [Option<&Pieces>; SIZES]) {
        let fine = self.fine.each_ref().map(|fine| fine.get().map(|pieces| &**pieces));
        (self.cells.get().map(|cells| &**cells), fine)
    }

    /// Sets cells that were made earlier, unless the mesh already has some.
    pub fn set_cells(&self, cells: Pieces, is_coarse: [bool; SIZES]) {
        self.cells.get_or_init(|| Arc::new((cells, is_coarse)));
    }

    /// Sets finer pieces for the size `index`, unless the mesh already has some.
    pub fn set_fine(&self, index: usize, pieces: Pieces) {
        self.fine[index].get_or_init(|| Arc::new(pieces));
    }
}

/// Runs `make` outside of the lock. It is parallel work, and a thread that waits for it may request
/// the same value.
fn made_once<T>(place: &OnceLock<Arc<T>>, make: impl FnOnce() -> T) -> &T {
    if let Some(known) = place.get() {
        return known;
    }
    let made = Arc::new(make());
    place.get_or_init(|| made)
}

//! Signed distances to a shape, sampled on a grid once and interpolated afterwards: for proposals, never for decisions.

use rayon::prelude::*;

use super::shape::{Shape, ShapeKind};
use crate::math::Vec3;

/// How far around a shape the grid reaches \[m\]: a little more than the margin within which descents ask for contacts.
const AROUND: f64 = 0.06;
/// Nodes of a grid, roughly. A link of a third of a metre gets cells of 10 mm; twice as fine a grid finds contacts that are
/// nearer to the exact ones by less than the points of a surface are apart, and takes eight times as long to fill.
const NODES: f64 = 32_768.0;
/// Nodes farther from the surface than this many cells are interpolated.
const NEAR: f64 = 2.5;
/// Of a cell, in its edges.
const HALF_DIAGONAL: f64 = 0.867;

/// Signed distances to one shape, in its frame: negative in the solid, for surfaces never.
#[derive(Debug)]
pub struct Field {
    origin: Vec3,
    /// \[m\]
    cell: f64,
    counts: [usize; 3],
    /// \[m\], the first axis fastest.
    values: Vec<f32>,
}

impl Field {
    /// Fills the grid around `shape`, on all threads of the current pool.
    pub fn around(shape: &Shape) -> Self {
        let size = (shape.bounds.half + Vec3::repeat(AROUND)) * 2.0;
        // Thin shapes keep two cells across their thickness, as long as their length allows.
        let cell = (size.product() / NODES).cbrt().max(size.max() / NODES.sqrt());
        // Odd, so that every other node makes a grid of its own.
        let counts = [0, 1, 2].map(|axis| 2 * (0.5 * size[axis] / cell).ceil() as usize + 1);
        let origin = shape.bounds.center - Vec3::from_fn(|axis, _| 0.5 * cell * (counts[axis] - 1) as f64);
        let every_other =
            Self { origin, cell: 2.0 * cell, counts: counts.map(|count| count / 2 + 1), values: Vec::new() };
        let coarse =
            every_other.filled(|point, before, stack| signed_distance(shape, point, 2.0 * cell, before, stack));
        // Away from the surface interpolation between those is good enough.
        let all = Self { origin, cell, counts, values: Vec::new() };
        all.filled(|point, _, stack| {
            let guess = coarse.value(point);
            if guess.abs() > NEAR * cell { guess } else { -shape.depth(point, stack) }
        })
    }

    /// Values at all nodes: a function of the node, of the value at the node before in its row, and of a stack to use.
    fn filled(mut self, value: impl Fn(&Vec3, Option<f64>, &mut Vec<(f64, u32)>) -> f64 + Sync) -> Self {
        let (origin, cell, counts) = (self.origin, self.cell, self.counts);
        self.values = vec![0.0; counts.iter().product()];
        self.values.par_chunks_mut(counts[0]).enumerate().for_each_init(Vec::new, |stack, (row, values)| {
            let (y, z) = (row % counts[1], row / counts[1]);
            let mut before = None;
            for (x, entry) in values.iter_mut().enumerate() {
                let point = origin + Vec3::new(x as f64, y as f64, z as f64) * cell;
                let distance = value(&point, before, stack);
                (before, *entry) = (Some(distance), distance as f32);
            }
        });
        self
    }

    /// The value at the node nearest to a point, or as far less as the point may be nearer than the node: a lower bound, to
    /// what interpolation errs by.
    #[inline]
    pub fn at_least(&self, point: &Vec3) -> f64 {
        let mut node = [0; 3];
        let mut beyond = 0.0;
        for axis in 0..3 {
            let exact = (point[axis] - self.origin[axis]) / self.cell;
            let inside = exact.clamp(0.0, (self.counts[axis] - 1) as f64);
            node[axis] = (inside + 0.5) as usize;
            beyond += (exact - inside) * (exact - inside);
        }
        let [x, y, z] = node;
        let value = f64::from(self.values[(z * self.counts[1] + y) * self.counts[0] + x]);
        if beyond > 0.0 {
            // The nearest point of the shape is no nearer than the grid's rim.
            return beyond.sqrt() * self.cell;
        }
        value - HALF_DIAGONAL * self.cell
    }

    /// Between neighbouring nodes \[m\].
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Interpolated signed distance \[m\] at a point (frame of the shape); beyond the grid at most the distance to the grid more than
    /// at its rim.
    pub fn value(&self, point: &Vec3) -> f64 {
        let (corners, share, beyond) = self.corners(point);
        interpolate(&corners, &share) + beyond.norm()
    }

    /// The unit direction in which the distance grows fastest; `None` where it is lost, as in the middle of a solid.
    pub fn direction(&self, point: &Vec3) -> Option<Vec3> {
        let (corners, share, beyond) = self.corners(point);
        // Along each axis, the difference of the two faces that lie across it.
        let mut gradient = Vec3::from_fn(|axis, _| {
            let (mut low, mut high) = (share, share);
            (low[axis], high[axis]) = (0.0, 1.0);
            (interpolate(&corners, &high) - interpolate(&corners, &low)) / self.cell
        });
        gradient += beyond.try_normalize(1e-9).unwrap_or_default();
        gradient.try_normalize(0.2)
    }

    /// Values at the corners of the cell that holds `point`, where in the cell it is (0 to 1), and how far it is beyond the grid.
    fn corners(&self, point: &Vec3) -> ([f64; 8], [f64; 3], Vec3) {
        let (mut at, mut share, mut beyond) = ([0; 3], [0.0; 3], Vec3::zeros());
        for axis in 0..3 {
            let last = (self.counts[axis] - 1) as f64;
            let exact = (point[axis] - self.origin[axis]) / self.cell;
            let inside = exact.clamp(0.0, last);
            at[axis] = (inside as usize).min(self.counts[axis] - 2);
            share[axis] = inside - at[axis] as f64;
            beyond[axis] = (exact - inside) * self.cell;
        }
        let [nx, ny, _] = self.counts;
        let first = (at[2] * ny + at[1]) * nx + at[0];
        let offsets = [0, 1, nx, nx + 1, nx * ny, nx * ny + 1, nx * ny + nx, nx * ny + nx + 1];
        (offsets.map(|offset| f64::from(self.values[first + offset])), share, beyond)
    }
}

/// Trilinear.
fn interpolate(corners: &[f64; 8], [x, y, z]: &[f64; 3]) -> f64 {
    let along = |k: usize| corners[k] + x * (corners[k + 1] - corners[k]);
    let (low, high) = (along(0) + y * (along(2) - along(0)), along(4) + y * (along(6) - along(4)));
    low + z * (high - low)
}

/// Signed distance of a point, whose neighbour at distance `step` has the signed distance `before`.
fn signed_distance(shape: &Shape, point: &Vec3, step: f64, before: Option<f64>, stack: &mut Vec<(f64, u32)>) -> f64 {
    if let (ShapeKind::Mesh(mesh), Some(before)) = (&shape.kind, before.filter(|before| *before > 1.01 * step)) {
        // Still outside, and the nearest triangle is hardly farther than it was.
        let limit = (before + 1.01 * step).powi(2);
        if let Some(nearest) = mesh.tree.closest_point(mesh.tree.root, point, limit, 0.0, stack) {
            return nearest.squared.sqrt();
        }
    }
    -shape.depth(point, stack)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::test_mesh::{bumpy, cuboid, opened};
    use crate::robot::Geometry;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    #[test]
    fn distances_and_directions_are_those_of_the_shape_to_a_cell() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let shapes = [
            Geometry::Mesh(Arc::new(bumpy(7, 3, 0.3))),
            Geometry::Mesh(Arc::new(opened(bumpy(5, 2, 0.2), 30))),
            Geometry::ConvexHull(Arc::new(cuboid(Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.2, 0.5, 0.1)))),
        ];
        for geometry in shapes {
            let shape = Shape::new(&geometry).unwrap();
            let field = Field::around(&shape);
            let (mut stack, mut agreeing) = (Vec::new(), 0);
            for _ in 0..2000 {
                let unit = Vec3::from_fn(|_, _| 2.0 * rng.random::<f64>() - 1.0);
                let point = shape.bounds.center + unit.component_mul(&(shape.bounds.half + Vec3::repeat(0.05)));
                let exact = -shape.depth(&point, &mut stack);
                // Nodes that are interpolated themselves may be off by twice as much.
                let most = field.cell * if exact.abs() < 1.5 * field.cell { 1.0 } else { 2.0 };
                let off = (field.value(&point) - exact).abs();
                assert!(off < most, "{off} at a distance of {exact} with cells of {}", field.cell);
                let Some(direction) = field.direction(&point) else { continue };
                let there = -shape.depth(&(point + direction * 1e-3), &mut stack);
                agreeing += usize::from(there - exact > 0.7e-3);
            }
            assert!(agreeing > 1700, "{agreeing} of 2000 directions lead away");
            assert!(field.values.len() < 3 * NODES as usize);
            let far = shape.bounds.center + Vec3::new(5.0, 0.0, 0.0);
            let (exact, found) = (-shape.depth(&far, &mut stack), field.value(&far));
            assert!((exact - 1e-3..exact + 2.0).contains(&found), "{found} {exact}");
        }
    }
}

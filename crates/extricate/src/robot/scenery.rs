//! Surroundings as sensors and maps give them: voxels, points, half-spaces and height fields, each
//! one body. For obstacles only. Plain data; the structures that make checks fast are elsewhere.

use serde::{Deserialize, Serialize};

use super::{Geometry, TriangleMesh};
use crate::error::{Error, Result};
use crate::math::{FARTHEST, Vec3};

/// Largest number of cells, points or heights of one shape.
pub const MOST: usize = 1 << 26;

/// File name in messages about scenery that was not read from a file.
const SHAPE: &str = "shape";

/// Occupied cells of a regular grid, which are solid: cell `[i, j, k]` extends from `(i, j, k) *
/// size` to `(i + 1, j + 1, k + 1) * size`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Voxels {
    size: f64,
    cells: Vec<[i32; 3]>,
}

/// A ball around every point, all of one radius. With radius 0, distances are to the points
/// themselves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointCloud {
    radius: f64,
    points: Vec<Vec3>,
}

/// The solid below a grid of heights, unbounded downward.
///
/// Height `[i, j]` is at `x = i * size`, `y = j * size`. The surface consists of two triangles per
/// cell, which share the edge from `[i, j]` to `[i + 1, j + 1]`. There is nothing beyond the grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeightField {
    size: f64,
    columns: u32,
    heights: Vec<f64>,
}

fn check_size(file: &str, element: &str, size: f64) -> Result<()> {
    if size > 0.0 && size <= FARTHEST {
        return Ok(());
    }
    Err(Error::input(file, format!("{element}: size"), format!("got {size:?}, expected a side > 0 and within 1e9 [m]")))
}

fn check_count(file: &str, element: &str, count: usize) -> Result<()> {
    if count <= MOST {
        return Ok(());
    }
    Err(Error::input(file, element, format!("got {count} rows, expected at most {MOST}")))
}

fn check_cells(file: &str, element: &str, size: f64, cells: &[[i32; 3]]) -> Result<()> {
    check_size(file, element, size)?;
    check_count(file, element, cells.len())?;
    let is_far = |cell: &[i32; 3]| cell.iter().any(|i| (f64::from(*i).abs() + 1.0) * size > FARTHEST);
    if let Some(row) = cells.iter().position(is_far) {
        let problem = format!("got {:?} of cells of {size} m, expected one within 1e9 m", cells[row]);
        return Err(Error::input(file, format!("{element}: row {}", row + 1), problem));
    }
    Ok(())
}

impl Voxels {
    /// Makes voxels from cells in any order; repeated ones count once, and there may be none.
    ///
    /// # Errors
    /// [`Error::Input`] of `element` in `file`: a side \[m\] that is not positive, a cell beyond
    /// 1e9 m.
    pub fn new(file: &str, element: &str, size: f64, mut cells: Vec<[i32; 3]>) -> Result<Self> {
        check_cells(file, element, size, &cells)?;
        cells.sort_unstable();
        cells.dedup();
        Ok(Self { size, cells })
    }

    /// Checks deserialised voxels, which did not pass through [`Voxels::new`].
    fn check(&self) -> Result<()> {
        check_cells(SHAPE, "voxels", self.size, &self.cells)?;
        match self.cells.windows(2).position(|two| two[0] >= two[1]) {
            Some(row) => Err(Error::input(SHAPE, format!("voxels: row {}", row + 2), "expected ascending cells")),
            None => Ok(()),
        }
    }

    /// Side of a cell \[m\].
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The occupied cells in ascending order, each once.
    pub fn cells(&self) -> &[[i32; 3]] {
        &self.cells
    }

    /// Centre of a cell \[m\].
    #[doc(hidden)]
    pub fn center(&self, cell: &[i32; 3]) -> Vec3 {
        Vec3::from(cell.map(|i| (f64::from(i) + 0.5) * self.size))
    }
}

impl PointCloud {
    /// Makes a cloud, which may be empty.
    ///
    /// # Errors
    /// [`Error::Input`] of `element` in `file`: a radius \[m\] that is negative, a coordinate \[m\]
    /// that is not finite or beyond 1e9.
    pub fn new(file: &str, element: &str, radius: f64, points: &[[f64; 3]]) -> Result<Self> {
        let cloud = Self { radius, points: points.iter().copied().map(Vec3::from).collect() };
        cloud.check(file, element)?;
        Ok(cloud)
    }

    /// As [`PointCloud::new`], but leaves out points with a NaN coordinate, which sensors report
    /// for missing measurements. Also returns their number.
    ///
    /// # Errors
    /// As [`PointCloud::new`].
    pub fn seen(file: &str, element: &str, radius: f64, points: &[[f64; 3]]) -> Result<(Self, usize)> {
        let is_lost = |point: &[f64; 3]| point.iter().any(|x| x.is_nan());
        let lost = points.iter().filter(|point| is_lost(point)).count();
        // The origin replaces lost points, so that messages have the right row numbers.
        let seen: Vec<[f64; 3]> = points.iter().map(|point| if is_lost(point) { [0.0; 3] } else { *point }).collect();
        let mut cloud = Self::new(file, element, radius, &seen)?;
        if lost > 0 {
            cloud.points = points.iter().filter(|point| !is_lost(point)).copied().map(Vec3::from).collect();
        }
        Ok((cloud, lost))
    }

    fn check(&self, file: &str, element: &str) -> Result<()> {
        let Self { radius, points } = self;
        if !(0.0..=FARTHEST).contains(radius) {
            let problem = format!("got {radius:?}, expected 0 to 1e9 [m]");
            return Err(Error::input(file, format!("{element}: radius"), problem));
        }
        check_count(file, element, points.len())?;
        if let Some(row) = points.iter().position(|p| !p.iter().all(|x| x.abs() <= FARTHEST)) {
            let p = points[row];
            let problem = format!("got ({}, {}, {}), expected finite coordinates [m] within 1e9", p.x, p.y, p.z);
            return Err(Error::input(file, format!("{element}: row {}", row + 1), problem));
        }
        Ok(())
    }

    /// Radius of the balls \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The points \[m\] in the given order.
    #[doc(hidden)]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }
}

fn check_field(file: &str, element: &str, size: f64, columns: usize, heights: &[f64]) -> Result<()> {
    check_size(file, element, size)?;
    check_count(file, element, heights.len())?;
    let rows = heights.len().checked_div(columns).unwrap_or(0);
    if rows < 2 || columns < 2 || rows * columns != heights.len() {
        let found = format!("got {} heights in rows of {columns}", heights.len());
        return Err(Error::input(file, element, format!("{found}, expected two full rows and columns at least")));
    }
    if let Some(at) = heights.iter().position(|h| !(-FARTHEST..=FARTHEST).contains(h)) {
        let (row, column) = (at / columns + 1, at % columns + 1);
        let problem = format!("column {column}: got {:?}, expected a finite height [m] within 1e9", heights[at]);
        return Err(Error::input(file, format!("{element}: row {row}"), problem));
    }
    if rows.max(columns) as f64 * size > FARTHEST {
        let problem = format!("got {rows} x {columns} cells of {size} m, expected a grid within 1e9 m");
        return Err(Error::input(file, element, problem));
    }
    Ok(())
}

impl HeightField {
    /// Makes a field from `heights` \[m\] row by row, `columns` to a row, with cells of side `size`
    /// \[m\].
    ///
    /// # Errors
    /// [`Error::Input`] of `element` in `file`: fewer than two rows or columns, rows of different
    /// lengths, heights that are not finite or beyond 1e9, a side that is not positive.
    pub fn new(file: &str, element: &str, size: f64, columns: usize, heights: Vec<f64>) -> Result<Self> {
        check_field(file, element, size, columns, &heights)?;
        Ok(Self { size, columns: columns as u32, heights })
    }

    /// Side of a cell \[m\].
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Number of rows (along x) and of columns (along y).
    pub fn shape(&self) -> [usize; 2] {
        let columns = (self.columns as usize).max(1);
        [self.heights.len() / columns, columns]
    }

    /// Point of the surface at a row and column of the grid \[m\].
    #[doc(hidden)]
    pub fn vertex(&self, i: usize, j: usize) -> Vec3 {
        Vec3::new(i as f64 * self.size, j as f64 * self.size, self.heights[i * self.shape()[1] + j])
    }

    /// One of the two triangles of a cell, counter-clockwise seen from above.
    #[doc(hidden)]
    pub fn triangle(&self, i: usize, j: usize, second: bool) -> [Vec3; 3] {
        let (near, far) = (self.vertex(i, j), self.vertex(i + 1, j + 1));
        if second { [near, far, self.vertex(i, j + 1)] } else { [near, self.vertex(i + 1, j), far] }
    }

    /// All heights \[m\], row by row.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }
}

impl Geometry {
    /// Makes the solid `n . x <= offset` \[m\], with `n` the unit vector along `normal`.
    ///
    /// # Errors
    /// [`Error::Input`] of `element` in `file`: a normal without direction, numbers that are not
    /// finite or beyond 1e9.
    pub fn half_space(file: &str, element: &str, normal: [f64; 3], offset: f64) -> Result<Self> {
        let fault = |problem| Err(Error::input(file, element, problem));
        if !normal.iter().all(|x| x.abs() <= FARTHEST) || !(-FARTHEST..=FARTHEST).contains(&offset) {
            return fault(format!("got {normal:?} and the offset {offset:?}, expected finite numbers within 1e9"));
        }
        match Vec3::from(normal).try_normalize(1e-9) {
            Some(unit) => Ok(Self::HalfSpace { normal: unit.into(), offset }),
            None => fault(format!("got the normal {normal:?}, expected one that points somewhere")),
        }
    }

    /// Checks that deserialised scenery could come from its constructors; accepts all other shapes.
    ///
    /// # Errors
    /// [`Error::Input`] that names the row.
    pub(super) fn check_scenery(&self) -> Result<()> {
        match self {
            Self::Voxels(voxels) => voxels.check(),
            Self::Points(cloud) => cloud.check(SHAPE, "points"),
            Self::HeightField(field) => {
                check_field(SHAPE, "height-field", field.size, field.columns as usize, &field.heights)
            }
            Self::HalfSpace { normal, offset } => {
                Self::half_space(SHAPE, "half-space", *normal, *offset)?;
                let length = Vec3::from(*normal).norm();
                if (length - 1.0).abs() > 1e-9 {
                    let problem = format!("got a normal of length {length}, expected length 1");
                    return Err(Error::input(SHAPE, "half-space", problem));
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Whether only obstacles can have the shape: it does not move and may be unbounded.
    pub fn is_scenery(&self) -> bool {
        matches!(self, Self::Voxels(_) | Self::Points(_) | Self::HalfSpace { .. } | Self::HeightField(_))
    }

    /// Distance \[m\] of the farthest point of scenery from the origin of its frame. For a
    /// half-space it is the distance of the plane; for a height field, that of the surface's
    /// farthest point.
    pub fn scenery_radius(&self) -> f64 {
        let farthest = |points: &mut dyn Iterator<Item = Vec3>| points.map(|p| p.norm()).fold(0.0, f64::max);
        match self {
            Self::Points(cloud) => cloud.radius + farthest(&mut cloud.points.iter().copied()),
            Self::Voxels(voxels) => {
                farthest(&mut voxels.cells.iter().map(|cell| voxels.center(cell).abs().add_scalar(0.5 * voxels.size)))
            }
            Self::HalfSpace { offset, .. } => offset.abs(),
            Self::HeightField(field) => {
                let [rows, columns] = field.shape();
                farthest(&mut (0..rows * columns).map(|at| field.vertex(at / columns, at % columns)))
            }
            _ => 0.0,
        }
    }

    /// Triangulates scenery for pictures: cubes, coarse balls, a surface, a square of 10 m on a
    /// plane.
    pub(crate) fn scenery_triangles(&self, segments: usize) -> TriangleMesh {
        let copies = |shape: Self, places: &mut dyn Iterator<Item = Vec3>| {
            let one = shape.tessellate(segments);
            let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
            for place in places {
                let first = vertices.len() as u32;
                vertices.extend(one.vertices.iter().map(|v| v + place));
                triangles.extend(one.triangles.iter().map(|t| t.map(|v| v + first)));
            }
            TriangleMesh::new(vertices, triangles)
        };
        match self {
            Self::Points(cloud) => copies(Self::Sphere { radius: cloud.radius }, &mut cloud.points.iter().copied()),
            Self::Voxels(voxels) => {
                let cube = Self::Box { half_extents: [0.5 * voxels.size; 3] };
                copies(cube, &mut voxels.cells.iter().map(|cell| voxels.center(cell)))
            }
            Self::HalfSpace { normal, offset } => {
                let normal = Vec3::from(*normal);
                let across = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize() * 5.0;
                let (foot, other) = (normal * *offset, normal.cross(&across));
                let corner = |x: f64, y: f64| foot + across * x + other * y;
                let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])
            }
            Self::HeightField(field) => {
                let [rows, columns] = field.shape();
                let vertices = (0..rows * columns).map(|at| field.vertex(at / columns, at % columns)).collect();
                let number = |i: usize, j: usize| (i * columns + j) as u32;
                let cell = |at: usize| {
                    let (i, j) = (at / (columns - 1), at % (columns - 1));
                    let (near, far) = (number(i, j), number(i + 1, j + 1));
                    [[near, number(i + 1, j), far], [near, far, number(i, j + 1)]]
                };
                TriangleMesh::new(vertices, (0..(rows - 1) * (columns - 1)).flat_map(cell).collect())
            }
            _ => TriangleMesh::new(Vec::new(), Vec::new()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn cells_are_sorted_and_counted_once() {
        let voxels = Voxels::new("s", "v", 0.5, vec![[1, 0, 0], [-1, 2, 3], [1, 0, 0]]).unwrap();
        assert_eq!(voxels.cells(), [[-1, 2, 3], [1, 0, 0]]);
        assert_eq!(voxels.center(&[-1, 2, 3]), Vec3::new(-0.25, 1.25, 1.75));
    }

    #[test]
    fn what_a_sensor_did_not_see_is_left_out_and_counted() {
        let nan = f64::NAN;
        let points = [[0.0; 3], [nan; 3], [1.0, 0.0, 0.0], [0.0, nan, 1.0]];
        let (cloud, lost) = PointCloud::seen("s", "p", 0.1, &points).unwrap();
        assert_eq!((cloud.points(), lost), (&[Vec3::zeros(), Vec3::x()][..], 2));
        let far = [&points[..], &[[0.0, f64::INFINITY, 0.0]]].concat();
        let message = PointCloud::seen("s", "p", 0.1, &far).unwrap_err().to_string();
        assert!(message.contains("p: row 5: got (0, inf, 0)"), "{message}");
    }

    #[test]
    fn faults_name_row_value_and_expectation() {
        let told = |error: Error| error.to_string();
        let cells = Voxels::new("s", "voxels", 0.5, vec![[0, 0, 0], [0, i32::MAX, 0]]).map(|_| ());
        assert_eq!(
            told(cells.unwrap_err()),
            "s: voxels: row 2: got [0, 2147483647, 0] of cells of 0.5 m, expected one within 1e9 m"
        );
        assert!(told(Voxels::new("s", "v", -1.0, Vec::new()).unwrap_err()).contains("v: size: got -1.0"));
        let points = PointCloud::new("s", "points", 0.1, &[[0.0; 3], [0.0, f64::NAN, 1.0]]);
        assert!(told(points.unwrap_err()).contains("points: row 2: got (0, NaN, 1), expected finite coordinates"));
        assert!(told(PointCloud::new("s", "p", f64::NAN, &[]).unwrap_err()).contains("p: radius: got NaN"));
        let field = |columns, heights: &[f64]| HeightField::new("s", "f", 0.1, columns, heights.to_vec());
        assert!(told(field(2, &[0.0; 5]).unwrap_err()).contains("got 5 heights in rows of 2, expected two full rows"));
        assert!(told(field(0, &[]).unwrap_err()).contains("got 0 heights"));
        let infinite = field(2, &[0.0, 0.0, 0.0, f64::INFINITY]).unwrap_err();
        assert!(told(infinite).contains("f: row 2: column 2: got inf"));
        let flat = Geometry::half_space("s", "h", [0.0; 3], 1.0).unwrap_err();
        assert!(told(flat).contains("h: got the normal [0.0, 0.0, 0.0], expected one that points somewhere"));
    }

    /// Models and pickled scenes store variants as numbers, so new ones may only be added at the
    /// end.
    #[test]
    fn bytes_of_older_shapes_stay_what_they_were() {
        let first = |geometry: &Geometry| postcard::to_stdvec(geometry).unwrap()[0];
        let mesh = Arc::new(TriangleMesh::new(vec![Vec3::zeros(), Vec3::x(), Vec3::y()], vec![[0, 1, 2]]));
        let field = HeightField::new("s", "f", 1.0, 2, vec![0.0; 4]).unwrap();
        let all = [
            Geometry::Sphere { radius: 1.0 },
            Geometry::Box { half_extents: [1.0, 0.0, 0.0] },
            Geometry::Cylinder { radius: 1.0, half_length: 1.0 },
            Geometry::Capsule { radius: 1.0, half_length: 1.0 },
            Geometry::Mesh(mesh.clone()),
            Geometry::ConvexHull(mesh),
            Geometry::Voxels(Arc::new(Voxels::new("s", "v", 1.0, vec![[1, 2, 3]]).unwrap())),
            Geometry::Points(Arc::new(PointCloud::new("s", "p", 0.0, &[[0.0, 1.0, 0.0]]).unwrap())),
            Geometry::half_space("s", "h", [0.0, 0.0, 2.0], 1.0).unwrap(),
            Geometry::HeightField(Arc::new(field)),
        ];
        assert_eq!(all.each_ref().map(first), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        for geometry in &all {
            let bytes = postcard::to_stdvec(geometry).unwrap();
            assert_eq!(&postcard::from_bytes::<Geometry>(&bytes).unwrap(), geometry);
        }
    }

    #[test]
    fn triangles_follow_the_surface() {
        let field = HeightField::new("s", "f", 0.5, 3, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_eq!(field.shape(), [2, 3]);
        assert_eq!(field.vertex(1, 2), Vec3::new(0.5, 1.0, 5.0));
        for second in [false, true] {
            let [a, b, c] = field.triangle(0, 1, second);
            assert!((b - a).cross(&(c - a)).z > 0.0, "counter-clockwise from above");
        }
        let mesh = Geometry::HeightField(Arc::new(field)).tessellate(8);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (6, 4));
        let plane = Geometry::half_space("s", "h", [0.0, 1.0, 1.0], 2.0).unwrap().tessellate(8);
        let normal = Vec3::new(0.0, 1.0, 1.0).normalize();
        assert!(plane.vertices.iter().all(|v| (normal.dot(v) - 2.0).abs() < 1e-12));
        let cubes = Geometry::Voxels(Arc::new(Voxels::new("s", "v", 1.0, vec![[0; 3], [5; 3]]).unwrap()));
        assert_eq!(cubes.tessellate(8).vertices.len(), 16);
        assert_eq!(cubes.scenery_radius(), Vec3::repeat(6.0).norm());
    }
}

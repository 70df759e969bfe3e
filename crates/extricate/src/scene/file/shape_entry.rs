//! `shape = { .. }` of an entry, and the shapes that lists or files of numbers describe.

use std::sync::Arc;

use serde::Deserialize;

use super::arrays::exactly_if_any;
use super::{GeometryKind, ObstacleEntry, ScaleEntry};
use crate::error::{Error, Result};
use crate::robot::formats::rows::for_each_row;
use crate::robot::{Geometry, HeightField, LoadLimits, PointCloud, TriangleMesh, Voxels, formats};
use crate::scene::Part;

/// `shape = { .. }`: exactly one of the shapes.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename_all = "kebab-case",
    expecting = "a table with one of box, sphere, cylinder, capsule, mesh, urdf, voxels, points, half-space, height-field"
)]
pub struct ShapeEntry {
    /// Full sides of a box \[m\].
    #[serde(rename = "box", default, deserialize_with = "exactly_if_any")]
    pub cuboid: Option<[f64; 3]>,
    /// Radius of a sphere \[m\].
    pub sphere: Option<f64>,
    /// Radius and length of a cylinder \[m\].
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub cylinder: Option<[f64; 2]>,
    /// Radius of a capsule, and length of its cylindrical part \[m\].
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub capsule: Option<[f64; 2]>,
    /// Path of a mesh file.
    pub mesh: Option<String>,
    /// A mesh in place of a path, for scenes that are not written as files.
    #[serde(skip)]
    pub triangles: Option<Arc<TriangleMesh>>,
    /// Scale of the mesh; 1 if absent.
    pub scale: Option<ScaleEntry>,
    /// Whether the mesh is replaced by its convex hull.
    #[serde(default)]
    pub convex: bool,
    /// Whether the mesh is replaced by several convex hulls that cover it.
    #[serde(default)]
    pub convex_parts: bool,
    /// Path of a URDF whose joints are all fixed.
    pub urdf: Option<String>,
    /// Folders where `package://` in the URDF is looked up first.
    #[serde(default)]
    pub packages: Vec<String>,
    /// Kind of shapes of the URDF, and treatment of their meshes.
    pub geometry: Option<GeometryKind>,
    /// Shapes of the URDF once it is read.
    #[serde(skip)]
    pub parts: Option<Vec<Part>>,
    /// Indices i, j, k of occupied cells.
    pub voxels: Option<RowsEntry>,
    /// Points x, y, z of a cloud \[m\].
    pub points: Option<RowsEntry>,
    /// Outward normal of a half-space, of any length.
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub half_space: Option<[f64; 3]>,
    /// Heights of a field, row by row \[m\].
    pub height_field: Option<RowsEntry>,
    /// Side of a cell of voxels or of a height field \[m\].
    pub size: Option<f64>,
    /// Radius of the ball around each point \[m\]; 0 if absent.
    pub radius: Option<f64>,
    /// Offset of a half-space's plane along its unit normal \[m\]; 0 if absent.
    pub offset: Option<f64>,
    /// Voxels, points, half-space or height field as geometry, once it is read or for scenes that
    /// are not written as files.
    #[serde(skip)]
    pub scenery: Option<Geometry>,
    /// Number of points that were left out because a coordinate is NaN.
    #[serde(skip)]
    pub left_out: usize,
}

/// Kinds of shapes for large worlds, which only obstacles may have.
pub const SCENERY: [&str; 4] = ["voxels", "points", "half-space", "height-field"];

/// Rows of numbers, or the path of a text file that holds them.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected rows of numbers or the path of a text file")]
pub enum RowsEntry {
    /// Path of a text file.
    File(String),
    /// Rows written in the scene file.
    Rows(Vec<Vec<f64>>),
}

/// Reads a file. The arguments are the element that names it, for messages, and the path in the
/// scene file; the results are the file's name, for messages, and its bytes.
pub type LoadRows<'a> = &'a mut dyn FnMut(&str, &str) -> Result<(String, Vec<u8>)>;

impl ShapeEntry {
    /// Returns the names of all shapes that are given.
    pub fn kinds(&self) -> Vec<&'static str> {
        let kind = |name: &str| match &self.scenery {
            Some(Geometry::Voxels(_)) => name == "voxels",
            Some(Geometry::Points(_)) => name == "points",
            Some(Geometry::HalfSpace { .. }) => name == "half-space",
            Some(Geometry::HeightField(_)) => name == "height-field",
            _ => false,
        };
        let given = [
            ("box", self.cuboid.is_some()),
            ("sphere", self.sphere.is_some()),
            ("cylinder", self.cylinder.is_some()),
            ("capsule", self.capsule.is_some()),
            ("mesh", self.mesh.is_some() || self.triangles.is_some()),
            ("urdf", self.urdf.is_some()),
            ("voxels", self.voxels.is_some() || kind("voxels")),
            ("points", self.points.is_some() || kind("points")),
            ("half-space", self.half_space.is_some() || kind("half-space")),
            ("height-field", self.height_field.is_some() || kind("height-field")),
        ];
        given.into_iter().filter_map(|(name, given)| given.then_some(name)).collect()
    }

    /// Yields the keys of numbers that are given, and the shapes that each belongs to.
    fn numbers(&self) -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
        let all: [(&str, &[&str], Option<f64>); 3] = [
            ("size", &["voxels", "height-field"], self.size),
            ("radius", &["points"], self.radius),
            ("offset", &["half-space"], self.offset),
        ];
        all.into_iter().filter(|(_, _, given)| given.is_some()).map(|(name, owners, _)| (name, owners))
    }

    /// Refuses keys that belong to another shape than `kind`.
    ///
    /// # Errors
    /// [`Error::Input`] that names the key and its shapes.
    pub fn check_numbers(&self, file: &str, element: &str, kind: &str) -> Result<()> {
        let of_urdf = self.geometry.is_some() || !self.packages.is_empty();
        if kind != "urdf" && of_urdf {
            let problem = format!("shape: `packages` and `geometry` belong to a urdf, got them with a {kind}");
            return Err(Error::input(file, element, problem));
        }
        match self.numbers().find(|(_, owners)| !owners.contains(&kind)) {
            Some((name, owners)) => {
                let owners = owners.join(" and ");
                let problem = format!("shape: `{name}` belongs to {owners}, got it with a {kind}");
                Err(Error::input(file, element, problem))
            }
            None => Ok(()),
        }
    }
}

/// Reads lists and files of numbers into [`ShapeEntry::scenery`], for entries that have no other
/// shape.
///
/// # Errors
/// [`Error::Input`] that names file, obstacle, row, value and what was expected; errors of `load`.
pub fn with_scenery(
    file: &str,
    entries: &[ObstacleEntry],
    limits: &LoadLimits,
    load: LoadRows,
) -> Result<Vec<ObstacleEntry>> {
    let mut all = entries.to_vec();
    for entry in &mut all {
        let element = format!("obstacle \"{}\"", entry.name);
        if let [kind] = entry.shape.kinds()[..]
            && entry.shape.scenery.is_none()
        {
            if let Some(rows) = &entry.shape.points {
                let (cloud, left_out) = cloud(file, &format!("{element}: points"), rows, &entry.shape, limits, load)?;
                (entry.shape.scenery, entry.shape.left_out) = (Some(Geometry::Points(Arc::new(cloud))), left_out);
            } else {
                entry.shape.scenery = scenery(file, &element, kind, &entry.shape, load)?;
            }
        }
    }
    Ok(all)
}

/// Reads the points of an entry; also returns how many were left out.
fn cloud(
    file: &str,
    element: &str,
    rows: &RowsEntry,
    entry: &ShapeEntry,
    limits: &LoadLimits,
    load: LoadRows,
) -> Result<(PointCloud, usize)> {
    let (name, points): (_, Vec<[f64; 3]>) = match rows {
        RowsEntry::Rows(_) => {
            let table = table_of(file, element, rows, load)?;
            let points = table.triples(element, "three coordinates x, y, z [m]")?;
            (file.to_string(), points.map(|(_, point)| point).collect())
        }
        RowsEntry::File(path) => {
            let (name, bytes) = load(element, path)?;
            let points = formats::cloud::parse(&name, element, &bytes, limits)?;
            (name, points.into_iter().map(<[f64; 3]>::from).collect())
        }
    };
    PointCloud::seen(&name, element, entry.radius.unwrap_or(0.0), &points)
}

/// Reads voxels, a half-space or a height field; returns `None` for a shape of another kind.
fn scenery(file: &str, element: &str, kind: &str, entry: &ShapeEntry, load: LoadRows) -> Result<Option<Geometry>> {
    let element = &format!("{element}: {kind}");
    let size = || {
        let missing =
            || Error::input(file, element, format!("no `size`, expected it beside {kind}: the side of a cell [m]"));
        entry.size.ok_or_else(missing)
    };
    if let Some(normal) = entry.half_space {
        return Geometry::half_space(file, element, normal, entry.offset.unwrap_or(0.0)).map(Some);
    }
    if let Some(rows) = &entry.voxels {
        let table = table_of(file, element, rows, load)?;
        let cells = table.triples(element, "three indices i, j, k")?;
        let cells = cells.map(|(row, cell)| index(&table, element, row, cell)).collect::<Result<_>>()?;
        return Ok(Some(Geometry::Voxels(Arc::new(Voxels::new(&table.file, element, size()?, cells)?))));
    }
    if let Some(rows) = &entry.height_field {
        let table = table_of(file, element, rows, load)?;
        let columns = table.rows.first().map_or(0, |(_, first)| first.len());
        if let Some((row, found)) = table.rows.iter().find(|(_, row)| row.len() != columns) {
            let problem = format!("got {} heights, expected {columns} as in the first row", found.len());
            return Err(table.fault(element, *row, problem));
        }
        let heights = table.rows.iter().flat_map(|(_, row)| row.iter().copied()).collect();
        let field = HeightField::new(&table.file, element, size()?, columns, heights)?;
        return Ok(Some(Geometry::HeightField(Arc::new(field))));
    }
    Ok(None)
}

/// Converts three numbers to the indices of a cell; they must be whole.
fn index(table: &Table, element: &str, row: usize, cell: [f64; 3]) -> Result<[i32; 3]> {
    let most = f64::from(i32::MAX);
    match cell.into_iter().find(|x| x.fract() != 0.0 || !(-most..=most).contains(x)) {
        Some(bad) => Err(table.fault(element, row, format!("got {bad:?}, expected whole numbers i, j, k"))),
        None => Ok(cell.map(|x| x as i32)),
    }
}

/// Rows of numbers with the places that messages name.
struct Table {
    file: String,
    /// Word for a row in messages.
    word: &'static str,
    /// Number of each row or line, from 1, and the row.
    rows: Vec<(usize, Vec<f64>)>,
}

impl Table {
    fn fault(&self, element: &str, row: usize, problem: String) -> Error {
        Error::input(&self.file, format!("{element}: {} {row}", self.word), problem)
    }

    /// Yields number and contents of all rows; fails unless each has three numbers.
    fn triples(&self, element: &str, expected: &str) -> Result<impl Iterator<Item = (usize, [f64; 3])> + '_> {
        if let Some((row, found)) = self.rows.iter().find(|(_, row)| row.len() != 3) {
            let problem = format!("got {} numbers, expected {expected}", found.len());
            return Err(self.fault(element, *row, problem));
        }
        Ok(self.rows.iter().map(|(number, row)| (*number, [row[0], row[1], row[2]])))
    }
}

fn table_of(file: &str, element: &str, entry: &RowsEntry, load: LoadRows) -> Result<Table> {
    match entry {
        RowsEntry::Rows(rows) => {
            let rows = rows.iter().enumerate().map(|(k, row)| (k + 1, row.clone())).collect();
            Ok(Table { file: file.to_string(), word: "row", rows })
        }
        RowsEntry::File(path) => {
            let (file, bytes) = load(element, path)?;
            let mut rows = Vec::new();
            for_each_row(
                &file,
                element,
                &bytes,
                |_, x| x.is_finite(),
                |line, row| {
                    rows.push((line, row.to_vec()));
                    Ok(())
                },
            )?;
            Ok(Table { file, word: "line", rows })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::scene::assemble::obstacles::others;
    use crate::scene::file;

    const CLOUD: &str = "x y z\n# metres\n0 0.5 1\n\n1,2, 3 # last\n-1;0;2e-1\n";

    fn told(shape: &str) -> Result<(Geometry, Vec<String>)> {
        let text = format!("[[obstacle]]\nname = 'a'\nshape = {shape}");
        let scene = file::parse("s.toml", &text)?;
        let mut load = |_: &str, path: &str| match path {
            "cloud.xyz" => Ok(("f/cloud.xyz".to_string(), CLOUD.as_bytes().to_vec())),
            "lost.txt" => {
                Ok(("f/lost.txt".to_string(), b"\xef\xbb\xbf0 1 2 9\nnan nan nan nan\n0 nan 2 9\n3 4 5 9".to_vec()))
            }
            "heights.csv" => Ok(("f/heights.csv".to_string(), b"0,1,2\n3,4,5\n".to_vec())),
            text => Ok(("f/text".to_string(), text.as_bytes().to_vec())),
        };
        let entries = with_scenery("s.toml", &scene.obstacle, &LoadLimits::default(), &mut load)?;
        let mut warnings = Vec::new();
        let bodies = others("s.toml", (&entries, &[]), &mut |_, _, _| panic!("no mesh"), &scene, &mut warnings)?;
        Ok((bodies.obstacles[0].parts[0].geometry.clone(), warnings))
    }

    fn one(shape: &str) -> Result<Geometry> {
        told(shape).map(|(geometry, _)| geometry)
    }

    #[test]
    fn points_that_are_no_numbers_are_left_out_and_counted() {
        for shape in ["{ points = 'lost.txt' }", "{ points = [[0, 1, 2], [nan, nan, nan], [0, nan, 2], [3, 4, 5]] }"] {
            let (Geometry::Points(cloud), warnings) = told(shape).unwrap() else { panic!() };
            assert_eq!(cloud.points(), [Vec3::new(0.0, 1.0, 2.0), Vec3::new(3.0, 4.0, 5.0)]);
            assert_eq!(warnings, ["obstacle `a`: 2 of 4 points are left out: they have coordinates that are NaN"]);
        }
    }

    #[test]
    fn lists_and_files_are_read() {
        let Geometry::Points(cloud) = one("{ points = 'cloud.xyz', radius = 0.1 }").unwrap() else { panic!() };
        assert_eq!(cloud.points(), [[0.0, 0.5, 1.0], [1.0, 2.0, 3.0], [-1.0, 0.0, 0.2]].map(Vec3::from));
        assert_eq!(cloud.radius(), 0.1);
        assert_eq!(
            one("{ points = [[0, 0.5, 1], [1, 2, 3], [-1, 0, 0.2]], radius = 0.1 }").unwrap(),
            Geometry::Points(cloud)
        );
        let Geometry::Voxels(voxels) = one("{ voxels = [[1, 2, -3]], size = 0.5 }").unwrap() else { panic!() };
        assert_eq!((voxels.cells(), voxels.size()), (&[[1, 2, -3]][..], 0.5));
        let Geometry::HeightField(field) = one("{ height-field = 'heights.csv', size = 2 }").unwrap() else { panic!() };
        assert_eq!((field.shape(), field.heights()), ([2, 3], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0][..]));
        let half = Geometry::HalfSpace { normal: [0.0, 0.0, 1.0], offset: -1.0 };
        assert_eq!(one("{ half-space = [0, 0, 4], offset = -1 }").unwrap(), half);
        assert!(matches!(one("{ points = [] }"), Ok(Geometry::Points(cloud)) if cloud.points().is_empty()));
    }

    #[test]
    fn faults_name_file_obstacle_row_value_and_expectation() {
        for (shape, expected) in [
            (
                r#"{ points = "0 1" }"#,
                "f/text: obstacle \"a\": points: line 1: got 2 numbers, expected three coordinates",
            ),
            (
                r#"{ points = "0 1 2\n0 x 1" }"#,
                "f/text: obstacle \"a\": points: line 2: got `x`, expected finite numbers",
            ),
            (r#"{ points = "0 1 inf" }"#, "line 1: got `inf`"),
            (r#"{ voxels = "0 1 nan", size = 1 }"#, "line 1: got `nan`"),
            (r#"{ height-field = "0 1 nan", size = 1 }"#, "line 1: got `nan`"),
            ("{ points = [[0, 1, 2], [0, 1]] }", "s.toml: obstacle \"a\": points: row 2: got 2 numbers"),
            ("{ points = [[0, 1, 2e9]] }", "points: row 1: got (0, 1, 2000000000), expected finite coordinates"),
            ("{ points = 3 }", "expected rows of numbers or the path of a text file"),
            ("{ points = [[0, 1, 2]], radius = -1 }", "points: radius: got -1.0, expected 0 to 1e9"),
            ("{ voxels = [[0, 0, 0.5]], size = 1 }", "voxels: row 1: got 0.5, expected whole numbers"),
            ("{ voxels = [[0, 0, 0]] }", "no `size`, expected it beside voxels"),
            ("{ voxels = [[0, 0, 0]], size = 0 }", "voxels: size: got 0.0"),
            ("{ height-field = [[0, 1], [0]], size = 1 }", "height-field: row 2: got 1 heights, expected 2"),
            ("{ height-field = [[0, 1]], size = 1 }", "expected two full rows and columns"),
            ("{ half-space = [0, 0] }", "got an array of 2, expected one of 3"),
            ("{ half-space = [0, 0, 0] }", "expected one that points somewhere"),
            (
                "{ half-space = [0, 0, 1], size = 1 }",
                "`size` belongs to voxels and height-field, got it with a half-space",
            ),
            ("{ sphere = 1, offset = 1 }", "`offset` belongs to half-space, got it with a sphere"),
            ("{ points = [], box = [1, 1, 1] }", "got box and points, expected exactly one of box"),
        ] {
            let message = one(shape).unwrap_err().to_string();
            assert!(message.contains(expected), "{shape}: {message}");
        }
    }
}

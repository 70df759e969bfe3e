//! Files of points: PLY, PCD, and text with one point per line. Measurements that a sensor misses
//! stay NaN.

#[cfg(feature = "meshes")]
use super::ply;
use super::rows::for_each_row;
use super::{pcd, without_mark};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::robot::{LoadLimit, LoadLimits};

/// Parses points \[m\] by the extension of `file` (its name in messages), in any case: `ply` or
/// `pcd`, otherwise text. Messages about text use `element`.
///
/// # Errors
/// [`Error::Input`] for a file that is not what its extension says or that is cut short, rows of
/// fewer than three numbers or of different lengths, and more points than are allowed.
pub fn parse(file: &str, element: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Vec<Vec3>> {
    limits.check(LoadLimit::FileBytes, bytes.len(), file, "file")?;
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase();
    match extension.as_str() {
        #[cfg(feature = "meshes")]
        "ply" => ply::points(file, without_mark(bytes), limits),
        #[cfg(not(feature = "meshes"))]
        "ply" => Err(Error::input(file, "file", super::WITHOUT_MESHES)),
        "pcd" => pcd::points(file, without_mark(bytes), limits),
        _ => text(file, element, bytes, limits),
    }
}

/// Reads points from the first three columns, and ignores others, such as colours.
fn text(file: &str, element: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Vec<Vec3>> {
    let (mut points, mut columns) = (Vec::new(), None);
    let accepts = |column: usize, x: f64| column > 2 || !x.is_infinite();
    for_each_row(file, element, bytes, accepts, |line, row| {
        let columns = *columns.get_or_insert(row.len());
        let fault = |problem: String| Err(Error::input(file, format!("{element}: line {line}"), problem));
        if row.len() < 3 {
            return fault(format!("got {} numbers, expected three coordinates x, y, z [m]", row.len()));
        }
        if row.len() != columns {
            return fault(format!("got {} numbers, expected {columns} as in the first row", row.len()));
        }
        limits.check(LoadLimit::Vertices, points.len() + 1, file, element)?;
        points.push(Vec3::new(row[0], row[1], row[2]));
        Ok(())
    })?;
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec3>> {
        parse("c.xyz", "points", text.as_bytes(), &LoadLimits::default())
    }

    #[test]
    fn further_columns_are_left_out() {
        let two = [Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0)];
        for same in ["0 0 0\n1 2 3\n", "\u{feff}0 0 0 255 0 0\n1 2 3 0 9 inf\n", "x,y,z,rgb\n0,0,0,nan\n1,2,3,4e9"] {
            assert_eq!(read(same).unwrap(), two, "{same}");
        }
        let lost = read("0 0 0\nnan NaN -nan\n1 2 3").unwrap();
        assert!(lost.len() == 3 && lost[1].iter().all(|x| x.is_nan()));
        let message = |text: &str| read(text).unwrap_err().to_string();
        assert_eq!(message("0 0 0 1\n0 0 0"), "c.xyz: points: line 2: got 3 numbers, expected 4 as in the first row");
        assert!(message("0 0").contains("line 1: got 2 numbers, expected three coordinates"));
        assert!(message("0 inf 0").contains("line 1: got `inf`, expected finite numbers"));
        assert!(message("0 0 0 red").contains("line 1: got `red`"));
    }

    #[test]
    fn points_are_counted() {
        let limits = LoadLimits::default().with(LoadLimit::Vertices, 2);
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            end_header\n0 0 0\n1 0 0\n2 0 0\n";
        let pcd =
            "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 3\nHEIGHT 1\nDATA ascii\n0 0 0\n1 0 0\n2 0 0\n";
        for (file, text) in [("a.ply", ply), ("a.pcd", pcd), ("a.txt", "0 0 0\n1 0 0\n2 0 0")] {
            assert_eq!(parse(file, "points", text.as_bytes(), &LoadLimits::default()).unwrap().len(), 3);
            let message = parse(file, "points", text.as_bytes(), &limits).unwrap_err().to_string();
            assert!(message.contains("got 3 corners, points or cells or more, expected at most 2"), "{message}");
        }
    }
}

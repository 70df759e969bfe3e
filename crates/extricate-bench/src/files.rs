//! Files that all sides of the benchmark share: meshes as OFF text, poses and configurations as
//! numbers.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use extricate::geometry::{Pose, TriangleMesh};
use extricate::internals::math::{Mat3, Vec3};
use extricate::internals::robot::formats;

/// Reads STL, OBJ, COLLADA, or OFF with triangles only.
pub fn read_mesh(path: &str) -> Result<TriangleMesh> {
    let bytes = std::fs::read(path).with_context(|| path.to_string())?;
    if !path.ends_with(".off") {
        return Ok(formats::parse(path, &bytes)?);
    }
    let text = String::from_utf8(bytes)?;
    let mut words = text.split_ascii_whitespace();
    ensure!(words.next() == Some("OFF"), "{path}: expected a file that begins with OFF");
    let mut number = || -> Result<f64> { Ok(words.next().context("the file ends early")?.parse()?) };
    let (vertices, triangles, _edges) = (number()? as usize, number()? as usize, number()?);
    let points = (0..vertices).map(|_| Ok(Vec3::new(number()?, number()?, number()?))).collect::<Result<_>>()?;
    let mut faces = Vec::with_capacity(triangles);
    for _ in 0..triangles {
        ensure!(number()? == 3.0, "{path}: expected triangles only");
        let face = [number()?, number()?, number()?];
        ensure!(face.iter().all(|v| (0.0..vertices as f64).contains(v)), "{path}: got a triangle without its vertex");
        faces.push(face.map(|v| v as u32));
    }
    Ok(TriangleMesh::new(points, faces))
}

/// Writes OFF, from which every coordinate is read back unchanged.
pub fn write_off(mesh: &TriangleMesh, path: &str) -> Result<()> {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    for v in &mesh.vertices {
        writeln!(text, "{} {} {}", v.x, v.y, v.z)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "3 {a} {b} {c}")?;
    }
    std::fs::write(path, text).with_context(|| path.to_string())
}

/// Binary STL, which robot files can name.
pub fn stl(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        bytes.extend(mesh.corners(t).iter().flat_map(|v| v.iter().flat_map(|x| (*x as f32).to_le_bytes())));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Reads little-endian f64.
pub fn read_numbers(path: &str) -> Result<Vec<f64>> {
    let bytes = std::fs::read(Path::new(path)).with_context(|| path.to_string())?;
    ensure!(bytes.len() % 8 == 0, "{path}: got {} bytes, expected a multiple of 8", bytes.len());
    Ok(bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight"))).collect())
}

/// Writes little-endian f64.
pub fn write_numbers(numbers: &[f64], path: &str) -> Result<()> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(path, bytes).with_context(|| path.to_string())
}

/// Twelve numbers per pose: the rotation row by row, then the translation \[m\].
pub fn pose_numbers(poses: &[Pose]) -> Vec<f64> {
    poses
        .iter()
        .flat_map(|p| p.rotation.transpose().iter().chain(p.translation.iter()).copied().collect::<Vec<_>>())
        .collect()
}

/// The inverse of [`pose_numbers`].
pub fn poses_of(numbers: &[f64]) -> Vec<Pose> {
    let pose = |n: &[f64]| Pose { rotation: Mat3::from_row_slice(&n[..9]), translation: Vec3::new(n[9], n[10], n[11]) };
    numbers.chunks_exact(12).map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::meshes;

    #[test]
    fn what_is_written_is_read() {
        let folder = std::env::temp_dir().join(format!("extricate-bench-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = |name: &str| folder.join(name).to_str().unwrap().to_string();
        let mesh = meshes::bumpy(2, 0.3);
        write_off(&mesh, &path("m.off")).unwrap();
        let read = read_mesh(&path("m.off")).unwrap();
        assert_eq!(read.triangles.len(), 128);
        // Reading may renumber vertices.
        assert!((0..128).all(|t| read.corners(t) == mesh.corners(t)));
        std::fs::write(path("m.stl"), stl(&mesh)).unwrap();
        assert_eq!(read_mesh(&path("m.stl")).unwrap().triangles.len(), mesh.triangles.len());
        let pose = Pose::from_xyz_rpy([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]);
        write_numbers(&pose_numbers(&[pose, pose]), &path("p.bin")).unwrap();
        assert_eq!(poses_of(&read_numbers(&path("p.bin")).unwrap()), [pose, pose]);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

//! Targets for files of meshes and of points, in every format. A scene must accept what is read.

use std::sync::Arc;

use extricate::geometry::{Body, Geometry, PointCloud, Pose};
use extricate::internals::robot::formats::{cloud, parse_among};
use extricate::{Error, Scene, builtin};

use crate::texts::{limits, use_any};

/// Triangles of a mesh that is checked against a robot; larger ones are only read.
const MAX_CHECKED_TRIANGLES: usize = 2_000;

/// Reads and uses an STL file.
pub fn stl(bytes: &[u8]) {
    mesh("a.stl", bytes);
}

/// Reads and uses a Wavefront OBJ file.
pub fn obj(bytes: &[u8]) {
    mesh("a.obj", bytes);
}

/// Reads and uses a COLLADA file.
pub fn dae(bytes: &[u8]) {
    mesh("a.dae", bytes);
}

/// Reads and uses a PLY file.
pub fn ply(bytes: &[u8]) {
    mesh("a.ply", bytes);
}

/// Reads and uses a glTF file, binary or text.
pub fn glb(bytes: &[u8]) {
    mesh("a.glb", bytes);
}

/// Reads and uses points as PLY, as PCD and as text.
pub fn cloud(bytes: &[u8]) {
    for file in ["a.ply", "a.pcd", "a.xyz"] {
        let seen = cloud::parse(file, "points", bytes, &limits())
            .map(|points| points.into_iter().map(<[f64; 3]>::from).collect::<Vec<_>>())
            .and_then(|points| PointCloud::seen(file, "points", 0.01, &points));
        let points = match seen {
            Ok((points, _)) => points,
            Err(error) => {
                use_any(Err(error));
                continue;
            }
        };
        assert!(points.points().iter().all(|point| point.iter().all(|x| x.abs() <= 1e9)), "a point too far away");
        let scene: Scene = builtin::scene("planar-arm").expect("a built-in scene");
        let body = Body::obstacle("fuzzed", Geometry::Points(Arc::new(points)), Pose::identity());
        use_any(scene.with_obstacles([body]));
    }
}

fn mesh(name: &str, bytes: &[u8]) {
    let mut beside = |uri: &str| match uri {
        "b.bin" => Ok(vec![0; 200]),
        _ => Err(Error::Read { path: uri.into(), source: std::io::ErrorKind::NotFound.into() }),
    };
    let mut warnings = Vec::new();
    let mesh = match parse_among(name, bytes, &limits(), &mut beside, &mut warnings) {
        Ok(mesh) => mesh,
        Err(error) => return use_any(Err(error)),
    };
    let corners = mesh.triangles.as_flattened();
    assert!(corners.iter().all(|&corner| (corner as usize) < mesh.vertices.len()), "a corner without a vertex");
    assert!(mesh.vertices.iter().all(|vertex| vertex.iter().all(|x| x.abs() <= 1e9)), "a vertex too far away");
    let parts: usize = mesh.components.iter().map(|component| component.triangles.len()).sum();
    assert_eq!(parts, mesh.triangles.len(), "triangles in no component, or in several");
    if mesh.triangles.len() <= MAX_CHECKED_TRIANGLES {
        let scene: Scene = builtin::scene("planar-arm").expect("a built-in scene");
        let body = Body::obstacle("fuzzed", Geometry::Mesh(Arc::new(mesh)), Pose::identity());
        use_any(scene.with_obstacles([body]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    #[test]
    fn seeds_are_read() {
        let kinds = [
            ("a.stl", seeds::stl()),
            ("a.obj", seeds::obj()),
            ("a.dae", seeds::dae()),
            ("a.ply", seeds::ply()),
            ("a.glb", seeds::glb()),
        ];
        for (file, seeds) in kinds {
            for (name, bytes) in seeds {
                let mut beside = |_: &str| Ok((0..60).collect());
                let read = parse_among(file, &bytes, &limits(), &mut beside, &mut Vec::new());
                // The buffer that the last glTF names holds arbitrary bytes.
                let is_other = file == "a.glb" && name == "seed-1";
                assert!(read.is_ok() || is_other, "{file} {name}: {}", read.err().unwrap());
            }
        }
        for (name, bytes) in seeds::cloud() {
            let is_read = |file: &&str| cloud::parse(file, "points", &bytes, &limits()).is_ok();
            assert!(["a.ply", "a.pcd", "a.xyz"].iter().any(is_read), "{name}");
        }
    }
}

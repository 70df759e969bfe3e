//! Synthetic meshes: for the growth curves, and awkward ones for the test of exactness.

use extricate::geometry::TriangleMesh;
use extricate::internals::math::Vec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A closed ball of radius about 1 with a few smooth bumps: `8 * 4^level` triangles, and the same
/// shape at every level.
pub fn bumpy(level: u32, phase: f64) -> TriangleMesh {
    let mut vertices: Vec<Vec3> = [1.0, -1.0].iter().flat_map(|s| (0..3).map(move |k| Vec3::ith(k, *s))).collect();
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 1, 2], [4, 0, 2], [1, 0, 5], [3, 1, 2], [0, 4, 5], [1, 3, 5], [3, 4, 2], [4, 3, 5]];
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        faces = faces.iter().flat_map(|t| quarters(t, &mut vertices, &mut middles)).collect();
    }
    for v in &mut vertices {
        let wave = |k: usize, f: f64| (f * v[k] + phase * (k as f64 + 1.0)).sin();
        *v *= 1.0 + 0.12 * wave(0, 5.0) * wave(1, 6.0) + 0.08 * wave(2, 7.0) * wave(0, 4.0);
    }
    TriangleMesh::new(vertices, faces)
}

type Middles = std::collections::BTreeMap<[u32; 2], u32>;

fn quarters(&[a, b, c]: &[u32; 3], vertices: &mut Vec<Vec3>, middles: &mut Middles) -> [[u32; 3]; 4] {
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
            vertices.len() as u32 - 1
        })
    };
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
}

/// A torus about z: `2 * around * across` triangles.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> TriangleMesh {
    let turn = |k: u32, n: u32| std::f64::consts::TAU * f64::from(k) / f64::from(n);
    let mut vertices = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (s, t) = (turn(i, around), turn(j, across));
            let r = major + minor * t.cos();
            vertices.push(Vec3::new(r * s.cos(), r * s.sin(), minor * t.sin()));
        }
    }
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let mut faces = Vec::new();
    for i in 0..around {
        for j in 0..across {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriangleMesh::new(vertices, faces)
}

/// An open, flat sheet of `2 n^2` triangles and side 1 about the origin, in the plane z = 0.
pub fn sheet(n: u32) -> TriangleMesh {
    let side = n + 1;
    let vertices = (0..side * side)
        .map(|k| Vec3::new(f64::from(k % side) / f64::from(n) - 0.5, f64::from(k / side) / f64::from(n) - 0.5, 0.0));
    let faces = (0..n * n).flat_map(|k| {
        let at = k / n * side + k % n;
        [[at, at + 1, at + side + 1], [at, at + side + 1, at + side]]
    });
    TriangleMesh::new(vertices.collect(), faces.collect())
}

/// A closed box whose faces are grids of `n x n` squares: coplanar triangles, thin along an axis
/// with a small half side.
pub fn slab(half: Vec3, n: u32) -> TriangleMesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let start = vertices.len() as u32;
            for v in &sheet(n).vertices {
                let mut p = Vec3::zeros();
                p[axis] = sign * half[axis];
                p[(axis + 1) % 3] = 2.0 * v.x * half[(axis + 1) % 3];
                p[(axis + 2) % 3] = 2.0 * v.y * half[(axis + 2) % 3];
                vertices.push(p);
            }
            let turned = |t: &[u32; 3]| if sign > 0.0 { *t } else { [t[0], t[2], t[1]] };
            faces.extend(sheet(n).triangles.iter().map(|t| turned(t).map(|v| v + start)));
        }
    }
    TriangleMesh::new(vertices, faces)
}

/// Loose triangles: ordinary ones, needles, and slivers as thin as a thousandth of a micrometre.
pub fn soup(count: usize, rng: &mut ChaCha8Rng) -> TriangleMesh {
    let mut vertices = Vec::new();
    for k in 0..count {
        let mut point = |s: f64| Vec3::from_fn(|_, _| s * (rng.random::<f64>() - 0.5));
        let (middle, u, v) = (point(1.6), point(1.0), point(1.0));
        let thin = [1.0, 1e-3, 1e-6, 1e-9][k % 4];
        vertices.extend([middle, middle + u, middle + u * 0.4 + v * thin]);
    }
    let faces = (0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriangleMesh::new(vertices, faces)
}

/// Joins all triangles of several meshes into one.
pub fn joined(meshes: &[TriangleMesh]) -> TriangleMesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let start = vertices.len() as u32;
        vertices.extend_from_slice(&mesh.vertices);
        faces.extend(mesh.triangles.iter().map(|t| t.map(|v| v + start)));
    }
    TriangleMesh::new(vertices, faces)
}

/// A solid with a cavity of the shape of `inner`, which has to lie inside `outer`.
pub fn hollow(outer: &TriangleMesh, mut inner: TriangleMesh) -> TriangleMesh {
    inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    joined(&[outer.clone(), inner])
}

/// The mesh without its last `count` triangles.
pub fn opened(mesh: &TriangleMesh, count: usize) -> TriangleMesh {
    TriangleMesh::new(mesh.vertices.clone(), mesh.triangles[..mesh.triangles.len() - count].to_vec())
}

pub fn single() -> TriangleMesh {
    TriangleMesh::new(
        vec![Vec3::new(-0.4, -0.3, 0.0), Vec3::new(0.5, -0.2, 0.1), Vec3::new(0.0, 0.5, -0.1)],
        vec![[0, 1, 2]],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn meshes_are_what_they_say() {
        assert_eq!(bumpy(3, 0.5).triangles.len(), 512);
        assert!(bumpy(3, 0.5).is_closed() && torus(0.18, 0.06, 24, 12).is_closed());
        assert_eq!(torus(0.18, 0.06, 24, 12).triangles.len(), 576);
        assert!(slab(Vec3::new(1.0, 0.5, 1e-4), 3).is_closed());
        assert_eq!(slab(Vec3::new(1.0, 0.5, 1e-4), 3).triangles.len(), 108);
        assert!(!sheet(4).is_closed());
        assert_eq!(soup(40, &mut ChaCha8Rng::seed_from_u64(1)).triangles.len(), 40);
        let shell = hollow(&bumpy(2, 0.0), bumpy(2, 0.0).scaled([0.5; 3]));
        assert!(!shell.is_cavity(0) && shell.is_cavity(1));
        assert_eq!(joined(&[single(), bumpy(1, 0.0)]).components.len(), 2);
    }
}

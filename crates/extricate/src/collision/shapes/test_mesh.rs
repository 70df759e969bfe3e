//! Meshes for tests.

use crate::math::Vec3;
use crate::robot::TriangleMesh;
use crate::robot::mesh::Component;

/// A ball of radius about 1 with random bumps: an octahedron, subdivided `level` times (8 x 4^level
/// faces).
pub fn bumpy(seed: u64, level: u32, bumps: f64) -> TriangleMesh {
    let mut vertices: Vec<Vec3> = [1.0, -1.0].iter().flat_map(|s| (0..3).map(move |k| Vec3::ith(k, *s))).collect();
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 1, 2], [4, 0, 2], [1, 0, 5], [3, 1, 2], [0, 4, 5], [1, 3, 5], [3, 4, 2], [4, 3, 5]];
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let mut middle = |a: u32, b: u32| {
                    *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                        vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                        vertices.len() as u32 - 1
                    })
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let mut rng: rand_chacha::ChaCha8Rng = rand::SeedableRng::seed_from_u64(seed);
    vertices.iter_mut().for_each(|v| *v *= 1.0 + bumps * (rand::RngExt::random::<f64>(&mut rng) - 0.5));
    TriangleMesh::new(vertices, triangles)
}

/// A closed box with half sides `half`.
pub fn cuboid(center: Vec3, half: Vec3) -> TriangleMesh {
    let corner = |k: u32| Vec3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] }) + center;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), triangles)
}

/// Opens a mesh by removing its last `count` triangles.
pub fn opened(mut mesh: TriangleMesh, count: usize) -> TriangleMesh {
    mesh.triangles.truncate(mesh.triangles.len() - count);
    mesh.components = vec![Component { triangles: 0..mesh.triangles.len(), closed: false }];
    mesh
}

/// Joins all components of `meshes` into one mesh.
pub fn joined(meshes: &[TriangleMesh]) -> TriangleMesh {
    let mut all = TriangleMesh { vertices: vec![], triangles: vec![], components: vec![] };
    for mesh in meshes {
        let (vertices, triangles) = (all.vertices.len() as u32, all.triangles.len());
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + vertices)));
        all.components.extend(mesh.components.iter().map(|c| Component {
            triangles: c.triangles.start + triangles..c.triangles.end + triangles,
            closed: c.closed,
        }));
    }
    all
}

/// Scales a mesh, then moves it.
pub fn placed(mut mesh: TriangleMesh, scale: f64, shift: Vec3) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v = *v * scale + shift);
    mesh
}

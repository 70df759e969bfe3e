//! Meshes whose solids touch along edges, such as a frame of bars: where four triangles share an
//! edge, nothing says which two belong together, so such solids are one component, and may face
//! other ways. Labels do not mind; cuts along faces do.

use std::collections::HashMap;

use crate::robot::TriangleMesh;

/// Solids of one mesh that are cut each on its own; more stay together.
const MOST_ALONE: usize = 48;

/// The solids that only touch others, each on its own, and what is left of the mesh, if anything
/// is. A mesh with cavities stays whole.
pub fn parted(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    let (mut alone, mut left) = (Vec::new(), Vec::new());
    for component in &mesh.components {
        let own = component.triangles.clone();
        let patches = if component.closed { patches(mesh, own.clone()) } else { Vec::new() };
        if patches.len() > 1 && patches.iter().all(|patch| is_closed(mesh, patch)) {
            alone.extend(patches);
        } else {
            left.extend(own);
        }
    }
    let has_cavities = (0..mesh.components.len()).any(|component| mesh.is_cavity(component));
    if alone.is_empty() || alone.len() > MOST_ALONE || has_cavities {
        return vec![mesh.clone()];
    }
    alone.push(left);
    let made = alone.into_iter().filter(|triangles| !triangles.is_empty());
    made.map(|triangles| {
        let triangles = triangles.iter().map(|&t| mesh.triangles[t]).collect();
        TriangleMesh::new(mesh.vertices.clone(), triangles)
    })
    .collect()
}

fn edges(mesh: &TriangleMesh, t: usize) -> [[u32; 2]; 3] {
    let [a, b, c] = mesh.triangles[t];
    [[a, b], [b, c], [c, a]]
}

fn key([from, to]: [u32; 2]) -> [u32; 2] {
    [from.min(to), from.max(to)]
}

/// Triangles that are joined by edges of two.
fn patches(mesh: &TriangleMesh, triangles: std::ops::Range<usize>) -> Vec<Vec<usize>> {
    let mut at_edge: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for t in triangles.clone() {
        edges(mesh, t).into_iter().for_each(|edge| at_edge.entry(key(edge)).or_default().push(t));
    }
    let mut is_done = vec![false; triangles.len()];
    let mut found = Vec::new();
    for first in triangles.clone() {
        let (mut patch, mut stack) = (Vec::new(), vec![first]);
        while let Some(t) = stack.pop() {
            if std::mem::replace(&mut is_done[t - triangles.start], true) {
                continue;
            }
            patch.push(t);
            let beside = edges(mesh, t).map(|edge| &at_edge[&key(edge)]);
            stack.extend(beside.iter().filter(|beside| beside.len() == 2).copied().flatten());
        }
        if !patch.is_empty() {
            found.push(patch);
        }
    }
    found
}

/// Whether as many triangles run along every edge either way.
fn is_closed(mesh: &TriangleMesh, patch: &[usize]) -> bool {
    let mut ways: HashMap<[u32; 2], i32> = HashMap::new();
    for edge in patch.iter().flat_map(|&t| edges(mesh, t)) {
        *ways.entry(key(edge)).or_default() += if edge[0] < edge[1] { 1 } else { -1 };
    }
    ways.values().all(|sum| *sum == 0)
}

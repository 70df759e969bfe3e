//! Turns the triangles of a closed component so that all normals point out of the solid.

use crate::math::Vec3;
use crate::robot::mesh::edges::{same_edge, sorted_sides};

/// The component's triangles, wound so that normals point outward.
///
/// Neighbours across an edge are made to run along it in opposite directions; then the sign of the
/// enclosed volume decides. Where no consistent winding exists (a self-touching or one-sided
/// surface) the result is as near to one as the walk got.
pub fn outward(triangles: &[[u32; 3]], vertices: &[Vec3]) -> Vec<[u32; 3]> {
    let mut result = triangles.to_vec();
    let sides = sorted_sides(triangles);
    let mut ring_of = vec![0; sides.len()];
    let mut first = 0;
    for ring in sides.chunk_by(same_edge) {
        ring.iter().for_each(|side| ring_of[3 * side.triangle as usize + usize::from(side.edge)] = first);
        first += ring.len();
    }
    let mut seen = vec![false; triangles.len()];
    let mut stack = Vec::new();
    for start in 0..triangles.len() {
        // Sheets that share only a vertex are turned each by its own volume.
        if seen[start] {
            continue;
        }
        seen[start] = true;
        stack.push(start);
        let mut sheet = vec![start];
        while let Some(k) = stack.pop() {
            for ring in &ring_of[3 * k..3 * k + 3] {
                let edge = &sides[*ring];
                let (a, b) = runs_along(&result[k], edge.low, edge.high);
                for side in sides[*ring..].iter().take_while(|side| same_edge(side, edge)) {
                    let other = side.triangle as usize;
                    if !seen[other] {
                        seen[other] = true;
                        if edges(&result[other]).contains(&(a, b)) {
                            result[other].swap(1, 2);
                        }
                        stack.push(other);
                        sheet.push(other);
                    }
                }
            }
        }
        let origin = vertices[result[start][0] as usize];
        let six_volumes = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| vertices[v as usize] - origin);
            a.dot(&b.cross(&c))
        };
        if sheet.iter().map(|&k| six_volumes(&result[k])).sum::<f64>() < 0.0 {
            sheet.iter().for_each(|&k| result[k].swap(1, 2));
        }
    }
    result
}

/// The ends of one of its edges, in the direction of a triangle's winding.
fn runs_along(t: &[u32; 3], low: u32, high: u32) -> (u32, u32) {
    if edges(t).contains(&(low, high)) { (low, high) } else { (high, low) }
}

fn edges(t: &[u32; 3]) -> [(u32, u32); 3] {
    [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::test_mesh::bumpy;

    #[test]
    fn shuffled_windings_are_mended() {
        let mesh = bumpy(1, 3, 0.2);
        for flip in [1, 2, 3] {
            let mut triangles = mesh.triangles.clone();
            triangles.iter_mut().step_by(flip).for_each(|t| t.swap(0, 1));
            for t in outward(&triangles, &mesh.vertices) {
                let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
                assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) > 0.0);
            }
        }
    }
}

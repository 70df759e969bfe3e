//! Two trees of triangles: whether they come near, and how near. Solids and what they hold are another file's matter.

use super::bounds::Relative;
use super::bvh::{Bvh, Node};
use super::triangle;

/// Some pair of triangles that cross or are nearer than `limit` \[m\]; `relative` maps the second mesh to the first.
pub fn nearer(a: &Bvh, b: &Bvh, relative: &Relative, limit: f64, stack: &mut Vec<(u32, u32)>) -> Option<(u32, u32)> {
    stack.clear();
    stack.push((0, 0));
    while let Some((i, j)) = stack.pop() {
        let (node_a, node_b) = (&a.nodes[i as usize], &b.nodes[j as usize]);
        if relative.apart(&node_a.bounds, &node_b.bounds, limit) {
            continue;
        }
        if node_a.count > 0 && node_b.count > 0 {
            for k in b.leaf(node_b) {
                let moved = b.triangles[k].moved(&relative.pose_a_b);
                if moved.is_apart(&node_a.bounds, limit) {
                    continue;
                }
                if let Some(found) = a.leaf(node_a).find(|&i| triangle::nearer(&a.triangles[i], &moved, limit)) {
                    return Some((found as u32, k as u32));
                }
            }
        } else if opens_first(node_a, node_b) {
            stack.extend([(node_a.first, j), (node_a.first + 1, j)]);
        } else {
            stack.extend([(i, node_b.first), (i, node_b.first + 1)]);
        }
    }
    None
}

/// Distance \[m\] of the nearest pair of triangles, if below `cutoff`; 0 where triangles cross, for a cutoff of 0 too.
pub fn closest(a: &Bvh, b: &Bvh, relative: &Relative, cutoff: f64, stack: &mut Vec<(f64, u32, u32)>) -> Option<f64> {
    let mut best = None;
    let mut limit = cutoff;
    let bound = |i: u32, j: u32| (relative.lower_bound(&a.nodes[i as usize].bounds, &b.nodes[j as usize].bounds), i, j);
    stack.clear();
    stack.push(bound(0, 0));
    while let Some((at_least, i, j)) = stack.pop() {
        let (node_a, node_b) = (&a.nodes[i as usize], &b.nodes[j as usize]);
        if at_least >= limit {
            continue;
        }
        if node_a.count > 0 && node_b.count > 0 {
            for k in b.leaf(node_b) {
                let moved = b.triangles[k].moved(&relative.pose_a_b);
                if moved.is_apart(&node_a.bounds, limit) {
                    continue;
                }
                for i in a.leaf(node_a) {
                    if let Some(witness) = triangle::closest(&a.triangles[i], &moved, limit * limit) {
                        limit = witness.squared.sqrt();
                        best = Some(limit);
                        if limit == 0.0 {
                            return best;
                        }
                    }
                }
            }
        } else {
            let (near, far) = if opens_first(node_a, node_b) {
                (bound(node_a.first, j), bound(node_a.first + 1, j))
            } else {
                (bound(i, node_b.first), bound(i, node_b.first + 1))
            };
            stack.extend(if near.0 <= far.0 { [far, near] } else { [near, far] });
        }
    }
    best
}

/// Whether of two nodes, not both leaves, the first is to be opened: the larger one, so that both shrink alike.
pub fn opens_first(a: &Node, b: &Node) -> bool {
    b.count > 0 || (a.count == 0 && a.bounds.half.norm_squared() > b.bounds.half.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::mesh_shape::MeshShape;
    use crate::collision::test_mesh::{bumpy, joined, opened, placed};
    use crate::math::{Pose, Vec3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Slow twin: all pairs of triangles.
    fn scan(a: &Bvh, b: &Bvh, pose: &Pose) -> f64 {
        let squared = |t: &triangle::Triangle| {
            let moved = t.moved(pose);
            a.triangles.iter().filter_map(|s| triangle::closest(s, &moved, 1e9).map(|w| w.squared)).fold(1e9, f64::min)
        };
        b.triangles.iter().map(squared).fold(1e9, f64::min).sqrt()
    }

    #[test]
    fn trees_equal_all_pairs_also_next_to_contact() {
        let mut rng = ChaCha8Rng::seed_from_u64(10);
        let meshes = [
            bumpy(1, 2, 0.5),
            opened(bumpy(2, 2, 0.9), 40),
            joined(&[placed(bumpy(3, 1, 0.3), 0.3, Vec3::x()), placed(bumpy(4, 1, 0.3), 0.4, Vec3::z())]),
        ];
        let shapes = meshes.map(|m| MeshShape::new(&m).tree);
        let (mut stack, mut bounded) = (Vec::new(), Vec::new());
        let mut near_contact = 0;
        for round in 0..400 {
            let (a, b) = (&shapes[round % 3], &shapes[round / 3 % 3]);
            let mut vector = |s: f64| Vec3::from_fn(|_, _| s * (rng.random::<f64>() - 0.5));
            let (turn, direction) = (vector(6.0), vector(1.0).normalize());
            let at = |x: f64| Relative::new(Pose::from_xyz_rpy((direction * x).into(), turn.into()));
            let (mut inner, mut outer) = (0.0, 4.0);
            let limit = [1e-4, 0.05][round % 2];
            // Bisection toward the boundary, checking the answers on the way; the last ones are within 1e-9 of it.
            for step in 0..32 {
                let x = if step == 0 { 1.0 } else { 0.5 * (inner + outer) };
                let relative = at(x);
                let hit = nearer(a, b, &relative, limit, &mut stack).is_some();
                let distance = closest(a, b, &relative, 9.0, &mut bounded).unwrap();
                assert_eq!(hit, distance < limit, "{round} {step} {distance}");
                assert_eq!(closest(a, b, &relative, limit, &mut bounded).is_some(), hit);
                if step % 8 == 7 || step == 0 {
                    assert!((scan(a, b, &relative.pose_a_b) - distance).abs() < 1e-12);
                }
                near_contact += usize::from((distance - limit).abs() < 1e-7);
                *(if hit { &mut inner } else { &mut outer }) = x;
            }
        }
        assert!(near_contact > 1000, "{near_contact}");
    }
}

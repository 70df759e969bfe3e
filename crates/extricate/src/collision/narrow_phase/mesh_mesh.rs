//! Two trees of triangles: whether they are near, and their distance. Meshes count as surfaces
//! here; [`super::pair`] handles solids.

use pulp::{Arch, Simd, WithSimd};

use super::triangle;
use crate::collision::shapes::bounds::Relative;
use crate::collision::shapes::bvh::{Bvh, Probe, Ref, View, below, lanes_of, push_sorted, rounded_up};
use crate::math::{LANES, Pose};

/// Two trees, each with a view of the other in its own frame.
pub struct Pair<'a> {
    pub a: &'a Bvh,
    pub b: &'a Bvh,
    /// Maps the frame of `b` to that of `a`.
    pub pose_a_b: Pose,
    pub pose_b_a: Pose,
    pub b_in_a: View,
    pub a_in_b: View,
}

/// Widest gap \[m\] along a face axis of two boxes, and the node or block of either tree.
pub type Entry = (f32, Ref, Ref);

impl<'a> Pair<'a> {
    pub fn new(a: &'a Bvh, b: &'a Bvh, relative: &Relative) -> Self {
        let pose_a_b = relative.pose_a_b;
        let pose_b_a = pose_a_b.inverse();
        let b_in_a = View::new(&pose_a_b, &a.cuboid, &b.cuboid);
        let a_in_b = View::new(&pose_b_a, &b.cuboid, &a.cuboid);
        Self { a, b, pose_a_b, pose_b_a, b_in_a, a_in_b }
    }

    /// Whether to open the first of two entries (not both blocks). The larger one is opened, so
    /// that both shrink alike.
    #[inline(always)]
    pub fn opens_first(&self, i: Ref, j: Ref) -> bool {
        j.is_block() || (!i.is_block() && self.a.bounds_of(i).size() >= self.b.bounds_of(j).size())
    }

    /// Returns the triangles of two blocks that may be nearer than `limit`, as one bit a lane for
    /// each block.
    #[inline(always)]
    fn candidates<S: Simd>(&self, simd: S, i: Ref, j: Ref, limit: f32) -> (u32, u32) {
        let (s, t) = (&self.a.blocks[i.index()], &self.b.blocks[j.index()]);
        let (first, _) = s.boxes.near(simd, &self.b_in_a, &self.b_in_a.see(&t.bounds, limit));
        if first == 0 {
            return (0, 0);
        }
        let (second, _) = t.boxes.near(simd, &self.a_in_b, &self.a_in_b.see(&s.bounds, limit));
        // Without a limit every lane passes the tests, even those that hold no triangle.
        (first & s.filled(), second & t.filled())
    }

    /// Calls `found` with the lanes of triangles of two blocks that are not proved farther apart
    /// than `limit` \[m\], and a lower bound on their distance. Stops and returns `true` as soon as
    /// `found` does; `found` may lower the limit.
    #[inline(always)]
    pub fn near_triangles<S: Simd>(
        &self,
        simd: S,
        i: Ref,
        j: Ref,
        mut limit: f64,
        mut found: impl FnMut(usize, usize, f64, &mut f64) -> bool,
    ) -> bool {
        let (s, t) = (&self.a.blocks[i.index()], &self.b.blocks[j.index()]);
        let (first, second) = self.candidates(simd, i, j, rounded_up(limit));
        if first == 0 || second == 0 {
            return false;
        }
        if first.count_ones() <= second.count_ones() {
            for k in lanes_of(first) {
                let reach = rounded_up(limit);
                let probe = Probe::new(&s.triangle(k), &self.pose_b_a, reach, self.a_in_b.rounding());
                let mask = probe.near(simd, &t.boxes) & second;
                if mask != 0 {
                    let (mask, gaps) = t.near(simd, &probe.triangle, limit, mask);
                    for l in lanes_of(mask) {
                        if found(k, l, gaps[l], &mut limit) {
                            return true;
                        }
                    }
                }
            }
        } else {
            for l in lanes_of(second) {
                let reach = rounded_up(limit);
                let probe = Probe::new(&t.triangle(l), &self.pose_a_b, reach, self.b_in_a.rounding());
                let mask = probe.near(simd, &s.boxes) & first;
                if mask != 0 {
                    let (mask, gaps) = s.near(simd, &probe.triangle, limit, mask);
                    for k in lanes_of(mask) {
                        if found(k, l, gaps[k], &mut limit) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }
}

/// Finds two triangles that cross or are nearer than `limit` \[m\]. `relative` maps the second mesh
/// to the first.
pub fn nearer(a: &Bvh, b: &Bvh, relative: &Relative, limit: f64, stack: &mut Vec<Entry>) -> Option<(u32, u32)> {
    Arch::new().dispatch(Nearer { pair: &Pair::new(a, b, relative), limit, stack })
}

struct Nearer<'a> {
    pair: &'a Pair<'a>,
    limit: f64,
    stack: &'a mut Vec<Entry>,
}

impl WithSimd for Nearer<'_> {
    type Output = Option<(u32, u32)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<(u32, u32)> {
        let Self { pair, limit, stack } = self;
        let (a, b) = (pair.a, pair.b);
        let reach = rounded_up(limit);
        stack.clear();
        stack.push((0.0, a.root, b.root));
        let mut hit = None;
        while let Some((_, i, j)) = stack.pop() {
            if i.is_block() && j.is_block() {
                let (s, t) = (&a.blocks[i.index()], &b.blocks[j.index()]);
                let is_hit = |k: usize, l: usize, _: f64, _: &mut f64| {
                    let is_near = triangle::nearer(&s.triangle(k), &t.triangle(l).moved(&pair.pose_a_b), limit);
                    if is_near {
                        hit = Some(((i.index() * LANES + k) as u32, (j.index() * LANES + l) as u32));
                    }
                    is_near
                };
                if pair.near_triangles(simd, i, j, limit, is_hit) {
                    return hit;
                }
            } else if pair.opens_first(i, j) {
                let node = &a.nodes[i.index()];
                let (mask, gaps) = node.boxes.near(simd, &pair.b_in_a, &pair.b_in_a.see(b.bounds_of(j), reach));
                let start = stack.len();
                for lane in lanes_of(mask) {
                    push_sorted(stack, start, (gaps[lane], node.children[lane], j), |entry| entry.0);
                }
            } else {
                let node = &b.nodes[j.index()];
                let (mask, gaps) = node.boxes.near(simd, &pair.a_in_b, &pair.a_in_b.see(a.bounds_of(i), reach));
                let start = stack.len();
                for lane in lanes_of(mask) {
                    push_sorted(stack, start, (gaps[lane], i, node.children[lane]), |entry| entry.0);
                }
            }
        }
        None
    }
}

/// Distance \[m\] of the nearest pair of triangles, if below `cutoff`. Crossing triangles have
/// distance 0 and count for a cutoff of 0 too.
pub fn closest(a: &Bvh, b: &Bvh, relative: &Relative, cutoff: f64, stack: &mut Vec<Entry>) -> Option<f64> {
    Arch::new().dispatch(Closest { pair: &Pair::new(a, b, relative), cutoff, stack })
}

struct Closest<'a> {
    pair: &'a Pair<'a>,
    cutoff: f64,
    stack: &'a mut Vec<Entry>,
}

impl WithSimd for Closest<'_> {
    type Output = Option<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<f64> {
        let Self { pair, cutoff, stack } = self;
        let (a, b) = (pair.a, pair.b);
        let mut limit = cutoff;
        let mut best = None;
        stack.clear();
        stack.push((0.0, a.root, b.root));
        while let Some((bound, i, j)) = stack.pop() {
            if f64::from(bound) >= limit && bound > 0.0 {
                continue;
            }
            if i.is_block() && j.is_block() {
                let (s, t) = (&a.blocks[i.index()], &b.blocks[j.index()]);
                pair.near_triangles(simd, i, j, limit, |k, l, _, still| {
                    let moved = t.triangle(l).moved(&pair.pose_a_b);
                    if let Some(witness) = triangle::closest(&s.triangle(k), &moved, limit * limit) {
                        limit = witness.squared.sqrt();
                        best = Some(limit);
                        *still = limit;
                    }
                    limit == 0.0
                });
                if best == Some(0.0) {
                    return best;
                }
            } else {
                let start = stack.len();
                children(simd, pair, i, j, rounded_up(limit), |bound, i, j| {
                    push_sorted(stack, start, (bound, i, j), |entry| entry.0);
                });
            }
        }
        best
    }
}

/// Opens one of two entries (not both blocks). Calls `each` with a lower bound on the distance
/// \[m\] of every resulting pair that may be nearer than `limit`; the bound is negative if boxes
/// overlap.
#[inline(always)]
pub fn children<S: Simd>(simd: S, pair: &Pair, i: Ref, j: Ref, limit: f32, mut each: impl FnMut(f32, Ref, Ref)) {
    if pair.opens_first(i, j) {
        let node = &pair.a.nodes[i.index()];
        let bounds = node.boxes.lower_bounds(simd, &pair.b_in_a, &pair.b_in_a.see(pair.b.bounds_of(j), 0.0));
        for lane in lanes_of(below(&bounds, limit)) {
            each(bounds[lane], node.children[lane], j);
        }
    } else {
        let node = &pair.b.nodes[j.index()];
        let bounds = node.boxes.lower_bounds(simd, &pair.a_in_b, &pair.a_in_b.see(pair.a.bounds_of(i), 0.0));
        for lane in lanes_of(below(&bounds, limit)) {
            each(bounds[lane], i, node.children[lane]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::shapes::mesh::MeshShape;
    use crate::collision::shapes::test_mesh::{bumpy, joined, opened, placed};
    use crate::math::{Pose, Vec3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Slow twin that compares all pairs of triangles.
    fn scan(a: &Bvh, b: &Bvh, pose: &Pose) -> f64 {
        let squared = |t: &triangle::Triangle| {
            let moved = t.moved(pose);
            a.triangles(0..a.blocks.len())
                .filter_map(|s| triangle::closest(&s, &moved, 1e9).map(|w| w.squared))
                .fold(1e9, f64::min)
        };
        b.triangles(0..b.blocks.len()).map(|t| squared(&t)).fold(1e9, f64::min).sqrt()
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
            // Bisect toward the boundary and check the answers on the way; the last ones are within
            // 1e-9 of it.
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

    /// Meshes of few triangles leave lanes of blocks empty.
    #[test]
    fn small_meshes_far_apart_are_as_far_as_all_pairs_say() {
        let mut rng = ChaCha8Rng::seed_from_u64(14);
        for round in 0..600 {
            let mut vector = |s: f64| Vec3::from_fn(|_, _| s * (rng.random::<f64>() - 0.5));
            let mut soup = |count: usize, shift: Vec3| {
                let vertices: Vec<Vec3> = (0..3 * count).map(|_| vector(1.0) + shift).collect();
                let triangles = (0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
                MeshShape::new(&crate::robot::TriangleMesh::new(vertices, triangles)).tree
            };
            let far = [0.0, 3.0, 40.0][round % 3];
            let (a, b) = (soup(1 + round % 11, Vec3::x() * far), soup(1 + round / 11 % 11, Vec3::y() * far));
            let relative = Relative::new(Pose::from_xyz_rpy(vector(2.0 * far).into(), vector(6.0).into()));
            let expected = scan(&a, &b, &relative.pose_a_b);
            for cutoff in [f64::INFINITY, 1e12, expected + 1.0] {
                let found = closest(&a, &b, &relative, cutoff, &mut Vec::new()).unwrap();
                assert!((found - expected).abs() < 1e-9 * (1.0 + expected), "{round} {cutoff}: {found} {expected}");
            }
        }
    }
}

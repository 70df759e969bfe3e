//! Contacts of two meshes.

use std::collections::BinaryHeap;

use pulp::{Arch, Simd, WithSimd};

use super::buffers::{ContactBuffers, TRIANGLES_ENTRY};
use super::overlap::crossing;
use super::sink::{Near, Sink};
use crate::collision::narrow_phase::best_first::Entry;
use crate::collision::narrow_phase::mesh_mesh::{self, Pair};
use crate::collision::narrow_phase::triangle;
use crate::collision::shapes::bounds::Relative;
use crate::collision::shapes::bvh::{Ref, rounded_up};
use crate::collision::shapes::mesh::MeshShape;

/// Distance \[m\] below which the direction between two points is lost to rounding.
const TOUCHING_DISTANCE_M: f64 = 1e-10;

pub fn mesh_with_mesh(
    a: &MeshShape,
    b: &MeshShape,
    relative: &Relative,
    buffers: &mut ContactBuffers,
    sink: &mut Sink,
) {
    let two = Pair::new(&a.tree, &b.tree, relative);
    let pose = &relative.pose_a_b;
    let whole = relative.lower_bound(&a.tree.bounds, &b.tree.bounds);
    buffers.restart(sink.margin, whole, a.tree.root.0, b.tree.root.0);
    let overlap = buffers.run(sink, |buffers, bound, i, j| {
        let limit = buffers.limit;
        if i == TRIANGLES_ENTRY {
            let [(i, k), (j, l)] = buffers.triangles[j as usize];
            let (s, t) = (&a.tree.blocks[i as usize], &b.tree.blocks[j as usize]);
            let (first, second) = (s.triangle(usize::from(k)), t.triangle(usize::from(l)).moved(pose));
            if let Some(witness) = triangle::closest(&first, &second, limit * limit) {
                let distance = witness.squared.sqrt();
                if distance > TOUCHING_DISTANCE_M {
                    let normal = (witness.first - witness.second) / distance;
                    let (point_first, point_second) = (witness.first, witness.second);
                    buffers.find(Near { distance, point_first, point_second, normal });
                } else {
                    let closed = [a.closed[s.group as usize], b.closed[t.group as usize]];
                    if let Some(near) = crossing(&first, closed[0], &second, closed[1]) {
                        buffers.find(near);
                    }
                }
            }
            return 1;
        }
        let (i, j) = (Ref(i), Ref(j));
        if i.is_block() && j.is_block() {
            let each = |k: usize, l: usize, gap: f64| {
                let second = buffers.triangles.len() as u32;
                buffers.queue.push(Entry { bound: gap.max(bound), first: TRIANGLES_ENTRY, second });
                buffers.triangles.push([(i.index() as u32, k as u8), (j.index() as u32, l as u8)]);
            };
            Arch::new().dispatch(NearTriangles { pair: &two, i, j, limit, each });
        } else {
            Arch::new().dispatch(Open { pair: &two, i, j, limit, queue: &mut buffers.queue });
        }
        0
    });
    if !overlap {
        for p in &b.representatives {
            let p = pose.point(p);
            if let Some((depth, surface)) = a.depth_inside(&p, 0.0, &mut buffers.nodes) {
                sink.offer(&Near {
                    distance: -depth,
                    point_first: surface,
                    point_second: p,
                    normal: (p - surface) / depth,
                });
            }
        }
        for p in &a.representatives {
            if let Some((depth, surface)) = b.depth_inside(&pose.inverse_point(p), 0.0, &mut buffers.nodes) {
                let surface = pose.point(&surface);
                let normal = (surface - p) / depth;
                sink.offer(&Near { distance: -depth, point_first: *p, point_second: surface, normal });
            }
        }
    }
}

/// Pushes the children of two nodes, of which not both are blocks, to the queue.
struct Open<'a> {
    pair: &'a Pair<'a>,
    i: Ref,
    j: Ref,
    limit: f64,
    queue: &'a mut BinaryHeap<Entry>,
}

impl WithSimd for Open<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        mesh_mesh::children(simd, self.pair, self.i, self.j, rounded_up(self.limit), |bound, i, j| {
            self.queue.push(Entry { bound: f64::from(bound), first: i.0, second: j.0 });
        });
    }
}

/// Calls `each` with the triangles of two blocks that may be nearer than the limit.
struct NearTriangles<'a, F> {
    pair: &'a Pair<'a>,
    i: Ref,
    j: Ref,
    limit: f64,
    each: F,
}

impl<F: FnMut(usize, usize, f64)> WithSimd for NearTriangles<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.pair.near_triangles(simd, self.i, self.j, self.limit, |k, l, gap, _| {
            (self.each)(k, l, gap);
            false
        });
    }
}

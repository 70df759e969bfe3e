//! Up to eight triangles side by side, and the test of all of them at once against one triangle. In `f64`; no tree.

// Lanes of several arrays go together: indices say so, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::boxes::{Boxes, Cuboid};
use crate::collision::bounds::{Aabb, ROUNDING};
use crate::collision::triangle::Triangle;
use crate::math::{LANES, Pose, Vec3};

/// Triangles, corner by corner and coordinate by coordinate; the box of each.
#[derive(Debug, Clone)]
pub struct Block {
    /// Around each triangle; nothing in lanes without one.
    pub boxes: Boxes,
    /// Around all of them.
    pub bounds: Cuboid,
    /// The group that all of them belong to.
    pub group: u32,
    len: u32,
    corners: [[[f64; LANES]; 3]; 3],
    normals: [[f64; LANES]; 3],
}

/// A triangle that blocks are tested against, in their frame.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// The triangle.
    pub triangle: Triangle,
    lower: [f32; 3],
    upper: [f32; 3],
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

impl Block {
    /// Of one to eight triangles of `group`.
    pub fn new(triangles: &[[Vec3; 3]], group: u32) -> Self {
        let bounds: Vec<Aabb> = triangles.iter().map(|points| Aabb::around(points.iter())).collect();
        let mut corners = [[[0.0; LANES]; 3]; 3];
        let mut normals = [[0.0; LANES]; 3];
        for (lane, points) in triangles.iter().enumerate() {
            let triangle = Triangle::new(*points);
            for i in 0..3 {
                normals[i][lane] = triangle.normal[i];
                for corner in 0..3 {
                    corners[corner][i][lane] = points[corner][i];
                }
            }
        }
        Self {
            boxes: Boxes::new(&bounds),
            bounds: Cuboid::around(&Aabb::around(triangles.as_flattened().iter())),
            group,
            len: triangles.len() as u32,
            corners,
            normals,
        }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.len as usize
    }

    /// One of the triangles.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let corner = |k: usize| {
            let [x, y, z] = &self.corners[k];
            Vec3::new(x[lane], y[lane], z[lane])
        };
        let [x, y, z] = &self.normals;
        Triangle { points: [corner(0), corner(1), corner(2)], normal: Vec3::new(x[lane], y[lane], z[lane]) }
    }

    /// Which triangles (of those in `mask`) are not proved farther from the probe than `limit` \[m\], one bit a lane.
    ///
    /// # Source
    /// S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996, doi:10.1145/237170.237244: separating axes of two
    /// convex sets are normals of faces and cross products of edges. Complete for triangles that cross; of those that do
    /// not, some pass although they are a little farther than the limit.
    #[inline(always)]
    pub fn near(&self, probe: &Triangle, limit: f64, mask: u32) -> u32 {
        let limit = limit + ROUNDING;
        let planes = self.plane_gaps(probe);
        let mut near = 0;
        for lane in 0..LANES {
            near |= u32::from(planes[lane] <= limit) << lane;
        }
        if near & mask == 0 {
            return 0;
        }
        let edges = self.edge_gaps(probe, limit * limit);
        for lane in 0..LANES {
            near &= !(u32::from(edges[lane] > 0.0) << lane);
        }
        near & mask
    }

    /// Gap \[m\] along the normals of the two triangles; 0 or less where neither parts them.
    #[inline(always)]
    fn plane_gaps(&self, probe: &Triangle) -> [f64; LANES] {
        let q = &probe.points;
        let mut gaps = [0.0; LANES];
        for lane in 0..LANES {
            let n = [self.normals[0][lane], self.normals[1][lane], self.normals[2][lane]];
            let mut own = [0.0; 3];
            let mut other = [0.0; 3];
            for k in 0..3 {
                let p = [self.corners[k][0][lane], self.corners[k][1][lane], self.corners[k][2][lane]];
                own[k] = probe.normal.x * (p[0] - q[0].x)
                    + probe.normal.y * (p[1] - q[0].y)
                    + probe.normal.z * (p[2] - q[0].z);
                other[k] = n[0] * (q[k].x - self.corners[0][0][lane])
                    + n[1] * (q[k].y - self.corners[0][1][lane])
                    + n[2] * (q[k].z - self.corners[0][2][lane]);
            }
            let above = greater(less(less(own[0], own[1]), own[2]), less(less(other[0], other[1]), other[2]));
            let below =
                greater(-greater(greater(own[0], own[1]), own[2]), -greater(greater(other[0], other[1]), other[2]));
            gaps[lane] = greater(above, below);
        }
        gaps
    }

    /// Positive where the cross product of two edges parts the triangles by more than the root of `limit_squared`.
    #[inline(always)]
    fn edge_gaps(&self, probe: &Triangle, limit_squared: f64) -> [f64; LANES] {
        let q = &probe.points;
        let mut parted = [0.0; LANES];
        for lane in 0..LANES {
            let mut widest = -1.0;
            for i in 0..3 {
                let at = |k: usize, axis: usize| self.corners[k % 3][axis][lane];
                let p = [at(i, 0), at(i, 1), at(i, 2)];
                let u = [at(i + 1, 0) - p[0], at(i + 1, 1) - p[1], at(i + 1, 2) - p[2]];
                let w = [at(i + 2, 0) - p[0], at(i + 2, 1) - p[1], at(i + 2, 2) - p[2]];
                for j in 0..3 {
                    let (a, b, c) = (&q[j], &q[(j + 1) % 3], &q[(j + 2) % 3]);
                    let v = [b.x - a.x, b.y - a.y, b.z - a.z];
                    let axis = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                    // On this axis each triangle is the segment from an edge to the corner across from it.
                    let own = axis[0] * w[0] + axis[1] * w[1] + axis[2] * w[2];
                    let edge = axis[0] * (a.x - p[0]) + axis[1] * (a.y - p[1]) + axis[2] * (a.z - p[2]);
                    let corner = axis[0] * (c.x - p[0]) + axis[1] * (c.y - p[1]) + axis[2] * (c.z - p[2]);
                    let above = less(edge, corner) - greater(own, 0.0);
                    let below = less(own, 0.0) - greater(edge, corner);
                    let gap = greater(greater(above, below), 0.0);
                    let squared = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
                    widest = greater(widest, gap * gap - limit_squared * squared);
                }
            }
            parted[lane] = widest;
        }
        parted
    }
}

impl Probe {
    /// `triangle` moved by `pose` into the frame of the blocks, for tests whether something is nearer than `limit` \[m\];
    /// `rounding` \[m\] as boxes need it.
    #[inline(always)]
    pub fn new(triangle: &Triangle, pose: &Pose, limit: f32, rounding: f32) -> Self {
        let triangle = triangle.moved(pose);
        let [a, b, c] = &triangle.points;
        let reach = limit + rounding;
        let (low, high) = (a.inf(b).inf(c), a.sup(b).sup(c));
        Self {
            lower: [low.x as f32 - reach, low.y as f32 - reach, low.z as f32 - reach],
            upper: [high.x as f32 + reach, high.y as f32 + reach, high.z as f32 + reach],
            triangle,
        }
    }

    /// Which boxes may hold something near, one bit a lane.
    #[inline(always)]
    pub fn near(&self, boxes: &Boxes) -> u32 {
        boxes.overlaps(&self.lower, &self.upper)
    }
}

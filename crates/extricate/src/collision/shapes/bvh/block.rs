//! Up to eight triangles side by side, tested all at once against one triangle. In `f64`; no tree.

use pulp::Simd;

use super::boxes::{Boxes, Cuboid};
use crate::collision::narrow_phase::triangle::Triangle;
use crate::collision::shapes::bounds::{Aabb, ROUNDING};
use crate::math::simd::{F64s, negative_f64};
use crate::math::{LANES, Pose, Vec3};

/// Triangles and their boxes; corners are stored by coordinate.
#[derive(Debug, Clone)]
pub struct Block {
    /// Box around each triangle; lanes without one have no box.
    pub boxes: Boxes,
    pub bounds: Cuboid,
    /// Group of all triangles.
    pub group: u32,
    len: u32,
    corners: [[[f64; LANES]; 3]; 3],
    normals: [[f64; LANES]; 3],
}

/// A triangle in the frame of the blocks that are tested against it.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    pub triangle: Triangle,
    lower: [f32; 3],
    upper: [f32; 3],
}

/// Vectors in lanes, one register for each coordinate.
type Vectors<S> = [F64s<S>; 3];

#[inline(always)]
fn dot<S: Simd>(a: &Vectors<S>, b: &Vectors<S>) -> F64s<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd>(a: &Vectors<S>, b: &Vectors<S>) -> Vectors<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn difference<S: Simd>(a: &Vectors<S>, b: &Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn splat<S: Simd>(simd: S, vector: &Vec3) -> Vectors<S> {
    [F64s::splat(simd, vector.x), F64s::splat(simd, vector.y), F64s::splat(simd, vector.z)]
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[[f64; LANES]; 3], at: usize) -> Vectors<S> {
    [F64s::load(simd, &lanes[0], at), F64s::load(simd, &lanes[1], at), F64s::load(simd, &lanes[2], at)]
}

#[inline(always)]
fn corners<S: Simd>(simd: S, triangle: &Triangle) -> [Vectors<S>; 3] {
    let [a, b, c] = &triangle.points;
    [splat(simd, a), splat(simd, b), splat(simd, c)]
}

/// Distance of three heights from 0 if all are above or all below it; else 0 or less.
#[inline(always)]
fn height<S: Simd>(simd: S, heights: &Vectors<S>) -> F64s<S> {
    let [a, b, c] = *heights;
    a.min(b).min(c).max(F64s::splat(simd, 0.0) - a.max(b).max(c))
}

impl Block {
    /// Makes a block from one to eight triangles of `group`.
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

    pub fn len(&self) -> usize {
        self.len as usize
    }

    /// Lanes that contain a triangle, one bit each.
    #[inline(always)]
    pub fn filled(&self) -> u32 {
        (1 << self.len) - 1
    }

    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let corner = |k: usize| {
            let [x, y, z] = &self.corners[k];
            Vec3::new(x[lane], y[lane], z[lane])
        };
        let [x, y, z] = &self.normals;
        Triangle { points: [corner(0), corner(1), corner(2)], normal: Vec3::new(x[lane], y[lane], z[lane]) }
    }

    /// Returns the triangles in `mask` that are not proved farther from the probe than `limit`
    /// \[m\], one bit a lane. Also returns lower bounds \[m\] on their distances, 0 or less if no
    /// plane separates the two.
    ///
    /// # Source
    /// S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996,
    /// doi:10.1145/237170.237244: separating axes of two convex sets are normals of faces and cross
    /// products of edges. The test finds all crossing triangles; it also passes some that are
    /// slightly farther than the limit.
    #[inline(always)]
    pub fn near<S: Simd>(&self, simd: S, probe: &Triangle, limit: f64, mask: u32) -> (u32, [f64; LANES]) {
        let limit = limit + ROUNDING;
        let (mut gaps, mut apart) = ([0.0; LANES], [0.0; LANES]);
        for at in 0..F64s::<S>::COUNT {
            let gap = self.plane_gap(simd, probe, at);
            (gap - F64s::splat(simd, ROUNDING)).store(&mut gaps, at);
            (F64s::splat(simd, limit) - gap).store(&mut apart, at);
        }
        let mask = mask & !negative_f64(&apart);
        if mask == 0 {
            return (0, gaps);
        }
        for at in 0..F64s::<S>::COUNT {
            self.edge_gap(simd, probe, limit * limit, at).store(&mut apart, at);
        }
        (mask & negative_f64(&apart), gaps)
    }

    /// Gap \[m\] along the normals of the two triangles; 0 or less if neither separates them.
    #[inline(always)]
    fn plane_gap<S: Simd>(&self, simd: S, probe: &Triangle, at: usize) -> F64s<S> {
        let q = corners(simd, probe);
        let p = self.corners_at(simd, at);
        let (across, normal) = (splat(simd, &probe.normal), load(simd, &self.normals, at));
        let mut over_probe = [F64s::splat(simd, 0.0); 3];
        let mut over_own = over_probe;
        for k in 0..3 {
            over_probe[k] = dot(&across, &difference(&p[k], &q[0]));
            over_own[k] = dot(&normal, &difference(&q[k], &p[0]));
        }
        height(simd, &over_probe).max(height(simd, &over_own))
    }

    #[inline(always)]
    fn corners_at<S: Simd>(&self, simd: S, at: usize) -> [Vectors<S>; 3] {
        let [a, b, c] = &self.corners;
        [load(simd, a, at), load(simd, b, at), load(simd, c, at)]
    }

    /// Nonnegative if the cross product of two edges separates the triangles by at least the root
    /// of `limit_squared`.
    #[inline(always)]
    fn edge_gap<S: Simd>(&self, simd: S, probe: &Triangle, limit_squared: f64, at: usize) -> F64s<S> {
        let (p, q) = (self.corners_at(simd, at), corners(simd, probe));
        let (zero, limit_squared) = (F64s::splat(simd, 0.0), F64s::splat(simd, limit_squared));
        let mut widest = F64s::splat(simd, -1.0);
        for i in 0..3 {
            let u = difference(&p[(i + 1) % 3], &p[i]);
            let w = difference(&p[(i + 2) % 3], &p[i]);
            for j in 0..3 {
                let v = difference(&q[(j + 1) % 3], &q[j]);
                let axis = cross(&u, &v);
                // On this axis, each triangle spans from an edge to the opposite corner.
                let own = dot(&axis, &w);
                let edge = dot(&axis, &difference(&q[j], &p[i]));
                let corner = dot(&axis, &difference(&q[(j + 2) % 3], &p[i]));
                let above = edge.min(corner) - own.max(zero);
                let below = own.min(zero) - edge.max(corner);
                let gap = above.max(below).max(zero);
                // An axis of length 0 separates nothing.
                widest = widest.max(gap * gap - limit_squared * dot(&axis, &axis));
            }
        }
        widest - F64s::splat(simd, f64::MIN_POSITIVE)
    }
}

impl Probe {
    /// Moves `triangle` by `pose` into the frame of the blocks, to find boxes nearer than `limit`
    /// \[m\]. `rounding` \[m\] is that of the boxes.
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

    /// Boxes that may contain something near, one bit a lane.
    #[inline(always)]
    pub fn near<S: Simd>(&self, simd: S, boxes: &Boxes) -> u32 {
        boxes.overlaps(simd, &self.lower, &self.upper)
    }
}

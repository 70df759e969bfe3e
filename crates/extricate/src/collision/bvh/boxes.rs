//! Eight boxes side by side, and tests of all of them at once against a box, a point or a ray. In `f32`, rounded so that only
//! "may be near" can be wrong; no triangles.
//!
//! The loops over lanes have no branches: compiled for a processor with vector instructions (`math::vectorized`) each is one
//! pass over a register.

// Lanes of several arrays go together: indices say so, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use crate::collision::bounds::Aabb;
use crate::math::{LANES, Pose, Vec3};

/// One value a box.
pub type Lanes = [f32; LANES];

/// A box around a node or a block \[m\].
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    /// Its centre.
    pub center: [f32; 3],
    /// Half of each side, rounded up.
    pub half: [f32; 3],
}

/// Eight boxes, axis by axis.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Boxes {
    center: [Lanes; 3],
    half: [Lanes; 3],
}

/// Half side \[m\] of a box that is none: nothing is near it, and its square is infinite.
const NO_BOX: f32 = -1e30;

/// What rounding to `f32` may take from a gap, as a share of the largest coordinate involved: some 20 roundings of 2^-24 each.
const ROUNDING: f64 = 4e-6;

/// How the frame of one tree lies in that of another, for tests of boxes.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// `rotation[i][j]`: component `i` of the other frame's axis `j`.
    rotation: [[f32; 3]; 3],
    /// Absolute values, rounded up: axes that are nearly parallel then part nothing.
    absolute: [[f32; 3]; 3],
    translation: [f32; 3],
    /// What rounding may take \[m\].
    rounding: f32,
}

/// A box of the other tree in this frame, with what the tests of all boxes share; reaches include the limit.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    center: [f32; 3],
    half: [f32; 3],
    limit: f32,
    /// Along this frame's axes.
    face: [f32; 3],
}

impl Cuboid {
    /// Around `bounds`.
    pub fn around(bounds: &Aabb) -> Self {
        let center = [bounds.center.x as f32, bounds.center.y as f32, bounds.center.z as f32];
        let half = std::array::from_fn(|i| {
            let moved = (f64::from(center[i]) - bounds.center[i]).abs();
            ((bounds.half[i] + moved) as f32).next_up()
        });
        Self { center, half }
    }

    /// Sum of the half sides: of two boxes the larger one is opened first.
    pub fn size(&self) -> f32 {
        self.half[0] + self.half[1] + self.half[2]
    }

    /// Whether the box, rounded up, holds `point`.
    pub fn may_hold(&self, point: &Vec3) -> bool {
        (0..3).all(|i| (point[i] - f64::from(self.center[i])).abs() <= f64::from(self.half[i]))
    }

    /// Square of the distance from the frame's origin to the farthest corner.
    fn farthest_squared(&self) -> f64 {
        (0..3).map(|i| f64::from(self.center[i].abs() + self.half[i]).powi(2)).sum()
    }
}

impl View {
    /// Of the other frame, which `pose` maps to this one; `own` and `other` hold all boxes of the two.
    pub fn new(pose: &Pose, own: &Cuboid, other: &Cuboid) -> Self {
        let rotation = std::array::from_fn(|i| std::array::from_fn(|j| pose.rotation[(i, j)] as f32));
        let translation = std::array::from_fn(|i| pose.translation[i] as f32);
        let farthest = pose.translation.norm() + own.farthest_squared().sqrt() + other.farthest_squared().sqrt();
        let absolute =
            std::array::from_fn(|i: usize| std::array::from_fn(|j: usize| (pose.rotation[(i, j)].abs() + 1e-6) as f32));
        Self { rotation, absolute, translation, rounding: (farthest * ROUNDING) as f32 }
    }

    /// What rounding may take from gaps between boxes of the two frames \[m\].
    #[inline(always)]
    pub fn rounding(&self) -> f32 {
        self.rounding
    }

    /// A box of the other frame, for tests whether it is nearer than `limit` \[m\].
    #[inline(always)]
    pub fn see(&self, other: &Cuboid, limit: f32) -> Seen {
        let (r, m, c, h) = (&self.rotation, &self.absolute, &other.center, &other.half);
        let limit = limit + self.rounding;
        let mut seen = Seen { center: self.translation, half: *h, limit, face: [limit; 3] };
        for i in 0..3 {
            seen.center[i] += r[i][0] * c[0] + r[i][1] * c[1] + r[i][2] * c[2];
            seen.face[i] += m[i][0] * h[0] + m[i][1] * h[1] + m[i][2] * h[2];
        }
        seen
    }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// One bit a lane: where `gaps` is not positive.
#[inline(always)]
fn overlapping(gaps: &Lanes) -> u32 {
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= u32::from(gaps[lane] <= 0.0) << lane;
    }
    mask
}

/// One bit a lane: where `values` are below `limit`; lanes without a box never are.
#[inline(always)]
pub fn below(values: &Lanes, limit: f32) -> u32 {
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= u32::from(values[lane] < limit) << lane;
    }
    mask
}

impl Boxes {
    /// Boxes around `bounds` (eight at most), and nothing in the other lanes.
    pub fn new(bounds: &[Aabb]) -> Self {
        let mut all = Self { center: [[0.0; LANES]; 3], half: [[NO_BOX; LANES]; 3] };
        for (lane, bounds) in bounds.iter().enumerate() {
            let cuboid = Cuboid::around(bounds);
            for i in 0..3 {
                all.center[i][lane] = cuboid.center[i];
                all.half[i][lane] = cuboid.half[i];
            }
        }
        all
    }

    /// One of the boxes.
    #[cfg(test)]
    pub fn get(&self, lane: usize) -> Cuboid {
        Cuboid {
            center: [self.center[0][lane], self.center[1][lane], self.center[2][lane]],
            half: [self.half[0][lane], self.half[1][lane], self.half[2][lane]],
        }
    }

    /// Gaps \[m\] along the face axes of all boxes and of the one seen: three and three.
    #[inline(always)]
    fn face_gaps(&self, view: &View, seen: &Seen) -> [[Lanes; 3]; 2] {
        let (r, m) = (&view.rotation, &view.absolute);
        let mut own = [[0.0; LANES]; 3];
        let mut other = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let t = [
                seen.center[0] - self.center[0][lane],
                seen.center[1] - self.center[1][lane],
                seen.center[2] - self.center[2][lane],
            ];
            let h = [self.half[0][lane], self.half[1][lane], self.half[2][lane]];
            for i in 0..3 {
                own[i][lane] = t[i].abs() - h[i] - seen.face[i];
            }
            for j in 0..3 {
                let along = t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j];
                let reach = h[0] * m[0][j] + h[1] * m[1][j] + h[2] * m[2][j];
                other[j][lane] = along.abs() - reach - (seen.half[j] + seen.limit);
            }
        }
        [own, other]
    }

    /// Which boxes may be nearer than the limit to the one seen, one bit a lane; and the widest gap \[m\] along a face axis.
    ///
    /// # Source
    /// S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996, doi:10.1145/237170.237244: fifteen separating axes.
    #[inline(always)]
    pub fn near(&self, view: &View, seen: &Seen) -> (u32, Lanes) {
        let [own, other] = self.face_gaps(view, seen);
        let mut gaps = [0.0; LANES];
        for lane in 0..LANES {
            let a = greater(greater(own[0][lane], own[1][lane]), own[2][lane]);
            let b = greater(greater(other[0][lane], other[1][lane]), other[2][lane]);
            gaps[lane] = greater(a, b);
        }
        let mask = overlapping(&gaps);
        if mask == 0 {
            return (0, gaps);
        }
        (mask & overlapping(&self.edge_gaps(view, seen)), gaps)
    }

    /// Widest gap along the cross products of edges. Those are shorter than unit where axes lean toward each other, so the limit
    /// asks too much there: safe.
    #[inline(always)]
    fn edge_gaps(&self, view: &View, seen: &Seen) -> Lanes {
        let (r, m) = (&view.rotation, &view.absolute);
        let mut widest = [f32::NEG_INFINITY; LANES];
        let mut reach_other = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                reach_other[i][j] = seen.half[j1] * m[i][j2] + seen.half[j2] * m[i][j1] + seen.limit;
            }
        }
        for lane in 0..LANES {
            let t = [
                seen.center[0] - self.center[0][lane],
                seen.center[1] - self.center[1][lane],
                seen.center[2] - self.center[2][lane],
            ];
            let h = [self.half[0][lane], self.half[1][lane], self.half[2][lane]];
            let mut gap = f32::NEG_INFINITY;
            for i in 0..3 {
                let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
                for j in 0..3 {
                    let reach = h[i1] * m[i2][j] + h[i2] * m[i1][j] + reach_other[i][j];
                    gap = greater(gap, (t[i2] * r[i1][j] - t[i1] * r[i2][j]).abs() - reach);
                }
            }
            widest[lane] = gap;
        }
        widest
    }

    /// Lower bounds \[m\] on the distances between what the boxes hold and what the one seen (with limit 0) holds; negative
    /// where two overlap along all face axes.
    #[inline(always)]
    pub fn lower_bounds(&self, view: &View, seen: &Seen) -> Lanes {
        let [own, other] = self.face_gaps(view, seen);
        let mut bounds = [0.0; LANES];
        for lane in 0..LANES {
            let mut squares = [0.0; 2];
            let mut widest = f32::NEG_INFINITY;
            for (gaps, square) in [&own, &other].into_iter().zip(&mut squares) {
                for axis in gaps {
                    let gap = axis[lane];
                    widest = greater(widest, gap);
                    let positive = greater(gap, 0.0);
                    *square += positive * positive;
                }
            }
            // Sums and root round relative to themselves.
            let distance = greater(squares[0], squares[1]).sqrt() * (1.0 - 1e-6);
            bounds[lane] = if widest > 0.0 { distance } else { widest };
        }
        bounds
    }

    /// Which boxes overlap the axis-aligned one from `lower` to `upper` \[m\] in this frame, one bit a lane.
    #[inline(always)]
    pub fn overlaps(&self, lower: &[f32; 3], upper: &[f32; 3]) -> u32 {
        let mut gaps = [0.0; LANES];
        for lane in 0..LANES {
            let mut gap = f32::NEG_INFINITY;
            for i in 0..3 {
                let (c, h) = (self.center[i][lane], self.half[i][lane]);
                gap = greater(gap, greater(lower[i] - c, c - upper[i]) - h);
            }
            gaps[lane] = gap;
        }
        overlapping(&gaps)
    }

    /// Lower bounds [m^2] on the squared distances of what the boxes hold from `point`; `rounding` as in [`rounding_at`].
    #[inline(always)]
    pub fn distances_squared(&self, point: &[f32; 3], rounding: f32) -> Lanes {
        let mut squares = [0.0; LANES];
        for lane in 0..LANES {
            let mut square = 0.0;
            for i in 0..3 {
                let gap = greater((point[i] - self.center[i][lane]).abs() - self.half[i][lane] - rounding, 0.0);
                square += gap * gap;
            }
            squares[lane] = square * (1.0 - 1e-6);
        }
        squares
    }

    /// Which boxes a ray from `origin` may meet, one bit a lane; `inverse` holds the inverses of its direction's components,
    /// `rounding` is as in [`rounding_at`].
    #[inline(always)]
    pub fn met_by(&self, origin: &[f32; 3], inverse: &[f32; 3], rounding: f32) -> u32 {
        let mut gaps = [0.0; LANES];
        for lane in 0..LANES {
            let (mut enters, mut leaves) = (0.0, f32::INFINITY);
            for i in 0..3 {
                let center = (self.center[i][lane] - origin[i]) * inverse[i];
                let reach = (self.half[i][lane] + rounding) * inverse[i].abs();
                enters = greater(enters, center - reach);
                leaves = if center + reach < leaves { center + reach } else { leaves };
            }
            gaps[lane] = enters - leaves;
        }
        overlapping(&gaps)
    }
}

/// What rounding may take \[m\] from gaps between `point` and boxes within `bounds`.
pub fn rounding_at(point: &Vec3, bounds: &Cuboid) -> f32 {
    ((point.norm() + bounds.farthest_squared().sqrt()) * ROUNDING) as f32
}

/// The least `f32` that is not less.
#[inline(always)]
pub fn rounded_up(limit: f64) -> f32 {
    (limit as f32).next_up()
}

/// The lanes of `mask`, ascending.
#[inline(always)]
pub fn lanes_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            lane
        })
    })
}

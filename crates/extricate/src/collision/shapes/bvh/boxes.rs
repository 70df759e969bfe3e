//! Eight boxes side by side, tested all at once against a box, a point or a ray. In `f32`, rounded
//! so that only "may be near" can be wrong; no triangles.

use pulp::Simd;

use crate::collision::shapes::bounds::Aabb;
use crate::math::simd::{F32s, negative};
use crate::math::{LANES, Pose, Vec3};

/// One value for each of eight boxes.
pub type Lanes = [f32; LANES];

/// A box around a node or a block \[m\].
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    pub center: [f32; 3],
    /// Half of each side, rounded up.
    pub half: [f32; 3],
}

/// Eight boxes, stored by axis.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Boxes {
    center: [Lanes; 3],
    half: [Lanes; 3],
}

/// Half side \[m\] of an empty lane: nothing is near it, and its square is infinite.
const NO_BOX_HALF_SIDE_M: f32 = -1e30;

/// Rounding error of a gap in `f32`, as a share of the largest coordinate involved: some 20
/// roundings of 2^-24 each.
const ROUNDING_SHARE: f64 = 4e-6;

/// A limit is wide if it exceeds this share of the half sides of the box tested.
const WIDE_LIMIT_SHARE: f32 = 0.1;
/// Upper bound on limits \[m\]; its square is still finite.
const MAX_LIMIT_M: f32 = 1e15;

/// Pose of the frame of one tree in that of another, prepared for box tests.
#[derive(Debug, Clone)]
pub struct View {
    /// Component `i` of axis `j` of the other frame is `columns[j][i]`; the fourth is padding.
    columns: [[f32; 4]; 3],
    /// Absolute values, rounded up so that nearly parallel axes separate nothing.
    absolute: [[f32; 4]; 3],
    translation: [f32; 4],
    /// Copies of `columns` and `absolute` that fill a register each.
    wide_columns: [[Lanes; 3]; 3],
    wide_absolute: [[Lanes; 3]; 3],
    /// Rounding error of a gap \[m\].
    rounding: f32,
}

/// A box of the other tree in this frame, with data for testing all boxes. Reaches include the
/// limit.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Limit without the rounding error.
    limit: f32,
    /// Whether the limit is so large compared with the box that gaps along single axes decide
    /// little.
    is_wide: bool,
    center: [f32; 4],
    /// Reach along the axes of this frame.
    face: [f32; 4],
    /// Reach along its own axes.
    own: [f32; 3],
    /// Reach along the cross product of axis `i` and its own axis `j`, at `edge[j][i]`.
    edge: [[f32; 4]; 3],
}

impl Cuboid {
    pub fn around(bounds: &Aabb) -> Self {
        let center = [bounds.center.x as f32, bounds.center.y as f32, bounds.center.z as f32];
        let half = std::array::from_fn(|i| {
            let moved = (f64::from(center[i]) - bounds.center[i]).abs();
            ((bounds.half[i] + moved) as f32).next_up()
        });
        Self { center, half }
    }

    /// Sum of the half sides, which decides which of two boxes is opened first.
    pub fn size(&self) -> f32 {
        self.half[0] + self.half[1] + self.half[2]
    }

    /// Whether the box, rounded up, holds `point`.
    pub fn may_hold(&self, point: &Vec3) -> bool {
        (0..3).all(|i| (point[i] - f64::from(self.center[i])).abs() <= f64::from(self.half[i]))
    }

    /// Squared distance from the origin of the frame to the farthest corner.
    fn farthest_squared(&self) -> f64 {
        (0..3).map(|i| f64::from(self.center[i].abs() + self.half[i]).powi(2)).sum()
    }
}

impl View {
    /// Prepares the other frame, which `pose` maps to this one. `own` and `other` contain all boxes
    /// of the two.
    pub fn new(pose: &Pose, own: &Cuboid, other: &Cuboid) -> Self {
        let farthest = pose.translation.norm() + own.farthest_squared().sqrt() + other.farthest_squared().sqrt();
        let column = |j: usize| std::array::from_fn(|i| if i < 3 { pose.rotation[(i, j)] as f32 } else { 0.0 });
        let columns: [[f32; 4]; 3] = std::array::from_fn(column);
        let absolute = columns.map(|column| column.map(|x| x.abs() + 1e-6));
        let wide = |columns: &[[f32; 4]; 3]| columns.map(|[x, y, z, _]| [[x; LANES], [y; LANES], [z; LANES]]);
        let [x, y, z] = pose.translation.into();
        Self {
            wide_columns: wide(&columns),
            wide_absolute: wide(&absolute),
            columns,
            absolute,
            translation: [x as f32, y as f32, z as f32, 0.0],
            rounding: (farthest * ROUNDING_SHARE) as f32,
        }
    }

    /// Rounding error of gaps between boxes of the two frames \[m\].
    #[inline(always)]
    pub fn rounding(&self) -> f32 {
        self.rounding
    }

    /// Prepares a box of the other frame for tests whether boxes are nearer than `limit` \[m\].
    #[inline(always)]
    pub fn see(&self, other: &Cuboid, limit: f32) -> Seen {
        let (r, m, c, h) = (&self.columns, &self.absolute, &other.center, &other.half);
        let (alone, limit) = (limit.min(MAX_LIMIT_M), limit + self.rounding);
        let mut seen = Seen {
            limit: alone,
            is_wide: alone > WIDE_LIMIT_SHARE * other.size(),
            center: self.translation,
            own: [h[0] + limit, h[1] + limit, h[2] + limit],
            face: [limit; 4],
            edge: [[limit; 4]; 3],
        };
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            for i in 0..4 {
                seen.center[i] += r[j][i] * c[j];
                seen.face[i] += m[j][i] * h[j];
                seen.edge[j][i] += h[j1] * m[j2][i] + h[j2] * m[j1][i];
            }
        }
        seen
    }
}

/// Lanes with `values` below `limit`, one bit each. Lanes without a box are never below.
#[inline(always)]
pub fn below(values: &Lanes, limit: f32) -> u32 {
    let limit = limit.min(f32::MAX);
    let mut rest = *values;
    for value in &mut rest {
        *value -= limit;
    }
    negative(&rest)
}

// Loops and functions replace closures and `map`, which are not inlined reliably and are then
// compiled for the least processor.

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[Lanes; 3], at: usize) -> [F32s<S>; 3] {
    [F32s::load(simd, &lanes[0], at), F32s::load(simd, &lanes[1], at), F32s::load(simd, &lanes[2], at)]
}

/// Sum of the squares of positive gaps.
#[inline(always)]
fn squared<S: Simd>(simd: S, gaps: &[F32s<S>; 3]) -> F32s<S> {
    let mut sum = F32s::splat(simd, 0.0);
    for gap in gaps {
        let positive = gap.max(F32s::splat(simd, 0.0));
        sum = sum + positive * positive;
    }
    sum
}

/// One register of boxes: offsets from their centres to that of the tested box, and their half
/// sides.
struct Part<S: Simd> {
    offset: [F32s<S>; 3],
    half: [F32s<S>; 3],
}

impl Boxes {
    /// Makes boxes around at most eight `bounds`; the other lanes stay empty.
    pub fn new(bounds: &[Aabb]) -> Self {
        let mut all = Self { center: [[0.0; LANES]; 3], half: [[NO_BOX_HALF_SIDE_M; LANES]; 3] };
        for (lane, bounds) in bounds.iter().enumerate() {
            let cuboid = Cuboid::around(bounds);
            for i in 0..3 {
                all.center[i][lane] = cuboid.center[i];
                all.half[i][lane] = cuboid.half[i];
            }
        }
        all
    }

    pub fn get(&self, lane: usize) -> Cuboid {
        Cuboid {
            center: [self.center[0][lane], self.center[1][lane], self.center[2][lane]],
            half: [self.half[0][lane], self.half[1][lane], self.half[2][lane]],
        }
    }

    #[inline(always)]
    fn part<S: Simd>(&self, simd: S, seen: &Seen, at: usize) -> Part<S> {
        let [x, y, z] = load(simd, &self.center, at);
        let offset = [
            F32s::splat(simd, seen.center[0]) - x,
            F32s::splat(simd, seen.center[1]) - y,
            F32s::splat(simd, seen.center[2]) - z,
        ];
        Part { offset, half: load(simd, &self.half, at) }
    }

    /// Returns the boxes that may be nearer than the limit to the tested one, one bit a lane. Also
    /// returns the widest gap \[m\] along a face axis, less the limit.
    ///
    /// # Source
    /// S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996,
    /// doi:10.1145/237170.237244: fifteen separating axes.
    #[inline(always)]
    pub fn near<S: Simd>(&self, simd: S, view: &View, seen: &Seen) -> (u32, Lanes) {
        let mut gaps = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            let [own, other] = self.part(simd, seen, at).face_gaps(simd, view, seen);
            let widest = own[0].max(own[1]).max(own[2]).max(other[0].max(other[1]).max(other[2]));
            widest.store(&mut gaps, at);
        }
        let mut mask = negative(&gaps);
        if mask != 0 && seen.is_wide {
            mask &= self.within(simd, view, seen);
        }
        if mask == 0 {
            return (0, gaps);
        }
        let mut edges = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            self.part(simd, seen, at).widest_edge_gap(simd, view, seen).store(&mut edges, at);
        }
        (mask & negative(&edges), gaps)
    }

    /// Boxes that may be nearer than the limit, judged by distances: the gaps along three
    /// orthogonal axes, combined as a vector.
    #[inline(always)]
    fn within<S: Simd>(&self, simd: S, view: &View, seen: &Seen) -> u32 {
        let limit = F32s::splat(simd, seen.limit);
        // The sums have relative rounding errors.
        let less = F32s::splat(simd, 1.0 - 2e-6);
        let mut rest = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            let [mut own, mut other] = self.part(simd, seen, at).face_gaps(simd, view, seen);
            for k in 0..3 {
                (own[k], other[k]) = (own[k] + limit, other[k] + limit);
            }
            let squares = squared(simd, &own).max(squared(simd, &other)) * less;
            (squares - limit * limit).store(&mut rest, at);
        }
        negative(&rest)
    }

    /// Lower bounds \[m\] on the distances from the contents of the boxes to those of the tested
    /// one (with limit 0). Negative if two boxes overlap along all face axes.
    #[inline(always)]
    pub fn lower_bounds<S: Simd>(&self, simd: S, view: &View, seen: &Seen) -> Lanes {
        let zero = F32s::splat(simd, 0.0);
        // The sums and the root have relative rounding errors.
        let less = F32s::splat(simd, 1.0 - 1e-6);
        let mut bounds = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            let [own, other] = self.part(simd, seen, at).face_gaps(simd, view, seen);
            let distance = squared(simd, &own).max(squared(simd, &other)).sqrt() * less;
            let widest = own[0].max(own[1]).max(own[2]).max(other[0].max(other[1]).max(other[2]));
            // The distance is 0 if no gap is positive. If one is, the widest adds nothing.
            (distance + widest.min(zero)).store(&mut bounds, at);
        }
        bounds
    }

    /// Boxes that overlap the axis-aligned one from `lower` to `upper` \[m\] in this frame, one bit
    /// a lane.
    #[inline(always)]
    pub fn overlaps<S: Simd>(&self, simd: S, lower: &[f32; 3], upper: &[f32; 3]) -> u32 {
        let mut gaps = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            let (center, half) = (load(simd, &self.center, at), load(simd, &self.half, at));
            let mut widest = F32s::splat(simd, f32::NEG_INFINITY);
            for i in 0..3 {
                let (lower, upper) = (F32s::splat(simd, lower[i]), F32s::splat(simd, upper[i]));
                widest = widest.max((lower - center[i]).max(center[i] - upper) - half[i]);
            }
            widest.store(&mut gaps, at);
        }
        negative(&gaps)
    }

    /// Lower bounds [m^2] on the squared distances from `point` to the contents of the boxes;
    /// `rounding` as in [`rounding_at`].
    #[inline(always)]
    pub fn distances_squared<S: Simd>(&self, simd: S, point: &[f32; 3], rounding: f32) -> Lanes {
        let zero = F32s::splat(simd, 0.0);
        let less = F32s::splat(simd, 1.0 - 1e-6);
        let rounding = F32s::splat(simd, rounding);
        let mut squares = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            let (center, half) = (load(simd, &self.center, at), load(simd, &self.half, at));
            let mut square = zero;
            for i in 0..3 {
                let offset = F32s::splat(simd, point[i]) - center[i];
                let gap = (offset.abs() - half[i] - rounding).max(zero);
                square = square + gap * gap;
            }
            (square * less).store(&mut squares, at);
        }
        squares
    }

    /// Boxes that a ray from `origin` may meet, one bit a lane. `inverse` contains the reciprocals
    /// of its direction; `rounding` is as in [`rounding_at`].
    #[inline(always)]
    pub fn met_by<S: Simd>(&self, simd: S, origin: &[f32; 3], inverse: &[f32; 3], rounding: f32) -> u32 {
        let mut gaps = [0.0; LANES];
        for at in 0..F32s::<S>::COUNT {
            let (center, half) = (load(simd, &self.center, at), load(simd, &self.half, at));
            let mut enters = F32s::splat(simd, 0.0);
            let mut leaves = F32s::splat(simd, f32::INFINITY);
            for i in 0..3 {
                let inverse = F32s::splat(simd, inverse[i]);
                let middle = (center[i] - F32s::splat(simd, origin[i])) * inverse;
                let reach = (half[i] + F32s::splat(simd, rounding)) * inverse.abs();
                enters = enters.max(middle - reach);
                leaves = leaves.min(middle + reach);
            }
            (enters - leaves).store(&mut gaps, at);
        }
        negative(&gaps)
    }
}

impl<S: Simd> Part<S> {
    /// Gaps \[m\] along the face axes of the boxes and of the tested box.
    #[inline(always)]
    fn face_gaps(&self, simd: S, view: &View, seen: &Seen) -> [[F32s<S>; 3]; 2] {
        let (t, h) = (&self.offset, &self.half);
        let mut gaps = [[F32s::splat(simd, 0.0); 3]; 2];
        for k in 0..3 {
            let (r, m) = (load(simd, &view.wide_columns[k], 0), load(simd, &view.wide_absolute[k], 0));
            let along = t[0] * r[0] + t[1] * r[1] + t[2] * r[2];
            let reach = h[0] * m[0] + h[1] * m[1] + h[2] * m[2];
            gaps[0][k] = t[k].abs() - h[k] - F32s::splat(simd, seen.face[k]);
            gaps[1][k] = along.abs() - reach - F32s::splat(simd, seen.own[k]);
        }
        gaps
    }

    /// Widest gap along the cross products of edges. Those of nearly parallel axes are shorter than
    /// unit length, so using the full limit is conservative.
    #[inline(always)]
    fn widest_edge_gap(&self, simd: S, view: &View, seen: &Seen) -> F32s<S> {
        let (t, h) = (&self.offset, &self.half);
        let mut widest = F32s::splat(simd, f32::NEG_INFINITY);
        for j in 0..3 {
            let (r, m) = (load(simd, &view.wide_columns[j], 0), load(simd, &view.wide_absolute[j], 0));
            for i in 0..3 {
                let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
                let reach = h[i1] * m[i2] + h[i2] * m[i1] + F32s::splat(simd, seen.edge[j][i]);
                widest = widest.max((t[i2] * r[i1] - t[i1] * r[i2]).abs() - reach);
            }
        }
        widest
    }
}

/// Rounding error \[m\] of gaps between `point` and boxes within `bounds`.
pub fn rounding_at(point: &Vec3, bounds: &Cuboid) -> f32 {
    ((point.norm() + bounds.farthest_squared().sqrt()) * ROUNDING_SHARE) as f32
}

/// Least `f32` above `limit` rounded to `f32`, hence no smaller than `limit`.
#[inline(always)]
pub fn rounded_up(limit: f64) -> f32 {
    (limit as f32).next_up()
}

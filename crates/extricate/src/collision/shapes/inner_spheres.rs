//! Balls inside solids, the overlap of which proves that the solids overlap. They never prove that
//! solids are apart.

use super::{ConvexSolid, Shape, ShapeKind};
use crate::math::{LANES, Pose, Vec3, vectorized};

/// Cells along the longest side of a box in the grid that is searched for balls.
const MAX_GRID_CELLS: usize = 10;
/// Overlap \[m\] from which balls decide. It exceeds the error of the exact tests, so that they
/// would agree.
const OVERLAP_MARGIN_M: f64 = 1e-8;

/// Up to eight balls inside a shape, in its frame, largest first.
#[derive(Debug, Clone)]
pub struct InnerSpheres {
    centers: [[f64; LANES]; 3],
    /// Radii \[m\]. In unused lanes they are so far below 0 that no sum with another radius is
    /// positive.
    radii: [f64; LANES],
    count: usize,
}

impl Default for InnerSpheres {
    fn default() -> Self {
        Self { centers: [[0.0; LANES]; 3], radii: [f64::MIN; LANES], count: 0 }
    }
}

impl InnerSpheres {
    /// Searches a grid for balls inside the shape; open surfaces contain none.
    pub fn of(shape: &Shape) -> Self {
        let (bounds, stack) = (&shape.bounds, &mut Vec::new());
        let depth = |point: &Vec3| shape.depth_above(point, 0.0, stack).unwrap_or(0.0);
        let found = largest_balls(&(bounds.center - bounds.half), &(bounds.center + bounds.half), LANES, depth);
        let mut balls = Self { count: found.len(), ..Self::default() };
        for (lane, (center, radius)) in found.into_iter().enumerate() {
            (0..3).for_each(|axis| balls.centers[axis][lane] = center[axis]);
            balls.radii[lane] = radius;
        }
        balls
    }

    /// Centres and radii \[m\], largest first.
    pub fn iter(&self) -> impl Iterator<Item = (Vec3, f64)> {
        let center = |lane: usize| Vec3::from_fn(|axis, _| self.centers[axis][lane]);
        (0..self.count).map(move |lane| (center(lane), self.radii[lane]))
    }
}

/// Largest balls in a solid, at most `most`, largest first: `(centre, radius)` \[m\]. Two centres
/// are farther apart than 0.7 radii of the larger ball. `depth` returns the depth of a point in the
/// solid. Centres lie on a grid between two corners.
pub fn largest_balls(low: &Vec3, high: &Vec3, most: usize, mut depth: impl FnMut(&Vec3) -> f64) -> Vec<(Vec3, f64)> {
    let size = high - low;
    let cell = size.max() / MAX_GRID_CELLS as f64;
    // The quotient is arbitrary for sizes near the least number.
    let cells = |axis: usize| ((size[axis] / cell).ceil() as usize).clamp(1, MAX_GRID_CELLS);
    let (nx, ny, nz) = (cells(0), cells(1), cells(2));
    let mut inside = Vec::new();
    for at in 0..nx * ny * nz {
        let place = [(at / (ny * nz), nx), (at / nz % ny, ny), (at % nz, nz)];
        let center = Vec3::from_fn(|axis, _| {
            let (index, count) = place[axis];
            low[axis] + (index as f64 + 0.5) / count as f64 * size[axis]
        });
        let radius = depth(&center);
        if radius > 0.0 {
            inside.push((center, radius));
        }
    }
    inside.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut chosen: Vec<(Vec3, f64)> = Vec::new();
    for (center, radius) in inside {
        if chosen.len() < most && chosen.iter().all(|(other, r)| (other - center).norm() > 0.7 * r) {
            chosen.push((center, radius));
        }
    }
    chosen
}

/// Whether the signed distance of two solids is proved below `limit` \[m\] (at least 0). Balls in
/// both must come that near. If the depth in one solid has a closed form, a ball in the other must
/// come that near to it.
pub fn proves_nearer(
    (a, in_a): (&Shape, &InnerSpheres),
    (b, in_b): (&Shape, &InnerSpheres),
    pose_a_b: &Pose,
    limit: f64,
) -> bool {
    match (&a.kind, &b.kind) {
        (_, ShapeKind::Convex(solid)) if solid.is_primitive() => {
            in_a.iter().any(|(center, radius)| reaches(solid, &pose_a_b.inverse_point(&center), radius, limit))
        }
        (ShapeKind::Convex(solid), _) if solid.is_primitive() => {
            in_b.iter().any(|(center, radius)| reaches(solid, &pose_a_b.point(&center), radius, limit))
        }
        _ => vectorized(
            #[inline(always)]
            || some_overlap(in_a, in_b, pose_a_b, limit),
        ),
    }
}

fn reaches(solid: &ConvexSolid, center: &Vec3, radius: f64, limit: f64) -> bool {
    solid.depth(center) + radius + limit > OVERLAP_MARGIN_M
}

#[inline(always)]
fn some_overlap(a: &InnerSpheres, b: &InnerSpheres, pose_a_b: &Pose, limit: f64) -> bool {
    for (center, radius) in b.iter() {
        let [x, y, z] = pose_a_b.point(&center).into();
        let more = radius + limit - OVERLAP_MARGIN_M;
        let mut gap = f64::INFINITY;
        for lane in 0..LANES {
            let offset = [a.centers[0][lane] - x, a.centers[1][lane] - y, a.centers[2][lane] - z];
            let reach = (a.radii[lane] + more).max(0.0);
            let squared = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
            gap = gap.min(squared - reach * reach);
        }
        if gap < 0.0 {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::narrow_phase::pair::surfaces_nearer;
    use crate::collision::narrow_phase::{Buffers, SeparatingWitness, proved_nearer};
    use crate::collision::prepared::{Placed, PreparedShape};
    use crate::collision::shapes::bounds::Relative;
    use crate::collision::shapes::test_mesh::{bumpy, cuboid, joined, opened, placed};
    use crate::robot::Geometry;
    use rand::{RngExt, SeedableRng};
    use std::sync::Arc;

    #[test]
    fn what_balls_prove_the_exact_tests_say_too() {
        let mesh = |mesh| Geometry::Mesh(Arc::new(mesh));
        let two = joined(&[placed(bumpy(3, 1, 0.3), 0.3, Vec3::x()), cuboid(Vec3::zeros(), Vec3::new(0.2, 0.9, 0.4))]);
        let shapes = [
            mesh(bumpy(1, 2, 0.5)),
            mesh(two),
            mesh(opened(bumpy(2, 2, 0.9), 40)),
            Geometry::ConvexHull(Arc::new(bumpy(4, 1, 0.2))),
            Geometry::Box { half_extents: [0.3, 0.6, 0.9] },
            Geometry::Cylinder { radius: 0.3, half_length: 0.8 },
            Geometry::Capsule { radius: 0.3, half_length: 0.5 },
            Geometry::Sphere { radius: 0.7 },
        ]
        .map(|geometry| PreparedShape::new(&geometry).unwrap());
        assert_eq!(shapes[2].inner.count, 0, "an open mesh holds nothing");
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(12);
        let (mut proved, mut near, mut buffers) = (0, 0, Buffers::default());
        for round in 0..20_000 {
            let mut vector = |scale: f64| Vec3::from_fn(|_, _| scale * (rng.random::<f64>() - 0.5));
            let pose = Pose::from_xyz_rpy(vector(3.0).into(), vector(6.0).into());
            let (a, b) = (&shapes[round % 8], &shapes[round / 8 % 8]);
            let first = Placed { prepared: a, pose: &Pose::identity() };
            let second = Placed { prepared: b, pose: &pose };
            let limit = [0.0, 1e-4, 0.2][round % 3];
            let relative = Relative::new(pose);
            let expected =
                surfaces_nearer(first, second, &relative, limit, &mut SeparatingWitness::default(), &mut buffers);
            let found = proved_nearer(first, second, limit);
            assert!(expected || !found, "{round}");
            proved += usize::from(found);
            near += usize::from(expected);
        }
        assert!(proved > near / 3 && near > 4000, "{proved} of {near}");
    }
}

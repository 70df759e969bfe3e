//! Merges coincident vertices; `components` then decides which triangles stay.

use std::collections::HashMap;

use crate::math::Vec3;

/// Share of the bounding box's diagonal below which two vertices are one. It is far below what f32
/// resolves (6e-8), so it undoes the rounding of a transform, but never a feature. `seams` closes
/// what files in f32 leave open.
const WELD_DIAGONAL_SHARE: f64 = 1e-9;

/// Width of a grid cell, in tolerances. It is so wide that most vertices search one cell only, and
/// so narrow that a cell holds at most some thousand, which are all compared.
const CELL_TOLERANCES: f64 = 16.0;

/// Returns the representatives of `points`, in order of first appearance, and for each point the
/// index of its representative.
///
/// # Guarantee
/// Representatives are at least 1e-9 of the bounding box's diagonal apart, and each point is nearer
/// than that to its own. A representative is an unchanged input point, but for -0.0, which becomes
/// 0.0.
pub(crate) fn weld(points: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    let (low, high) = bounds(points);
    let diagonal = (high - low).norm();
    weld_within(points, if diagonal.is_finite() { WELD_DIAGONAL_SHARE * diagonal } else { 0.0 })
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let none = Vec3::repeat(f64::INFINITY);
    points.iter().fold((none, -none), |(low, high), point| (low.inf(point), high.sup(point)))
}

/// As [`weld`], within `tolerance` \[m\].
pub(crate) fn weld_within(points: &[Vec3], tolerance: f64) -> (Vec<Vec3>, Vec<u32>) {
    let (low, _) = bounds(points);
    let mut exact: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len() / 4);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut kept: Vec<Vec3> = Vec::new();
    let mut map = Vec::with_capacity(points.len());
    // Without a tolerance the grid is not used, and its cells would have no width.
    let inverse_width = if tolerance > 0.0 { 1.0 / (CELL_TOLERANCES * tolerance) } else { 0.0 };
    let cell = |point: &Vec3| [0, 1, 2].map(|k| ((point[k] - low[k]) * inverse_width).floor() as i64);
    for point in points {
        let point = point.map(|x| x + 0.0);
        let bits = [point.x.to_bits(), point.y.to_bits(), point.z.to_bits()];
        let index = *exact.entry(bits).or_insert_with(|| {
            let near = if tolerance > 0.0 { nearby(&point, tolerance, &kept, &grid, cell) } else { None };
            near.unwrap_or_else(|| {
                kept.push(point);
                if tolerance > 0.0 {
                    grid.entry(cell(&point)).or_default().push(kept.len() as u32 - 1);
                }
                kept.len() as u32 - 1
            })
        });
        map.push(index);
    }
    (kept, map)
}

/// The earliest kept point nearer than `tolerance`.
fn nearby(
    point: &Vec3,
    tolerance: f64,
    kept: &[Vec3],
    grid: &HashMap<[i64; 3], Vec<u32>>,
    cell: impl Fn(&Vec3) -> [i64; 3],
) -> Option<u32> {
    let (first, last) = (cell(&point.add_scalar(-tolerance)), cell(&point.add_scalar(tolerance)));
    let mut found = None;
    for x in first[0]..=last[0] {
        for y in first[1]..=last[1] {
            for z in first[2]..=last[2] {
                for &index in grid.get(&[x, y, z]).into_iter().flatten() {
                    if (kept[index as usize] - point).norm() < tolerance && found.is_none_or(|f| index < f) {
                        found = Some(index);
                    }
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn agrees_with_comparing_all_pairs() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut points = vec![Vec3::zeros(), Vec3::repeat(1.0)];
        for _ in 0..300 {
            let point = Vec3::from_fn(|_, _| rng.random::<f64>());
            points.push(point);
            points.push(point + Vec3::from_fn(|_, _| 3e-9 * (rng.random::<f64>() - 0.5)));
        }
        let tolerance = 1e-9 * 3f64.sqrt();
        let (kept, map) = weld(&points);
        let mut slow: Vec<Vec3> = Vec::new();
        for (point, index) in points.iter().zip(map) {
            let near = slow.iter().position(|k| (k - point).norm() < tolerance);
            let expected = near.unwrap_or_else(|| {
                slow.push(*point);
                slow.len() - 1
            });
            assert_eq!(index as usize, expected);
        }
        assert_eq!(kept, slow);
        assert!(kept.len() > 310 && kept.len() < 600, "both cases must occur: {}", kept.len());
    }

    #[test]
    fn the_sign_of_zero_does_not_matter() {
        let (kept, map) = weld(&[Vec3::new(0.0, -0.0, 1.0), Vec3::new(-0.0, 0.0, 1.0)]);
        assert_eq!((kept.len(), map), (1, vec![0, 0]));
        assert!(weld(&[]).0.is_empty());
    }
}

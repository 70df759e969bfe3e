//! Support function of a point set in nearly constant time. Directions are sorted into cells of a
//! cube map. Each cell keeps only the points that can be farthest for some direction in it.

use crate::math::Vec3;

/// Lanes of a block: few enough that a cell rarely holds padding, enough for the compiler to
/// vectorise.
const LANES: usize = 8;
/// Margin of a cell in cube map coordinates, which run from -1 to 1. Far above the rounding of a
/// look-up.
const CELL_MARGIN: f64 = 1e-9;

/// Points that span a convex hull; interior points and duplicates are allowed.
///
/// # Cost
/// A support query scans one or two blocks of 8 points, whatever the number of points. The memory
/// is a few times that of the points.
#[derive(Debug, Clone)]
pub struct HullPoints {
    points: Vec<Vec3>,
    center: Vec3,
    reach: f64,
    /// Cells along an edge of a cube face.
    resolution: usize,
    /// Block range `[start, end)` of each cell: cube face, row, column.
    cells: Vec<[u32; 2]>,
    blocks: Vec<Block>,
}

/// Eight points as a structure of arrays \[m\]; short blocks repeat a point.
#[derive(Debug, Clone, Copy)]
struct Block {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
}

impl HullPoints {
    /// Prepares the support function of at least one point \[m\].
    ///
    /// # Panics
    /// If `points` is empty.
    pub fn new(points: &[Vec3]) -> Self {
        assert!(!points.is_empty(), "a hull needs at least one point");
        let low = points.iter().fold(points[0], |low, p| low.inf(p));
        let high = points.iter().fold(points[0], |high, p| high.sup(p));
        let reach = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
        // About as many cells as points, which leaves one or two blocks a cell.
        let levels = match points.len() {
            0..=8 => 0,
            9..=40 => 1,
            41..=160 => 2,
            161..=640 => 3,
            _ => 4,
        };
        let resolution = 1 << levels;
        let mut hull = Self {
            points: points.to_vec(),
            center: (low + high) * 0.5,
            reach,
            resolution,
            cells: vec![[0, 0]; 6 * resolution * resolution],
            blocks: Vec::new(),
        };
        let all: Vec<u32> = (0..points.len() as u32).collect();
        for face in 0..6 {
            hull.divide(face, [0, 0], resolution, &all);
        }
        hull
    }

    /// The points, as given \[m\].
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Middle of the bounding box \[m\].
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// Distance from the origin to the farthest point \[m\].
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Point farthest along `direction` (of any length) \[m\].
    #[inline(always)]
    pub fn support(&self, direction: &Vec3) -> Vec3 {
        let [start, end] = self.cells[self.cell(direction)];
        farthest(&self.blocks[start as usize..end as usize], direction)
    }

    /// Cell that contains `direction`; any cell if the direction is zero or not finite.
    #[inline(always)]
    fn cell(&self, d: &Vec3) -> usize {
        // No branches on the direction: they would be unpredictable.
        let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
        let axis = usize::from((x < y) | (x < z)) * (1 + usize::from(y < z));
        let around = [d.x, d.y, d.z, d.x, d.y];
        let (main, u, v) = (around[axis], around[axis + 1], around[axis + 2]);
        let half = 0.5 * self.resolution as f64;
        let scale = half / main.abs();
        let last = self.resolution - 1;
        // A float cast saturates, and sends NaN to 0.
        let row = ((u * scale + half) as usize).min(last);
        let column = ((v * scale + half) as usize).min(last);
        ((2 * axis + usize::from(main < 0.0)) * self.resolution + row) * self.resolution + column
    }

    /// Fills the square of `span` x `span` cells at `corner` of a cube face. Halves the square
    /// until its points fit one block.
    fn divide(&mut self, face: usize, corner: [usize; 2], span: usize, candidates: &[u32]) {
        let kept = undominated(&self.points, &self.corner_directions(face, corner, span), candidates);
        if span > 1 && kept.len() > LANES {
            let half = span / 2;
            for [row, column] in [[0, 0], [0, half], [half, 0], [half, half]] {
                self.divide(face, [corner[0] + row, corner[1] + column], half, &kept);
            }
            return;
        }
        let start = self.blocks.len() as u32;
        for chunk in kept.chunks(LANES) {
            let lane = |k: usize| self.points[chunk[k.min(chunk.len() - 1)] as usize];
            self.blocks.push(Block {
                x: std::array::from_fn(|k| lane(k).x),
                y: std::array::from_fn(|k| lane(k).y),
                z: std::array::from_fn(|k| lane(k).z),
            });
        }
        let range = [start, self.blocks.len() as u32];
        for row in corner[0]..corner[0] + span {
            for column in corner[1]..corner[1] + span {
                self.cells[(face * self.resolution + row) * self.resolution + column] = range;
            }
        }
    }

    /// The four directions that span the widened square.
    fn corner_directions(&self, face: usize, corner: [usize; 2], span: usize) -> [Vec3; 4] {
        let (axis, sign) = (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 });
        let along = |cell: usize, margin: f64| 2.0 * cell as f64 / self.resolution as f64 - 1.0 + margin;
        let [u0, v0] = corner.map(|cell| along(cell, -CELL_MARGIN));
        let [u1, v1] = corner.map(|cell| along(cell + span, CELL_MARGIN));
        [[u0, v0], [u0, v1], [u1, v0], [u1, v1]].map(|[u, v]| {
            let mut direction = Vec3::zeros();
            direction[axis] = sign;
            direction[(axis + 1) % 3] = u;
            direction[(axis + 2) % 3] = v;
            direction
        })
    }
}

/// Candidates that no other candidate beats at all four corners. Directions of a cell are positive
/// combinations of its corners. A point that beats another at all corners therefore beats it in the
/// whole cell.
fn undominated(points: &[Vec3], corners: &[Vec3; 4], candidates: &[u32]) -> Vec<u32> {
    let mut heights: Vec<([f64; 4], u32)> =
        candidates.iter().map(|&i| (corners.map(|corner| corner.dot(&points[i as usize])), i)).collect();
    // A point that beats another has the larger sum, hence comes first; being beaten is transitive.
    let sum = |h: &[f64; 4]| h.iter().sum::<f64>();
    heights.sort_by(|a, b| sum(&b.0).total_cmp(&sum(&a.0)).then(a.1.cmp(&b.1)));
    let mut kept: Vec<([f64; 4], u32)> = Vec::new();
    for (height, i) in heights {
        let beaten = |(other, j): &([f64; 4], u32)| {
            (0..4).all(|k| other[k] > height[k]) || points[*j as usize] == points[i as usize]
        };
        if !kept.iter().any(beaten) {
            kept.push((height, i));
        }
    }
    kept.into_iter().map(|(_, i)| i).collect()
}

#[inline(always)]
fn farthest(blocks: &[Block], d: &Vec3) -> Vec3 {
    let (mut best, mut best_height) = (Vec3::zeros(), f64::NEG_INFINITY);
    for block in blocks {
        let heights: [f64; LANES] = std::array::from_fn(|k| block.x[k] * d.x + block.y[k] * d.y + block.z[k] * d.z);
        let (lane, height) = highest(&heights);
        if height > best_height {
            (best, best_height) = (Vec3::new(block.x[lane], block.y[lane], block.z[lane]), height);
        }
    }
    best
}

/// Returns the first lane with the maximum, and the maximum. Written to compile to vector maxima
/// and a mask: one mispredicted branch costs more than the rest.
#[inline(always)]
fn highest(heights: &[f64; LANES]) -> (usize, f64) {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let four: [f64; 4] = std::array::from_fn(|k| larger(heights[k], heights[k + 4]));
    let best = larger(larger(four[0], four[2]), larger(four[1], four[3]));
    let lanes = (0..LANES).fold(0_u32, |lanes, k| lanes | u32::from(heights[k] == best) << k);
    (lanes.trailing_zeros() as usize % LANES, best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn support_is_the_plain_maximum() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for count in [1, 2, 4, 8, 9, 33, 200, 700] {
            let mut points: Vec<Vec3> = (0..count).map(|_| Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5)).collect();
            if count % 2 == 1 {
                // Points on a sphere with one duplicate, and points on a grid with many coplanar
                // ties.
                points.iter_mut().for_each(|p| *p = p.normalize());
                points.push(points[0]);
            } else if count > 100 {
                points.iter_mut().for_each(|p| *p = p.map(|x| (x * 8.0).round() / 8.0));
            }
            let hull = HullPoints::new(&points);
            for n in 0..2000 {
                let mut d = Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5);
                if n % 3 == 0 {
                    // Include directions exactly on cell borders.
                    d = d.map(|x| (x * 4.0).round());
                }
                let slow = points.iter().map(|p| p.dot(&d)).fold(f64::NEG_INFINITY, f64::max);
                assert!((hull.support(&d).dot(&d) - slow).abs() <= 1e-15 * d.norm(), "{count} {d}");
            }
        }
    }

    #[test]
    fn cells_stay_short() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let points: Vec<Vec3> = (0..200).map(|_| Vec3::from_fn(|_, _| rng.random::<f64>() - 0.5).normalize()).collect();
        let hull = HullPoints::new(&points);
        let scanned: usize = hull.cells.iter().map(|[start, end]| (end - start) as usize).sum();
        assert!(scanned < 2 * hull.cells.len(), "{scanned} blocks in {} cells", hull.cells.len());
    }

    #[test]
    fn odd_directions_do_not_panic() {
        let hull = HullPoints::new(&[Vec3::x(), Vec3::y(), Vec3::z()]);
        for x in [0.0, f64::NAN, f64::INFINITY, 1e-320] {
            hull.support(&Vec3::new(x, 0.0, 0.0));
        }
    }
}

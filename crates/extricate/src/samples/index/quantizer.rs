//! Stores the points of lists as approximations of one byte a coordinate. A search waits for
//! memory, and these take a quarter of it. Only near ones need the exact points (Weber, Schek and
//! Blott, "A quantitative analysis and performance study for similarity-search methods in
//! high-dimensional spaces", VLDB 1998).

use serde::{Deserialize, Serialize};

use crate::learning::svm::kernel::LANES;
use crate::math::linear_algebra::distance;

const MAX_CODE: f64 = 255.0;

/// Approximations of the members of lists.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Codes {
    dimensions: usize,
    /// List after list, each padded to whole blocks of one row of codes for each coordinate.
    codes: Vec<[u8; LANES]>,
    frames: Vec<Frame>,
    /// Least value of each coordinate, list after list.
    origins: Vec<f64>,
}

/// Scale of a list, whose codes mean `origin + step * code`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Frame {
    len: u32,
    step: f32,
    /// Bound as in [`ListCodes::moved`].
    moved: f64,
}

/// The codes of one list, scaled for one query.
#[derive(Clone, Copy)]
pub struct ListCodes<'a> {
    /// Block after block, a row of codes for each coordinate.
    pub blocks: &'a [[u8; LANES]],
    /// Points in the last block; the lanes beyond are padding.
    pub in_last: usize,
    /// Change of a coordinate for a change of its code by 1.
    pub step: f32,
    /// Bound on the distance of a point from what its codes mean, query rounding included.
    pub moved: f64,
}

impl Codes {
    /// Creates an empty set of lists.
    pub fn new(dimensions: usize) -> Self {
        Self { dimensions, ..Self::default() }
    }

    /// Appends a list of rows.
    pub fn push(&mut self, rows: &[&[f64]]) {
        let d = self.dimensions;
        let bound = |k: usize, start: f64, pick: fn(f64, f64) -> f64| rows.iter().map(|row| row[k]).fold(start, pick);
        let least: Vec<f64> = (0..d).map(|k| bound(k, f64::INFINITY, f64::min)).collect();
        let width = (0..d).map(|k| bound(k, f64::NEG_INFINITY, f64::max) - least[k]).fold(0.0, f64::max);
        // Rounded up, and normal; its rounding does no harm, since `moved` is measured.
        let step = ((width / MAX_CODE) as f32).next_up().max(1e-30);
        let first = self.codes.len();
        self.codes.resize(first + rows.len().div_ceil(LANES) * d, [0; LANES]);
        let (mut moved, mut stood_for) = (0.0_f64, vec![0.0; d]);
        for (i, row) in rows.iter().enumerate() {
            for (k, x) in row.iter().enumerate() {
                let code = ((x - least[k]) / f64::from(step)).round().clamp(0.0, MAX_CODE);
                self.codes[first + i / LANES * d + k][i % LANES] = code as u8;
                stood_for[k] = least[k] + f64::from(step) * code;
            }
            moved = moved.max(distance(row, &stood_for));
        }
        // For a near query, rounding it to `f32` moves it by little, compared to the list.
        let rounded = f64::from(step) * MAX_CODE * (d as f64).sqrt() * 2e-7;
        let moved = moved * (1.0 + 1e-9) + rounded + 1e-30;
        self.frames.push(Frame { len: rows.len() as u32, step, moved });
        self.origins.extend(least);
    }

    /// Appends the lists of `other`.
    pub fn append(&mut self, other: &Self) {
        self.codes.extend_from_slice(&other.codes);
        self.frames.extend_from_slice(&other.frames);
        self.origins.extend_from_slice(&other.origins);
    }

    /// Returns the codes of the list that begins at block `first`, and writes the query relative to
    /// its origin to `relative`.
    #[inline(always)]
    pub fn list(&self, list: usize, first: usize, query: &[f64], relative: &mut Vec<f32>) -> ListCodes<'_> {
        let Frame { len, step, moved } = self.frames[list];
        let len = len as usize;
        let origin = &self.origins[list * self.dimensions..][..self.dimensions];
        relative.clear();
        relative.extend(query.iter().zip(origin).map(|(x, o)| (x - o) as f32));
        let blocks = &self.codes[first * self.dimensions..][..len.div_ceil(LANES) * self.dimensions];
        ListCodes { blocks, in_last: len - len.saturating_sub(1) / LANES * LANES, step, moved }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Distances computed from codes are within their claimed error: for wide lists and single
    /// points, near zero and far from it, seen from near and from far.
    #[test]
    fn codes_tell_distances_within_what_they_claim() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (mut worst_share, mut relative) = (0.0_f64, Vec::new());
        for case in 0..400 {
            let d = 1 + case % 16;
            let (width, far) = ([0.0, 1e-6, 1.0, 50.0][case % 4], [0.0, 100.0][case / 4 % 2]);
            let mut row = |width: f64| -> Vec<f64> { (0..d).map(|_| far + width * rng.random::<f64>()).collect() };
            let rows: Vec<Vec<f64>> = (0..1 + case % 21).map(|_| row(width)).collect();
            let queries = [row(width), row(width + 1e-3), row(30.0 * width + 10.0), rows[0].clone()];
            let mut codes = Codes::new(d);
            codes.push(&[&row(1.0), &row(1.0)]);
            codes.push(&rows.iter().map(|row| &row[..]).collect::<Vec<_>>());
            for query in &queries {
                let list = codes.list(1, 1, query, &mut relative);
                assert_eq!(list.in_last, (rows.len() - 1) % LANES + 1);
                for (i, row) in rows.iter().enumerate() {
                    let block = &list.blocks[i / LANES * d..][..d];
                    let offset = |(codes, x): (&[u8; LANES], &f32)| f32::from(codes[i % LANES]) * list.step - x;
                    let squared: f32 = block.iter().zip(&relative).map(offset).map(|x| x * x).sum();
                    let (exact, squared) = (distance(row, query), f64::from(squared));
                    // The same as `Lists::relative_error`.
                    let error = (2 * d + 16) as f64 * 0.5 * f64::from(f32::EPSILON);
                    let (nearest, farthest) = ((squared * (1.0 - error)).sqrt(), (squared * (1.0 + error)).sqrt());
                    assert!(
                        nearest - list.moved <= exact && exact <= farthest + list.moved,
                        "{case}: {exact} {squared}"
                    );
                    worst_share = worst_share.max((squared.sqrt() - exact).abs() / (list.moved + error * exact));
                }
            }
        }
        assert!(
            worst_share > 0.5,
            "what is said to be off is {worst_share} of the bound at most: too wide to be of use"
        );
    }
}

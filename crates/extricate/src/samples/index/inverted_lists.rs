//! The data of the index: points in lists around k-means centres, and bounds on the distance to a
//! list. The search is elsewhere.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::kmeans::k_means;
use super::quantizer::Codes;
use crate::learning::svm::kernel::{LANES, PointSet, TOGETHER, block_distances_squared_of, vectorized};
use crate::math::linear_algebra::distance;

/// Unit roundoff of `f32`.
const ROUNDOFF: f64 = 1.0 / (1u64 << 24) as f64;

/// Marks a place without a point.
pub const PADDING: u32 = u32::MAX;

/// Points grouped into lists of near ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lists {
    /// Number of coordinates of a point.
    pub dimensions: usize,
    /// Number of points in all lists.
    pub len: usize,
    /// Codes of the points, list after list, each padded to whole blocks.
    pub codes: Codes,
    /// Id of the point at each place in `codes`; [`PADDING`] if there is none.
    pub ids: Vec<u32>,
    /// First block of each list, and the end of the last.
    pub starts: Vec<u32>,
    /// Centres of the lists, exactly representable in `f32`.
    pub centres: PointSet,
    /// Greatest distance of a member of each list from its centre, rounded up.
    pub radii: Vec<[f32; LANES]>,
    /// Slab of reference centre `r` and list `c`, at block `r * centres.block_count() + c / LANES`.
    pub slabs: Vec<Slab>,
    /// Greatest norm of a point; it bounds how far rounding to `f32` moves points.
    pub reach: f64,
}

/// How far members of eight lists `c` stay beyond the plane that bisects a centre `r` and theirs.
///
/// With `u` the unit vector from `r` to `c`, any member `x` and any query `q` have
/// `|q - x| >= u.(x - q) = (|x - r|^2 - |x - c|^2 - |q - r|^2 + |q - c|^2) / (2 |r - c|)`. This
/// bound needs no distances but those to the centres. With balls around the centres alone, a search
/// on a warped sphere scans 3 to 5 times as many points in 7 dimensions, and nearly all in 16. A
/// second reference centre would save 7 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slab {
    /// Least `|x - r|^2 - |x - c|^2` of a member, rounded down.
    pub margin: [f32; LANES],
    /// `1 / (2 |r - c|)`; 0 if the centres coincide or the list is empty.
    pub scale: [f32; LANES],
}

impl Lists {
    /// Sorts `points` (`n x dimensions`, row major, finite) into `lists <= n` lists.
    pub fn build(points: &[f64], dimensions: usize, lists: usize, seed: u64) -> Self {
        let (centres, assigned) = if lists > 0 { k_means(points, dimensions, lists, seed) } else { Default::default() };
        let members = members(&assigned, lists);
        let mut built = Self::sorted(points, dimensions, &centres, &members);
        built.slabs = built.slabs(&centres, &built.measure_margins(&centres, &members, points));
        built
    }

    /// Rebuilds lists from known assignments, with the centres and margins of an earlier build.
    pub fn again(points: &[f64], dimensions: usize, centres: &[f64], assigned: &[u32], margins: &[f32]) -> Self {
        let members = members(assigned, centres.len() / dimensions);
        let mut built = Self::sorted(points, dimensions, centres, &members);
        built.slabs = built.slabs(centres, margins);
        built
    }

    /// Builds the lists, without slabs.
    fn sorted(points: &[f64], dimensions: usize, centres: &[f64], members: &[Vec<u32>]) -> Self {
        let lists = members.len();
        let row = |i: u32| &points[i as usize * dimensions..][..dimensions];
        let (mut ids, mut starts) = (Vec::new(), vec![0]);
        for list in members {
            ids.extend(list);
            ids.resize(ids.len().next_multiple_of(LANES), PADDING);
            starts.push((ids.len() / LANES) as u32);
        }
        let of_list = |(c, list): (usize, &Vec<u32>)| {
            let mut codes = Codes::new(dimensions);
            codes.push(&list.iter().map(|id| row(*id)).collect::<Vec<_>>());
            let centre = &centres[c * dimensions..][..dimensions];
            (codes, list.iter().map(|id| distance(row(*id), centre)).fold(0.0, f64::max))
        };
        let coded: Vec<(Codes, f64)> = members.par_iter().enumerate().map(of_list).collect();
        let (mut codes, mut radii) = (Codes::new(dimensions), vec![[0.0; LANES]; lists.div_ceil(LANES)]);
        for (c, (list, radius)) in coded.iter().enumerate() {
            codes.append(list);
            radii[c / LANES][c % LANES] = (radius * (1.0 + 1e-6)) as f32;
        }
        Self {
            dimensions,
            len: points.len() / dimensions,
            codes,
            ids,
            starts,
            radii,
            slabs: Vec::new(),
            centres: PointSet::from_rows_padded(centres, dimensions, f32::INFINITY),
            reach: points.chunks_exact(dimensions).map(norm).fold(0.0, f64::max),
        }
    }

    /// Bound on the relative error of a squared distance in `f32`, with a margin for the few
    /// operations that follow it.
    pub fn relative_error(&self) -> f64 {
        (2 * self.dimensions + 16) as f64 * ROUNDOFF
    }

    /// Bounds how far rounding to `f32` can move a point and the query together.
    pub fn moved_by_rounding(&self, query: &[f64]) -> f64 {
        (self.reach + norm(query)) * ROUNDOFF * 1.01 + 1e-30
    }

    /// Returns a lower bound on the distance from a query to the members of list `c`. It takes the
    /// squared `f32` distances to the centres of a reference list `r` and of `c`, and the result of
    /// [`Lists::moved_by_rounding`].
    pub fn bound(&self, (to_reference, r): (f32, u32), (to_centre, c): (f32, u32), moved: f64) -> f32 {
        let (block, lane) = (c as usize / LANES, c as usize % LANES);
        let slab = &self.slabs[r as usize * self.centres.block_count() + block];
        let error = self.relative_error() as f32;
        let ball = (to_centre * (1.0 - error)).sqrt() - self.radii[block][lane];
        let uncertain = error * (to_reference + to_centre);
        let plane = (slab.margin[lane] - to_reference + to_centre - uncertain) * slab.scale[lane];
        // The factor covers the rounding of the lines above.
        ball.max(plane) * (1.0 - 1e-6) - moved as f32
    }

    /// Returns the margins of all [`Slab`]s, at `r * lists + c` for reference centre `r` and list
    /// `c`; infinite if a list is empty. A single list has none.
    fn measure_margins(&self, centres: &[f64], members: &[Vec<u32>], points: &[f64]) -> Vec<f32> {
        let (d, count, blocks) = (self.dimensions, self.centres.len(), self.centres.block_count());
        if count < 2 {
            return Vec::new();
        }
        let error = self.relative_error() as f32;
        let margins = |c: usize| {
            let centre = gather_block(&centres[c * d..][..d]);
            let (mut least, mut rows) = (vec![[f32::INFINITY; LANES]; blocks], vec![0.0; TOGETHER * d]);
            for ids in members[c].chunks(TOGETHER) {
                for (i, row) in rows.chunks_exact_mut(d).enumerate() {
                    // The last chunk may be short; repeating its first member changes nothing.
                    let exact = &points[*ids.get(i).unwrap_or(&ids[0]) as usize * d..][..d];
                    row.iter_mut().zip(exact).for_each(|(rounded, x)| *rounded = *x as f32);
                }
                let (least, rows, centre) = (&mut least[..], &rows[..], &centre[..]);
                vectorized(
                    #[inline(always)]
                    move || {
                        let rows = std::array::from_fn(|i| &rows[i * d..][..d]);
                        let own = block_distances_squared_of(centre, rows);
                        for (least, block) in least.iter_mut().zip(self.centres.blocks(0, blocks)) {
                            let squared = block_distances_squared_of(block, rows);
                            for (squared, own) in squared.iter().zip(&own) {
                                for lane in 0..LANES {
                                    let margin = squared[lane] * (1.0 - error) - own[lane] * (1.0 + error);
                                    least[lane] = if margin < least[lane] { margin } else { least[lane] };
                                }
                            }
                        }
                    },
                );
            }
            least
        };
        let of_list: Vec<Vec<[f32; LANES]>> = (0..count).into_par_iter().map(margins).collect();
        let margin = |i: usize| {
            let (r, c) = (i / count, i % count);
            let margin = of_list[c][r / LANES][r % LANES];
            // Rounded down.
            margin - if margin.is_finite() { margin.abs() * 1e-6 } else { 0.0 }
        };
        (0..count * count).into_par_iter().map(margin).collect()
    }

    /// Returns the slabs of all pairs of lists, from margins as [`Lists::margins`] returns them.
    fn slabs(&self, centres: &[f64], margins: &[f32]) -> Vec<Slab> {
        let (d, count, blocks) = (self.dimensions, self.centres.len(), self.centres.block_count());
        let slab = |r: usize, b: usize| {
            let mut slab = Slab { margin: [0.0; LANES], scale: [0.0; LANES] };
            for (lane, c) in (b * LANES..count.min((b + 1) * LANES)).enumerate() {
                let apart = distance(&centres[r * d..][..d], &centres[c * d..][..d]);
                let margin = margins[r * count + c];
                if apart > 0.0 && margin.is_finite() {
                    slab.margin[lane] = margin;
                    slab.scale[lane] = (0.5 / apart) as f32;
                }
            }
            slab
        };
        let slabs = if margins.is_empty() { 0 } else { count * blocks };
        (0..slabs).into_par_iter().map(|i| slab(i / blocks, i % blocks)).collect()
    }

    /// Returns the margins of all slabs, one row for each reference list; infinite if no plane is
    /// known. A single list has none.
    pub fn margins(&self) -> Vec<f32> {
        let (count, blocks) = (self.centres.len(), self.centres.block_count());
        let margin = |r: usize, c: usize| {
            let (slab, lane) = (&self.slabs[r * blocks + c / LANES], c % LANES);
            if slab.scale[lane] > 0.0 { slab.margin[lane] } else { f32::INFINITY }
        };
        let rows = if self.slabs.is_empty() { 0 } else { count };
        (0..rows).flat_map(|r| (0..count).map(move |c| margin(r, c))).collect()
    }
}

/// Returns the number of lists for `n` points. Between 1 and 2 roots of `n` made no difference in 7
/// to 16 dimensions with 10^4 to 10^5 points. The cap bounds the memory of the slabs, which grows
/// with the square.
pub fn list_count(n: usize) -> usize {
    ((1.5 * (n as f64).sqrt()) as usize).min(1_200)
}

/// Returns the points of each list, ascending.
fn members(assigned: &[u32], lists: usize) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); lists];
    assigned.iter().enumerate().for_each(|(i, list)| members[*list as usize].push(i as u32));
    members
}

fn gather_block(row: &[f64]) -> Vec<[f32; LANES]> {
    row.iter().map(|x| [*x as f32; LANES]).collect()
}

fn norm(row: &[f64]) -> f64 {
    row.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::svm::kernel::block_distances_squared;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn no_member_is_nearer_than_the_bound_of_its_list() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut uniform = |n: usize| -> Vec<f64> { (0..n).map(|_| rng.random::<f64>()).collect() };
        let (d, count) = (5, 20);
        let points = uniform(2_000 * d);
        let lists = Lists::build(&points, d, count, 1);
        let (mut tight, mut all) = (0, 0);
        for query in uniform(20 * d).chunks_exact(d) {
            let rounded: Vec<f32> = query.iter().map(|x| *x as f32).collect();
            let to_centre = |c: u32| {
                let block = lists.centres.blocks(c as usize / LANES, c as usize / LANES + 1).next().unwrap();
                (block_distances_squared(block, &rounded)[c as usize % LANES], c)
            };
            for (r, c) in (0..count as u32).flat_map(|r| (0..count as u32).map(move |c| (r, c))) {
                let bound = f64::from(lists.bound(to_centre(r), to_centre(c), lists.moved_by_rounding(query)));
                let places = lists.starts[c as usize] as usize * LANES..lists.starts[c as usize + 1] as usize * LANES;
                let members = lists.ids[places].iter().filter(|id| **id != PADDING);
                let nearest = members.map(|id| distance(&points[*id as usize * d..][..d], query)).fold(9.0, f64::min);
                assert!(bound <= nearest, "list {c}, seen from {r}: {bound}, a member at {nearest}");
                all += 1;
                tight += usize::from(bound > 0.5 * nearest);
            }
        }
        assert!(10 * tight > all, "{tight} of {all}");
    }
}

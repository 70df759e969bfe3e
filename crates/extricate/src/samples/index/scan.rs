//! The inner loops of a search: bounds on lists, and distances to the points of one list. They name
//! vector instructions, because the optimiser turned plain loops into shuffles of whole groups of
//! blocks.

use pulp::{Simd, WithSimd};

use super::inverted_lists::{Lists, PADDING};
use super::quantizer::ListCodes;
use crate::math::LANES;
use crate::math::simd::{F32s, lanes_of, negative};

/// The point whose neighbours are searched.
#[derive(Clone, Copy)]
pub struct Query<'a> {
    /// Coordinates as the caller gave them.
    pub exact: &'a [f64],
    /// Coordinates rounded to `f32`.
    pub rounded: &'a [f32],
    /// Bound on how far rounding moves the query and a point together.
    pub moved: f64,
}

/// Blocks processed together, so that a coordinate of the query is read once for all.
const BLOCKS_TOGETHER: usize = 4;

/// Writes the squared distances from `query` to the points of all blocks, each one row a
/// coordinate. `difference` subtracts a coordinate of the query from a row. The sums equal those of
/// [`crate::learning::svm::kernel::block_distances_squared`] to the last bit.
#[inline(always)]
fn square_all<S: Simd, T>(
    simd: S,
    rows: &[T],
    query: &[f32],
    squared: &mut [[f32; LANES]],
    difference: impl Fn(&T, F32s<S>, usize) -> F32s<S>,
) {
    let (mut many, mut of_many) =
        (rows.chunks_exact(BLOCKS_TOGETHER * query.len()), squared.chunks_exact_mut(BLOCKS_TOGETHER));
    for (rows, squared) in many.by_ref().zip(of_many.by_ref()) {
        square_together::<S, T, BLOCKS_TOGETHER>(simd, rows, query, squared, &difference);
    }
    let rest = many.remainder().chunks_exact(query.len());
    for (rows, squared) in rest.zip(of_many.into_remainder().chunks_exact_mut(1)) {
        square_together::<S, T, 1>(simd, rows, query, squared, &difference);
    }
}

/// Does the same as [`square_all`] for `N` blocks.
#[inline(always)]
fn square_together<S: Simd, T, const N: usize>(
    simd: S,
    rows: &[T],
    query: &[f32],
    squared: &mut [[f32; LANES]],
    difference: &impl Fn(&T, F32s<S>, usize) -> F32s<S>,
) {
    let (rows, squared) = (&rows[..N * query.len()], &mut squared[..N]);
    for part in 0..F32s::<S>::COUNT {
        let mut sums = [F32s::splat(simd, 0.0); N];
        for (k, x) in query.iter().enumerate() {
            let x = F32s::splat(simd, *x);
            for n in 0..N {
                let difference = difference(&rows[n * query.len() + k], x, part);
                sums[n] = sums[n] + difference * difference;
            }
        }
        for n in 0..N {
            sums[n].store(&mut squared[n], part);
        }
    }
}

/// Returns one bit a lane: whether its value is at most `limit`. NaN may give either.
#[inline(always)]
pub fn up_to<S: Simd>(simd: S, values: &[f32; LANES], limit: f32) -> u32 {
    let mut room = [0.0; LANES];
    for part in 0..F32s::<S>::COUNT {
        (F32s::splat(simd, limit) - F32s::load(simd, values, part)).store(&mut room, part);
    }
    !negative(&room) & 0xff
}

/// Fills `bounds` with lower bounds on the distance from the query to the members of each list, and
/// returns the list of the nearest centre.
pub struct BoundLists<'a> {
    /// The lists of the index, at least two.
    pub lists: &'a Lists,
    /// The query, exact and rounded.
    pub query: Query<'a>,
    /// Scratch memory, one row for each block of centres.
    pub squared: &'a mut [[f32; LANES]],
    /// The bounds, one row for each block of centres.
    pub bounds: &'a mut [[f32; LANES]],
}

impl WithSimd for BoundLists<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let Self { lists, query, squared, bounds } = self;
        let blocks = squared.len();
        let least = square_centres(simd, lists, query.rounded, squared);
        // Padded places are at infinity.
        let to_nearest = least.into_iter().fold(f32::INFINITY, f32::min);
        let found = squared.iter().map(|squared| up_to(simd, squared, to_nearest)).enumerate();
        let (block, mask) = found.into_iter().find(|(_, mask)| *mask != 0).unwrap_or_default();
        let nearest = (block * LANES + mask.trailing_zeros() as usize).min(lists.centres.len() - 1);
        let slabs = &lists.slabs[nearest * blocks..][..blocks];
        let splat = |x: f32| F32s::splat(simd, x);
        let error = lists.relative_error() as f32;
        let (error, kept, to_nearest) = (splat(error), splat(1.0 - error), splat(to_nearest));
        // The factor covers the rounding of the lines below.
        let (factor, moved) = (splat(1.0 - 1e-6), splat(query.moved as f32));
        for (((bounds, squared), radii), slab) in bounds.iter_mut().zip(squared.iter()).zip(&lists.radii).zip(slabs) {
            for part in 0..F32s::<S>::COUNT {
                let load = |lanes: &[f32; LANES]| F32s::load(simd, lanes, part);
                let squared = load(squared);
                let ball = (squared * kept).sqrt() - load(radii);
                let uncertain = error * (to_nearest + squared);
                let plane = (load(&slab.margin) - to_nearest + squared - uncertain) * load(&slab.scale);
                (ball.max(plane) * factor - moved).store(bounds, part);
            }
        }
        nearest
    }
}

/// Collects the lists of at least `most` nearest centres, with their squared distances.
pub struct NearestCentres<'a> {
    /// The lists of the index, more than `most`.
    pub lists: &'a Lists,
    /// The query, exact and rounded.
    pub query: Query<'a>,
    /// Number of lists wanted, at least one.
    pub most: usize,
    /// Scratch memory, one row for each block of centres.
    pub squared: &'a mut [[f32; LANES]],
    /// The result: squared distances and lists.
    pub order: &'a mut Vec<(f32, u32)>,
}

impl WithSimd for NearestCentres<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lists, query, most, squared, order } = self;
        let mut least = square_centres(simd, lists, query.rounded, squared);
        // At least `most` lanes have a centre within this limit.
        least.sort_unstable_by(f32::total_cmp);
        let limit = least.get(most - 1).map_or(f32::INFINITY, |limit| *limit);
        order.clear();
        for (block, squared) in squared.iter().enumerate() {
            for lane in lanes_of(up_to(simd, squared, limit)) {
                let c = block * LANES + lane;
                if c < lists.centres.len() {
                    order.push((squared[lane], c as u32));
                }
            }
        }
    }
}

/// Collects the lists whose bounds are at most `radius`, except for `nearest`.
pub struct ListsWithin<'a> {
    /// Number of lists of the index.
    pub count: usize,
    /// The list that was scanned already.
    pub nearest: usize,
    /// Bounds computed by [`BoundLists`].
    pub bounds: &'a [[f32; LANES]],
    /// Radius of the search.
    pub radius: f64,
    /// The result: bounds and lists.
    pub order: &'a mut Vec<(f32, u32)>,
}

impl WithSimd for ListsWithin<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { count, nearest, bounds, radius, order } = self;
        // Rounded up, for a first test of eight bounds at a time.
        let about = (radius * (1.0 + 1e-6)) as f32;
        for (block, bounds) in bounds.iter().enumerate() {
            for lane in lanes_of(up_to(simd, bounds, about)) {
                let c = block * LANES + lane;
                if c < count && c != nearest && f64::from(bounds[lane]) <= radius {
                    order.push((bounds[lane], c as u32));
                }
            }
        }
    }
}

/// Calls `visit` with the points of one list that may be within `radius`, and updates `radius`.
pub struct ScanList<'a> {
    /// The lists of the index.
    pub lists: &'a Lists,
    /// Index of the list.
    pub list: usize,
    /// The query, exact and rounded.
    pub query: Query<'a>,
    /// Scratch memory for the distances to its points.
    pub distances: &'a mut ListDistances,
    /// Radius of the search.
    pub radius: &'a mut f64,
    /// The callback of [`super::Index::search`].
    pub visit: &'a mut dyn FnMut(u32) -> f64,
}

impl WithSimd for ScanList<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lists, list, query, distances, radius, visit } = self;
        let error = lists.relative_error();
        let moved = square_list(simd, lists, list, query.exact, distances);
        // Largest computed squared distance of a point within `radius`, rounding included.
        let threshold = |radius: f64| ((radius + moved).powi(2) * (1.0 + error)) as f32;
        let first = lists.starts[list] as usize;
        for (b, squared) in (first..).zip(distances.squared.iter()) {
            for place in lanes_of(up_to(simd, squared, threshold(*radius))).map(|lane| b * LANES + lane) {
                if lists.ids[place] != PADDING {
                    *radius = visit(lists.ids[place]);
                }
            }
        }
    }
}

/// Scratch memory for the distances to one list.
#[derive(Debug, Clone, Default)]
pub struct ListDistances {
    /// The query relative to the origin of the list.
    relative: Vec<f32>,
    /// Squared distance from the query to what each code means; infinite in the padding.
    pub squared: Vec<[f32; LANES]>,
}

/// Fills `distances` with the squared distances from the query to all points of a list, and returns
/// by how much rounding may have changed their roots. Skipping blocks by balls around them took
/// longer, in branches that the processor cannot predict.
#[inline(always)]
pub fn square_list<S: Simd>(simd: S, lists: &Lists, list: usize, query: &[f64], distances: &mut ListDistances) -> f64 {
    let ListDistances { relative, squared } = distances;
    let ListCodes { blocks, in_last, step, moved } =
        lists.codes.list(list, lists.starts[list] as usize, query, relative);
    squared.resize(blocks.len() / lists.dimensions, [0.0; LANES]);
    square_all(
        simd,
        blocks,
        relative,
        squared,
        #[inline(always)]
        |codes, x, part| F32s::load(simd, &codes.map(f32::from), part) * F32s::splat(simd, step) - x,
    );
    if let Some(last) = squared.last_mut() {
        last[in_last..].fill(f32::INFINITY);
    }
    moved
}

/// Fills `squared` with squared distances from the query to all centres; returns the least a lane.
#[inline(always)]
fn square_centres<S: Simd>(simd: S, lists: &Lists, query: &[f32], squared: &mut [[f32; LANES]]) -> [f32; LANES] {
    square_all(
        simd,
        lists.centres.rows(),
        query,
        squared,
        #[inline(always)]
        |row, x, part| F32s::load(simd, row, part) - x,
    );
    least_of_lanes(simd, squared)
}

/// Returns the least value of each lane.
#[inline(always)]
pub fn least_of_lanes<S: Simd>(simd: S, values: &[[f32; LANES]]) -> [f32; LANES] {
    let mut least = [f32::INFINITY; LANES];
    for part in 0..F32s::<S>::COUNT {
        let mut lesser = F32s::splat(simd, f32::INFINITY);
        for values in values {
            lesser = lesser.min(F32s::load(simd, values, part));
        }
        lesser.store(&mut least, part);
    }
    least
}

//! Exact nearest neighbours among embedded points: lists around k-means centres, scanned with
//! vector instructions. The index knows Euclidean distances alone; the caller re-ranks under its
//! own metric.

pub mod inverted_lists;
pub mod kmeans;
pub mod projection;
pub mod quantizer;
pub mod rerank;
pub mod scan;

use std::cmp::Ordering;

use pulp::Arch;
use serde::{Deserialize, Serialize};

use crate::learning::svm::kernel::LANES;
use inverted_lists::{Lists, list_count};
use rerank::{Exact, Shortlist, ShowList};
use scan::{BoundLists, ListDistances, ListsWithin, NearestCentres, Query, ScanList};

/// Fewer points than this form one list, since scanning them all is as fast.
const MIN_POINTS_FOR_LISTS: usize = 1_500;

/// Lists scanned in order of their bounds, to reach a small radius early. Of the others, those
/// within the radius are scanned in any order.
const SORTED_LISTS: usize = 16;

/// An immutable index over `n` points of R^m.
///
/// ```
/// use extricate::internals::samples::index::{Knn, Index, SearchScratch};
/// let (points, query) = ([[0.0, 0.0], [3.0, 4.0], [1.0, 0.0]], [0.9, 0.0_f64]);
/// let index = Index::build(points.as_flattened(), 2, 0);
/// let (mut scratch, mut nearest) = (SearchScratch::default(), Vec::new());
/// let mut exact = |found: &mut [(u32, f64)]| {
///     for (id, distance) in found {
///         let [x, y] = points[*id as usize];
///         *distance = (x - query[0]).hypot(y - query[1]);
///     }
/// };
/// index.nearest(&query, Knn::of_all(2), &mut exact, &mut scratch, &mut nearest);
/// assert_eq!((nearest[0].0, nearest[1].0), (2, 0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Index {
    pub(crate) lists: Lists,
}

/// Options of [`Index::nearest`]: how many points, how far and in how many lists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knn {
    /// Largest number of points returned.
    pub k: usize,
    /// Largest distance of a point returned.
    pub within: f64,
    /// Number of lists searched, those of the nearest centres; 0 counts as 1.
    pub lists: usize,
}

impl Knn {
    /// Selects the `k` nearest of all points.
    pub fn of_all(k: usize) -> Self {
        Self { k, within: f64::INFINITY, lists: usize::MAX }
    }
}

/// Memory that searches reuse; one for each thread.
#[derive(Debug, Clone, Default)]
pub struct SearchScratch {
    rounded: Vec<f32>,
    squared: Vec<[f32; LANES]>,
    bounds: Vec<[f32; LANES]>,
    order: Vec<(f32, u32)>,
    few_bounds: Vec<f64>,
    of_list: ListDistances,
    shortlist: Shortlist,
}

impl Index {
    /// Indexes `points` (`n x dimensions`, row major, finite); point `i` gets the id `i`.
    ///
    /// # Guarantee
    /// The same arguments give the same index, whatever the number of threads.
    pub fn build(points: &[f64], dimensions: usize, seed: u64) -> Self {
        assert!(dimensions > 0 && points.len().is_multiple_of(dimensions), "rows are not {dimensions} wide");
        let n = points.len() / dimensions;
        let lists = if n < MIN_POINTS_FOR_LISTS { 1 } else { list_count(n) };
        Self { lists: Lists::build(points, dimensions, lists.min(n), seed) }
    }

    /// Number of points in the index.
    pub fn len(&self) -> usize {
        self.lists.len
    }

    /// Whether the index has no point.
    pub fn is_empty(&self) -> bool {
        self.lists.len == 0
    }

    /// Number of coordinates of a point.
    pub fn dimensions(&self) -> usize {
        self.lists.dimensions
    }

    /// Calls `visit` with the points near `query` (finite, of norm below 1e18), roughly nearest
    /// first, from the `most` lists whose centres are nearest. `visit` returns the radius beyond
    /// which points are of no interest. It starts at `within` and must not grow.
    ///
    /// # Guarantee
    /// With all lists, every point within the radius returned last is visited, once. This also
    /// holds for any metric that is never less than the Euclidean distance of the embeddings, so
    /// re-ranking is exact.
    pub fn search(
        &self,
        query: &[f64],
        within: f64,
        most: usize,
        scratch: &mut SearchScratch,
        visit: &mut dyn FnMut(u32) -> f64,
    ) {
        let mut distances = std::mem::take(&mut scratch.of_list);
        self.go_through(query, within, most, scratch, &mut |lists, list, query, radius| {
            let mut radius = radius;
            Arch::new().dispatch(ScanList {
                lists,
                list,
                query,
                distances: &mut distances,
                radius: &mut radius,
                visit,
            });
            radius
        });
        scratch.of_list = distances;
    }

    /// Calls `scan` with up to `most` lists, roughly nearest first, and with the radius that it
    /// returned last, at first `within`.
    fn go_through(
        &self,
        query: &[f64],
        within: f64,
        most: usize,
        scratch: &mut SearchScratch,
        scan: &mut dyn FnMut(&Lists, usize, Query, f64) -> f64,
    ) {
        assert_eq!(query.len(), self.lists.dimensions, "a query of another dimension than the index");
        if self.lists.len == 0 {
            return;
        }
        let SearchScratch { rounded, squared, bounds, order, few_bounds, .. } = scratch;
        rounded.clear();
        rounded.extend(query.iter().map(|x| *x as f32));
        let (lists, count) = (&self.lists, self.lists.centres.len());
        let query = Query { exact: query, rounded, moved: lists.moved_by_rounding(query) };
        if count == 1 {
            scan(lists, 0, query, within);
            return;
        }
        for lanes in [&mut *squared, &mut *bounds] {
            lanes.resize(lists.centres.block_count(), [0.0; LANES]);
        }
        let most = most.max(1);
        if most < count {
            // Lists of the nearest centres hold points as near as those of the least bounds, and
            // take half the time to find.
            Arch::new().dispatch(NearestCentres { lists, query, most, squared, order });
            put_least_first(order, most);
            order.truncate(most);
            order.sort_unstable_by(by_bound);
            // All bounds are computed at once, so that their cache misses overlap.
            let reference = order[0];
            few_bounds.clear();
            few_bounds.extend(order.iter().map(|near| f64::from(lists.bound(reference, *near, query.moved))));
            let mut radius = within;
            for ((_, c), bound) in order.iter().zip(&*few_bounds) {
                if *bound <= radius {
                    radius = scan(lists, *c as usize, query, radius);
                }
            }
            return;
        }
        let nearest = Arch::new().dispatch(BoundLists { lists, query, squared, bounds });
        let mut radius = scan(lists, nearest, query, within);
        order.clear();
        Arch::new().dispatch(ListsWithin { count, nearest, bounds, radius, order });
        // Sorting pays off only for the lists that come first.
        put_least_first(order, SORTED_LISTS);
        let in_order = order.len().min(SORTED_LISTS);
        order[..in_order].sort_unstable_by(by_bound);
        for (bound, c) in order.iter() {
            if f64::from(*bound) <= radius {
                radius = scan(lists, *c as usize, query, radius);
            }
        }
    }

    /// Writes the `k` nearest points no farther than `within` to `out`, nearest first and ties by
    /// id. They come from the `few.lists` lists whose centres are nearest. Their distances are
    /// those that `exact` writes: Euclidean ones, which the index knows only rounded.
    ///
    /// `exact` gets the ids of all candidates at once, with space for their distances.
    ///
    /// # Guarantee
    /// With all lists, no point is missed.
    pub fn nearest(
        &self,
        query: &[f64],
        few: Knn,
        exact: &mut Exact,
        scratch: &mut SearchScratch,
        out: &mut Vec<(u32, f64)>,
    ) {
        let Knn { k, within, lists: most } = few;
        out.clear();
        if k == 0 || self.lists.len == 0 {
            return;
        }
        let mut shortlist = std::mem::take(&mut scratch.shortlist);
        shortlist.reset(k, within);
        self.go_through(query, within, most, scratch, &mut |lists, list, query, _| {
            Arch::new().dispatch(ShowList { lists, list, query, shortlist: &mut shortlist });
            shortlist.radius
        });
        shortlist.finish(&self.lists, within, exact, out);
        scratch.shortlist = shortlist;
    }
}

fn by_bound(a: &(f32, u32), b: &(f32, u32)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// Puts the `count` least bounds first, in any order.
fn put_least_first(order: &mut [(f32, u32)], count: usize) {
    if count < order.len() {
        order.select_nth_unstable_by(count, by_bound);
    }
}

#[cfg(test)]
mod tests;

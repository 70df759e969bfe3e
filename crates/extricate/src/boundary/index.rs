//! Exact nearest neighbours among embedded points: lists around k-means centres, scanned with vector instructions. Knows
//! Euclidean distance only; the caller re-ranks under its own metric.

use std::cmp::Ordering;

use pulp::Arch;
use serde::{Deserialize, Serialize};

use super::lists::{Lists, list_count};
use super::scan::{BoundLists, ListRoom, ListsWithin, NearestCentres, Query, ScanList};
use super::shortlist::{Exact, Shortlist, ShowList};
use crate::learning::kernel::LANES;

/// Fewer points than this are one list: scanning them all is as fast.
const LINEAR_BELOW: usize = 1_500;

/// Lists that are looked through in order of their bounds, to come by a small radius; of the others, all that it does not rule out.
const IN_ORDER: usize = 16;

/// An immutable index over `n` points of R^m.
///
/// ```
/// use extricate::boundary::index::{Few, Index, SearchScratch};
/// let (points, query) = ([[0.0, 0.0], [3.0, 4.0], [1.0, 0.0]], [0.9, 0.0_f64]);
/// let index = Index::build(points.as_flattened(), 2, 0);
/// let (mut scratch, mut nearest) = (SearchScratch::default(), Vec::new());
/// let mut exact = |found: &mut [(u32, f64)]| {
///     for (id, distance) in found {
///         let [x, y] = points[*id as usize];
///         *distance = (x - query[0]).hypot(y - query[1]);
///     }
/// };
/// index.nearest(&query, Few::of_all(2), &mut exact, &mut scratch, &mut nearest);
/// assert_eq!((nearest[0].0, nearest[1].0), (2, 0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Index {
    pub(super) lists: Lists,
}

/// How many points [`Index::nearest`] looks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Few {
    /// At most so many.
    pub k: usize,
    /// No farther than this.
    pub within: f64,
    /// In the lists of so many nearest centres, at least one.
    pub lists: usize,
}

impl Few {
    /// The `k` nearest of all points.
    pub fn of_all(k: usize) -> Self {
        Self { k, within: f64::INFINITY, lists: usize::MAX }
    }
}

/// Room that a search needs; one for each thread.
#[derive(Debug, Clone, Default)]
pub struct SearchScratch {
    rounded: Vec<f32>,
    squared: Vec<[f32; LANES]>,
    bounds: Vec<[f32; LANES]>,
    order: Vec<(f32, u32)>,
    few_bounds: Vec<f64>,
    of_list: ListRoom,
    shortlist: Shortlist,
}

impl Index {
    /// Over `points` (`n x dimensions`, row major, finite); point `i` gets the id `i`.
    ///
    /// # Guarantee
    /// The same arguments give the same index, whatever the number of threads.
    pub fn build(points: &[f64], dimensions: usize, seed: u64) -> Self {
        assert!(dimensions > 0 && points.len().is_multiple_of(dimensions), "rows are not {dimensions} wide");
        let n = points.len() / dimensions;
        let lists = if n < LINEAR_BELOW { 1 } else { list_count(n) };
        Self { lists: Lists::build(points, dimensions, lists.min(n), seed) }
    }

    /// Memory for `n` points of `dimensions` coordinates \[bytes\].
    pub fn bytes(dimensions: usize, n: usize) -> usize {
        let lists = list_count(n);
        // In bytes, with an id each; slabs by the square of the lists. In f64 while it is built.
        n * (9 * dimensions + 4) + lists * lists * 8 + lists * 4 * dimensions
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.lists.len
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.lists.len == 0
    }

    /// Coordinates a point.
    pub fn dimensions(&self) -> usize {
        self.lists.dimensions
    }

    /// Shows `visit` the points near `query` (finite, of norm below 1e18), roughly nearest first, of those in the `most` lists whose centres are
    /// nearest. `visit` returns the radius beyond which nothing more is of interest: at first `within`, and never more than before.
    ///
    /// # Guarantee
    /// With all lists, every point within the radius returned last is visited, once. For a metric that is never less than the
    /// Euclidean distance of the embeddings, so is every point within that radius of the metric: re-ranking is exact.
    pub fn search(
        &self,
        query: &[f64],
        within: f64,
        most: usize,
        scratch: &mut SearchScratch,
        visit: &mut dyn FnMut(u32) -> f64,
    ) {
        let mut room = std::mem::take(&mut scratch.of_list);
        self.go_through(query, within, most, scratch, &mut |lists, list, query, radius| {
            let mut radius = radius;
            Arch::new().dispatch(ScanList { lists, list, query, room: &mut room, radius: &mut radius, visit });
            radius
        });
        scratch.of_list = room;
    }

    /// Shows `scan` up to `most` lists, roughly nearest first, with the radius that it returned last, at first `within`.
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
            // The nearest centres have as near points as the least bounds have, for half of the time.
            Arch::new().dispatch(NearestCentres { lists, query, most, squared, order });
            put_least_first(order, most);
            order.truncate(most);
            order.sort_unstable_by(by_bound);
            // All at once, so that memory is waited for once.
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
        // Sorting is worth it only for lists that come first.
        put_least_first(order, IN_ORDER);
        let in_order = order.len().min(IN_ORDER);
        order[..in_order].sort_unstable_by(by_bound);
        for (bound, c) in order.iter() {
            if f64::from(*bound) <= radius {
                radius = scan(lists, *c as usize, query, radius);
            }
        }
    }

    /// The `k` nearest points that are no farther than `within`, nearest first, of equals those of smaller id, of those in the `most` lists whose
    /// centres are nearest; with what `exact` writes beside them as their distances: the Euclidean ones, which the index knows rounded.
    ///
    /// `exact` gets ids and room for the distances, of all that may be among the nearest at once.
    ///
    /// # Guarantee
    /// With all lists, none is missed.
    pub fn nearest(
        &self,
        query: &[f64],
        few: Few,
        exact: &mut Exact,
        scratch: &mut SearchScratch,
        out: &mut Vec<(u32, f64)>,
    ) {
        let Few { k, within, lists: most } = few;
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
mod tests {
    use super::*;
    use crate::boundary::lists::distance;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Slow twin of [`Index::nearest`].
    fn linear_scan(points: &[f64], dimensions: usize, query: &[f64], k: usize) -> Vec<(u32, f64)> {
        let rows = points.chunks_exact(dimensions).enumerate();
        let mut all: Vec<(u32, f64)> = rows.map(|(i, row)| (i as u32, distance(row, query))).collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        all.truncate(k);
        all
    }

    /// What knows the points, for [`Index::nearest`].
    fn exactly<'a>(points: &'a [f64], dimensions: usize, query: &'a [f64]) -> impl FnMut(&mut [(u32, f64)]) + 'a {
        move |found| {
            for (id, out) in found {
                *out = distance(&points[*id as usize * dimensions..][..dimensions], query);
            }
        }
    }

    fn assert_exact(points: &[f64], dimensions: usize, lists: usize, queries: &[f64]) {
        let index = Index { lists: Lists::build(points, dimensions, lists, 3) };
        let (mut scratch, mut found) = (SearchScratch::default(), Vec::new());
        for query in queries.chunks_exact(dimensions) {
            for k in [1, 7, points.len() / dimensions + 1] {
                let mut exact = exactly(points, dimensions, query);
                index.nearest(query, Few::of_all(k), &mut exact, &mut scratch, &mut found);
                assert_eq!(found, linear_scan(points, dimensions, query, k), "k = {k}, {lists} lists, {query:?}");
            }
        }
    }

    fn uniform(count: usize, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| 2.0 * rng.random::<f64>() - 1.0).collect()
    }

    #[test]
    fn exact_on_random_points() {
        for (dimensions, lists) in [(1, 12), (2, 30), (7, 20), (7, 1), (16, 40), (40, 20)] {
            let queries: Vec<f64> = uniform(20 * dimensions, 2).iter().map(|x| 1.5 * x).collect();
            assert_exact(&uniform(600 * dimensions, 1), dimensions, lists, &queries);
        }
    }

    #[test]
    fn exact_on_clusters_and_duplicates() {
        let noise = uniform(900 * 3, 4);
        // Clusters far from the origin, where f32 is coarse, with many points that f32 cannot tell apart.
        let clustered: Vec<f64> =
            noise.iter().enumerate().map(|(i, x)| ((i / 3) % 5) as f64 * 100.0 + 1e-6 * x + 1000.0).collect();
        assert_exact(&clustered, 3, 25, &clustered[..30 * 3]);
        let duplicates: Vec<f64> = (0..800).flat_map(|i| [f64::from(i % 4), 0.0]).collect();
        assert_exact(&duplicates, 2, 20, &[0.0, 0.0, 1.5, 0.0, 9.0, 9.0]);
        assert_exact(&vec![0.25; 500], 1, 15, &[0.25, 0.0]);
    }

    #[test]
    fn far_queries_are_exact() {
        assert_exact(&uniform(500 * 4, 5), 4, 22, &[1e6, 0.0, 0.0, -1e6, 1e3, 1e3, 1e3, 1e3]);
    }

    #[test]
    fn empty_and_single() {
        let (mut scratch, mut found) = (SearchScratch::default(), vec![(9, 9.0)]);
        let empty = Index::build(&[], 3, 0);
        empty.nearest(&[0.0; 3], Few::of_all(4), &mut |_| (), &mut scratch, &mut found);
        assert!(found.is_empty() && empty.is_empty());
        let single = Index::build(&[1.0, 2.0, 2.0], 3, 0);
        let mut three = |found: &mut [(u32, f64)]| found.iter_mut().for_each(|(_, distance)| *distance = 3.0);
        single.nearest(&[0.0; 3], Few::of_all(4), &mut three, &mut scratch, &mut found);
        assert_eq!(found, [(0, 3.0)]);
        single.nearest(&[0.0; 3], Few::of_all(0), &mut three, &mut scratch, &mut found);
        assert!(found.is_empty());
        single.nearest(&[0.0; 3], Few { within: 2.9, ..Few::of_all(4) }, &mut three, &mut scratch, &mut found);
        assert!(found.is_empty());
    }

    #[test]
    fn re_ranking_under_a_larger_metric_is_exact() {
        let (points, queries) = (uniform(2_000 * 5, 6), uniform(50 * 5, 7));
        let index = Index::build(&points, 5, 0);
        // Not less than the Euclidean distance, and not in its order.
        let stretch = |id: u32| 1.0 + f64::from(id * 7919 % 100) / 50.0;
        let mut scratch = SearchScratch::default();
        for query in queries.chunks_exact(5) {
            let (mut best, mut visits) = ((u32::MAX, f64::INFINITY), 0);
            index.search(query, f64::INFINITY, usize::MAX, &mut scratch, &mut |id| {
                let metric = distance(&points[id as usize * 5..][..5], query) * stretch(id);
                if metric < best.1 {
                    best = (id, metric);
                }
                visits += 1;
                best.1
            });
            let metric =
                linear_scan(&points, 5, query, 2_000).iter().map(|(id, d)| d * stretch(*id)).fold(9.0, f64::min);
            assert_eq!(best.1, metric);
            assert!(visits < 400, "{visits} of 2000 visited");
        }
    }

    #[test]
    fn few_lists_hold_most_of_the_nearest() {
        let (points, queries) = (uniform(20_000 * 8, 9), uniform(40 * 8, 10));
        let index = Index::build(&points, 8, 0);
        let (mut scratch, mut nearest_ten, mut hits, mut visited) = (SearchScratch::default(), Vec::new(), 0, 0);
        for query in queries.chunks_exact(8) {
            let far = |id: u32| distance(&points[id as usize * 8..][..8], query);
            let mut exact = exactly(&points, 8, query);
            index.nearest(query, Few::of_all(10), &mut exact, &mut scratch, &mut nearest_ten);
            let mut found = Vec::new();
            index.search(query, f64::INFINITY, 20, &mut scratch, &mut |id| {
                found.push(id);
                f64::INFINITY
            });
            visited += found.len();
            hits += nearest_ten.iter().filter(|(id, _)| found.contains(id)).count();
            // The few nearest in as many lists are of what was visited, and within a radius the same ones.
            let few = Few { lists: 20, ..Few::of_all(10) };
            let mut nearest = Vec::new();
            index.nearest(query, few, &mut exact, &mut scratch, &mut nearest);
            let mut expected: Vec<(u32, f64)> = found.iter().map(|id| (*id, far(*id))).collect();
            expected.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            assert_eq!(nearest, expected[..10]);
            let few = Few { within: expected[3].1, ..few };
            index.nearest(query, few, &mut exact, &mut scratch, &mut nearest);
            assert_eq!(nearest, expected[..4]);
            // No list is as good as one.
            let of_lists = |lists| Few { lists, ..Few::of_all(3) };
            index.nearest(query, of_lists(1), &mut exact, &mut scratch, &mut nearest);
            let of_one = nearest.clone();
            index.nearest(query, of_lists(0), &mut exact, &mut scratch, &mut nearest);
            assert_eq!((of_one.len(), &nearest), (3, &of_one));
        }
        // A tenth of the points.
        assert!(visited < 40 * 3_000 && hits > 320, "{visited} visited, {hits} of 400 found");
    }

    #[test]
    fn every_point_is_visited_once_without_a_radius() {
        let index = Index::build(&uniform(3_000 * 3, 8), 3, 0);
        let mut seen = vec![0; 3_000];
        index.search(&[0.1, 0.2, 0.3], f64::INFINITY, usize::MAX, &mut SearchScratch::default(), &mut |id| {
            seen[id as usize] += 1;
            f64::INFINITY
        });
        assert!(seen.iter().all(|count| *count == 1));
    }

    #[test]
    fn same_index_for_any_number_of_threads_and_after_serialisation() {
        let points = uniform(4_000 * 6, 9);
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let build = || Index::build(&points, 6, 1);
        let index = pool(1).install(build);
        assert_eq!(index, pool(3).install(build));
        let bytes = postcard::to_stdvec(&index).unwrap();
        assert_eq!(postcard::from_bytes::<Index>(&bytes).unwrap(), index);
    }
}

//! Compares the index with scans of all points.

use super::*;
use crate::math::linear_algebra::distance;
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

/// Writes exact distances, for [`Index::nearest`].
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
            index.nearest(query, Knn::of_all(k), &mut exact, &mut scratch, &mut found);
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
    // Clusters far from the origin, where f32 is coarse, with many points that f32 cannot tell
    // apart.
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
    empty.nearest(&[0.0; 3], Knn::of_all(4), &mut |_| (), &mut scratch, &mut found);
    assert!(found.is_empty() && empty.is_empty());
    let single = Index::build(&[1.0, 2.0, 2.0], 3, 0);
    let mut three = |found: &mut [(u32, f64)]| found.iter_mut().for_each(|(_, distance)| *distance = 3.0);
    single.nearest(&[0.0; 3], Knn::of_all(4), &mut three, &mut scratch, &mut found);
    assert_eq!(found, [(0, 3.0)]);
    single.nearest(&[0.0; 3], Knn::of_all(0), &mut three, &mut scratch, &mut found);
    assert!(found.is_empty());
    single.nearest(&[0.0; 3], Knn { within: 2.9, ..Knn::of_all(4) }, &mut three, &mut scratch, &mut found);
    assert!(found.is_empty());
}

#[test]
fn re_ranking_under_a_larger_metric_is_exact() {
    let (points, queries) = (uniform(2_000 * 5, 6), uniform(50 * 5, 7));
    let index = Index::build(&points, 5, 0);
    // The metric is never less than the Euclidean distance, and orders points differently.
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
        let metric = linear_scan(&points, 5, query, 2_000).iter().map(|(id, d)| d * stretch(*id)).fold(9.0, f64::min);
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
        index.nearest(query, Knn::of_all(10), &mut exact, &mut scratch, &mut nearest_ten);
        let mut found = Vec::new();
        index.search(query, f64::INFINITY, 20, &mut scratch, &mut |id| {
            found.push(id);
            f64::INFINITY
        });
        visited += found.len();
        hits += nearest_ten.iter().filter(|(id, _)| found.contains(id)).count();
        // With the same lists, `nearest` returns the nearest visited points, within a radius too.
        let few = Knn { lists: 20, ..Knn::of_all(10) };
        let mut nearest = Vec::new();
        index.nearest(query, few, &mut exact, &mut scratch, &mut nearest);
        let mut expected: Vec<(u32, f64)> = found.iter().map(|id| (*id, far(*id))).collect();
        expected.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        assert_eq!(nearest, expected[..10]);
        let few = Knn { within: expected[3].1, ..few };
        index.nearest(query, few, &mut exact, &mut scratch, &mut nearest);
        assert_eq!(nearest, expected[..4]);
        // A request for no list counts as one list.
        let of_lists = |lists| Knn { lists, ..Knn::of_all(3) };
        index.nearest(query, of_lists(1), &mut exact, &mut scratch, &mut nearest);
        let of_one = nearest.clone();
        index.nearest(query, of_lists(0), &mut exact, &mut scratch, &mut nearest);
        assert_eq!((of_one.len(), &nearest), (3, &of_one));
    }
    // Less than 15 % of the points are visited, and more than 80 % of the nearest are found.
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

//! Verified boundary samples, free but close to a collision, and the search for the nearest.

pub mod arrays;
pub mod contact_planes;
pub mod index;
mod mismatch;
pub mod trace;

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use contact_planes::{ContactPlanes, Planes};
use index::projection::Projection;
use index::{Index, Knn, SearchScratch};

use crate::metric::{Anchor, Metric, MetricScratch};

/// Free configurations at the boundary of the obstacle region, indexed under a metric's embedding.
/// The last of them may be *solved*: each is the nearest exit that a query found for a
/// configuration solved during learning. Solved samples have an index of their own.
pub struct SampleSet {
    nq: usize,
    configs: Vec<f64>,
    embedding_len: usize,
    all: Indexed,
    solved: Option<Indexed>,
    /// Contact planes of the solved samples, or of none.
    planes: ContactPlanes,
}

/// Options of [`SampleSet::nearest`]: which samples, how far and how thoroughly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleQuery {
    /// The samples that are searched.
    pub among: SampleKind,
    /// Largest distance of a result, in metric units.
    pub within: f64,
    /// How thoroughly the index is searched.
    pub care: Probes,
}

/// A selection of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKind {
    /// All samples, solved ones included.
    All,
    /// The solved samples alone.
    Solved,
}

/// Number of lists that a search probes. An exact search in 16 dimensions evaluates many samples.
///
/// Errors were measured with 260,000 to 390,000 samples, in the mean of 300 to 2,500
/// configurations. The first sample of a quick search is farther than the nearest by 0.1 to 1.1 %
/// in 6 and 7 dimensions, and by 3.1 % in 16. A glance adds another 0.6 and 0.9 %.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Probes {
    /// As many lists as an exact result takes.
    Exact,
    /// The lists of the four nearest centres.
    Quick,
    /// The lists of the three nearest centres.
    Glance,
}

impl Probes {
    fn lists(self) -> usize {
        match self {
            Probes::Exact => usize::MAX,
            Probes::Quick => 4,
            Probes::Glance => 3,
        }
    }
}

impl SampleQuery {
    /// Searches all samples exactly, at any distance.
    pub const NEAREST: Self = Self { among: SampleKind::All, within: f64::INFINITY, care: Probes::Exact };
}

/// An index over the samples from `first` on.
struct Indexed {
    index: Index,
    /// Set if the embedding has more than [`MAX_INDEX_DIMENSIONS`].
    projection: Option<Projection>,
    /// Sample with id 0 in the index.
    first: usize,
}

/// Longer embeddings are projected onto this many principal axes, which never increases distances.
///
/// The search stays exact. In 16 dimensions it still prunes; in 84 (a 7-joint arm under the object
/// norm) it would scan all samples.
const MAX_INDEX_DIMENSIONS: usize = 16;

/// Memory that searches reuse.
#[derive(Default)]
pub struct BoundaryScratch {
    search: SearchScratch,
    embedding: Vec<f64>,
    projected: Vec<f64>,
    metric: MetricScratch,
    heap: BinaryHeap<Ranked>,
}

/// A sample, ordered by its distance, then its id.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ranked {
    distance: f64,
    id: u32,
}

impl Eq for Ranked {}

impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.id.cmp(&other.id))
    }
}

impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Indexed {
    /// Indexes the rows of `points` from `first` on.
    fn build(points: &[f64], embedding_len: usize, first: usize, seed: u64) -> Self {
        let points = &points[first * embedding_len..];
        let project = embedding_len > MAX_INDEX_DIMENSIONS && !points.is_empty();
        let projection = project.then(|| Projection::fit(points, embedding_len, MAX_INDEX_DIMENSIONS));
        let index = match &projection {
            Some(projection) => Index::build(&projection.apply_all(points), projection.projected_dimensions(), seed),
            None => Index::build(points, embedding_len, seed),
        };
        Self { index, projection, first }
    }
}

/// The embeddings of `configs`, row major.
fn embedded(metric: &Metric, nq: usize, configs: &[f64]) -> Vec<f64> {
    let embedding_len = metric.embedding_len();
    let mut points = vec![0.0; configs.len() / nq * embedding_len];
    let rows = configs.par_chunks_exact(nq).zip(points.par_chunks_exact_mut(embedding_len));
    rows.for_each_init(MetricScratch::default, |scratch, (q, out)| metric.embed(q, scratch, out));
    points
}

impl SampleSet {
    /// Indexes `configs` (row major, `nq` a row), each called free by the exact checker.
    pub fn new(metric: &Metric, nq: usize, configs: Vec<f64>, seed: u64) -> Self {
        Self::with_solved(metric, nq, configs, 0, seed)
    }

    /// Does the same as [`SampleSet::new`]; the last `solved` rows are solved samples.
    ///
    /// # Panics
    /// Panics if there are fewer rows.
    pub fn with_solved(metric: &Metric, nq: usize, configs: Vec<f64>, solved: usize, seed: u64) -> Self {
        let embedding_len = metric.embedding_len();
        let rows = configs.len() / nq;
        assert!(solved <= rows, "{solved} solved of {rows} samples");
        let points = embedded(metric, nq, &configs);
        let all = Indexed::build(&points, embedding_len, 0, seed);
        let solved = (solved > 0).then(|| Indexed::build(&points, embedding_len, rows - solved, seed));
        Self { nq, configs, embedding_len, all, solved, planes: ContactPlanes::default() }
    }

    /// Number of coordinates of a sample.
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Number of samples, solved ones included.
    pub fn len(&self) -> usize {
        self.configs.len() / self.nq
    }

    /// Number of solved samples; they are stored last.
    pub fn solved(&self) -> usize {
        self.solved.as_ref().map_or(0, |solved| self.len() - solved.first)
    }

    /// Stores the contact planes of every solved sample, in their order.
    ///
    /// # Panics
    /// Panics if there is not one entry for each solved sample.
    pub fn set_contact_planes(&mut self, planes: ContactPlanes) {
        assert_eq!(planes.len(), self.solved(), "one entry a solved one");
        self.planes = planes;
    }

    /// Returns the contact planes of sample `id`; `None` unless it is solved and
    /// [`SampleSet::set_contact_planes`] was called.
    pub fn planes(&self, id: u32) -> Option<Planes<'_>> {
        let exit = (id as usize).checked_sub(self.len() - self.solved())?;
        (exit < self.planes.len()).then(|| self.planes.planes(exit))
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.configs.is_empty()
    }

    /// All samples, row major.
    pub fn configs(&self) -> &[f64] {
        &self.configs
    }

    /// Coordinates of sample `id`.
    pub fn config(&self, id: u32) -> &[f64] {
        &self.configs[id as usize * self.nq..(id as usize + 1) * self.nq]
    }

    /// Writes the `k` `wanted` samples nearest to the anchor to `out`, nearest first, with their
    /// distances in metric units.
    ///
    /// # Guarantee
    /// With [`Probes::Exact`] the result is exact under the metric, since distances of embeddings
    /// are lower bounds of it. Otherwise samples may be missed.
    pub fn nearest(
        &self,
        wanted: SampleQuery,
        metric: &Metric,
        anchor: &Anchor,
        k: usize,
        scratch: &mut BoundaryScratch,
        out: &mut Vec<(u32, f64)>,
    ) {
        out.clear();
        let indexed = match wanted.among {
            SampleKind::All => Some(&self.all),
            SampleKind::Solved => self.solved.as_ref(),
        };
        let Some(indexed) = indexed.filter(|_| k > 0) else { return };
        scratch.embedding.resize(self.embedding_len, 0.0);
        metric.embed(&anchor.q, &mut scratch.metric, &mut scratch.embedding);
        let (metric_scratch, heap) = (&mut scratch.metric, &mut scratch.heap);
        heap.clear();
        let point = match &indexed.projection {
            Some(projection) => {
                scratch.projected.resize(projection.projected_dimensions(), 0.0);
                projection.apply(&scratch.embedding, &mut scratch.projected);
                &scratch.projected
            }
            None => &scratch.embedding,
        };
        let (within, lists) = (wanted.within, wanted.care.lists());
        if indexed.projection.is_none() && metric.embedding_is_exact() {
            let mut exact = |found: &mut [(u32, f64)]| {
                let config = |id: u32| self.config(id + indexed.first as u32);
                // Touches all these samples first, so that their cache misses overlap.
                std::hint::black_box(found.iter().map(|(id, _)| config(*id)[0]).sum::<f64>());
                found.iter_mut().for_each(|(id, out)| *out = metric.distance_from(anchor, config(*id), metric_scratch));
            };
            indexed.index.nearest(point, Knn { k, within, lists }, &mut exact, &mut scratch.search, out);
            return out.iter_mut().for_each(|(id, _)| *id += indexed.first as u32);
        }
        indexed.index.search(point, within, lists, &mut scratch.search, &mut |id| {
            let id = id + indexed.first as u32;
            let distance = metric.distance_from(anchor, self.config(id), metric_scratch);
            // A heap, since inserting into a sorted list would move half of it for every nearer
            // sample.
            if heap.len() < k {
                if distance <= within {
                    heap.push(Ranked { distance, id });
                }
            } else if let Some(mut farthest) = heap.peek_mut()
                && distance < farthest.distance
            {
                *farthest = Ranked { distance, id };
            }
            heap.peek().filter(|_| heap.len() == k).map_or(within, |farthest| farthest.distance)
        });
        out.extend(heap.drain().map(|Ranked { distance, id }| (id, distance)));
        out.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    }
}

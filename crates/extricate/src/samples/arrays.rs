//! Plain arrays of all that is slow to compute about samples: their index lists and the contact
//! planes of solved ones. File formats are defined elsewhere.
//!
//! Arrays from a file are checked as far as possible. Any assignment to lists gives an exact index,
//! a basis is tested, and planes only propose. Margins of lists are trusted, as is the freedom of
//! the samples. With wrong margins, searches would miss samples, and exits would be farther than
//! necessary. They would still be verified, and lower bounds use no samples.

use super::contact_planes::{ContactPlaneArrays, ContactPlanes};
use super::index::Index;
use super::index::inverted_lists::{Lists, PADDING};
use super::index::projection::Projection;
pub use super::mismatch::Mismatch;
use super::{Indexed, SampleSet, embedded};
use crate::learning::svm::kernel::LANES;
use crate::metric::Metric;

/// The stored arrays of a [`SampleSet`]: of its indices and of its contact planes.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleArrays {
    /// Arrays of the index over all samples.
    pub all: IndexArrays,
    /// Arrays of the index over the solved samples, if there are any.
    pub solved: Option<IndexArrays>,
    /// Contact planes of the solved samples.
    pub planes: ContactPlaneArrays,
}

/// The stored arrays of one index and its projection.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct IndexArrays {
    /// List of each point, in the order of the points.
    pub lists: Vec<u16>,
    /// Centre of each list, row major: one number for each dimension of the index.
    pub centres: Vec<f32>,
    /// Margins, as [`Lists::margins`] returns them.
    pub margins: Vec<f32>,
    /// Basis of the projection, row major; empty if there is none.
    pub basis: Vec<f64>,
}

impl SampleSet {
    /// Returns the arrays of all that is slow to compute.
    pub fn kept(&self) -> SampleArrays {
        SampleArrays {
            all: self.all.kept(),
            solved: self.solved.as_ref().map(Indexed::kept),
            planes: self.planes.kept(),
        }
    }

    /// Restores a set from `configs`, whose last `solved` rows are solved, and from its arrays. The
    /// scene has `pairs` checked pairs and `nv` tangent coordinates.
    ///
    /// # Errors
    /// [`Mismatch`] if the arrays visibly belong to another set.
    pub fn restored(
        metric: &Metric,
        [nq, nv, pairs]: [usize; 3],
        configs: Vec<f64>,
        solved: usize,
        kept: &SampleArrays,
    ) -> Result<Self, Mismatch> {
        let embedding_len = metric.embedding_len();
        let points = embedded(metric, nq, &configs);
        let first = (configs.len() / nq).saturating_sub(solved);
        let all = Indexed::restored(&points, embedding_len, 0, &kept.all)?;
        let of_solved = kept.solved.as_ref().filter(|_| solved > 0);
        let of_solved = of_solved.map(|kept| Indexed::restored(&points, embedding_len, first, kept)).transpose();
        let of_solved = of_solved.map_err(|unfit| Mismatch { of: "exits", ..unfit })?;
        if of_solved.is_some() != (solved > 0) {
            return Err(Mismatch { of: "exits", array: "lists", expected: "an index of the solved" });
        }
        let planes = ContactPlanes::restored(nv, pairs, solved, &kept.planes)?;
        Ok(Self { nq, configs, embedding_len, all, solved: of_solved, planes })
    }
}

impl Indexed {
    fn kept(&self) -> IndexArrays {
        let basis = self.projection.as_ref().map_or_else(Vec::new, |projection| projection.basis().to_vec());
        IndexArrays { basis, ..self.index.kept() }
    }

    fn restored(points: &[f64], embedding_len: usize, first: usize, kept: &IndexArrays) -> Result<Self, Mismatch> {
        let points = &points[first * embedding_len..];
        let projection = if kept.basis.is_empty() {
            None
        } else {
            let found = Projection::from_basis(&kept.basis, embedding_len);
            Some(found.ok_or(Mismatch {
                of: "index",
                array: "basis",
                expected: "orthonormal rows as long as an embedding",
            })?)
        };
        let index = match &projection {
            Some(projection) => Index::restored(&projection.apply_all(points), projection.projected_dimensions(), kept),
            None => Index::restored(points, embedding_len, kept),
        }?;
        Ok(Self { index, projection, first })
    }
}

impl Index {
    fn kept(&self) -> IndexArrays {
        let Lists { len, ids, starts, centres, dimensions, .. } = &self.lists;
        let mut lists = vec![0; *len];
        for (list, ends) in starts.windows(2).enumerate() {
            let places = ends[0] as usize * LANES..ends[1] as usize * LANES;
            // The cast is exact: an index has far fewer than 2^16 lists.
            ids[places].iter().filter(|id| **id != PADDING).for_each(|id| lists[*id as usize] = list as u16);
        }
        let centres = (0..centres.len()).flat_map(|c| (0..*dimensions).map(move |k| centres.coordinate(c, k)));
        IndexArrays { lists, centres: centres.collect(), margins: self.lists.margins(), basis: Vec::new() }
    }

    fn restored(points: &[f64], dimensions: usize, kept: &IndexArrays) -> Result<Self, Mismatch> {
        let (n, count) = (points.len() / dimensions, kept.centres.len() / dimensions);
        let check =
            |holds: bool, array, expected| if holds { Ok(()) } else { Err(Mismatch { of: "index", array, expected }) };
        let are_centres = kept.centres.len().is_multiple_of(dimensions) && kept.centres.iter().all(|x| x.is_finite());
        check(are_centres && (count > 0 || n == 0), "centres", "finite rows as long as the index has dimensions")?;
        let are_lists = kept.lists.len() == n && kept.lists.iter().all(|list| usize::from(*list) < count);
        check(are_lists, "lists", "a list of the index for every sample")?;
        let margins = if count < 2 { 0 } else { count * count };
        let are_margins = kept.margins.len() == margins && !kept.margins.iter().any(|x| x.is_nan());
        check(are_margins, "margins", "a number for every two lists")?;
        let centres: Vec<f64> = kept.centres.iter().map(|x| f64::from(*x)).collect();
        let assigned: Vec<u32> = kept.lists.iter().map(|list| u32::from(*list)).collect();
        Ok(Self { lists: Lists::again(points, dimensions, &centres, &assigned, &kept.margins) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn uniform(count: usize) -> Vec<f64> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        (0..count).map(|_| 2.0 * rng.random::<f64>() - 1.0).collect()
    }

    #[test]
    fn an_index_is_the_same_once_more() {
        // No points, one list, many lists; then empty lists, because most points are equal.
        let mut alike = uniform(9_000);
        alike[3_000..].fill(0.5);
        for points in [Vec::new(), uniform(30), uniform(9_000), alike] {
            let built = Index::build(&points, 3, 7);
            assert!(Index::restored(&points, 3, &built.kept()).unwrap() == built, "{} points", points.len() / 3);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let points = uniform(9_000);
        let sound = Index::build(&points, 3, 7).kept();
        let refused = |spoil: fn(&mut IndexArrays)| {
            let mut kept = sound.clone();
            spoil(&mut kept);
            Index::restored(&points, 3, &kept).err().map(|unfit| unfit.array)
        };
        assert_eq!(refused(|_| ()), None);
        assert_eq!(refused(|kept| kept.lists[17] = u16::MAX), Some("lists"));
        assert_eq!(refused(|kept| kept.lists.truncate(100)), Some("lists"));
        assert_eq!(refused(|kept| kept.centres.truncate(100)), Some("centres"));
        assert_eq!(refused(|kept| kept.centres.truncate(99)), Some("lists"));
        assert_eq!(refused(|kept| kept.centres.clear()), Some("centres"));
        assert_eq!(refused(|kept| kept.centres[5] = f32::NAN), Some("centres"));
        assert_eq!(refused(|kept| kept.margins[5] = f32::NAN), Some("margins"));
        assert_eq!(refused(|kept| kept.margins.clear()), Some("margins"));
    }
}

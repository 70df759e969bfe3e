//! What takes long to find out about samples, as plain arrays to keep beside them: to which list of its index each belongs, and the planes of
//! exits. No file format.
//!
//! What comes back from a file is never trusted further than it can be checked or does harm: lists of any kind give an exact index, a basis is
//! tested, and planes only propose. Margins of lists are believed, as it is believed that the samples of the file are free: were they wrong,
//! searches would miss samples, and ways out would be longer than they need be, but still verified, beside lower bounds that know of no sample.

use super::index::Index;
use super::lists::{Lists, PADDING};
use super::projection::Projection;
use super::tangents::{KeptTangents, Tangents};
use super::{Indexed, SampleSet, embedded};
use crate::learning::kernel::LANES;
use crate::metric::Metric;

/// What is kept of the indices of a [`SampleSet`], and of its planes.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptSamples {
    /// Over all samples.
    pub all: KeptIndex,
    /// Over the exits, where there are any.
    pub exits: Option<KeptIndex>,
    /// Of the exits.
    pub tangents: KeptTangents,
}

/// What is kept of an index.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KeptIndex {
    /// Of each point, in their order.
    pub lists: Vec<u16>,
    /// Of each list, as many numbers as the index has dimensions.
    pub centres: Vec<f32>,
    /// As [`Lists::margins`] has them.
    pub margins: Vec<f32>,
    /// Of the projection, row after row; empty where there is none.
    pub basis: Vec<f64>,
}

/// An array that does not fit what it stands beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unfit {
    /// Of what it is an array: `index`, `exits` or `planes`.
    pub of: &'static str,
    /// Its name.
    pub array: &'static str,
    /// What it should hold.
    pub expected: &'static str,
}

impl SampleSet {
    /// What takes long to find out.
    pub fn kept(&self) -> KeptSamples {
        KeptSamples {
            all: self.all.kept(),
            exits: self.exits.as_ref().map(Indexed::kept),
            tangents: self.tangents.kept(),
        }
    }

    /// The set of which that was kept: of `configs`, whose last rows are exits; of `pairs` checked pairs, with `nv` tangent coordinates.
    ///
    /// # Errors
    /// [`Unfit`] where it was kept of another one, as far as that can be told.
    pub fn restored(
        metric: &Metric,
        [nq, nv, pairs]: [usize; 3],
        configs: Vec<f64>,
        exits: usize,
        kept: &KeptSamples,
    ) -> Result<Self, Unfit> {
        let embedding_len = metric.embedding_len();
        let points = embedded(metric, nq, &configs);
        let first = (configs.len() / nq).saturating_sub(exits);
        let all = Indexed::restored(&points, embedding_len, 0, &kept.all)?;
        let of_exits = kept.exits.as_ref().filter(|_| exits > 0);
        let of_exits = of_exits.map(|kept| Indexed::restored(&points, embedding_len, first, kept)).transpose();
        let of_exits = of_exits.map_err(|unfit| Unfit { of: "exits", ..unfit })?;
        if of_exits.is_some() != (exits > 0) {
            return Err(Unfit { of: "exits", array: "lists", expected: "an index of the exits" });
        }
        let tangents = Tangents::restored(nv, pairs, exits, &kept.tangents)?;
        Ok(Self { nq, configs, embedding_len, all, exits: of_exits, tangents })
    }
}

impl Indexed {
    fn kept(&self) -> KeptIndex {
        let basis = self.projection.as_ref().map_or_else(Vec::new, |projection| projection.basis().to_vec());
        KeptIndex { basis, ..self.index.kept() }
    }

    fn restored(points: &[f64], embedding_len: usize, first: usize, kept: &KeptIndex) -> Result<Self, Unfit> {
        let points = &points[first * embedding_len..];
        let projection = if kept.basis.is_empty() {
            None
        } else {
            let found = Projection::from_basis(&kept.basis, embedding_len);
            Some(found.ok_or(Unfit {
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
    fn kept(&self) -> KeptIndex {
        let Lists { len, ids, starts, centres, dimensions, .. } = &self.lists;
        let mut lists = vec![0; *len];
        for (list, ends) in starts.windows(2).enumerate() {
            let places = ends[0] as usize * LANES..ends[1] as usize * LANES;
            // Fewer lists than that are ever made.
            ids[places].iter().filter(|id| **id != PADDING).for_each(|id| lists[*id as usize] = list as u16);
        }
        let centres = (0..centres.len()).flat_map(|c| (0..*dimensions).map(move |k| centres.coordinate(c, k)));
        KeptIndex { lists, centres: centres.collect(), margins: self.lists.margins(), basis: Vec::new() }
    }

    fn restored(points: &[f64], dimensions: usize, kept: &KeptIndex) -> Result<Self, Unfit> {
        let (n, count) = (points.len() / dimensions, kept.centres.len() / dimensions);
        let check =
            |holds: bool, array, expected| if holds { Ok(()) } else { Err(Unfit { of: "index", array, expected }) };
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
        // No point, one list, many; and lists that attract nothing, where most points are one.
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
        let refused = |spoil: fn(&mut KeptIndex)| {
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

//! Contact planes of solved samples: one linearised constraint for each near contact.

use rayon::prelude::*;

use super::mismatch::Mismatch;

/// For each of some samples, the linearised signed distances of its near contacts. To first order,
/// a step `t` (tangent coordinates) from a sample respects contact `k` if
/// `gradient(k) . t >= -room(k)`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactPlanes {
    nv: usize,
    /// First plane of each sample, and the end of the last.
    starts: Vec<u32>,
    /// One row a plane: by how much the distance exceeds the clearance \[m\], then `nv` numbers of
    /// the gradient \[m per rad or m\]. Rows are contiguous because descents wait for memory. They
    /// are in single precision because they only propose.
    planes: Vec<f32>,
    /// Checked pair of each plane, stored apart because only queries in a changed scene need it.
    pairs: Vec<u32>,
}

/// [`ContactPlanes`] in the form that is stored, without the coordinates that cannot change the
/// distance of a pair: about half of all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactPlaneArrays {
    /// Number of planes of each sample.
    pub counts: Vec<u8>,
    /// The checked pair of each plane.
    pub pairs: Vec<u32>,
    /// For every checked pair and tangent coordinate: 1 if some gradient is not zero there, else 0.
    pub columns: Vec<u8>,
    /// Room of each plane, then its gradient at the coordinates that `columns` marks for its pair.
    pub numbers: Vec<f32>,
}

const SAMPLES_PER_TASK: usize = 1024;

impl ContactPlanes {
    /// Returns the form that is stored.
    pub fn kept(&self) -> ContactPlaneArrays {
        let width = self.nv + 1;
        let pairs = self.pairs.iter().max().map_or(0, |most| *most as usize + 1);
        let mut columns = vec![0; pairs * self.nv];
        let planes = || self.pairs.iter().zip(self.planes.chunks_exact(width));
        for (pair, plane) in planes() {
            let columns = &mut columns[*pair as usize * self.nv..][..self.nv];
            columns.iter_mut().zip(&plane[1..]).for_each(|(column, x)| *column |= u8::from(*x != 0.0));
        }
        let mut numbers = Vec::new();
        for (pair, plane) in planes() {
            let columns = &columns[*pair as usize * self.nv..][..self.nv];
            numbers.push(plane[0]);
            numbers.extend(columns.iter().zip(&plane[1..]).filter(|(column, _)| **column == 1).map(|(_, x)| x));
        }
        let counts = self.starts.windows(2).map(|ends| (ends[1] - ends[0]) as u8).collect();
        ContactPlaneArrays { counts, pairs: self.pairs.clone(), columns, numbers }
    }

    /// Restores the planes of `samples` samples with `nv` tangent coordinates, in a scene of
    /// `checked_pairs` checked pairs.
    ///
    /// # Errors
    /// [`Mismatch`] if the arrays visibly belong to something else.
    pub fn restored(
        nv: usize,
        checked_pairs: usize,
        samples: usize,
        kept: &ContactPlaneArrays,
    ) -> Result<Self, Mismatch> {
        let ContactPlaneArrays { counts, pairs, columns, numbers } = kept;
        let check =
            |holds: bool, array, expected| if holds { Ok(()) } else { Err(Mismatch { of: "planes", array, expected }) };
        check(counts.len() == samples, "counts", "a number for every exit")?;
        let planes: usize = counts.iter().map(|count| usize::from(*count)).sum();
        check(pairs.len() == planes, "pairs", "as many as there are planes")?;
        let known = columns.len() / nv.max(1);
        let are_columns = columns.len() == known * nv && known <= checked_pairs && columns.iter().all(|x| *x < 2);
        check(are_columns, "columns", "0 or 1 for every coordinate of checked pairs")?;
        check(pairs.iter().all(|pair| (*pair as usize) < known), "pairs", "checked pairs with columns")?;
        let columns = columns.chunks_exact(nv.max(1)).map(|row| (0..nv).filter(|k| row[*k] == 1).collect());
        let columns: Vec<Vec<usize>> = columns.collect();
        let width_of = |pair: &u32| 1 + columns[*pair as usize].len();
        let are_numbers = numbers.len() == pairs.iter().map(width_of).sum::<usize>();
        check(are_numbers && numbers.iter().all(|x| x.is_finite()), "numbers", "as many finite ones as planes take")?;
        let mut starts = vec![0];
        let mut end = 0;
        starts.extend(counts.iter().map(|count| {
            end += u32::from(*count);
            end
        }));
        let mut all = vec![0.0; planes * (nv + 1)];
        let (mut rest, mut tasks) = ((&mut all[..], &pairs[..], &numbers[..]), Vec::new());
        for counts in counts.chunks(SAMPLES_PER_TASK) {
            let count: usize = counts.iter().map(|count| usize::from(*count)).sum();
            let (of_chunk, pairs) = rest.1.split_at(count);
            let (planes, dense) = rest.0.split_at_mut(count * (nv + 1));
            let (numbers, sparse) = rest.2.split_at(of_chunk.iter().map(width_of).sum());
            tasks.push((planes, of_chunk, numbers));
            rest = (dense, pairs, sparse);
        }
        tasks.into_par_iter().for_each(|(planes, pairs, mut numbers)| {
            for (plane, pair) in planes.chunks_exact_mut(nv + 1).zip(pairs) {
                let (of_plane, others) = numbers.split_at(width_of(pair));
                plane[0] = of_plane[0];
                columns[*pair as usize].iter().zip(&of_plane[1..]).for_each(|(k, x)| plane[1 + k] = *x);
                numbers = others;
            }
        });
        Ok(Self { nv, starts, planes: all, pairs: pairs.clone() })
    }

    /// Creates an empty set for samples with `nv` tangent coordinates.
    pub fn new(nv: usize) -> Self {
        Self { nv, starts: vec![0], ..Self::default() }
    }

    /// Adds a plane of the checked pair `pair` to the current sample.
    pub fn push(&mut self, pair: usize, room: f64, gradient: &[f64]) {
        self.pairs.push(pair as u32);
        self.planes.push(room as f32);
        self.planes.extend(gradient.iter().map(|x| *x as f32));
    }

    /// Ends the current sample; planes that follow belong to the next.
    pub fn end_sample(&mut self) {
        self.starts.push(self.count());
    }

    /// Appends the samples of `other`.
    pub fn append(&mut self, other: &Self) {
        let before = self.count();
        self.planes.extend_from_slice(&other.planes);
        self.pairs.extend_from_slice(&other.pairs);
        self.starts.extend(other.starts.iter().skip(1).map(|end| before + end));
    }

    /// Number of planes of all samples.
    fn count(&self) -> u32 {
        (self.planes.len() / (self.nv + 1)) as u32
    }

    /// Number of samples that were ended.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether no sample was ended.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the planes of one sample.
    pub fn planes(&self, sample: usize) -> Planes<'_> {
        let width = self.nv + 1;
        let (first, last) = (self.starts[sample] as usize, self.starts[sample + 1] as usize);
        let (numbers, pairs) = (&self.planes[first * width..last * width], &self.pairs[first..last]);
        Planes { width, numbers, pairs, holding: None }
    }
}

/// The planes of one sample, see [`ContactPlanes`].
#[derive(Debug, Clone, Copy)]
pub struct Planes<'a> {
    width: usize,
    numbers: &'a [f32],
    pairs: &'a [u32],
    /// Whether the planes of each checked pair hold; `None` if all do.
    holding: Option<&'a [bool]>,
}

impl<'a> Planes<'a> {
    /// Restricts the planes to marked pairs; a pair beyond the end of the list is not marked.
    pub fn of_pairs(self, holding: &'a [bool]) -> Self {
        Self { holding: Some(holding), ..self }
    }

    /// Iterates over the room \[m\] and the gradient of each plane.
    pub fn iter(&self) -> impl Iterator<Item = (f64, impl Iterator<Item = f64> + use<'a>)> + use<'a> {
        let holding = self.holding;
        let holds = move |pair: u32| holding.is_none_or(|holding| holding.get(pair as usize) == Some(&true));
        let planes = self.numbers.chunks_exact(self.width).zip(self.pairs).filter(move |(_, pair)| holds(**pair));
        planes.map(move |(plane, _)| (f64::from(plane[0]), plane[1..].iter().map(|x| f64::from(*x))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_append_to_the_whole() {
        let planes = |stored: &ContactPlanes, sample| -> Vec<(f64, Vec<f64>)> {
            stored.planes(sample).iter().map(|(room, gradient)| (room, gradient.collect())).collect()
        };
        let (mut a, mut b) = (ContactPlanes::new(2), ContactPlanes::new(2));
        a.push(0, 0.5, &[1.0, 2.0]);
        a.push(0, 0.25, &[-1.0, 0.0]);
        a.end_sample();
        b.end_sample();
        b.push(0, 0.75, &[3.0, 4.0]);
        b.end_sample();
        let mut all = ContactPlanes::new(2);
        assert!(all.is_empty());
        all.append(&a);
        all.append(&b);
        assert_eq!(all.len(), 3);
        assert_eq!(planes(&all, 0), [(0.5, vec![1.0, 2.0]), (0.25, vec![-1.0, 0.0])]);
        assert_eq!(planes(&all, 1), []);
        assert_eq!(planes(&all, 2), [(0.75, vec![3.0, 4.0])]);
    }

    fn noted() -> ContactPlanes {
        let mut stored = ContactPlanes::new(3);
        for sample in 0..3000u32 {
            for pair in [1, 4].into_iter().take((sample % 3) as usize) {
                // Coordinate 0 is zero for even samples alone, coordinate 1 for all.
                stored.push(pair, 0.1 * f64::from(sample), &[f64::from(sample % 2), 0.0, 1.0 + pair as f64]);
            }
            stored.end_sample();
        }
        stored
    }

    #[test]
    fn what_is_kept_is_all_of_it() {
        let stored = noted();
        let kept = stored.kept();
        assert_eq!(kept.numbers.len(), 3 * kept.pairs.len());
        assert!(ContactPlanes::restored(3, 5, 3000, &kept).unwrap() == stored);
        let none = ContactPlanes::new(3);
        assert!(ContactPlanes::restored(3, 0, 0, &none.kept()).unwrap() == none);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let sound = noted().kept();
        let refused = |spoil: fn(&mut ContactPlaneArrays)| {
            let mut kept = sound.clone();
            spoil(&mut kept);
            ContactPlanes::restored(3, 5, 3000, &kept).err().map(|unfit| unfit.array)
        };
        assert_eq!(refused(|kept| kept.counts.truncate(2999)), Some("counts"));
        assert_eq!(refused(|kept| kept.counts[0] += 1), Some("pairs"));
        assert_eq!(refused(|kept| kept.pairs[0] = 5), Some("pairs"));
        assert_eq!(refused(|kept| kept.columns.truncate(13)), Some("columns"));
        assert_eq!(refused(|kept| kept.columns.resize(18, 0)), Some("columns"));
        assert_eq!(refused(|kept| kept.columns[0] = 2), Some("columns"));
        assert_eq!(refused(|kept| kept.columns[3] ^= 1), Some("numbers"));
        assert_eq!(refused(|kept| kept.numbers[3] = f32::INFINITY), Some("numbers"));
        assert_eq!(refused(|kept| kept.numbers.truncate(7)), Some("numbers"));
        assert_eq!(ContactPlanes::restored(3, 4, 3000, &sound).err().map(|unfit| unfit.array), Some("columns"));
    }

    #[test]
    fn only_planes_of_marked_pairs_hold() {
        let mut stored = ContactPlanes::new(1);
        for (pair, room) in [(0, 0.5), (2, 0.25), (7, 0.125)] {
            stored.push(pair, room, &[1.0]);
        }
        stored.end_sample();
        let planes = stored.planes(0).of_pairs(&[true, true, false]);
        assert_eq!(planes.iter().map(|(room, _)| room).collect::<Vec<_>>(), [0.5]);
    }
}

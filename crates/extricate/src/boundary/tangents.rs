//! What stored exits know of the free space around them: a plane for each contact near by.

/// Numbers of single precision in one.
const CACHE_LINE: usize = 16;

/// For each of some samples, the linearised signed distances of its near contacts: a step `t` (tangent coordinates) from sample `i` keeps
/// contact `k` to first order where `gradient(k) . t >= -room(k)`.
#[derive(Debug, Clone, Default)]
pub struct Tangents {
    nv: usize,
    /// Where the planes of each sample start, and the end of the last.
    starts: Vec<u32>,
    /// By how much the distance exceeds the clearance \[m\], then `nv` numbers of the gradient \[m per rad or m\], a plane: side by side, as who
    /// follows them waits for memory. Single precision: they only propose.
    planes: Vec<f32>,
    /// The checked pair of each plane, apart from them: only who asks in a changed scene wants to know.
    pairs: Vec<u32>,
}

impl Tangents {
    /// Of no sample yet, with `nv` tangent coordinates.
    pub fn new(nv: usize) -> Self {
        Self { nv, starts: vec![0], ..Self::default() }
    }

    /// Adds a plane of the checked pair `pair` to the sample that comes next.
    pub fn push(&mut self, pair: usize, room: f64, gradient: &[f64]) {
        self.pairs.push(pair as u32);
        self.planes.push(room as f32);
        self.planes.extend(gradient.iter().map(|x| *x as f32));
    }

    /// Ends the sample that comes next.
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

    /// Planes so far.
    fn count(&self) -> u32 {
        (self.planes.len() / (self.nv + 1)) as u32
    }

    /// Samples so far.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Memory that they take \[bytes\].
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.planes[..]) + size_of_val(&self.pairs[..])
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Of one sample: each plane's room and gradient.
    pub fn planes(&self, sample: usize) -> Planes<'_> {
        let width = self.nv + 1;
        let (first, last) = (self.starts[sample] as usize, self.starts[sample + 1] as usize);
        let (numbers, pairs) = (&self.planes[first * width..last * width], &self.pairs[first..last]);
        Planes { width, numbers, pairs, elsewhere: None }
    }
}

/// The planes of one sample, see [`Tangents`].
#[derive(Debug, Clone, Copy)]
pub struct Planes<'a> {
    width: usize,
    numbers: &'a [f32],
    pairs: &'a [u32],
    elsewhere: Option<Elsewhere<'a>>,
}

/// What becomes of planes in another scene.
#[derive(Debug, Clone, Copy)]
pub struct Elsewhere<'a> {
    /// For every checked pair of the scene in which they were noted, whether it is checked here too, and its bodies are what they were.
    pub stays: &'a [bool],
    /// By how much the clearance is larger here \[m\].
    pub wider: f64,
}

impl<'a> Planes<'a> {
    /// Reads a number of each cache line.
    pub fn touch(&self) -> f32 {
        self.numbers.iter().step_by(CACHE_LINE).sum()
    }

    /// Those that still hold in another scene; what is new there has none.
    pub fn elsewhere(self, elsewhere: Elsewhere<'a>) -> Self {
        Self { elsewhere: Some(elsewhere), ..self }
    }

    /// Room \[m\] and gradient of each.
    pub fn iter(&self) -> impl Iterator<Item = (f64, impl Iterator<Item = f64> + use<'a>)> + use<'a> {
        let elsewhere = self.elsewhere;
        let wider = elsewhere.map_or(0.0, |elsewhere| elsewhere.wider);
        let holds = move |pair: u32| elsewhere.is_none_or(|at| at.stays.get(pair as usize).is_some_and(|stays| *stays));
        let planes = self.numbers.chunks_exact(self.width).zip(self.pairs).filter(move |(_, pair)| holds(**pair));
        planes.map(move |(plane, _)| (f64::from(plane[0]) - wider, plane[1..].iter().map(|x| f64::from(*x))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_append_to_the_whole() {
        let planes = |tangents: &Tangents, sample| -> Vec<(f64, Vec<f64>)> {
            tangents.planes(sample).iter().map(|(room, gradient)| (room, gradient.collect())).collect()
        };
        let (mut a, mut b) = (Tangents::new(2), Tangents::new(2));
        a.push(0, 0.5, &[1.0, 2.0]);
        a.push(0, 0.25, &[-1.0, 0.0]);
        a.end_sample();
        b.end_sample();
        b.push(0, 0.75, &[3.0, 4.0]);
        b.end_sample();
        let mut all = Tangents::new(2);
        assert!(all.is_empty());
        all.append(&a);
        all.append(&b);
        assert_eq!(all.len(), 3);
        assert_eq!(planes(&all, 0), [(0.5, vec![1.0, 2.0]), (0.25, vec![-1.0, 0.0])]);
        assert_eq!(planes(&all, 1), []);
        assert_eq!(planes(&all, 2), [(0.75, vec![3.0, 4.0])]);
    }

    #[test]
    fn elsewhere_only_planes_of_pairs_that_stay_hold_and_have_less_room() {
        let mut tangents = Tangents::new(1);
        for (pair, room) in [(0, 0.5), (2, 0.25), (7, 0.125)] {
            tangents.push(pair, room, &[1.0]);
        }
        tangents.end_sample();
        let stays = [true, true, false];
        let planes = tangents.planes(0).elsewhere(Elsewhere { stays: &stays, wider: 0.0625 });
        // A pair that is not told of does not stay.
        assert_eq!(planes.iter().map(|(room, _)| room).collect::<Vec<_>>(), [0.4375]);
    }
}

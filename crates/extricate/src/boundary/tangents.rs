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
}

impl Tangents {
    /// Of no sample yet, with `nv` tangent coordinates.
    pub fn new(nv: usize) -> Self {
        Self { nv, starts: vec![0], ..Self::default() }
    }

    /// Adds a plane to the sample that comes next.
    pub fn push(&mut self, room: f64, gradient: &[f64]) {
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
        size_of_val(&self.starts[..]) + size_of_val(&self.planes[..])
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Of one sample: each plane's room and gradient.
    pub fn planes(&self, sample: usize) -> Planes<'_> {
        let width = self.nv + 1;
        let (first, last) = (self.starts[sample] as usize, self.starts[sample + 1] as usize);
        Planes { width, numbers: &self.planes[first * width..last * width] }
    }
}

/// The planes of one sample, see [`Tangents`].
#[derive(Debug, Clone, Copy)]
pub struct Planes<'a> {
    width: usize,
    numbers: &'a [f32],
}

impl<'a> Planes<'a> {
    /// Reads a number of each cache line.
    pub fn touch(&self) -> f32 {
        self.numbers.iter().step_by(CACHE_LINE).sum()
    }

    /// Room \[m\] and gradient of each.
    pub fn iter(&self) -> impl Iterator<Item = (f64, impl Iterator<Item = f64> + use<'a>)> + use<'a> {
        let plane = |plane: &'a [f32]| (f64::from(plane[0]), plane[1..].iter().map(|x| f64::from(*x)));
        self.numbers.chunks_exact(self.width).map(plane)
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
        a.push(0.5, &[1.0, 2.0]);
        a.push(0.25, &[-1.0, 0.0]);
        a.end_sample();
        b.end_sample();
        b.push(0.75, &[3.0, 4.0]);
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
}

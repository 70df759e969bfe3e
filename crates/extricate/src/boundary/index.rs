//! stub: linear scan
/// x
pub struct Index {
    p: Vec<f64>,
    d: usize,
}
/// x
#[derive(Default)]
pub struct SearchScratch {}
impl Index {
    /// x
    pub fn build(p: &[f64], d: usize, _: u64) -> Self {
        Self { p: p.to_vec(), d }
    }
    /// x
    pub fn search(&self, q: &[f64], _: &mut SearchScratch, f: &mut dyn FnMut(u32, f64) -> f64) {
        let mut r = f64::INFINITY;
        for (i, x) in self.p.chunks_exact(self.d).enumerate() {
            let d = x.iter().zip(q).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            if d <= r {
                r = f(i as u32, d);
            }
        }
    }
}

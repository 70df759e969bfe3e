//! Timings on whole robots: labels one at a time and in batches, and near pairs with their
//! gradients.

use std::hint::black_box;
use std::time::Instant;

use anyhow::{Result, bail};
use extricate::internals::collision::{ContactQuery, ContactSearch};
use extricate::internals::cspace::sampling;
use extricate::internals::kinematics::{Twists, forward};
use extricate::{CheckScratch, Checker, Label, Scene};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::clock::ThreadTime;

/// Repetitions of a batch, of which the fastest counts.
const BATCH_REPEATS: usize = 20;

pub struct Robot {
    checker: Checker,
}

impl Robot {
    pub fn new(scene: Scene) -> Self {
        Self { checker: Checker::new(scene.into()) }
    }

    /// Returns coordinates, bodies, pairs and joint names.
    pub fn describe(&self) -> Value {
        let scene = self.checker.scene();
        let names: Vec<&str> = scene.joints().iter().map(|joint| joint.name.as_str()).collect();
        json!({ "nq": scene.space().nq(), "bodies": scene.bodies().len(), "pairs": scene.pairs().len(), "joints": names })
    }

    /// Draws uniform configurations, or both ends of segments between opposite labels, bisected
    /// down to 1/1000 rad.
    pub fn configs(&self, kind: &str, count: usize, seed: u64) -> Result<Vec<f64>> {
        let space = self.checker.scene().space();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut scratch = CheckScratch::default();
        let mut draw = || {
            let mut q = vec![0.0; space.nq()];
            sampling::uniform(space, &mut rng, &mut q);
            q
        };
        match kind {
            "uniform" => Ok((0..count).flat_map(|_| draw()).collect()),
            "boundary" => {
                let mut rows = Vec::new();
                for _ in 0..1000 * count {
                    let (mut a, mut b) = (draw(), draw());
                    let label = self.checker.label(&a, &mut scratch);
                    if self.checker.label(&b, &mut scratch) == label {
                        continue;
                    }
                    while gap(&a, &b) > 1e-3 {
                        let middle: Vec<f64> = a.iter().zip(&b).map(|(x, y)| 0.5 * (x + y)).collect();
                        let same = self.checker.label(&middle, &mut scratch) == label;
                        *(if same { &mut a } else { &mut b }) = middle;
                    }
                    rows.extend([a, b]);
                    if rows.len() >= count {
                        break;
                    }
                }
                rows.truncate(count);
                Ok(rows.concat())
            }
            _ => bail!("got `{kind}`, expected uniform or boundary"),
        }
    }

    /// Times labels one at a time: the mean over the whole loop, then median and 95th percentile of
    /// single calls.
    pub fn label(&self, configs: &[f64], out: Option<&str>) -> Result<Value> {
        let nq = self.checker.scene().space().nq();
        let mut scratch = CheckScratch::default();
        for q in configs.chunks_exact(nq).take(configs.len() / nq / 10) {
            black_box(self.checker.label(q, &mut scratch));
        }
        let start = ThreadTime::now();
        for q in configs.chunks_exact(nq) {
            black_box(self.checker.label(q, &mut scratch));
        }
        let mean = start.elapsed() / (configs.len() / nq) as f64;
        let mut answers = Vec::new();
        let each = timed(configs.chunks_exact(nq), |q| {
            answers.push(u8::from(self.checker.label(q, &mut scratch) == Label::Colliding));
        });
        if let Some(path) = out {
            std::fs::write(path, &answers)?;
        }
        let colliding = answers.iter().filter(|a| **a == 1).count() as f64 / answers.len() as f64;
        Ok(json!({ "mean": mean, "median": each.0, "p95": each.1, "colliding": colliding }))
    }

    /// Times a batch on `threads` threads; with 0, the serial function on the calling thread.
    pub fn batch(&self, configs: &[f64], threads: usize) -> Result<Value> {
        let count = configs.len() / self.checker.scene().space().nq();
        let mut labels = vec![Label::Free; count];
        let seconds = if threads == 0 {
            let mut scratch = CheckScratch::default();
            let start = ThreadTime::now();
            self.checker.label_batch_serial(configs, &mut labels, &mut scratch);
            start.elapsed()
        } else {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            // Other programs lengthen wall time, so the shortest of several runs counts.
            let mut once = || {
                let start = Instant::now();
                self.checker.label_batch(configs, &mut labels);
                start.elapsed().as_secs_f64()
            };
            pool.install(|| (0..BATCH_REPEATS).map(|_| once()).fold(f64::INFINITY, f64::min))
        };
        let colliding = labels.iter().filter(|label| **label == Label::Colliding).count();
        Ok(json!({ "seconds": seconds, "count": count, "hits": colliding }))
    }

    /// Times the evaluations that a step of refinement needs: the contacts nearer than `margin`
    /// \[m\], and the gradient of each distance.
    pub fn contacts(&self, configs: &[f64], margin: f64, search: &str) -> Result<Value> {
        let search = match search {
            "coarse" => ContactSearch::Proposal,
            "exact" => ContactSearch::Exact,
            _ => bail!("got `{search}`, expected coarse or exact"),
        };
        let scene = self.checker.scene();
        let (nq, nv) = (scene.space().nq(), scene.space().nv());
        let (mut scratch, mut contacts, mut poses) = (CheckScratch::default(), Vec::new(), Vec::new());
        let (mut gradients, mut twists, mut found) = (vec![0.0; nv], Twists::default(), 0);
        let mut step = |q: &[f64]| {
            contacts.clear();
            self.checker.contacts(q, ContactQuery { margin, search }, &mut scratch, &mut contacts);
            forward(scene, q, &mut poses);
            twists.set(scene, &poses);
            gradients.clear();
            gradients.resize(nv * contacts.len(), 0.0);
            for (contact, row) in contacts.iter().zip(gradients.chunks_exact_mut(nv)) {
                contact.add_gradient(scene, &twists, row);
            }
            black_box(&gradients);
            found += contacts.len();
        };
        configs.chunks_exact(nq).take(configs.len() / nq / 10).for_each(&mut step);
        let (median, p95) = timed(configs.chunks_exact(nq), &mut step);
        let per = found as f64 / (configs.len() / nq) as f64 / 1.1;
        Ok(json!({ "median": median, "p95": p95, "contacts": per }))
    }
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// Median and 95th percentile of the seconds of single calls.
fn timed<T>(inputs: impl Iterator<Item = T>, mut call: impl FnMut(T)) -> (f64, f64) {
    let seconds = |input| {
        let start = Instant::now();
        call(input);
        start.elapsed().as_secs_f64()
    };
    let mut each: Vec<f64> = inputs.map(seconds).collect();
    each.sort_by(f64::total_cmp);
    if each.is_empty() { (0.0, 0.0) } else { (each[each.len() / 2], each[each.len() * 19 / 20]) }
}

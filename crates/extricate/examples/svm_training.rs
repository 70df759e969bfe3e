//! Trains a support vector machine on uniform configurations of a scene, on one thread, and writes
//! the training data for other programs: `svm_training SCENE.toml SAMPLES GAMMA_FACTOR PENALTY
//! FOLDER`. bench/svm.py uses it.
//!
//! FOLDER gets `features.f64` (rows of scaled features, little endian) and `labels.u8` (1 free);
//! one line of JSON goes to standard output. Timing begins with the rows that other programs get,
//! so it includes finding the directions in which they vary.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use extricate::internals::cspace::sampling::Halton;
use extricate::internals::io;
use extricate::internals::learning::svm::kernel::PointSet;
use extricate::internals::learning::svm::model_selection::median_squared_distance;
use extricate::internals::learning::svm::scaling::{Scaling, Standardization};
use extricate::internals::learning::svm::smo::{SvmOptions, train};
use extricate::internals::metric::{Metric, MetricScratch};
use extricate::{Checker, Label, MetricKind};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, samples, gamma_factor, penalty, folder] = &args[..] else {
        return Err("expected: SCENE.toml SAMPLES GAMMA_FACTOR PENALTY FOLDER".into());
    };
    let (samples, gamma_factor, penalty): (usize, f64, f64) =
        (samples.parse()?, gamma_factor.parse()?, penalty.parse()?);
    let scene = Arc::new(io::load_scene(Path::new(scene))?);
    let (checker, metric) = (Checker::new(scene.clone()), Metric::of_kind(scene.clone(), MetricKind::ObjectNorm));
    let (nq, dimensions) = (scene.space().nq(), metric.embedding_len());
    let halton = Halton::new(scene.space().nv(), 0);
    let mut configs = vec![0.0; samples * nq];
    configs.chunks_exact_mut(nq).enumerate().for_each(|(i, q)| halton.config(scene.space(), i as u64, q));
    let mut labels = vec![Label::Free; samples];
    checker.label_batch(&configs, &mut labels);
    let mut features = vec![0.0; samples * dimensions];
    let mut scratch = MetricScratch::default();
    for (q, row) in configs.chunks_exact(nq).zip(features.chunks_exact_mut(dimensions)) {
        metric.embed(q, &mut scratch, row);
    }
    let (rows, dimensions) = scaled(&features, dimensions);
    let free: Vec<bool> = labels.iter().map(|l| *l == Label::Free).collect();
    let gamma = gamma_factor / median_squared_distance(&PointSet::from_rows(&rows, dimensions), 0);
    let options = SvmOptions { c_positive: penalty, c_negative: penalty, gamma, tolerance: 1e-3, cache_bytes: 1 << 30 };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (solution, seconds, cpu_seconds) = pool.install(|| {
        let (started, before) = (Instant::now(), thread_seconds());
        let standardization = Standardization::fit(&rows, dimensions, Scaling::Global);
        let points = PointSet::from_rows(&standardization.apply_all(&rows), standardization.kept());
        let solution = train(&points, &free, &options, None);
        let wall = started.elapsed().as_secs_f64();
        (solution, wall, before.and_then(|before| Some(thread_seconds()? - before)).unwrap_or(wall))
    });
    let bytes: Vec<u8> = rows.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(Path::new(folder).join("features.f64"), bytes)?;
    std::fs::write(Path::new(folder).join("labels.u8"), free.iter().map(|f| u8::from(*f)).collect::<Vec<u8>>())?;
    println!(
        "{}",
        serde_json::json!({
            "samples": samples,
            "dimensions": dimensions,
            "gamma": gamma,
            "penalty": penalty,
            "seconds": seconds,
            "cpu_seconds": cpu_seconds,
            "dual_objective": solution.dual_objective,
            "violation": solution.violation,
            "support_vectors": solution.alphas.iter().filter(|a| **a > 0.0).count(),
            "steps": solution.iterations,
        })
    );
    Ok(())
}

/// Returns the columns that vary, centred and all scaled by one factor to unit mean variance, and
/// their number.
fn scaled(rows: &[f64], dimensions: usize) -> (Vec<f64>, usize) {
    let count = (rows.len() / dimensions) as f64;
    let column = |k: usize| rows.iter().skip(k).step_by(dimensions);
    let moments = |k: usize| {
        let mean = column(k).sum::<f64>() / count;
        (k, mean, column(k).map(|x| (x - mean).powi(2)).sum::<f64>() / count)
    };
    let kept: Vec<(usize, f64, f64)> =
        (0..dimensions).map(moments).filter(|(_, _, variance)| *variance > 1e-20).collect();
    let scale = (kept.iter().map(|(_, _, variance)| variance).sum::<f64>() / kept.len() as f64).sqrt().recip();
    let row = |row: &[f64]| kept.iter().map(|(k, mean, _)| (row[*k] - mean) * scale).collect::<Vec<f64>>();
    (rows.chunks_exact(dimensions).flat_map(row).collect(), kept.len())
}

/// Returns the processor time of this thread [s], if the system reports it; the wall clock also
/// counts the time of others.
fn thread_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}

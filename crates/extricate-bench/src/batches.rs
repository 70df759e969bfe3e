//! One batch of queries as a program in Rust asks it, timed as a whole: what other languages add is measured against it.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use extricate::{Config, QueryScratch, store};
use serde_json::json;

use crate::clock::ProcessTime;
use crate::queries::options;

/// Answers the rows of `queries` (f64, little endian, nothing between them) as a batch on `how` many threads, or in a plain `loop` that
/// keeps nothing, and writes one JSON line: `wall` and `processor` seconds from the numbers to the last answer, and the sum of depths.
pub fn answer(model: &str, queries: &str, effort: &str, how: &str, mut output: impl Write) -> Result<()> {
    let options = options(effort)?;
    let model = store::load_model(Path::new(model))?;
    let bytes = std::fs::read(queries).with_context(|| queries.to_string())?;
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    let (space, mut depth) = (&model.scene().space, 0.0);
    ensure!(numbers.len().is_multiple_of(space.nq()), "{queries}: expected rows of {} numbers", space.nq());
    let (began, processor) = (Instant::now(), ProcessTime::now());
    let rows = numbers.chunks_exact(space.nq());
    let count = rows.len();
    let given = if how == "loop" {
        let mut scratch = QueryScratch::default();
        for q in rows {
            depth += model.query(&space.config(q)?, &options, &mut scratch).depth;
        }
        count
    } else {
        let rows: Vec<Config> = rows.map(|q| space.config(q)).collect::<Result<_, _>>()?;
        let threads = how.parse().with_context(|| format!("expected `loop` or a number of threads, found {how}"))?;
        model.query_batch(rows, &options, threads, &mut |answered| {
            depth += answered.answer.depth;
            ControlFlow::Continue(())
        })
    };
    let (wall, processor) = (began.elapsed().as_secs_f64(), processor.elapsed());
    ensure!(given == count, "{given} of {count} queries were answered");
    writeln!(output, "{}", json!({ "queries": count, "wall": wall, "processor": processor, "depth": depth }))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use extricate::{LearnOptions, Model, scene::builtin};

    use super::*;

    #[test]
    fn a_batch_is_answered_and_nonsense_an_error() {
        let folder = std::env::temp_dir().join(format!("extricate-bench-batch-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let at = |name: &str| folder.join(name).to_str().unwrap().to_string();
        let options = LearnOptions { labels: 3000, seconds: None, ..LearnOptions::default() };
        let scene = builtin::scene("planar-arm").unwrap();
        let model = Model::learn(scene, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        store::save_model(&model, Path::new(&at("arm.model"))).unwrap();
        let rows = [[0.5, 0.0, 0.0], [0.6, 0.1, 0.0]].concat();
        let bytes: Vec<u8> = rows.iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
        std::fs::write(at("queries"), &bytes).unwrap();
        std::fs::write(at("broken"), &bytes[..40]).unwrap();
        let depths = rows.chunks(3).map(|q| {
            let q = model.scene().space.config(q).unwrap();
            model.query(&q, &Default::default(), &mut Default::default()).depth
        });
        let depth = depths.sum::<f64>();
        for how in ["loop", "1", "2"] {
            let mut out = Vec::new();
            answer(&at("arm.model"), &at("queries"), "refined", how, &mut out).unwrap();
            let line: serde_json::Value = serde_json::from_slice(&out).unwrap();
            assert_eq!((line["queries"].as_u64(), line["depth"].as_f64()), (Some(2), Some(depth)));
        }
        assert!(answer(&at("arm.model"), &at("broken"), "refined", "1", Vec::new()).is_err());
        assert!(answer(&at("arm.model"), &at("queries"), "refined", "many", Vec::new()).is_err());
        assert!(answer(&at("arm.model"), &at("queries"), "best", "1", Vec::new()).is_err());
        std::fs::remove_dir_all(folder).unwrap();
    }
}

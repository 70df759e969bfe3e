//! Batches of queries from Rust, each timed as a whole, and alternating with another language whose
//! overhead is measured against them.

use std::io::{BufRead, Write};
use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use extricate::internals::io;
use extricate::{Config, Solver};
use serde_json::json;

use super::options;
use crate::clock::ProcessTime;

/// Answers some rows of `queries` (f64, little endian, without gaps) for each line `FROM TO HOW` of
/// `commands`. Writes one JSON line for each: `wall` and `processor` seconds from the numbers to
/// the last answer, and the sum of depths.
///
/// `HOW` is a number of threads for a batch, or `loop` for a plain loop that keeps no answers. With
/// `each:THREADS` every thread answers all rows in such a loop; `wall` is that of the slowest
/// thread and `depth` is the sum over all.
pub fn serve(model: &str, queries: &str, effort: &str, commands: impl BufRead, mut output: impl Write) -> Result<()> {
    let solver = Solver::of_model(io::load_model(Path::new(model))?).options(options(effort)?)?;
    let bytes = std::fs::read(queries).with_context(|| queries.to_string())?;
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    let nq = solver.scene().space().nq();
    ensure!(numbers.len().is_multiple_of(nq), "{queries}: expected rows of {nq} numbers");
    writeln!(output, "{}", json!({ "rows": numbers.len() / nq }))?;
    output.flush()?;
    for line in commands.lines() {
        let line = line?;
        let (rows, how) = command(&line, numbers.len() / nq)
            .with_context(|| format!("expected `FROM TO THREADS|loop|each:THREADS`, found `{line}`"))?;
        let values = &numbers[rows.start * nq..rows.end * nq];
        let (began, processor) = (Instant::now(), ProcessTime::now());
        let depth = match how {
            How::Batch(threads) => batch(&solver, values, threads)?,
            How::Each(1) => in_a_loop(&solver, values)?,
            How::Each(threads) => thread::scope(|scope| {
                let work = || in_a_loop(&solver, values);
                let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
                workers.into_iter().map(|worker| worker.join().expect("queries do not panic")).sum::<Result<f64>>()
            })?,
        };
        let (wall, processor) = (began.elapsed().as_secs_f64(), processor.elapsed());
        writeln!(output, "{}", json!({ "wall": wall, "processor": processor, "depth": depth }))?;
        output.flush()?;
    }
    Ok(())
}

enum How {
    /// One batch on so many threads.
    Batch(usize),
    /// All rows on each of so many threads.
    Each(usize),
}

fn command(line: &str, rows: usize) -> Option<(Range<usize>, How)> {
    let [from, to, how] = line.split(' ').collect::<Vec<_>>()[..] else { return None };
    let range = from.parse().ok()?..to.parse().ok()?;
    let how = match how.strip_prefix("each:") {
        Some(threads) => How::Each(threads.parse().ok()?),
        None if how == "loop" => How::Each(1),
        None => How::Batch(how.parse().ok()?),
    };
    (range.start <= range.end && range.end <= rows).then_some((range, how))
}

fn batch(solver: &Solver, values: &[f64], threads: usize) -> Result<f64> {
    let space = solver.scene().space();
    let rows: Vec<Config> = values.chunks_exact(space.nq()).map(|q| space.config(q)).collect::<Result<_, _>>()?;
    let (count, mut depth) = (rows.len(), 0.0);
    let given = solver.batch_each(rows, threads, &mut |answered| {
        depth += answered.answer.map_or(f64::INFINITY, |answer| answer.depth);
        ControlFlow::Continue(())
    });
    ensure!(given == count, "{given} of {count} queries were answered");
    Ok(depth)
}

fn in_a_loop(solver: &Solver, values: &[f64]) -> Result<f64> {
    let space = solver.scene().space();
    let ask = |q: &[f64]| {
        let answer = solver.query(&space.config(q)?);
        Ok(answer.map_or(f64::INFINITY, |answer| answer.depth))
    };
    values.chunks_exact(space.nq()).map(ask).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::queries::learned_arm;

    #[test]
    fn blocks_are_answered_and_nonsense_an_error() {
        let folder = learned_arm("batches");
        let at = |name: &str| folder.join(name).to_str().unwrap().to_string();
        let solver = Solver::of_model(io::load_model(Path::new(&at("arm.model"))).unwrap());
        let rows = [[0.5, 0.0, 0.0], [0.6, 0.1, 0.0], [0.7, 0.1, 0.0]].concat();
        let bytes: Vec<u8> = rows.iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
        std::fs::write(at("queries"), &bytes).unwrap();
        std::fs::write(at("broken"), &bytes[..40]).unwrap();
        let depths: Vec<f64> =
            rows.chunks(3).map(|q| solver.query(&solver.scene().space().config(q).unwrap()).unwrap().depth).collect();
        let ask = |queries: &str, effort: &str, commands: &str| {
            let mut out = Vec::new();
            serve(&at("arm.model"), &at(queries), effort, commands.as_bytes(), &mut out).map(|()| {
                let lines = String::from_utf8(out).unwrap();
                let lines = lines.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
                lines.collect::<Vec<_>>()
            })
        };
        let lines = ask("queries", "refined", "0 3 loop\n0 3 1\n1 3 2\n2 2 1\n1 3 each:2").unwrap();
        assert_eq!(lines[0]["rows"], 3);
        let all: f64 = depths.iter().sum();
        let expected = [all, all, depths[1] + depths[2], 0.0, 2.0 * (depths[1] + depths[2])];
        for (line, depth) in lines[1..].iter().zip(expected) {
            assert!((line["depth"].as_f64().unwrap() - depth).abs() < 1e-12, "{line}");
            assert!(line["wall"].as_f64().unwrap() >= 0.0 && line["processor"].is_number());
        }
        assert_eq!(lines.len(), 6);
        for nonsense in ["0 4 1", "2 1 1", "0 3", "0 3 many", "0 3 each:", "0 3 1 2"] {
            assert!(ask("queries", "refined", nonsense).is_err(), "{nonsense}");
        }
        assert!(ask("broken", "refined", "").is_err());
        assert!(ask("queries", "best", "").is_err());
        std::fs::remove_dir_all(folder).unwrap();
    }
}

//! Answers the queries of a file and times each in processor time, which excludes other programs. A
//! warm-up excludes the costs of a program's first queries.

pub mod batches;
pub mod moved;
pub mod streams;

use std::io::Write;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use extricate::internals::io;
use extricate::{Config, ConfigSpace, QueryOptions, Solver, Termination};
use serde_json::{Value, json};

use crate::clock::ThreadTime;

/// Time for which other configurations are queried first.
pub const WARM_UP: Duration = Duration::from_millis(100);

/// Writes a JSON line for each line of `queries` (`{"q": [...]}`), with the keys of `extricate
/// query --json` that the benchmarks read; `seconds` are processor time of this thread. `target` is
/// a model, which may be queried in another scene, or a scene file (.toml), which is queried
/// without a model. `effort` is the name of an effort, a number of starts of `refined`, or its
/// largest number of checks, as `50-checks`.
pub fn answer(target: &str, other: Option<&str>, queries: &str, effort: &str, mut output: impl Write) -> Result<()> {
    let text = std::fs::read_to_string(queries).with_context(|| queries.to_string())?;
    let solver = load(target, other)?.options(options(effort)?)?;
    solver.warm_up(WARM_UP);
    for line in text.lines() {
        let q = config(solver.scene().space(), line).with_context(|| queries.to_string())?;
        let started = ThreadTime::now();
        let answer = solver.query(&q);
        let seconds = started.elapsed();
        let answer = answer.context("nothing free was found")?;
        let line = json!({
            "depth": answer.depth,
            "lower_bound": answer.lower_bound,
            "witness": answer.witness,
            "checks": answer.checks,
            "verified": answer.verified,
            "seconds": seconds,
        });
        writeln!(output, "{line}")?;
    }
    Ok(())
}

fn load(target: &str, other: Option<&str>) -> Result<Solver> {
    let path = Path::new(target);
    if path.extension().is_some_and(|extension| extension == "toml") {
        return Ok(Solver::new(io::load_scene(path)?));
    }
    let solver = Solver::of_model(io::load_model(path)?);
    match other {
        Some(other) => Ok(solver.with_scene(io::load_scene(Path::new(other))?)?),
        None => Ok(solver),
    }
}

/// Reads the configuration of a line `{"q": [...]}`.
pub fn config(space: &ConfigSpace, line: &str) -> Result<Config> {
    let line: Value = serde_json::from_str(line).with_context(|| line.to_string())?;
    let numbers = line["q"].as_array().context("a query without `q`")?;
    let numbers: Vec<f64> = numbers.iter().filter_map(Value::as_f64).collect();
    Ok(space.config(&numbers)?)
}

/// Options of `refined` with a number of starts or at most so many checks, or of a named effort.
pub fn options(effort: &str) -> Result<QueryOptions> {
    let options = QueryOptions::default();
    if let Ok(effort) = effort.parse() {
        return Ok(options.effort(effort));
    }
    Ok(match (effort.parse(), effort.strip_suffix("-checks").map(str::parse)) {
        (Ok(starts), _) => options.starts(starts),
        (_, Some(Ok(checks))) => options.termination(Termination::after_checks(checks)),
        _ => {
            bail!("expected nearest, refined, exhaustive, a number of starts or of checks (50-checks), found {effort}")
        }
    })
}

/// Learns a small model of `planar-arm` into `arm.model`, in a new folder for the test `test`.
#[cfg(test)]
pub fn learned_arm(test: &str) -> std::path::PathBuf {
    use extricate::{LearnOptions, Model, builtin};
    let folder = std::env::temp_dir().join(format!("extricate-bench-{test}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut options = LearnOptions::default().labels(3000);
    options.seconds = None;
    let scene = builtin::scene("planar-arm").unwrap();
    let model = Model::learn(scene, &options).unwrap();
    io::save_model(&model, folder.join("arm.model")).unwrap();
    folder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_query_has_an_answer_and_nonsense_an_error() {
        let folder = learned_arm("queries");
        let at = |name: &str| folder.join(name).to_str().unwrap().to_string();
        std::fs::write(at("queries"), "{\"q\": [0.5, 0, 0]}\n{\"q\": [0.6, 0.1, 0]}\n").unwrap();
        let mut out = Vec::new();
        for effort in ["nearest", "refined", "1", "9-checks"] {
            answer(&at("arm.model"), None, &at("queries"), effort, &mut out).unwrap();
        }
        let lines: Vec<Value> =
            String::from_utf8(out).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        assert_eq!(lines.len(), 8);
        // Proving a bound may take a few more.
        assert!(lines[6..].iter().all(|l| l["checks"].as_u64().is_some_and(|checks| checks <= 12)));
        assert!(lines.iter().all(|l| l["lower_bound"].as_f64() <= l["depth"].as_f64() && l["seconds"].is_number()));
        assert!(answer(&at("arm.model"), None, &at("queries"), "best", Vec::new()).is_err());
        std::fs::remove_dir_all(folder).unwrap();
    }
}

//! Our side of the benchmarks, and the test of the checker against all pairs of triangles.
//!
//! ```text
//! extricate-bench serve                    commands from standard input, answers as JSON lines (see `server`)
//! extricate-bench exact [--poses N]        N poses against brute force; exit status 1 on any disagreement
//! extricate-bench query SCENE|MODEL QUERIES EFFORT|STARTS|N-checks [--scene OTHER]  answers with processor times as JSON lines
//! extricate-bench batch MODEL QUERIES EFFORT|STARTS|N-checks  blocks of queries that standard input names, each timed as a whole
//! extricate-bench stream MODEL QUERIES STEPS FRAMES ROUNDS      frames between successive queries, by a stream and one by one
//! extricate-bench moved SCENE N                          a world in which N obstacles moved, beside one made anew
//! extricate-bench bounds SCENE|chains:FROM-TO N SEED     lower bounds of N queries against all that is found below them
//! extricate-bench distances SCENE N SEED DRAWS          N signed distances beside what DRAWS rays find and queries cost
//! extricate-bench scenery points|voxels N meshes|hulls   a cloud of N points around the built-in arm as one body, timed, as a JSON line
//! extricate-bench draw FOLDER SEED [--robots DIR]        scenes drawn at random, and what they are as JSON lines
//! ```
//!
//! `bench/collision.py` runs the first two beside the peers, the scripts beside it the others.

mod bounds;
mod clock;
mod drawn;
mod exact;
mod files;
mod labels;
mod queries;
mod robots;
mod scenery;
mod server;
mod signed_distances;

use std::path::Path;
use std::process::ExitCode;

use crate::queries::streams::Walk;

fn main() -> anyhow::Result<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["serve"] => server::serve(std::io::stdin().lock(), std::io::stdout().lock()).map(|()| ExitCode::SUCCESS),
        ["exact"] => exact_report(100_000),
        ["exact", "--poses", count] => exact_report(count.parse()?),
        ["query", model, queries, effort] => {
            queries::answer(model, None, queries, effort, std::io::stdout().lock()).map(|()| ExitCode::SUCCESS)
        }
        ["query", model, queries, effort, "--scene", other] => {
            queries::answer(model, Some(other), queries, effort, std::io::stdout().lock()).map(|()| ExitCode::SUCCESS)
        }
        ["batch", model, queries, effort] => {
            let (input, output) = (std::io::stdin().lock(), std::io::stdout().lock());
            crate::queries::batches::serve(model, queries, effort, input, output).map(|()| ExitCode::SUCCESS)
        }
        ["stream", model, queries, steps, frames, rounds] => {
            let walk = Walk { steps: steps.parse()?, frames: frames.parse()?, rounds: rounds.parse()? };
            crate::queries::streams::compare(model, queries, walk, std::io::stdout().lock()).map(|()| ExitCode::SUCCESS)
        }
        ["moved", scene, count] => {
            crate::queries::moved::measure(scene, count.parse()?, std::io::stdout().lock()).map(|()| ExitCode::SUCCESS)
        }
        ["distances", source, count, seed, draws] => {
            let output = std::io::stdout().lock();
            signed_distances::measure(source, count.parse()?, seed.parse()?, draws.parse()?, output)
                .map(|()| ExitCode::SUCCESS)
        }
        ["scenery", kind, count, links] => {
            scenery::measure(kind, count.parse()?, links, std::io::stdout().lock()).map(|()| ExitCode::SUCCESS)
        }
        ["bounds", source, count, seed] => {
            let holds = bounds::measure(source, count.parse()?, seed.parse()?, std::io::stdout().lock())?;
            Ok(if holds { ExitCode::SUCCESS } else { ExitCode::from(1) })
        }
        ["draw", folder, seed] => draw(folder, seed, None),
        ["draw", folder, seed, "--robots", robots] => draw(folder, seed, Some(Path::new(robots))),
        _ => {
            eprintln!(
                "expected `serve`, `exact [--poses N]`, `query SCENE|MODEL QUERIES EFFORT|STARTS|N-checks [--scene OTHER]`, \
                 `batch MODEL QUERIES EFFORT|STARTS|N-checks`, `stream MODEL QUERIES STEPS FRAMES ROUNDS`, \
                 `moved SCENE N`, `distances SCENE N SEED DRAWS`, `scenery points|voxels N meshes|hulls`, `bounds SCENE|chains:FROM-TO N SEED` or `draw FOLDER SEED [--robots DIR]`"
            );
            Ok(ExitCode::from(2))
        }
    }
}

fn draw(folder: &str, seed: &str, robots: Option<&Path>) -> anyhow::Result<ExitCode> {
    drawn::draw(Path::new(folder), seed.parse()?, robots, std::io::stdout().lock()).map(|()| ExitCode::SUCCESS)
}

fn exact_report(poses: usize) -> anyhow::Result<ExitCode> {
    let report = exact::run(poses, 1);
    println!("{}", report.json());
    Ok(if report.disagreements == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

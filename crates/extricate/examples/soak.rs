//! A soak test of the query. It queries many random configurations of the built-in scenes, and of
//! scene files if any are named, in every kind (efforts, several exits, streams, budgets, changed
//! scenes). It judges every claim of every answer with another library's distances.
//! ```sh
//! cargo run --release --example soak -- 1000000                       # over the built-in scenes, shared evenly
//! cargo run --release --example soak -- 1000000 a.toml b.toml         # and these
//! ```
//!
//! Exit status 0: no witness collides, every claim holds and no answer is missing. Otherwise the
//! faults are printed.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use extricate::internals::io;
use extricate::{Model, Scene, Solver, builtin};

#[path = "../tests/all/judge.rs"]
mod judge;
#[path = "../tests/all/memory.rs"]
#[allow(dead_code)]
mod memory;
#[path = "../tests/all/recheck.rs"]
mod recheck;
#[path = "../tests/all/soak.rs"]
mod soak;

/// Labels that a scene is learned with: enough for solved samples, which the queries of a default
/// model start from.
const LABELS: usize = 1_000_000;
/// Limit on the printed faults of each scene.
const MAX_PRINTED_FAULTS: usize = 5;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(count) = arguments.next().and_then(|n| n.parse::<usize>().ok()) else {
        eprintln!("usage: soak QUERIES [SCENE.toml ...]");
        return ExitCode::from(2);
    };
    let files: Vec<String> = arguments.collect();
    let scenes = builtin::NAMES.iter().map(|name| (name.to_string(), builtin::scene(name)));
    let scenes = scenes.chain(files.iter().map(|file| (file.clone(), io::load_scene(Path::new(file)))));
    let each = count.div_ceil(builtin::NAMES.len() + files.len());
    let mut faults = 0;
    for (name, scene) in scenes {
        match scene.and_then(|scene| run(&name, scene, each)) {
            Ok(found) => faults += found,
            Err(error) => {
                eprintln!("{name}: {error}");
                faults += 1;
            }
        }
    }
    println!("{faults} faults");
    if faults == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run(name: &str, scene: Scene, count: usize) -> extricate::Result<usize> {
    let model = Solver::of_model(Model::learn(scene, &memory::labels_alone(LABELS, 0))?);
    let mut told = Instant::now();
    let findings = soak::soak(&model, count, &mut |findings| {
        if told.elapsed().as_secs() >= 10 {
            told = Instant::now();
            let asked: usize = findings.counts.values().map(|kind| kind.configs).sum();
            eprintln!("{name}: {asked} of {count} asked, {} faults", findings.faults.len());
        }
    });
    println!("{name}");
    for (kind, ..) in soak::KINDS {
        let soak::Count { configs, answers, colliding, faults, seconds } = findings.counts[kind];
        println!(
            "  {kind:<10} {configs:>8} asked, {colliding:>8} of them in collision, {answers:>8} answers, {faults} faults, {seconds:.0} s"
        );
    }
    findings.faults.iter().take(MAX_PRINTED_FAULTS).for_each(|fault| println!("  {fault}"));
    Ok(findings.faults.len())
}

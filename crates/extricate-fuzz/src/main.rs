//! Runs a target on inputs that a random number generator makes of its corpus, with any toolchain.
//!
//! `extricate-fuzz TARGET COUNT SEED [FOLDER]` reports every place that panics, once, with the
//! number of inputs that got there; every input that takes longer than 10 s of the processor; and
//! how many were tried. What it reports lies in FOLDER, which is `fuzz/artifacts/TARGET` where none
//! is given.
//! Nothing stops an input that never ends but a second thread, which keeps it and ends the
//! program. `extricate-fuzz corpus FOLDER` writes the corpora, a folder each.

use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use std::{env, fs, io, thread};

use extricate_fuzz::{TARGETS, Target, target};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::time::{ClockId, clock_gettime};

/// An input that takes longer is reported: time of the processor, since others may use it too.
const SLOW: Duration = Duration::from_secs(10);
/// One that takes longer ends the program.
const ENDLESS: Duration = Duration::from_secs(60);
/// Inputs between two lines that say how far it is.
const BETWEEN_LINES: u64 = 20_000;
/// Inputs that are kept to be changed again, beside the corpus.
const KEPT: usize = 64;
/// After so many inputs the kept ones are forgotten: changes of changes end as noise that is
/// refused at the first byte.
const GENERATION: u64 = 5_000;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["replay", name, file] => match target(name) {
            Some(target) => fs::read(file).map(|bytes| (target.run)(&bytes)).map(|()| true),
            None => return usage(),
        },
        ["corpus", folder] => write_corpora(Path::new(folder)).map(|()| true),
        [name, count, seed, ref rest @ ..] if rest.len() < 2 => match (target(name), count.parse(), seed.parse()) {
            (Some(target), Ok(count), Ok(seed)) => {
                let folder = rest.first().map_or_else(|| format!("fuzz/artifacts/{name}"), |folder| folder.to_string());
                fuzz(target, count, seed, Path::new(&folder))
            }
            _ => return usage(),
        },
        _ => return usage(),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn usage() -> ExitCode {
    let names: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
    eprintln!("usage: extricate-fuzz TARGET COUNT SEED [FOLDER] | corpus FOLDER | replay TARGET FILE");
    eprintln!("TARGET: {}", names.join(", "));
    ExitCode::from(2)
}

fn write_corpora(folder: &Path) -> io::Result<()> {
    for target in TARGETS {
        let folder = folder.join(target.name);
        fs::create_dir_all(&folder)?;
        for (name, bytes) in (target.corpus)() {
            fs::write(folder.join(name), bytes)?;
        }
    }
    Ok(())
}

/// The input that is being tried and when it began, for the thread that watches.
type Current = Arc<Mutex<Option<(Duration, Vec<u8>)>>>;

/// What all threads of this process have taken of the processor.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(u64::try_from(time.tv_sec).unwrap_or_default(), u32::try_from(time.tv_nsec).unwrap_or_default())
}

/// Whether nothing was found.
fn fuzz(target: &Target, count: u64, seed: u64, folder: &Path) -> io::Result<bool> {
    fs::create_dir_all(folder)?;
    let place: Arc<Mutex<String>> = Arc::default();
    let told = place.clone();
    panic::set_hook(Box::new(move |info| {
        let at = info.location().map(|at| format!("{}:{}", at.file(), at.line())).unwrap_or_default();
        *told.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = format!("{at}: {info}");
    }));
    let mut inputs: Vec<Vec<u8>> = (target.corpus)().into_iter().map(|(_, bytes)| bytes).collect();
    let corpus = inputs.len();
    let current: Current = Arc::default();
    watch(current.clone(), folder.join("endless"));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut found, mut slow, started) = (BTreeMap::<String, u64>::new(), 0, Instant::now());
    for number in 0..count {
        if number % GENERATION == 0 {
            inputs.truncate(corpus);
        }
        let [one, other] = [(); 2].map(|()| rng.random_range(0..inputs.len()));
        // The corpus itself comes first.
        let input = match inputs.get(number as usize).filter(|_| number < corpus as u64) {
            Some(input) => input.clone(),
            None => (target.mutate)(&mut rng, &inputs[one], &inputs[other]),
        };
        let began = processor_time();
        *current.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some((began, input.clone()));
        let outcome = panic::catch_unwind(AssertUnwindSafe(|| (target.run)(&input)));
        *current.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = None;
        if outcome.is_err() {
            let message = place.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).clone();
            let key = message.split(": ").next().unwrap_or_default().to_string();
            let times = found.entry(key.clone()).or_default();
            *times += 1;
            if *times == 1 {
                let name = key.replace(['/', ':', '.'], "-");
                fs::write(folder.join(&name), &input)?;
                println!("input {number}: {message}\n  kept as {}", folder.join(&name).display());
            }
        }
        let took = processor_time().saturating_sub(began);
        if took > SLOW {
            slow += 1;
            let name = folder.join(format!("slow-{number}"));
            fs::write(&name, &input)?;
            println!("input {number}: {:.0} s, kept as {}", took.as_secs_f64(), name.display());
        }
        // A change of a change goes further than one of the corpus.
        if outcome.is_ok() && rng.random_range(0..8) == 0 {
            if inputs.len() < corpus + KEPT {
                inputs.push(input);
            } else {
                let at = rng.random_range(corpus..inputs.len());
                inputs[at] = input;
            }
        }
        if (number + 1) % BETWEEN_LINES == 0 {
            println!("{} inputs, {} places, {slow} slow", number + 1, found.len());
        }
    }
    println!("{}: {count} inputs in {:.0} s, seed {seed}", target.name, started.elapsed().as_secs_f64());
    found.iter().for_each(|(key, times)| println!("  {times} panics at {key}"));
    println!("  {} places that panic, {slow} slow inputs", found.len());
    Ok(found.is_empty() && slow == 0)
}

/// Keeps an input that does not end, and ends the program.
fn watch(current: Current, path: PathBuf) {
    thread::spawn(move || {
        loop {
            thread::sleep(Duration::from_secs(1));
            let held = current.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let endless = |began: &Duration| processor_time().saturating_sub(*began) > ENDLESS;
            if let Some((_, input)) = held.as_ref().filter(|(began, _)| endless(began)) {
                println!("an input of {} bytes takes longer than {:.0} s", input.len(), ENDLESS.as_secs_f64());
                match fs::write(&path, input) {
                    Ok(()) => println!("  kept as {}", path.display()),
                    Err(error) => println!("  not kept: {error}"),
                }
                std::process::exit(3);
            }
        }
    });
}

//! Runs a target on inputs that a random number generator makes of its corpus, with any toolchain.
//!
//! `extricate-fuzz TARGET COUNT SEED [FOLDER]` reports every place that panics, once, with the
//! number of inputs that got there. It also reports every input that takes longer than 10 s of the
//! processor, and how many were tried. Reported inputs are kept in FOLDER, which is
//! `fuzz/artifacts/TARGET` by default. A second thread keeps an input that never ends and ends the
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

/// Processor time beyond which an input is reported; others may use the processor too.
const SLOW_LIMIT: Duration = Duration::from_secs(10);
/// Processor time beyond which an input ends the program.
const ENDLESS_LIMIT: Duration = Duration::from_secs(60);
/// Inputs between two lines of progress.
const PROGRESS_INPUTS: u64 = 20_000;
/// Inputs that are kept to be changed again, besides the corpus.
const MAX_KEPT_INPUTS: usize = 64;
/// The kept inputs are dropped after this many inputs: repeated changes end as noise that is
/// refused at the first byte.
const GENERATION_INPUTS: u64 = 5_000;

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

/// The current input and when it began, for the thread that watches.
type Current = Arc<Mutex<Option<(Duration, Vec<u8>)>>>;

/// Returns the processor time that all threads of this process have taken.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(u64::try_from(time.tv_sec).unwrap_or_default(), u32::try_from(time.tv_nsec).unwrap_or_default())
}

/// Returns whether nothing was found.
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
        if number % GENERATION_INPUTS == 0 {
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
        if took > SLOW_LIMIT {
            slow += 1;
            let name = folder.join(format!("slow-{number}"));
            fs::write(&name, &input)?;
            println!("input {number}: {:.0} s, kept as {}", took.as_secs_f64(), name.display());
        }
        // A change of a change goes further than one of the corpus.
        if outcome.is_ok() && rng.random_range(0..8) == 0 {
            if inputs.len() < corpus + MAX_KEPT_INPUTS {
                inputs.push(input);
            } else {
                let at = rng.random_range(corpus..inputs.len());
                inputs[at] = input;
            }
        }
        if (number + 1) % PROGRESS_INPUTS == 0 {
            println!("{} inputs, {} places, {slow} slow", number + 1, found.len());
        }
    }
    println!("{}: {count} inputs in {:.0} s, seed {seed}", target.name, started.elapsed().as_secs_f64());
    found.iter().for_each(|(key, times)| println!("  {times} panics at {key}"));
    println!("  {} places that panic, {slow} slow inputs", found.len());
    Ok(found.is_empty() && slow == 0)
}

/// Watches the current input; keeps one that does not end, and ends the program.
fn watch(current: Current, path: PathBuf) {
    thread::spawn(move || {
        loop {
            thread::sleep(Duration::from_secs(1));
            let held = current.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let endless = |began: &Duration| processor_time().saturating_sub(*began) > ENDLESS_LIMIT;
            if let Some((_, input)) = held.as_ref().filter(|(began, _)| endless(began)) {
                println!("an input of {} bytes takes longer than {:.0} s", input.len(), ENDLESS_LIMIT.as_secs_f64());
                match fs::write(&path, input) {
                    Ok(()) => println!("  kept as {}", path.display()),
                    Err(error) => println!("  not kept: {error}"),
                }
                std::process::exit(3);
            }
        }
    });
}

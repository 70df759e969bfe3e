//! Answers many queries on all cores and returns the answers in the order of the queries.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::memory::Memory;
use crate::cspace::Config;
use crate::query::{Answer, QueryScratch};

/// One answer of a batch.
#[derive(Debug, Clone)]
pub struct Answered<T = Answer> {
    /// Number of the query, counted from 0.
    pub index: usize,
    /// The answer to that query.
    pub answer: T,
    /// Time that the query took on its core \[s\].
    pub seconds: f64,
}

/// Target duration of a block of queries: long enough that starting threads costs next to nothing,
/// short enough that the caller can interrupt.
const TARGET_BLOCK_DURATION: Duration = Duration::from_millis(60);
/// Limits the queries of a block, so that memory does not grow with the number of queries.
const MAX_BLOCK_QUERIES: usize = 4096;

/// Runs `ask` on each of `queries` on `threads` threads (0: one per core). Passes the results in
/// order, on the calling thread, to `each`, which may end the batch. Returns how many it passed.
///
/// # Guarantee
/// Order and answers do not depend on the number of threads. At most 4096 answers are held at a
/// time, or one per thread if there are more threads than that.
pub fn in_blocks<T: Send>(
    queries: &mut dyn Iterator<Item = Config>,
    threads: usize,
    memory: &Memory,
    ask: &(dyn Fn(&Config, &mut QueryScratch) -> T + Sync),
    each: &mut dyn FnMut(Answered<T>) -> ControlFlow<()>,
) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, |n| n.get());
    let threads = if threads == 0 { cores() } else { threads };
    let (mut block, mut done, mut size) = (Vec::new(), 0, threads);
    loop {
        block.clear();
        block.extend((0..size).map_while(|_| queries.next()));
        if block.is_empty() {
            return done;
        }
        let started = Instant::now();
        let answers = answer_block(&block, memory, ask, threads);
        for (answer, seconds) in answers {
            done += 1;
            if each(Answered { index: done - 1, answer, seconds }).is_break() {
                return done;
            }
        }
        let taken = started.elapsed();
        if taken < TARGET_BLOCK_DURATION / 2 {
            size = (2 * size).min(MAX_BLOCK_QUERIES.max(threads));
        } else if taken > 2 * TARGET_BLOCK_DURATION {
            size = (size / 2).max(threads);
        }
    }
}

/// Answers one block; each thread takes the next query as soon as it is free.
fn answer_block<T: Send>(
    block: &[Config],
    memory: &Memory,
    ask: &(dyn Fn(&Config, &mut QueryScratch) -> T + Sync),
    threads: usize,
) -> Vec<(T, f64)> {
    let next = AtomicUsize::new(0);
    let work = || {
        memory.of_queries(|scratch| {
            let mut answers = Vec::new();
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(q) = block.get(at) else { return answers };
                let started = Instant::now();
                let answer = ask(q, scratch);
                answers.push((at, (answer, started.elapsed().as_secs_f64())));
            }
        })
    };
    let mut answers = std::thread::scope(|scope| {
        let more = block.len().min(threads).saturating_sub(1);
        let spawned = (0..more).map(|_| std::thread::Builder::new().spawn_scoped(scope, work));
        // If the system starts no more threads, the existing ones do the work.
        let spawned: Vec<_> = spawned.filter_map(Result::ok).collect();
        let mut answers = work();
        for thread in spawned {
            match thread.join() {
                Ok(more) => answers.extend(more),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        answers
    });
    answers.sort_unstable_by_key(|(at, _)| *at);
    answers.into_iter().map(|(_, answer)| answer).collect()
}

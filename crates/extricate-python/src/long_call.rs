//! Work that takes long: without the interpreter lock, on its own threads or the calling one, ended
//! by Ctrl-C, or left alone if it cannot be ended.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

use extricate::Stop;
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How often the calling thread looks for signals and news: often enough that a bar moves smoothly
/// and Ctrl-C seems to work at once.
const PERIOD: Duration = Duration::from_millis(50);

/// What the work and the calling thread tell each other.
pub struct Line<News> {
    stop: Arc<AtomicBool>,
    news: Mutex<Option<News>>,
}

impl<News> Line<News> {
    /// Whether the work should end.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The same, for work that is told to go on or not.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The same, for queries.
    pub fn stop(&self) -> Stop {
        let stop = Arc::clone(&self.stop);
        Stop::when(move || stop.load(Ordering::Relaxed))
    }

    /// Leaves news for the calling thread, in place of older news that it has not fetched.
    pub fn tell(&self, news: News) {
        *self.news.lock().expect(UNPOISONED) = Some(news);
    }

    fn fetch(&self) -> Option<News> {
        self.news.lock().expect(UNPOISONED).take()
    }
}

/// Runs `work` on a new thread without the interpreter lock; the calling thread passes news to
/// `hear` and looks for signals.
///
/// # Errors
/// The exception of a signal handler (`KeyboardInterrupt`) or of `hear`, once the work has ended;
/// it is asked to. RuntimeError if the system starts no thread.
pub fn run<T: Send, News: Send>(
    py: Python<'_>,
    hear: impl Fn(Python<'_>, News) -> PyResult<()> + Sync,
    work: impl FnOnce(&Line<News>) -> T + Send,
) -> PyResult<T> {
    let line = Line { stop: Arc::default(), news: Mutex::new(None) };
    py.detach(|| {
        thread::scope(|scope| {
            // Never sent on: it closes when the work is done, also if that panics.
            let (open, done) = mpsc::channel::<()>();
            let line = &line;
            let worker = thread::Builder::new().spawn_scoped(scope, move || {
                let _open = open;
                work(line)
            });
            let worker = worker.map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
            let mut failure = None;
            loop {
                let waiting = done.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout);
                if failure.is_none() {
                    let listen = |py: Python<'_>| {
                        py.check_signals()?;
                        line.fetch().map_or(Ok(()), |news| hear(py, news))
                    };
                    failure = Python::attach(listen).err();
                    if failure.is_some() {
                        line.stop.store(true, Ordering::Relaxed);
                    }
                }
                if !waiting {
                    break;
                }
            }
            match (worker.join(), failure) {
                (Err(panic), _) => std::panic::resume_unwind(panic),
                (Ok(_), Some(failure)) => Err(failure),
                (Ok(result), None) => Ok(result),
            }
        })
    })
}

/// As [`aside`], for work on all threads of the current pool: it has a pool of its own.
///
/// # Errors
/// As [`aside`] and [`pool`].
pub fn apart<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let pool = pool(0)?;
    aside(py, move || pool.install(work))
}

/// Runs `work`, which cannot be told to stop, on a new thread without the interpreter lock; the
/// calling thread looks for signals.
///
/// # Errors
/// The exception of a signal handler (`KeyboardInterrupt`), at once: the work goes on, and what
/// it finds is thrown away. RuntimeError if the system starts no thread.
pub fn aside<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let (tell, found) = mpsc::channel();
    // Nobody may be there to hear it.
    let worker = thread::Builder::new().spawn(move || drop(tell.send(work())));
    let worker = worker.map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
    py.detach(move || {
        loop {
            match found.recv_timeout(PERIOD) {
                Ok(found) => return Ok(found),
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let panic = worker.join().expect_err("it ended and told nothing");
        std::panic::resume_unwind(panic)
    })
}

/// Runs `work`, which reads or prepares geometry, without the interpreter lock and on a pool of its
/// own: the library does both on all threads of the current pool.
///
/// # Errors
/// As [`pool`].
pub fn pooled<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool(0)?;
    Ok(py.detach(|| pool.install(work)))
}

/// Looks for signals on behalf of queries on the calling thread, which ask it before each step:
/// starting a thread, as [`run`] does, takes longer than most queries.
#[derive(Clone)]
pub struct Watch(Arc<Mutex<Watched>>);

struct Watched {
    /// When to look.
    next: Instant,
    /// What a signal handler raised.
    failure: Option<PyErr>,
}

impl Watch {
    /// One that has seen nothing.
    pub fn new() -> Self {
        Self(Arc::new(Mutex::new(Watched { next: Instant::now() + PERIOD, failure: None })))
    }

    /// What a query asks.
    pub fn stop(&self) -> Stop {
        let watch = self.clone();
        Stop::when(move || watch.has_failed())
    }

    /// Runs `work`, which asks [`Watch::stop`] and does not hold the interpreter lock.
    ///
    /// # Errors
    /// The exception of a signal handler (`KeyboardInterrupt`).
    pub fn over<T>(&self, work: impl FnOnce() -> T) -> PyResult<T> {
        self.watched().next = Instant::now() + PERIOD;
        let result = work();
        self.watched().failure.take().map_or(Ok(result), Err)
    }

    fn has_failed(&self) -> bool {
        let now = Instant::now();
        let mut watched = self.watched();
        if watched.failure.is_some() || now < watched.next {
            return watched.failure.is_some();
        }
        watched.next = now + PERIOD;
        // A signal handler may do anything, for long; nothing is held meanwhile.
        drop(watched);
        let failure = Python::attach(|py| py.check_signals()).err();
        let has_failed = failure.is_some();
        self.watched().failure = failure;
        has_failed
    }

    fn watched(&self) -> MutexGuard<'_, Watched> {
        self.0.lock().expect(UNPOISONED)
    }
}

const UNPOISONED: &str = "never poisoned: nothing panics while it is held";

/// A pool of `threads` threads, 0 for one per core. Every call has its own: a global one would not
/// survive `fork`.
///
/// # Errors
/// `OSError` if the system starts no such number of threads.
pub fn pool(threads: usize) -> PyResult<ThreadPool> {
    let refused = |error| PyOSError::new_err(format!("threads: cannot start {threads} ({error})"));
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(refused)
}

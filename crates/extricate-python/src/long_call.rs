//! Runs long work without the interpreter lock, on its own threads or the calling one. Ctrl-C ends
//! the work, or abandons it if it cannot be ended.

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

/// Period at which the calling thread polls signals and news: short enough that a bar moves
/// smoothly and Ctrl-C seems to work at once.
const POLL_PERIOD: Duration = Duration::from_millis(50);

/// Connects the work and the calling thread: a stop flag one way, the latest news the other.
pub struct Line<News> {
    stop: Arc<AtomicBool>,
    news: Mutex<Option<News>>,
}

impl<News> Line<News> {
    /// Whether the work should end.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns [`Line::stopped`] as a control flow.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Returns [`Line::stopped`] as a stop of queries.
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
/// `hear` and polls signals.
///
/// # Errors
/// The exception of a signal handler (`KeyboardInterrupt`) or of `hear`, which sets the stop flag
/// and is returned once the work has ended. `RuntimeError` if the system starts no thread.
pub fn run<T: Send, News: Send>(
    py: Python<'_>,
    hear: impl Fn(Python<'_>, News) -> PyResult<()> + Sync,
    work: impl FnOnce(&Line<News>) -> T + Send,
) -> PyResult<T> {
    let line = Line { stop: Arc::default(), news: Mutex::new(None) };
    py.detach(|| {
        thread::scope(|scope| {
            // Nothing is ever sent: the channel closes when the work ends, also by a panic.
            let (open, done) = mpsc::channel::<()>();
            let line = &line;
            let worker = thread::Builder::new().spawn_scoped(scope, move || {
                let _open = open;
                work(line)
            });
            let worker = worker.map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
            let mut failure = None;
            loop {
                let waiting = done.recv_timeout(POLL_PERIOD) == Err(RecvTimeoutError::Timeout);
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

/// Runs `work` as [`aside`] does, but on a pool of its own: work on many threads needs one.
///
/// # Errors
/// As [`aside`] and [`pool`].
pub fn apart<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let pool = pool(0)?;
    aside(py, move || pool.install(work))
}

/// Runs `work`, which cannot be stopped, on a new thread without the interpreter lock; the calling
/// thread polls signals.
///
/// # Errors
/// The exception of a signal handler (`KeyboardInterrupt`), at once: the work goes on, and its
/// result is dropped. `RuntimeError` if the system starts no thread.
pub fn aside<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let (tell, found) = mpsc::channel();
    // The receiver is gone if a signal handler raised.
    let worker = thread::Builder::new().spawn(move || drop(tell.send(work())));
    let worker = worker.map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
    py.detach(move || {
        loop {
            match found.recv_timeout(POLL_PERIOD) {
                Ok(found) => return Ok(found),
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let panic = worker.join().expect_err("it ended and told nothing");
        std::panic::resume_unwind(panic)
    })
}

/// Runs `work`, which reads or prepares geometry, without the interpreter lock. It gets a pool of
/// its own, because the library does both on all threads of the current pool.
///
/// # Errors
/// As [`pool`].
pub fn pooled<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool(0)?;
    Ok(py.detach(|| pool.install(work)))
}

/// Polls signals for queries on the calling thread, which call it before each step. Starting a
/// thread, as [`run`] does, would take longer than most queries.
#[derive(Clone)]
pub struct Watch(Arc<Mutex<Watched>>);

struct Watched {
    /// Time of the next poll.
    next: Instant,
    /// The exception that a signal handler raised.
    failure: Option<PyErr>,
}

impl Watch {
    pub fn new() -> Self {
        Self(Arc::new(Mutex::new(Watched { next: Instant::now() + POLL_PERIOD, failure: None })))
    }

    /// Returns the stop that ends a query once a signal handler has raised an exception.
    pub fn stop(&self) -> Stop {
        let watch = self.clone();
        Stop::when(move || watch.has_failed())
    }

    /// Runs `work`, which polls [`Watch::stop`] and does not hold the interpreter lock.
    ///
    /// # Errors
    /// The exception of a signal handler (`KeyboardInterrupt`).
    pub fn over<T>(&self, work: impl FnOnce() -> T) -> PyResult<T> {
        self.watched().next = Instant::now() + POLL_PERIOD;
        let result = work();
        self.watched().failure.take().map_or(Ok(result), Err)
    }

    fn has_failed(&self) -> bool {
        let now = Instant::now();
        let mut watched = self.watched();
        if watched.failure.is_some() || now < watched.next {
            return watched.failure.is_some();
        }
        watched.next = now + POLL_PERIOD;
        // A signal handler may take long and call anything, so nothing is locked meanwhile.
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

/// Makes a pool of `threads` threads, 0 for one per core. Every call has its own: a global one
/// would not survive `fork`.
///
/// # Errors
/// `OSError` if the system does not start that many threads.
pub fn pool(threads: usize) -> PyResult<ThreadPool> {
    let refused = |error| PyOSError::new_err(format!("threads: cannot start {threads} ({error})"));
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(refused)
}

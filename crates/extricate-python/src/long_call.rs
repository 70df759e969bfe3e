//! Work that takes long: without the interpreter lock, on its own threads, ended by Ctrl-C.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How often the calling thread looks for signals and news: often enough that a bar moves smoothly and Ctrl-C seems to work
/// at once.
const PERIOD: Duration = Duration::from_millis(50);

/// What the work and the calling thread tell each other.
pub struct Line<News> {
    stop: AtomicBool,
    news: Mutex<Option<News>>,
}

impl<News> Line<News> {
    /// Whether the work should end.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Leaves news for the calling thread, in place of older news that it has not fetched.
    pub fn tell(&self, news: News) {
        *self.news.lock().expect("never poisoned: nothing panics while it is held") = Some(news);
    }

    fn fetch(&self) -> Option<News> {
        self.news.lock().expect("never poisoned: nothing panics while it is held").take()
    }
}

/// Runs `work` on a new thread without the interpreter lock; the calling thread passes news to `hear` and looks for signals.
///
/// # Errors
/// The exception of a signal handler (`KeyboardInterrupt`) or of `hear`, once the work has ended; it is asked to.
pub fn run<T: Send, News: Send>(
    py: Python<'_>,
    hear: impl Fn(Python<'_>, News) -> PyResult<()> + Sync,
    work: impl FnOnce(&Line<News>) -> T + Send,
) -> PyResult<T> {
    let line = Line { stop: AtomicBool::new(false), news: Mutex::new(None) };
    py.detach(|| {
        thread::scope(|scope| {
            // Never sent on: it closes when the work is done, also where that panics.
            let (open, done) = mpsc::channel::<()>();
            let line = &line;
            let worker = scope.spawn(move || {
                let _open = open;
                work(line)
            });
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

/// A pool of `threads` threads, 0 for one per core. Every call has its own: a global one would not survive `fork`.
///
/// # Errors
/// `OSError` where the system starts no such number of threads.
pub fn pool(threads: usize) -> PyResult<ThreadPool> {
    let refused = |error| PyOSError::new_err(format!("threads: cannot start {threads} ({error})"));
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(refused)
}

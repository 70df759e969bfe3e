//! Time spent on a processor, by this thread or by all of the program: what other programs do
//! meanwhile is not in it.

use rustix::time::{ClockId, clock_gettime};

/// A point of time of the calling thread.
#[derive(Clone, Copy)]
pub struct ThreadTime(f64);

impl ThreadTime {
    /// Now. Takes a few hundred nanoseconds: for loops, not for single checks.
    pub fn now() -> Self {
        Self(seconds_of(ClockId::ThreadCPUTime))
    }

    /// Seconds of the calling thread since then.
    pub fn elapsed(self) -> f64 {
        Self::now().0 - self.0
    }
}

/// A point of time of all threads of this program together.
#[derive(Clone, Copy)]
pub struct ProcessTime(f64);

impl ProcessTime {
    /// Now.
    pub fn now() -> Self {
        Self(seconds_of(ClockId::ProcessCPUTime))
    }

    /// Seconds of all threads since then.
    pub fn elapsed(self) -> f64 {
        Self::now().0 - self.0
    }
}

fn seconds_of(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleep_is_not_counted() {
        let start = ThreadTime::now();
        std::thread::sleep(std::time::Duration::from_millis(300));
        assert!((0.0..0.2).contains(&start.elapsed()));
    }
}

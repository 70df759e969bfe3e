//! Processor time of this thread or of the whole program. Unlike wall time, it does not count other
//! programs.

use rustix::time::{ClockId, clock_gettime};

#[derive(Clone, Copy)]
pub struct ThreadTime(f64);

impl ThreadTime {
    /// Reads the clock, which takes a few hundred nanoseconds: time loops with it, not single
    /// checks.
    pub fn now() -> Self {
        Self(seconds_of(ClockId::ThreadCPUTime))
    }

    /// Processor seconds of the calling thread since this point.
    pub fn elapsed(self) -> f64 {
        Self::now().0 - self.0
    }
}

/// A point of time on the clock that adds up all threads of this program.
#[derive(Clone, Copy)]
pub struct ProcessTime(f64);

impl ProcessTime {
    pub fn now() -> Self {
        Self(seconds_of(ClockId::ProcessCPUTime))
    }

    /// Processor seconds of all threads since this point.
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

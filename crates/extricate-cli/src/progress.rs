//! Progress of a long job on standard error: a bar on a terminal, otherwise a plain line now and
//! then.

use std::collections::VecDeque;
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::notice;

/// Jobs shorter than this show nothing.
const SILENT_TIME: Duration = Duration::from_secs(1);
/// Time between two plain lines.
const PLAIN_INTERVAL: Duration = Duration::from_secs(5);
/// Time between two redraws of the bar.
const REDRAW_INTERVAL: Duration = Duration::from_millis(100);
/// Shortest time over which the speed is averaged \[s\].
const SPEED_WINDOW_S: f64 = 10.0;
/// Least progress from which time is estimated, so that a job that pauses gives no estimate.
const MIN_SHARE: f64 = 1e-3;
/// Largest share that is shown of an unfinished job.
const MAX_SHOWN_SHARE: f64 = 0.99;
/// Steps of the bar for progress from 0 to 1.
const BAR_STEPS: u64 = 1000;

pub struct Progress {
    title: &'static str,
    estimate: Estimate,
    started: Instant,
    next: Instant,
    destination: Destination,
}

enum Destination {
    /// Shows nothing, because rows on the terminal are progress enough.
    Nowhere,
    Lines,
    Terminal(Option<ProgressBar>),
}

impl Progress {
    /// Progress of a job that prints nothing else meanwhile.
    pub fn new(title: &'static str) -> Self {
        let destination =
            if std::io::stderr().is_terminal() { Destination::Terminal(None) } else { Destination::Lines };
        let started = Instant::now();
        Self { title, estimate: Estimate::default(), started, next: started + SILENT_TIME, destination }
    }

    /// Progress of a job that writes rows to standard output as it goes.
    pub fn beside_rows(title: &'static str) -> Self {
        let mut progress = Self::new(title);
        if std::io::stdout().is_terminal() {
            progress.destination = Destination::Nowhere;
        }
        progress
    }

    /// Reports the progress: `fraction` in `[0, 1]`, if it is known, and `message`. Cheap if no
    /// report is due.
    pub fn update(&mut self, fraction: Option<f64>, message: impl FnOnce() -> String) {
        let now = Instant::now();
        if now < self.next {
            return;
        }
        let left = fraction.and_then(|f| self.estimate.left(self.started.elapsed().as_secs_f64(), f));
        // After the budget is spent, remaining work such as measuring a model takes an unknown
        // time.
        let left = left.filter(|_| fraction.is_some_and(|f| f < MAX_SHOWN_SHARE));
        let fraction = fraction.map(|f| f.clamp(0.0, MAX_SHOWN_SHARE));
        let left = left.map_or(String::new(), |seconds| format!(", about {} left", whole_duration(seconds)));
        match &mut self.destination {
            Destination::Nowhere => {}
            Destination::Lines => {
                self.next = now + PLAIN_INTERVAL;
                let share = fraction.map_or(String::new(), |f| format!("{:.0} %, ", 100.0 * f));
                notice::note(format_args!("{}: {share}{}{left}", self.title, message()));
            }
            Destination::Terminal(bar) => {
                self.next = now + REDRAW_INTERVAL;
                let bar = bar.get_or_insert_with(|| new_bar(self.title, self.started.elapsed(), fraction.is_some()));
                match fraction {
                    Some(f) => bar.set_position((f * BAR_STEPS as f64) as u64),
                    None => bar.tick(),
                }
                bar.set_message(message() + &left);
            }
        }
    }

    /// Runs `print`, which writes to standard error, while the bar is hidden.
    pub fn aside(&self, print: impl FnOnce()) {
        match &self.destination {
            Destination::Terminal(Some(bar)) => bar.suspend(print),
            _ => print(),
        }
    }
}

/// Estimates the remaining time of a job from its recent speed.
#[derive(Default)]
struct Estimate {
    /// Seconds and fractions, oldest first.
    seen: VecDeque<(f64, f64)>,
}

impl Estimate {
    /// Returns the seconds left if `fraction` is done at `now` \[s\]; `None` if too little was
    /// observed.
    fn left(&mut self, now: f64, fraction: f64) -> Option<f64> {
        self.seen.push_back((now, fraction));
        // Stages differ in speed, so early progress says little; but the window grows with the job.
        let window = f64::max(SPEED_WINDOW_S, now / 4.0);
        while self.seen.get(1).is_some_and(|(then, _)| now - then >= window) {
            self.seen.pop_front();
        }
        let (then, before) = *self.seen.front()?;
        let (time, share) = (now - then, fraction - before);
        (time > 0.0 && share > MIN_SHARE).then(|| (1.0 - fraction).max(0.0) * time / share)
    }
}

/// Formats remaining time as people say it: two digits suffice.
fn whole_duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.ceil()),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

/// Does `work`, whose progress is unknown. If it takes long, `what` and the elapsed seconds are
/// printed now and then.
pub fn busy<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let (done, until_done) = mpsc::channel::<()>();
    thread::scope(|scope| {
        let tell = move || {
            let mut interval = SILENT_TIME;
            while until_done.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                notice::note(format_args!("{what}: {:.0} s so far", started.elapsed().as_secs_f64()));
                interval = PLAIN_INTERVAL;
            }
        };
        // If the system starts no more threads, the work is done in silence.
        let _ = thread::Builder::new().spawn_scoped(scope, tell);
        let result = work();
        drop(done);
        result
    })
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Destination::Terminal(Some(bar)) = &self.destination {
            bar.finish_and_clear();
        }
    }
}

fn new_bar(title: &'static str, elapsed: Duration, known: bool) -> ProgressBar {
    let template = if known {
        "{prefix} [{bar:32}] {percent:>3} % {elapsed:>4} {msg}"
    } else {
        "{prefix} {spinner} {elapsed:>4} {msg}"
    };
    let style = ProgressStyle::with_template(template).expect("the template is a constant").progress_chars("=> ");
    ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr())
        .with_style(style)
        .with_prefix(title)
        .with_elapsed(elapsed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_the_speed_of_late() {
        let mut estimate = Estimate::default();
        assert_eq!(estimate.left(0.0, 0.5), None, "a run that was resumed begins anywhere");
        let left = (1..=20).filter_map(|i| estimate.left(f64::from(i), 0.5 + 0.01 * f64::from(i))).last().unwrap();
        assert!((left - 30.0).abs() < 1e-6, "{left}");
        // From here the job is half as fast.
        let left = (1..=20).filter_map(|i| estimate.left(20.0 + f64::from(i), 0.7 + 0.005 * f64::from(i))).last();
        assert!((left.unwrap() - 40.0).abs() < 1e-6, "{left:?}");
        assert_eq!(estimate.left(50.0, 1.0), Some(0.0));
        // The job pauses; an estimate would be hours.
        let left = (1..=20).map(|i| estimate.left(50.0 + f64::from(i), 1.0 + 1e-5 * f64::from(i))).last().unwrap();
        assert_eq!(left, None);
    }

    #[test]
    fn time_left_reads_well() {
        let texts = [0.2, 59.7, 600.0, 7300.0].map(whole_duration);
        assert_eq!(texts, ["1 s", "60 s", "10 min", "2 h"]);
    }
}

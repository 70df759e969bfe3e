//! Learns with a progress bar, until the end or Ctrl-C.

use std::ops::ControlFlow;
use std::time::Instant;

use extricate::{LearnOptions, Model, Scene};

use crate::interrupt::StopOnInterrupt;
use crate::notice;
use crate::progress::Progress;
use crate::report::{count, percent};

/// A model, and figures of its run. The file does not contain them because they differ from run to
/// run.
pub struct Learned {
    pub model: Model,
    /// Wall time of learning \[s\].
    pub seconds: f64,
    pub interrupted: bool,
}

/// Learns to the end, or until Ctrl-C, which keeps the samples that were found.
pub fn learn_with_progress(scene: Scene, options: &LearnOptions) -> extricate::Result<Learned> {
    let started = Instant::now();
    let stop = StopOnInterrupt::new();
    let mut progress = Progress::new("learning");
    let learned = Model::learn_with(scene, options, &mut |state| {
        progress.update(Some(state.fraction), || {
            in_words(state.stage, state.labels, state.boundary_samples, state.accuracy)
        });
        if stop.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    drop(progress);
    let (model, interrupted) = (learned?, stop.asked());
    if interrupted {
        let labels = count(model.statistics().labels);
        notice::warning(format_args!("stopped by the user; keeping the model learned so far ({labels} labels)"));
    }
    Ok(Learned { model, seconds: started.elapsed().as_secs_f64(), interrupted })
}

/// Returns `, with 123 MiB at most` if the system reports the memory of the process.
pub fn memory_in_words() -> String {
    peak_memory().map_or(String::new(), |bytes| format!(", with {} MiB at most", count(bytes as usize >> 20)))
}

fn in_words(stage: &str, labels: usize, samples: usize, accuracy: Option<f64>) -> String {
    let accuracy = accuracy.map_or(String::new(), |a| format!(", accuracy {}", percent(a)));
    format!("{stage}: {} labels, {} boundary samples{accuracy}", count(labels), count(samples))
}

/// Peak memory of this process \[bytes\]; `None` if the system does not report it.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_reads_well() {
        let told = |accuracy| in_words("exploring", 1500, 30, accuracy);
        assert_eq!(told(None), "exploring: 1,500 labels, 30 boundary samples");
        assert!(told(Some(0.953)).ends_with("accuracy 95.3 %"));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn peak_memory_grows_with_use() {
        let before = peak_memory().unwrap();
        let used = std::hint::black_box(vec![1u8; 200 << 20]);
        assert!(peak_memory().unwrap() >= (used.len() as u64).max(before));
    }
}

//! The `extricate` command: reads arguments and prints reports; the library `extricate` computes
//! everything. The public items serve the program and the fuzz targets, and are no stable
//! interface.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod commands;
pub mod input;
mod interrupt;
mod notice;
mod output;
mod pages;
mod progress;
mod report;

use std::io::ErrorKind;
use std::process::ExitCode;

use anyhow::Context;

/// Runs the command line of the process. Exit codes: 0 done, 1 the operation failed, 2 (by clap)
/// the command line is invalid.
pub fn run() -> ExitCode {
    let cli = match args::Cli::read(std::env::args_os()) {
        Ok(cli) => cli,
        Err(error) => return notice::usage(&error),
    };
    // Start the threads here, so that a failure is reported as an error.
    let threads = rayon::ThreadPoolBuilder::new().build_global().context("cannot start threads, one per core");
    match threads.and_then(|()| commands::run(cli)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            notice::error(in_words(&error));
            ExitCode::FAILURE
        }
    }
}

/// Whether the reader of standard output stopped reading, as `head` does once it has enough.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| cause.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == ErrorKind::BrokenPipe))
}

/// Joins the error and its causes, without those that the error already quotes.
fn in_words(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_told_once() {
        let source = std::io::Error::from(ErrorKind::NotFound);
        let said = source.to_string();
        let read = extricate::Error::Read { path: "a.toml".into(), source };
        assert_eq!(in_words(&read.into()), format!("cannot read a.toml: {said}"));
        let context = anyhow::Error::new(std::io::Error::from(ErrorKind::NotFound)).context("cannot read b");
        assert_eq!(in_words(&context), format!("cannot read b: {said}"));
    }

    #[test]
    fn a_closed_pipe_is_told_from_a_failed_write() {
        let error = |kind| anyhow::Error::new(std::io::Error::from(kind)).context("writing");
        assert!(is_broken_pipe(&error(ErrorKind::BrokenPipe)));
        assert!(!is_broken_pipe(&error(ErrorKind::StorageFull)));
    }
}

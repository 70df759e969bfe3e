//! The `extricate` command: arguments in, reports out. All that is computed is computed by the
//! library `extricate`. Public is what its program and the fuzz targets need, and no interface.
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
/// the command line makes no sense.
pub fn run() -> ExitCode {
    let cli = match args::Cli::read(std::env::args_os()) {
        Ok(cli) => cli,
        Err(error) => return notice::usage(&error),
    };
    // Made here, where it can be said that there is no room for its threads.
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

/// Whether the reader of standard output went away, as `| head` does: it has what it wanted.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| cause.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == ErrorKind::BrokenPipe))
}

/// The error and its causes, leaving out those that the error quotes already.
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

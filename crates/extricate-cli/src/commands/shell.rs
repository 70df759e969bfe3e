//! `completions` and `man`: what shells and manual readers want to know of the command line.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::args::Cli;
use crate::output::Output;

/// Arguments of `completions`.
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell that completes
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args)]
pub struct ManArgs {
    /// Folder for the pages, one a command; made where it is missing
    folder: PathBuf,
}

/// Prints the script of a shell.
pub fn completions(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "extricate", &mut script);
    let mut out = Output::new(false);
    out.line(String::from_utf8_lossy(&script).trim_end())?;
    out.finish()
}

/// Writes the manual pages.
pub fn man(args: &ManArgs) -> anyhow::Result<()> {
    let cannot = || format!("cannot write {}", args.folder.display());
    fs::create_dir_all(&args.folder).with_context(cannot)?;
    clap_mangen::generate_to(Cli::command(), &args.folder).with_context(cannot)
}
